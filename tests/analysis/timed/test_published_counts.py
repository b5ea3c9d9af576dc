"""Published numbers of state classes and edges (TINA's distribution; Berthomieu and Vernadat, TACAS 2003)."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.analysis.timed.nets import compile_timed_net
from dineros.analysis.timed.search import class_graph
from dineros.metamodel.files import load

FOLDER = Path(__file__).resolve().parents[4] / "shared/tpn"
FIGURES = json.loads((FOLDER / "expected.json").read_text())["figures"] if FOLDER.exists() else {}

COUNTED = [(name, kind) for name, kinds in FIGURES.items() for kind in kinds if kind in "WMSE"]

pytestmark = pytest.mark.skipif(not FIGURES, reason="the nets are not beside the project")


@pytest.mark.parametrize(("name", "kind"), COUNTED)
def test_classes_and_edges(name: str, kind: str) -> None:
    net = compile_timed_net(load(FOLDER / "nets" / f"{name}.net"))
    graph = class_graph(net, kind)  # type: ignore[arg-type]
    assert graph.is_complete
    assert [graph.classes, graph.edges] == FIGURES[name][kind]
