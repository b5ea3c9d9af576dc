"""Witnesses that repeat are printed once, and firings are put in an order in which they repeat."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.asking import find_marking
from dineros.analysis.questions.formulas import verify_linear
from dineros.analysis.witnesses.folding import folded, in_rounds
from dineros.analysis.witnesses.witness import pumping_witness
from dineros.metamodel import pn

TEXT = st.text(alphabet="abc", max_size=60)


def unfolded(items: str) -> str:
    return "".join(items[block.start : block.start + block.length] * block.times for block in folded(items))


@given(TEXT, TEXT, st.integers(1, 9))
def test_blocks_say_the_same(one: str, other: str, times: int) -> None:
    text = one + other * times + one
    assert unfolded(text) == text


def test_the_longest_repetition_is_named_once() -> None:
    text = "xy" + "abcdefgh" * 12 + "z"
    assert [(block.length, block.times) for block in folded(text)] == [(1, 1), (1, 1), (8, 12), (1, 1)]
    assert [(block.length, block.times) for block in folded("aaab")] == [(1, 1)] * 4


MAKE = CompiledNet.build(
    {"on": 1, "due": 0, "busy": 0, "queue": 0},
    [
        Transition("tick", {"on": 1}, {"on": 1, "due": 1}),
        Transition("begin", {"due": 1}, {"busy": 1}),
        Transition("end", {"busy": 1}, {"queue": 1}),
        Transition("lose", {"queue": 10}, {"queue": 10}),
    ],
)


@pytest.mark.parametrize("seed", range(5))
def test_ten_rounds_in_any_order_become_one(seed: int) -> None:
    rng, marking, trace = random.Random(seed), [1, 0, 0, 0], []
    left = {0: 10, 1: 10, 2: 10}
    while any(left.values()):
        t = rng.choice([t for t, count in left.items() if count and MAKE.is_enabled(t, marking)])
        left[t] -= 1
        trace.append(t)
        marking = MAKE.fire(t, marking)
    ordered = in_rounds(MAKE, [*trace, 3])
    assert sorted(ordered) == sorted([*trace, 3])
    assert ordered[-1] == 3
    assert replay(MAKE, ordered)[-1] == replay(MAKE, [*trace, 3])[-1]
    assert sum(block.length for block in folded(ordered)) <= 4


PASSING = CompiledNet.build(
    {"idle": 1, "busy": 0, "sent": 0, "ready": 1, "took": 0, "done": 0},
    [
        Transition("begin", {"idle": 1}, {"busy": 1}),
        Transition("send", {"busy": 1}, {"idle": 1, "sent": 1}),
        Transition("take", {"sent": 1, "ready": 1}, {"took": 1}),
        Transition("finish", {"took": 1}, {"ready": 1, "done": 1}),
        Transition("grow", {"done": 12}, {"done": 13}),
    ],
)


def mixed_rounds(times: int) -> list[int]:
    """Return that many rounds of the net, in any order."""
    rng, marking, mixed = random.Random(7), [1, 0, 0, 1, 0, 0], list[int]()
    left = dict.fromkeys(range(4), times)
    while any(left.values()):
        t = rng.choice([t for t, count in left.items() if count and PASSING.is_enabled(t, marking)])
        left[t] -= 1
        mixed.append(t)
        marking = PASSING.fire(t, marking)
    return mixed


def test_a_way_to_growth_comes_in_rounds() -> None:
    """Twelve rounds lead to the marking in which what repeats begins, in an order that folds."""
    mixed = mixed_rounds(12)
    witness = pumping_witness(Subject(pn.Net(id="passing"), PASSING), Pumping(tuple(mixed), (4,), (5,)))
    fired = [PASSING.transitions.index(step.transition) for step in witness.steps]
    assert witness.loop == len(mixed)
    assert sorted(fired[: witness.loop]) == sorted(mixed)
    assert fired[witness.loop :] == [4]
    assert replay(PASSING, fired[: witness.loop])[-1] == replay(PASSING, mixed)[-1]
    assert sum(block.length for block in folded(mixed)) > 20
    assert sum(block.length for block in folded(fired[: witness.loop])) <= 8


@pytest.mark.parametrize("asked", ["find", "verify"])
def test_ways_to_a_marking_come_in_rounds(asked: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever order the search finds."""
    mixed = mixed_rounds(12)
    goal, names = "done >= 12", NetNames(PASSING)
    answer = Outcome("reachable", trace=tuple(mixed))
    assert replay(PASSING, mixed)[-1][-1] == 12
    monkeypatch.setattr("dineros.analysis.portfolio.asking.answered", lambda *_: answer)
    if asked == "find":
        found = find_marking(PASSING, goal, names)
    else:
        found = verify_linear(PASSING, f"G !({goal})", names)
        assert found.status == "violated"
    assert sum(block.length for block in folded(mixed)) > 20
    assert sum(block.length for block in folded(found.stem)) <= 8
    assert replay(PASSING, found.stem)[-1][-1] == 12
