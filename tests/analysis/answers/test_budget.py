"""One budget, and what its stages get of it."""

from __future__ import annotations

import time

import pytest

from dineros.analysis.answers.budget import DEFAULT_MEMORY, UNLIMITED, Budget, BudgetExceededError, Progress


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return a clock that stands still, in a list, to be set."""
    now = [100.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
    return now


def test_time_runs_from_the_beginning_on(clock: list[float]) -> None:
    budget = Budget(seconds=10)
    clock[0] += 5
    assert (budget.left, budget.spent) == (10, 0)
    begun = budget.begun()
    clock[0] += 4
    assert (begun.left, begun.spent, begun.begun() is begun) == (6, 4, True)
    clock[0] += 7
    assert begun.is_over
    with pytest.raises(BudgetExceededError, match="time ran out"):
        begun.check_time()


def test_stages_share_one_deadline(clock: list[float]) -> None:
    whole = Budget(memory_bytes=1000, states=50, seconds=10).begun()
    clock[0] += 2
    stage = whole.share(time=0.25, memory=0.5, most_states=20)
    assert (stage.memory_bytes, stage.states, stage.seconds, stage.left) == (500, 20, 2, 2)
    clock[0] += 3
    assert (stage.is_over, whole.left) == (True, 5)
    rest = whole.share(most_bytes=100)
    assert (rest.memory_bytes, rest.states, rest.deadline, rest.seconds) == (100, 50, whole.deadline, 10)


def test_no_limit_is_never_exceeded() -> None:
    budget = UNLIMITED.begun().share(time=0.1, memory=0.1)
    assert (budget.left, budget.is_over, budget.memory_bytes, budget.memory) == (
        None,
        False,
        None,
        DEFAULT_MEMORY,
    )
    budget.check_memory(1 << 60)
    budget.report(Progress("states", 1 << 40, 1 << 40))


def test_states_of_a_diagram_are_no_states() -> None:
    told: list[str] = []
    budget = Budget(states=10, progress=lambda progress: told.append(str(progress)))
    budget.report(Progress("nodes", 11, 3 << 20))
    with pytest.raises(BudgetExceededError, match="states: more than 10"):
        budget.report(Progress("markings", 1100, 1 << 20, 5000.0))
    assert told == ["11 nodes, 3 MiB", "1,100 markings, 5,000/s, 1 MiB"]
    with pytest.raises(BudgetExceededError, match="memory ran out: more than 1 MiB needed"):
        Budget(1 << 20).check_memory(1 << 21)


def test_a_budget_without_a_limit_gets_one() -> None:
    unlimited, limited = Budget().unless_limited(2), Budget(seconds=9).unless_limited(2)
    assert unlimited.left is not None and unlimited.left <= 2
    assert limited.left is not None and 2 < limited.left <= 9
