"""Published numbers of state classes and edges (TINA's distribution; Berthomieu and Vernadat, TACAS 2003)."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.analysis.timed.graph import class_graph
from dineros.analysis.timed.nets import compile_timed_net
from dineros.metamodel.files import load

FOLDER = Path(__file__).resolve().parents[4] / "shared/tpn"
FIGURES = json.loads((FOLDER / "expected.json").read_text())["figures"] if FOLDER.exists() else {}

COUNTED_ELSEWHERE = [("countertrains4", "A")]
"""``test_atomic_graph.py`` makes this graph and compares its figures, which saves 17 s of the processor."""

COUNTED = [
    pytest.param(name, kind, marks=[pytest.mark.long] * name.endswith("4"))
    for name, kinds in FIGURES.items()
    for kind in kinds
    if (name, kind) not in COUNTED_ELSEWHERE
]

pytestmark = pytest.mark.skipif(not FIGURES, reason="the nets are not beside the project")


@pytest.mark.parametrize(("name", "kind"), COUNTED)
def test_classes_and_edges(name: str, kind: str) -> None:
    net = compile_timed_net(load(FOLDER / "nets" / f"{name}.net"))
    graph = class_graph(net, kind)  # type: ignore[arg-type]
    assert graph.is_complete
    assert [graph.classes, graph.edges] == FIGURES[name][kind]


@pytest.mark.parametrize(
    ("name", "figures"),
    [
        ("trains2", (192, 844)),
        ("trains3", (6_966, 49_802)),
        pytest.param("trains4", (356_940, 3_447_624), marks=pytest.mark.long),
    ],
)
def test_atomic_classes_of_trains(name: str, figures: tuple[int, int]) -> None:
    """Those of two trains are the paper's. The others were counted by this program: a change is noticed."""
    graph = class_graph(compile_timed_net(load(FOLDER / "nets" / f"{name}.net")), "A")
    assert (graph.classes, graph.edges) == figures
