"""The guide's pictures of traces, drawn by the tool while the guide is built.

The witness in `examples` took a minute to find, so that it is kept; a test replays it.
The run is recorded again.
"""

from __future__ import annotations

import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from dineros.cli.presentation.traces import loads_of
from dineros.metamodel import sym
from dineros.metamodel.files import load
from dineros.views.reports.sweep_figures import sweep_figures
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.figures import trace_svg
from dineros.views.traces.net_pane import net_content
from dineros.views.traces.page import trace_page
from dineros.views.traces.reading import build, header_of

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
MODEL = "case_study/sorting.sym.xmi"


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the pictures to the guide; the hook that MkDocs calls."""
    for name, content in pictures().items():
        files.append(File.generated(config, f"pictures/{name}", content=content))
    return files


def pictures() -> dict[str, str | bytes]:
    """Return each picture by the name of its file."""
    model = load(ROOT / MODEL)
    assert isinstance(model, sym.SystemModel)
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "sorting"
        _record(model, run)
        views = {
            "trace-witness": _view(
                EXAMPLES / "sort_red_then_green.jsonl", "sort_red_then_green.jsonl", model
            ),
            "trace-run": _view(run, "sorting", model),
        }
    made: dict[str, str | bytes] = {
        "sweep.svg": sweep_figures(_table(), title="Sorting n objects of each colour")
    }
    for name, view in views.items():
        for theme in ("light", "dark"):
            made[f"{name}-{theme}.svg"] = trace_svg([view], theme, filter="-dispatcher", time=True)
        made[f"{name}.html"] = trace_page({"view": view, "net": net_content(model)}, title=name)
    return made


def _view(path: Path, title: str, model: sym.SystemModel) -> dict[str, Any]:
    header = header_of([path])
    return TraceCoder(build([path], model, loads_of(model, header)), title).snapshot()


def _record(model: sym.SystemModel, folder: Path) -> None:
    sys.path.insert(0, str(EXAMPLES))
    try:
        record = import_module("record_sorting").record
    finally:
        sys.path.remove(str(EXAMPLES))
    record(model, MODEL, folder)


def _table() -> list[dict[str, Any]]:
    """Return the table of a sweep that was made before: `examples/sorting_sweep.csv`."""
    import csv

    with (EXAMPLES / "sorting_sweep.csv").open(encoding="utf-8", newline="") as file:
        rows: list[dict[str, Any]] = list(csv.DictReader(file))
    for row in rows:
        for name, text in row.items():
            if name in ("complete", "reduced"):
                row[name] = text == "true"
            elif name == "seconds":
                row[name] = float(text)
            elif text.isdecimal():
                row[name] = int(text)
    return rows
