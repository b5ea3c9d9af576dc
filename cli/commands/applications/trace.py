"""``dineros trace``: the Trace Visualizer (paper, Sect. 9)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dineros.cli.console import say, summarise, warn
from dineros.cli.options import (
    ModelPath,
    flag,
    model_path_option,
    output_option,
    settings_option,
    theme_option,
    value_option,
)
from dineros.cli.outputs import refuse_output
from dineros.cli.presentation.traces import loads_of, model_of
from dineros.cli.supervising import serving_command, within_limits
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.metamodel import pn
    from dineros.metamodel.records import Header
    from dineros.views.traces.building import TraceBuilder
    from dineros.views.traces.pictures import TracePictures

_PICTURES = (".html", ".svg", ".png")


@serving_command(
    "dineros trace pick.jsonl -o pick.html",
    "dineros trace pick.jsonl -o pick.svg --fold --filter 'Pick|Place|Sensor'",
    "dineros trace pick.jsonl --compare place.jsonl -o both.html",
    "dineros trace pick.jsonl -o pick.mcap",
)
@click.argument("files", type=ModelPath(), metavar="FILE...", nargs=-1, required=True)
@output_option("A picture (.html, .svg, .png), or an export (.mcap, .csv).")
@flag("--follow", "Open a live page that follows a running application.")
@value_option("--port N", "Port of the live page.", type=click.IntRange(0, 65535), default=0)
@model_path_option("--model MODEL", "The model, if it has moved.", into="given")
@model_path_option("--compare FILE", "Show a second trace, and where the two diverge.")
@flag("--fold", "Fold steps that do not concern the shown lanes (.svg, .png).")
@value_option("--filter WORDS", "Lanes to show (.svg, .png).", into="words", default="")
@flag("--firings", "For a run: by number of firings, not by time (.svg, .png).")
@theme_option
@settings_option
def trace(
    files: tuple[Path, ...],
    output: Path | None,
    follow: bool,
    port: int,
    given: Path | None,
    compare: Path | None,
    fold: bool,
    words: str,
    firings: bool,
    theme: str,
    settings: tuple[str, ...],
) -> int:
    """Draw, export or follow traces: witnesses of `find`, `verify` and `check`, and runs of an application.

    FILE is a witness, a node's trace, or a folder of a run. Several are the nodes of one run, merged in the
    order of their messages. Without -o, the steps are listed.
    """
    from dineros.views.traces.reading import build, header_of

    if follow:
        if output is not None or compare is not None or len(files) != 1:
            raise click.UsageError("--follow takes one FILE or folder, and neither -o nor --compare")
        return _follow(files[0], port, given, settings)
    suffix = output.suffix.lower() if output is not None else ""
    if output is not None:
        _refuse(output, suffix, compare, fold=fold, words=words, firings=firings, theme=theme)
    header = header_of(files)
    model = model_of(header, files, given, settings)
    builder = build(files, model, loads_of(model, header))
    title = files[0].name
    if output is None:
        _list(builder)
    elif suffix in _PICTURES:
        from dineros.views.traces.pictures import TracePictures

        pictures = TracePictures(title, builder, model)
        if compare is not None:
            _compare(pictures, compare, given, settings)
        pictures.write(output, {"theme": theme, "fold": fold, "filter": words, "time": not firings})
        if pictures.without_net is not None:
            warn(f"{output}: without the net: {pictures.without_net}")
    else:
        from dineros.metamodel.files.atomic import write_atomically
        from dineros.views.exports import export

        write_atomically(output, export(builder, suffix))
    if output is not None:
        summarise(f"{title} -> {output}: {counted(len(builder.steps), 'step')}")
    return 0


def _compare(pictures: TracePictures, path: Path, given: Path | None, settings: tuple[str, ...]) -> None:
    """Show a second trace next to the first one, and print their divergence."""
    from dineros.views.traces.reading import build, header_of

    header = header_of([path])
    model = model_of(header, [path], given, settings)
    other = build([path], model, loads_of(model, header))
    parting = pictures.compare(path.name, other)
    if parting is None:
        summarise(f"{pictures.title} and {path.name} do not differ")
        return
    said = [
        repr(trace.steps[at].text) if at < len(trace.steps) else "the end"
        for trace, at in ((pictures.builder, parting.a), (other, parting.b))
    ]
    where = f" of {parting.node}" if parting.node else ""
    summarise(f"first divergence{where} at step {parting.a + 1}: {said[0]}, but {said[1]} in {path.name}")


def _refuse(output: Path, suffix: str, compare: Path | None, **drawing: Any) -> None:
    """Reject an unknown format, and options without effect for it."""
    from dineros.views.exports import EXPORTS

    refuse_output(output, (*_PICTURES, *EXPORTS), "of traces")
    if suffix not in _PICTURES and compare is not None:
        raise click.UsageError("--compare requires .html, .svg or .png")
    given = [name for name, value in drawing.items() if value not in (False, "", "light")]
    if given and suffix not in (".svg", ".png"):
        option = {"words": "filter"}.get(given[0], given[0])
        raise click.UsageError(f"--{option} requires .svg or .png; a page has buttons for it")


def _list(builder: TraceBuilder) -> None:
    width = max((len(step.node or "") for step in builder.steps), default=0)
    start = next((step.time for step in builder.steps if step.time is not None), None)
    if any("window" in step.details for step in builder.steps):
        start = None  # the steps of a schedule say themselves when they happen, in the unit of the net
    for number, step in enumerate(builder.steps):
        if number == builder.loop:
            say("  forever:")
        when = f"{step.time - start:10.3f} s" if start is not None and step.time is not None else ""
        say(f"  {number + 1:4} {when}  {step.node or '':{width}}  {step.text}")


def _follow(path: Path, port: int, given: Path | None, settings: tuple[str, ...]) -> int:
    from dineros.views.live import serve_live

    def find_model(header: Header) -> pn.Net | None:
        return model_of(header, [path], given, settings)

    with within_limits():
        handle = serve_live(path, find_model, port=port)
    try:
        say(f"following {path}: {handle.url}")
        handle.wait()
    except KeyboardInterrupt:
        return 0
    finally:
        handle.stop()
    return 0
