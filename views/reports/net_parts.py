"""Pictures of the part of a net that a finding is about."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from dineros.metamodel import pn
from dineros.views.nets import ViewModel, around, collapse_if_large, layout, to_svg, view_of

MOST = 40
"""Elements beyond which a picture shows fewer steps around them."""


class NetParts:
    """Draws parts of one model.

    Parameters
    ----------
    model : pn.Net
        The model.
    """

    def __init__(self, model: pn.Net) -> None:
        self._view = view_of(model)
        self._known = {node.id for node in self._view.nodes} | {box.id for box in self._view.boxes}

    def draw(self, elements: Sequence[str]) -> dict[Literal["light", "dark"], str]:
        """Return the surroundings of elements as SVG in both themes; nothing where none is in the picture.

        Raises
        ------
        DinerosError
            Nothing that lays nets out is installed.
        """
        shown = [element for element in elements if element in self._known]
        if not shown:
            return {}
        positioned = layout(collapse_if_large(self._part(shown)))
        return {
            "light": to_svg(positioned, highlights=shown, theme="light"),
            "dark": to_svg(positioned, highlights=shown, theme="dark"),
        }

    def _part(self, shown: Sequence[str]) -> ViewModel:
        for steps in (3, 2, 1):
            part = around(self._view, shown, steps)
            if len(part.nodes) <= MOST:
                return part
        return part
