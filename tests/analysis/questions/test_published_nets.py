"""Coloured nets with published counts: read as PNML, unfolded, and counted."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.models import compile_net
from dineros.analysis.questions.state_space import state_space
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.metamodel.files.pnml import read_pnml
from tests.support.references.coloured import Coloured
from tests.support.references.published_nets import peterson, repeated_requests, safe_bus, shared_memory


@pytest.mark.parametrize(
    ("coloured", "states"),
    [(repeated_requests(2), 7_424), (peterson(2), 20_754), (safe_bus(3), 4_650)],
    ids=["CSRepetitions-02", "Peterson-2", "SafeBus-03"],
)
@pytest.mark.parametrize("engine", ["symbolic", "explicit"])
def test_states_of_the_literature(tmp_path: Path, coloured: Coloured, states: int, engine: str) -> None:
    file = tmp_path / "net.pnml"
    file.write_text(coloured.pnml(), encoding="utf-8")
    space = state_space(compile_net(read_pnml(file)), engine=engine)  # type: ignore[arg-type]
    assert space.complete
    assert space.states == states


def test_deadlocks_are_counted_where_few_small_tests_decide(tmp_path: Path) -> None:
    """What lets one processor go on is looked at before all pairs of a processor and a memory."""
    file = tmp_path / "net.pnml"
    file.write_text(shared_memory(20).pnml(), encoding="utf-8")
    space = state_space(compile_net(read_pnml(file)), engine="symbolic", budget=Budget(seconds=60))
    assert (space.states, space.arcs, space.deadlocks) == (445_146_141_861, 9_197_362_408_860, 0)


@pytest.mark.long
def test_shared_variables_may_be_below_the_processes(tmp_path: Path) -> None:
    """Peterson's algorithm for six processes: those rounds that come last are at the bottom."""
    file = tmp_path / "net.pnml"
    file.write_text(peterson(5).pnml(), encoding="utf-8")
    space = symbolic_state_space(compile_net(read_pnml(file)))
    assert (space.markings, space.arcs(), space.deadlocks()) == (136_561_677_682, 819_370_066_092, 0)
    assert space.search_work < 16_000_000
