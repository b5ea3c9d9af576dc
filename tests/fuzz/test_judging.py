"""The judge of fuzzing finds what it is there for."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError
from tests.fuzz import judging
from tests.fuzz.judging import Outcome, judge, refused_or


def hang(content: bytes) -> Outcome:
    while True:
        pass


def take_memory(content: bytes) -> Outcome:
    # Far more than allowed: meanwhile the system may take back memory that earlier tests used.
    return Outcome(len(bytearray(judging.MEMORY + (512 << 20))) * 0)


def fail(content: bytes) -> Outcome:
    return refused_or(lambda: int("x"))


def refuse(content: bytes) -> Outcome:
    def work() -> None:
        raise DinerosError("no", hint="yes")

    return refused_or(work)


@pytest.mark.parametrize(
    ("attempt", "said"),
    [
        (hang, "hangs"),
        (fail, "ValueError"),
        (lambda _: Outcome(4), "exit status 4"),
        (lambda _: Outcome(2), "without a word"),
        (lambda _: Outcome(2, "a: b\n  c\n"), "more than lines"),
        (lambda _: Outcome(1, "Traceback (most recent call last)\n"), "Traceback"),
        (lambda _: Outcome(2, "dineros: unexpected KeyError: 3 (please report it)\n"), "unexpected"),
        (refuse, None),
    ],
)
def test_faults(
    monkeypatch: pytest.MonkeyPatch, attempt: Callable[[bytes], Outcome], said: str | None
) -> None:
    monkeypatch.setattr(judging, "CPU_SECONDS", 0.2)
    fault = judge(attempt, b"").fault
    assert fault is None if said is None else said in str(fault)


def test_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(judging, "MEMORY", 50 << 20)
    assert "memory: " in str(judge(take_memory, b"").fault)


def test_left_over_files(tmp_path: Path) -> None:
    (tmp_path / ".x.dineros-tmp").touch()
    assert "left over" in str(judge(refuse, b"", tmp_path).fault)
