"""Pictures of nets in the guide, drawn by the tool itself while the guide is built."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from dineros.metamodel.files import load
from dineros.metamodel.settings import apply
from dineros.views.nets import (
    ViewModel,
    around,
    collapse,
    collapse_to_read,
    compare,
    layout,
    to_html,
    to_svg,
    view_of,
    with_badges,
)

CASE_STUDY = Path(__file__).resolve().parents[2] / "case_study" / "sorting.sym.xmi"
PARTS = {
    "RedObjects": "1",
    "BlueObjects": "1",
    "GreenObjects": "1",
    "RobotControllerL": "2",
    "RobotControllerR": "2",
    "GetControlServer": "3",
    "ControlState": "4",
    "EndControlServer": "5",
    "PickServer": "6",
    "PlaceServer": "6",
    "Safety": "7",
    "TPick": "8",
    "TPlace": "8",
    "sensorics": "9",
    "TSense": "10",
    "feedback": "11",
}
"""The numbers of the paper's Fig. 14 by element of the case study."""


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the pictures to the guide; the hook that MkDocs calls."""
    for path, content in pictures().items():
        files.append(File.generated(config, path, content=content))
    return files


@cache
def pictures() -> dict[str, str]:
    """Return the content of every picture and page by its path in the guide."""
    whole = _case_study()
    views = {
        "overview": collapse(whole),
        "case-study": with_badges(whole, PARTS),
        "around": around(whole, ["TStop"], 2),
        "compared": around(
            compare(
                whole,
                _case_study("LeftCellObjects.publisher.SortRed.limit=5", "SelectBlue.clause=Blue & !Red"),
            ),
            ["SelectRed", "SelectBlue"],
            2,
        ),
    }
    made = {}
    for name, view in views.items():
        positioned = layout(view)
        made[f"pictures/net-{name}.svg"] = to_svg(positioned)
        made[f"pictures/net-{name}-dark.svg"] = to_svg(positioned, theme="dark")
    made["pictures/sorting.html"] = to_html(collapse_to_read(with_badges(whole, PARTS)))
    return made


def _case_study(*settings: str) -> ViewModel:
    model = load(CASE_STUDY)
    for setting in settings:
        apply(model, setting)
    return view_of(model)
