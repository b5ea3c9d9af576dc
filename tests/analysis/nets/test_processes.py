"""Groups of places with one token stay within processes, even if transitions move all of them at once."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.state_machines import processes, state_machines
from dineros.analysis.symbolic.engine import symbolic_state_space
from tests.analysis import classic_nets as classic
from tests.analysis.reference_search import reference_search


def _moved_together(workers: int, pool: int = 0) -> CompiledNet:
    """Workers that a transition moves at once, twice; some of them need tokens of a pool between."""
    places = {"begin": 1, "middle": 0, "end": 0, "pool": pool}
    rows: list[Transition] = []
    for i in range(workers):
        places |= {f"idle{i}": 1, f"called{i}": 0, f"works{i}": 0, f"ready{i}": 0, f"fails{i}": 0}
        rows.append(Transition(f"work{i}", {f"called{i}": 1}, {f"works{i}": 1}))
        rows.append(Transition(f"stop{i}", {f"works{i}": 1}, {f"ready{i}": 1}))
        rows.append(Transition(f"fail{i}", {f"works{i}": 1, "pool": 1}, {f"fails{i}": 1}))
    everyone = range(workers)
    rows.append(
        Transition(
            "call",
            {"begin": 1, **{f"idle{i}": 1 for i in everyone}},
            {"middle": 1, **{f"called{i}": 1 for i in everyone}},
        )
    )
    rows.append(
        Transition(
            "collect",
            {"middle": 1, **{f"ready{i}": 1 for i in everyone}},
            {"end": 1, **{f"idle{i}": 1 for i in everyone}},
        )
    )
    return CompiledNet.build(places, rows)


@pytest.mark.parametrize("workers", [4, 6, 20])
def test_groups_stay_within_processes_that_move_together(workers: int) -> None:
    net = _moved_together(workers, pool=2)
    steps = [{f"{step}{i}" for step in ("called", "works", "ready", "fails")} for i in range(workers)]
    assert [{net.places[p] for p in process} for process in processes(net)] == steps
    groups = [{net.places[p] for p in group} for group in state_machines(net, range(len(net.places)))]
    for own in steps:
        assert sum(not own.isdisjoint(group) for group in groups) == 1


def test_places_of_neighbours_are_no_processes() -> None:
    assert processes(classic.philosophers(6)) == []
    assert processes(CompiledNet.build({"a": 1}, [])) == []
    assert processes(CompiledNet.build({}, [])) == []


@given(st.integers(3, 4), st.integers(0, 2))
@settings(max_examples=10, deadline=None)
def test_counts_of_processes_that_move_together(workers: int, pool: int) -> None:
    net = _moved_together(workers, pool)
    expected = reference_search(net)
    space = symbolic_state_space(net)
    assert expected is not None
    assert (space.markings, space.arcs(), space.deadlocks()) == expected[:3]
