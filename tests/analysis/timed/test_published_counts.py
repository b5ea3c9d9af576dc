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

COUNTED = [
    pytest.param(name, kind, marks=[pytest.mark.long] * name.endswith("4"))
    for name, kinds in FIGURES.items()
    for kind in kinds
]
CUT_IN_ANOTHER_ORDER = [("countertrains4", "A")]
"""Not met: 257 858 classes and 3 201 833 edges are found, published are 257 863 and 3 202 032.

Of 88 ways of cutting, 64 give 257 858, and none gives the published figures; see "Orders of cuts" in
``docs/benchmarks.md``. One bound at a time gave as few as 257 844 in another program. Without the
rule that equal classes are one, there are more than 286 000, and the other figures are not met, either.

Both figures can be right. ``test_atomic_graph.py`` finds by other means that all 3 201 833 edges are
stable: each state of a class leads into each class after it. Fewer classes are enough, so the published
graph is not the smallest one. What does not lead there is not convex, and can be cut into convex classes in
several ways; so there is no one coarsest set of them, and the figure belongs to the cuts of one program.
"""

pytestmark = pytest.mark.skipif(not FIGURES, reason="the nets are not beside the project")


@pytest.mark.parametrize(("name", "kind"), COUNTED)
def test_classes_and_edges(name: str, kind: str) -> None:
    net = compile_timed_net(load(FOLDER / "nets" / f"{name}.net"))
    graph = class_graph(net, kind)  # type: ignore[arg-type]
    assert graph.is_complete
    if (name, kind) in CUT_IN_ANOTHER_ORDER:
        assert [graph.classes, graph.edges] == pytest.approx(FIGURES[name][kind], rel=1e-4)
    else:
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
