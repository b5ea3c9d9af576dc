"""One budget, and what its stages get of it."""

from __future__ import annotations

import time

import pytest

from dineros.analysis.answers.apart import Apart
from dineros.analysis.answers.budget import (
    DEFAULT_MEMORY,
    UNLIMITED,
    Budget,
    BudgetExceededError,
    Progress,
    processor_seconds,
)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return a clock that stands still, in a list, to be set; the processor has worked all the time."""
    now = [100.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
    monkeypatch.setattr(time, "process_time", lambda: now[0] - 90.0)
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


def test_stages_have_their_share_on_a_busy_machine(
    clock: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stage that got half of the processor may work on; the whole ends by the clock."""
    monkeypatch.setattr(time, "process_time", lambda: clock[0] / 2)
    whole = Budget(seconds=20).begun()
    stage = whole.share(time=0.25)
    assert stage.left == 5
    clock[0] += 6
    assert (stage.left, stage.share(time=0.5).left) == (2, 1)
    clock[0] += 4
    assert (stage.is_over, whole.left) == (True, 10)
    last = whole.at_most(8)
    clock[0] += 10
    assert last.is_over  # 5 seconds of the processor, but the whole is over


def test_a_large_share_leaves_the_rest_on_a_busy_machine(
    clock: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time, "process_time", lambda: clock[0] / 10)
    whole = Budget(seconds=20).begun()
    stage = whole.share(time=0.75)
    clock[0] += 15
    assert (stage.is_over, whole.left) == (True, 5)


def test_a_stage_that_waits_ends(clock: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    """What waits takes no time of the processor; its stage is limited by the clock nevertheless."""
    monkeypatch.setattr(time, "process_time", lambda: 1.0)
    stage = Budget(seconds=100).begun().at_most(2)
    clock[0] += 7
    assert stage.left == 1
    clock[0] += 1
    assert stage.is_over


def test_a_forked_process_continues_the_seconds_of_its_parent() -> None:
    until = time.process_time() + 0.05
    while time.process_time() < until:
        pass
    before = processor_seconds()
    with Apart(lambda _: processor_seconds()) as apart:
        list(apart.messages())
        assert apart.value() >= before


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
