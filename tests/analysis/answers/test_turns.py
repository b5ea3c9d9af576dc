"""Engines that take turns: who answers, who waits, and what ends all of them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator

import pytest

from dineros.analysis.answers import turns
from dineros.analysis.answers.budget import Budget, BudgetExceededError, Progress
from dineros.analysis.answers.turns import Member, first_answer

TOLD = Progress("nodes", 1, 0)


@pytest.fixture(autouse=True)
def short_shares(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let the turn change at every report; no thread may be left."""
    monkeypatch.setattr(turns, "SHARE", 0.0)
    before = threading.active_count()
    yield
    assert threading.active_count() == before


def counting(
    seen: list[str], name: str, rounds: int | None, answer: str | None
) -> Callable[[Budget], str | None]:
    def work(budget: Budget) -> str | None:
        done = 0
        while rounds is None or done < rounds:
            seen.append(name)
            done += 1
            time.sleep(0.001)  # the clock of the processor is no finer
            sum(range(20_000))
            budget.report(TOLD)
        return answer

    return work


def test_one_that_never_ends_does_not_keep_the_other_from_answering() -> None:
    seen: list[str] = []
    members = [Member(counting(seen, "slow", None, None)), Member(counting(seen, "quick", 5, "found"))]
    assert first_answer(members, Budget()) == "found"
    assert seen.count("quick") == 5
    assert 5 <= seen.count("slow") <= 7
    assert seen[:4] == ["slow", "quick", "slow", "quick"]


def test_an_answer_that_is_not_final_waits_for_the_others() -> None:
    seen: list[str] = []
    members = [Member(counting(seen, "first", 1, "a way")), Member(counting(seen, "second", 4, "no way"))]
    assert first_answer(members, Budget(), lambda answer: answer == "no way") == "no way"
    members = [Member(counting(seen, "first", 1, "a way")), Member(counting(seen, "second", 4, None))]
    assert first_answer(members, Budget(), lambda answer: answer == "no way") == "a way"


def test_nobody_answers() -> None:
    seen: list[str] = []
    members = [Member(counting(seen, "a", 2, None)), Member(counting(seen, "b", 3, None))]
    assert first_answer(members, Budget()) is None


@pytest.mark.parametrize("position", [0, 1])
def test_an_error_ends_all(position: int) -> None:
    def fail(budget: Budget) -> str:
        budget.report(TOLD)
        raise ValueError("broken")

    members = [Member(counting([], "a", None, None)), Member(fail)]
    with pytest.raises(ValueError, match="broken"):
        first_answer(members if position else members[::-1], Budget())


def test_an_interruption_ends_all() -> None:
    told: list[Progress] = []

    def interrupt(progress: Progress) -> None:
        told.append(progress)
        if len(told) > 5 and threading.current_thread() is threading.main_thread():
            raise KeyboardInterrupt

    members = [Member(counting([], "a", None, None)), Member(counting([], "b", None, None))]
    with pytest.raises(KeyboardInterrupt):
        first_answer(members, Budget(progress=interrupt))


def test_time_ends_all_and_memory_is_divided() -> None:
    memories: list[int | None] = []

    def work(budget: Budget) -> str:
        memories.append(budget.memory_bytes)
        while True:
            budget.report(TOLD)

    assert first_answer([Member(work), Member(work)], Budget(1 << 20, seconds=0.2)) is None
    assert memories == [1 << 19, 1 << 19]
    with pytest.raises(BudgetExceededError):
        first_answer([Member(work)], Budget(seconds=0.05))
