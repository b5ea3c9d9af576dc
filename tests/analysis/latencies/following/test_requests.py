"""Response times of a service that goals call, against a plain program: each slot has a request under way."""

from __future__ import annotations

import os
from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import Latencies
from dineros.metamodel import sym
from dineros.metamodel.elements import find
from tests.support.timed_systems.goals.calls import Explorer, GoalCalls

pytestmark = pytest.mark.usefixtures("own_time")

SEEDS = 200 * int(os.environ.get("DINEROS_EXAMPLES", "1"))


def require_equal(system: GoalCalls, is_shared: bool, seconds: float = 60) -> bool:
    """Require exact times of the plain program, and bounds not below; return whether the search ended."""
    facts = Explorer(system, 100_000)
    assert facts.response is not None
    model = system.model(is_shared)
    look = find(model, "Look", sym.CallbackPage)
    assert look is not None
    bound = Bounds(model).response(look).greatest
    assert bound is None or bound.value >= facts.response[1], system
    found = Latencies(model, Budget(seconds=seconds)).response(look)
    if found.least is None or found.greatest is None:
        return False
    times = found.least.value, found.greatest.value
    if is_shared:
        assert times == tuple(map(Fraction, facts.response)), system
    else:  # each slot is a client of its own, and the order of requests of several clients is open
        assert times[0] <= facts.response[0] and times[1] >= facts.response[1], system
    return True


@pytest.mark.parametrize("is_shared", [False, True])
@pytest.mark.parametrize(
    "system",
    [
        GoalCalls(2, 0, (1, 1), (0, 1), (2, 2), 2, (0, 0), (1, 1)),
        GoalCalls(3, 0, (0, 0), (0, 1), (1, 2), 3, (0, 1), (0, 0)),
        GoalCalls(3, 1, (1, 1), (0, 0), (2, 3), 2, (0, 2), (1, 1)),
    ],
)
def test_requests_of_slots_wait_for_each_other(system: GoalCalls, is_shared: bool) -> None:
    assert require_equal(system, is_shared)


@pytest.mark.long
@pytest.mark.parametrize("is_shared", [False, True])
def test_random_systems(is_shared: bool) -> None:
    drawn = (GoalCalls.drawn(Random(seed)) for seed in range(SEEDS))
    compared = sum(require_equal(system, is_shared, seconds=3) for system in drawn)
    assert compared > SEEDS * 0.8
