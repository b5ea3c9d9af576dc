"""One trace, or two side by side, as files: a page, SVG or PNG."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.atomic import write_atomically
from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.comparing import Divergence, first_divergence


class TracePictures:
    """Pictures of a trace, with another one to compare it with.

    Attributes
    ----------
    title : str
        The name of the trace.
    builder : TraceBuilder
        Holds its steps.
    without_net : DinerosError or None
        The reason if a written page shows no net.
    """

    def __init__(self, title: str, builder: TraceBuilder, model: pn.Net | None) -> None:
        self.title, self.builder = title, builder
        self.without_net: DinerosError | None = None
        self._model = model
        self._views = [TraceCoder(builder, title).snapshot()]
        self._divergence: dict[str, Any] | None = None

    def compare(self, title: str, other: TraceBuilder) -> Divergence | None:
        """Also show another trace; return the divergence of the two."""
        self._views.append(TraceCoder(other, title).snapshot())
        parting = first_divergence(self.builder, other)
        self._divergence = parting.to_json() if parting else None
        return parting

    def write(self, output: Path, options: dict[str, Any]) -> None:
        """Write a picture atomically.

        Parameters
        ----------
        output : Path
            The file: ``.html``, ``.svg`` or ``.png``.
        options : dict
            Options of figures: ``theme``, ``fold``, ``filter``, ``time``; a page has buttons for that.
        """
        from dineros.views.traces.figures import trace_png, trace_svg

        suffix = output.suffix.lower()
        if suffix == ".html":
            write_atomically(output, self._page().encode())
            return
        if self._divergence:
            options = {**options, "divergence": self._divergence}
        if suffix == ".svg":
            write_atomically(output, trace_svg(self._views, **options).encode())
        else:
            write_atomically(output, trace_png(self._views, **options))

    def _page(self) -> str:
        from dineros.views.traces.net_pane import net_content
        from dineros.views.traces.page import trace_page

        content: dict[str, Any] = {"view": self._views[0], "divergence": self._divergence}
        if len(self._views) > 1:
            content["other"] = self._views[1]
        try:
            content["net"] = net_content(self._model)
        except DinerosError as error:  # the trace itself can be shown
            self.without_net = error
        return trace_page(content, title=f"{self.title} – trace")
