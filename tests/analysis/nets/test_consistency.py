"""Consistent nets: some firings, each transition at least once, change nothing; semiflows bound them best."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.optimize import linprog

from dineros.analysis.nets.bounds import flows_and_bounds, place_bounds
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.linear_programs import LinearProgram
from dineros.analysis.nets.semiflows import is_consistent
from tests.analysis import classic_nets as classic
from tests.analysis.strategies import nets


def has_repetition(net: CompiledNet) -> bool:
    """Return whether numbers of firings, at least 1 of each transition, add up to no change."""
    change = np.zeros((len(net.places), len(net.transitions)))
    for transition, row in enumerate(net.delta):
        for place, tokens in row.items():
            change[place, transition] = tokens
    found = linprog(
        np.zeros(len(net.transitions)), A_eq=change, b_eq=np.zeros(len(net.places)), bounds=(1, None)
    )
    return bool(found.status == 0)


def with_reverses(net: CompiledNet) -> CompiledNet:
    """Return the net with a transition for each one that undoes it."""
    places, transitions = net.by_names()
    back = [Transition(f"{each.name} back", each.outputs, each.inputs) for each in transitions]
    return CompiledNet.build(places, [*transitions, *back])


@settings(max_examples=200, deadline=None)
@given(nets())
def test_consistency_is_that_of_a_linear_program(net: CompiledNet) -> None:
    assert is_consistent(net) is has_repetition(net)
    assert is_consistent(with_reverses(net))


@settings(max_examples=100, deadline=None)
@given(nets())
def test_semiflows_bound_consistent_nets_as_tightly_as_programs(net: CompiledNet) -> None:
    net = with_reverses(net)
    for bound, other in zip(flows_and_bounds(net)[1], place_bounds(net), strict=True):
        assert (bound and bound.value) == (other and other.value)


@pytest.mark.parametrize(
    "net", [classic.kanban(5), classic.flexible_manufacturing(5), classic.swimming_pool(2)]
)
def test_bounds_of_consistent_nets_take_no_linear_program(
    net: CompiledNet, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The solver takes longer to load than these nets take in all."""

    def refused(*_: object) -> None:
        raise AssertionError("a linear program was solved")

    monkeypatch.setattr(LinearProgram, "solve", refused)
    assert all(bound is not None for bound in flows_and_bounds(net)[1])


def test_much_work_is_not_done() -> None:
    assert is_consistent(classic.kanban(5))
    assert not is_consistent(classic.kanban(5), most_work=10)
