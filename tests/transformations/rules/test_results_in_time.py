"""The time at which clients of actions have the results of goals that overlap, against a plain program."""

from __future__ import annotations

import os
from random import Random

import pytest

from tests.support.timed_systems.goals.results import GoalResults, results_by_time
from tests.transformations.rules.test_times import explored

pytestmark = pytest.mark.usefixtures("own_time")

SEEDS = 40 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
HORIZON = 14


def results_in_net(system: GoalResults) -> set[tuple[int, int]]:
    found = explored(system.model(HORIZON))
    places = found.net.untimed.places
    columns = [places.index(each) for each in ("Now", "Done")]
    return {(int(now), int(done)) for now, done in found.markings[:, columns]}


def require_all(system: GoalResults) -> None:
    """Require that the net can do what the program does, and no more with one goal.

    With a timer, the latter holds if it takes no thread meanwhile: latencies begin again then.
    """
    plain, net = results_by_time(system, HORIZON), results_in_net(system)
    assert plain <= net, (system, sorted(plain - net))
    total = 4 * system.latency + system.work[1]
    if system.goals == 1 and (system.is_engine or system.apart[0] > total):
        assert {pair for pair in net if pair[0] < HORIZON} == {
            pair for pair in plain | {(now - 1, done) for now, done in plain} if 0 <= pair[0] < HORIZON
        }, system


@pytest.mark.parametrize("is_engine", [False, True])
@pytest.mark.parametrize(
    ("goals", "apart", "work", "latency"), [(1, 1, 0, 1), (1, 10, 1, 2), (2, 1, 0, 1), (2, 3, 1, 1)]
)
def test_results_of_short_goals(goals: int, apart: int, work: int, latency: int, is_engine: bool) -> None:
    require_all(GoalResults(goals, (apart, apart), (work, work), latency, 2, is_engine))


@pytest.mark.long
def test_random_systems() -> None:
    for seed in range(SEEDS):
        require_all(GoalResults.drawn(Random(seed)))
