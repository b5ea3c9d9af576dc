"""Answers about nets with time, decided again: true ones are confirmed, false ones are noticed."""

from __future__ import annotations

from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.answers.budget import UNLIMITED
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.evidence.timed_confirmation import (
    COUNTED,
    ONLY_ATOMIC,
    STRONG,
    confirm_timed_answer,
)
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.questions.engines import Timed
from dineros.analysis.questions.net_questions import Branching, Enabled, Linear, Marking, Question
from dineros.analysis.timed.branching_time import check_timed_ctl
from dineros.analysis.timed.nets import Interval, TimedNet
from tests.analysis.timed.test_linear_time import FORMULAS
from tests.analysis.timed.time_nets import RandomNet, lively_net


def questions(net: RandomNet, random: Random) -> list[Question]:
    """Return one question of each kind that can be decided again."""
    plain, names = net.net.untimed, NetNames(net.net.untimed)
    places, transitions = plain.places, plain.transitions
    tokens = f"{random.choice(places)} + {random.choice(places)} >= {random.randint(1, 3)}"
    return [
        Marking(plain, names, tokens),
        Marking(plain, names, f"enabled({random.choice(transitions)}) & !({tokens})"),
        Marking(plain, names, f"deadlock & {random.choice(places)} >= 1"),
        Enabled(plain, names, random.choice(transitions)),
        Linear(plain, names, f"G !({tokens})"),
        Linear(plain, names, random.choice(FORMULAS)),
    ]


def opposite(answer: Outcome) -> Outcome:
    other = {"reachable": "unreachable", "unreachable": "reachable", "holds": "violated", "violated": "holds"}
    return Outcome(other[answer.status])


@pytest.mark.long
@pytest.mark.parametrize("part", range(4))
def test_random_nets(part: int) -> None:
    """True answers are confirmed, false ones are not, by whoever can decide the question."""
    who: set[str] = set()
    for seed in range(part, 40, 4):
        net = lively_net(Random(8_000 + seed), is_closed=seed % 2 == 0, most=800)
        for question in questions(net, Random(seed)):
            answer = Timed(net.net).answer(question, UNLIMITED)
            told = confirm_timed_answer(net.net, question, Outcome(answer.status))
            assert told.agrees is True, (seed, question, told)
            lie = confirm_timed_answer(net.net, question, opposite(answer))
            assert lie.agrees is False, (seed, question, lie)
            who.update(word.partition(" (")[0] for word in told.by)
    assert who == {COUNTED, STRONG}


def test_who_decides() -> None:
    net = lively_net(Random(3), is_closed=True, most=800)
    plain, names = net.net.untimed, NetNames(net.net.untimed)
    told = confirm_timed_answer(net.net, Marking(plain, names, "p0 >= 100"), Outcome("unreachable"))
    assert told.agrees and told.by[0].startswith(COUNTED)
    told = confirm_timed_answer(net.net, Linear(plain, names, "G p0 <= 100"), Outcome("holds"))
    assert told.agrees and told.by[0].startswith(COUNTED)
    told = confirm_timed_answer(
        net.net, Marking(plain, names, "p0 >= 100 & deadlock"), Outcome("unreachable")
    )
    assert told.agrees and told.by[0].startswith(STRONG)
    for formula, status in (("AG p0 <= 100", "holds"), ("EF p0 > 100", "violated")):
        told = confirm_timed_answer(net.net, Branching(plain, names, formula), Outcome(status))
        assert told.agrees and told.by[0].startswith(COUNTED)
        lie = opposite(Outcome(status))
        assert confirm_timed_answer(net.net, Branching(plain, names, formula), lie).agrees is False
    told = confirm_timed_answer(net.net, Branching(plain, names, "AG EF p0 <= 100"), Outcome("holds"))
    assert (told.agrees, told.reason) == (None, ONLY_ATOMIC)
    told = confirm_timed_answer(net.net, Linear(plain, names, "G[<=3] p0 <= 100"), Outcome("holds"))
    assert told.agrees and told.by[0].startswith(STRONG)


def test_whole_units_of_time_do_not_keep_what_can_come_next() -> None:
    """Why CTL is not confirmed by counted time: this formula is true if `go` fires between 0 and 1 only.

    After `go` at x, `left` fires at 1 + x. At x = 0 it may come before `early`, at x = 1 after `late`. In
    whole units `go` fires at 0 or at 1, and all that follows has one moment.
    """
    steps = [
        Transition("go", {"start": 1}, {"gone": 1}),
        Transition("early", {"soon": 1}, {"first": 1}),
        Transition("left", {"gone": 1}, {"a": 1}),
        Transition("late", {"wait": 1}, {"b": 1}),
    ]
    one, two = Fraction(1), Fraction(2)
    times = {"go": Interval(Fraction(0), one), "early": Interval(one, one)}
    times |= {"left": Interval(one, one), "late": Interval(two, two)}
    places = {"start": 1, "gone": 0, "soon": 1, "first": 0, "wait": 1, "a": 0, "b": 0}
    between = "EF (gone == 1 & soon == 1 & AX (first == 1 & a == 0 & AX (a == 1)))"
    assert check_timed_ctl(TimedNet.build(places, steps, times), between).status == "holds"
    for whole in (Fraction(0), one):
        times["go"] = Interval(whole, whole)
        assert check_timed_ctl(TimedNet.build(places, steps, times), between).status == "violated"


def test_strong_classes_do_not_confirm_themselves() -> None:
    net = next(
        found
        for seed in range(100)
        if (found := lively_net(Random(seed), has_priorities=True, most=800)).net.has_priorities
    )
    question = Marking(net.net.untimed, NetNames(net.net.untimed), "p0 >= 100")
    assert confirm_timed_answer(net.net, question, Outcome("unreachable")).agrees is None
