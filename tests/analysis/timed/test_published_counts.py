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
"""Where a class is cut by several bounds, their order may matter a little: 257 858 classes, not 257 863."""

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


def test_atomic_classes_of_two_trains() -> None:
    """The figure of the paper, which started from the largest strong classes."""
    graph = class_graph(compile_timed_net(load(FOLDER / "nets" / "trains2.net")), "A")
    assert (graph.classes, graph.edges) == (192, 844)
