"""Engines side by side: who answers ends the other side, and no process stays behind."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from dineros.analysis.answers import turns
from dineros.analysis.answers.beside import first_of_two
from dineros.analysis.answers.budget import Budget, BudgetExceededError, Progress
from dineros.analysis.answers.turns import Member

TOLD = Progress("nodes", 1, 0)
LARGE = Budget(1 << 30, seconds=60)


def children() -> list[str]:
    return Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()


@pytest.fixture(autouse=True)
def two_cores(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Fork at the first report."""
    monkeypatch.setattr(turns, "SHARE", 0.0)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    before = children()
    yield
    assert children() == before


def member(rounds: int | None, answer: object) -> Member[object]:
    def work(budget: Budget) -> object:
        done = 0
        while rounds is None or done < rounds:
            done += 1
            time.sleep(0.001)
            budget.report(TOLD)
        if isinstance(answer, Exception):
            raise answer
        return os.getpid() if answer == "process" else answer

    return Member(work)


def test_who_knows_ends_the_others() -> None:
    here = os.getpid()
    assert first_of_two([member(3, "process"), member(None, "no")], LARGE) == here
    assert first_of_two([member(None, "no"), member(None, "no"), member(3, "process")], LARGE) != here


@pytest.mark.parametrize(("cores", "left"), [(2, 1), (4, 3)])
def test_the_other_side_leaves_a_core(monkeypatch: pytest.MonkeyPatch, cores: int, left: int) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)))
    beside: Member[object] = Member(lambda budget: budget.share(time=0.5).workers)
    assert first_of_two([member(None, "no"), beside], LARGE) == left
    assert first_of_two([beside], LARGE) == cores


def test_an_answer_that_is_not_final_waits_for_the_other_side() -> None:
    def is_final(answer: object) -> bool:
        return answer == "final"

    for one, other, expected in (
        (member(3, "a way"), member(40, "final"), "final"),
        (member(40, "final"), member(3, "a way"), "final"),
        (member(3, "a way"), member(40, None), "a way"),
        (member(3, None), member(40, "a way"), "a way"),
        (member(0, None), member(3, "a way"), "a way"),  # before the other side begins
        (member(3, None), member(3, None), None),
        (member(3, "a way"), member(3, BudgetExceededError("time")), "a way"),
    ):
        assert first_of_two([one, other], LARGE, is_final) == expected


@pytest.mark.parametrize("position", [0, 1])
def test_an_error_ends_both_sides(position: int) -> None:
    members = [member(None, "no"), member(2, ValueError("broken"))]
    with pytest.raises(ValueError, match="broken"):
        first_of_two(members if position else members[::-1], LARGE)


def test_a_side_that_is_killed_leaves_the_question_to_the_other() -> None:
    def kill(_: Budget) -> object:
        os.kill(os.getpid(), signal.SIGKILL)
        return None

    assert first_of_two([member(100, "here"), Member(kill)], LARGE) == "here"


def test_time_is_kept_by_both_sides() -> None:
    assert first_of_two([member(3, None), member(None, "no")], Budget(1 << 30, seconds=0.3)) is None


def test_one_core_or_little_memory_is_one_process(monkeypatch: pytest.MonkeyPatch) -> None:
    members = [member(None, "no"), member(3, "process")]
    assert first_of_two(members, Budget(1 << 20, seconds=60)) == os.getpid()
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
    assert first_of_two(members, LARGE) == os.getpid()


@pytest.mark.parametrize("marking_bytes", [0, 16])
def test_who_cannot_store_all_markings_gives_way(marking_bytes: int) -> None:
    seen: list[int] = []
    others = len(children())  # of earlier tests of this process

    def known(budget: Budget) -> object:
        for at_least in (0, 1 << 40):
            for _ in range(20):
                time.sleep(0.01)
                budget.report(Progress("nodes", 1, 0, at_least=at_least))
            seen.append(len(children()) - others)
        return "known"

    beside: Member[object] = Member(member(None, "no").work, marking_bytes=marking_bytes)
    assert first_of_two([Member(known), beside], LARGE) == "known"
    assert seen == [1, 0 if marking_bytes else 1]


def test_who_cannot_store_all_markings_does_not_begin_later() -> None:
    def gives_up(budget: Budget) -> object:
        with pytest.raises(BudgetExceededError):
            budget.share(time=0.0).report(Progress("nodes", 1, 0, at_least=1 << 40))
        return None

    beside: Member[object] = Member(lambda budget: "an answer", marking_bytes=16)
    assert first_of_two([Member(gives_up), beside], LARGE) is None
