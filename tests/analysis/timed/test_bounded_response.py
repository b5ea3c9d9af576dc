"""Formulas that bound times against a search through time in small steps, which keeps all obligations."""

from __future__ import annotations

from collections import deque
from fractions import Fraction
from random import Random
from typing import TypeAlias

import pytest

from dineros.analysis.logic.language.bounded import Bounded, read_bounded
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.syntax import Comparison, Fired, Formula, Not
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.timed.durations.bounded_response import decide_bounded
from dineros.analysis.timed.nets import Interval, TimedNet
from tests.analysis.timed.time_nets import RandomNet, lively_net

STEPS = 2
"""Steps in a unit of time: enough for bounds of nets that are whole and closed, and whole windows."""

MOST = 60_000
Marking: TypeAlias = tuple[int, ...]
State: TypeAlias = tuple[Marking, tuple[tuple[int, int], ...], frozenset[int]]


class TooLargeError(Exception):
    """The reference has too many states."""


def is_violated(net: RandomNet, formula: Bounded, units: int = 1) -> bool:
    """Whether a run violates a formula: each obligation is kept with its age, in steps.

    `units` of the formula are one of the net.
    """
    transitions = net.transitions
    low, high = (int(bound * STEPS * units) for bound in (formula.window.earliest, formula.window.latest))

    def is_in(age: int) -> bool:
        below = age > low if formula.window.is_open_below else age >= low
        return below and (age < high if formula.window.is_open_above else age <= high)

    def is_past(age: int) -> bool:
        return age >= high if formula.window.is_open_above else age > high

    def holds(condition: Formula, marking: Marking, fired: int | None) -> bool:
        if isinstance(condition, Not):
            return not holds(condition.operand, marking, fired)
        if isinstance(condition, Fired):
            return fired is not None and transitions[fired].name == condition.name.text
        assert isinstance(condition, Comparison) and condition.operator == ">="
        ((_, name),) = condition.terms
        return marking[int(name.text[1:])] >= condition.bound

    def is_of_step(condition: Formula) -> bool:
        return any(isinstance(part, Fired) for part in condition.subformulas())

    def looked(ages: frozenset[int], marking: Marking, fired: int | None) -> frozenset[int] | None:
        """Look at a moment, or at a firing; None where the formula is violated."""
        if is_of_step(formula.condition) == (fired is not None):
            is_met = holds(formula.condition, marking, fired)
            if formula.always and not is_met and any(is_in(age) for age in ages):
                return None
            if not formula.always and is_met:
                ages = frozenset(age for age in ages if not is_in(age))
        return ages

    def began(ages: frozenset[int], marking: Marking, fired: int | None) -> frozenset[int]:
        """Add an obligation that begins at a moment, or with a firing."""
        trigger = formula.trigger
        if (
            trigger is None
            or is_of_step(trigger) != (fired is not None)
            or not holds(trigger, marking, fired)
        ):
            return ages
        return ages | {0}

    def at_moment(state: State) -> State | None:
        marking, clocks, ages = state
        ages = began(ages, marking, None)
        after = looked(ages, marking, None)
        return None if after is None else (marking, clocks, after)

    def enabled(marking: Marking) -> list[int]:
        return [t for t, one in enumerate(transitions) if one.is_enabled(marking)]

    first = frozenset({0}) if formula.trigger is None else frozenset()
    start = at_moment((net.initial, tuple((t, 0) for t in enabled(net.initial)), first))
    if start is None:
        return True
    known, queue = {start}, deque([start])
    while queue:
        marking, clocks, ages = queue.popleft()
        after: list[State | None] = []
        ready = {t for t, clock in clocks if clock >= transitions[t].earliest * STEPS}
        if all(
            transitions[t].latest is None or clock + 1 <= transitions[t].latest * STEPS  # type: ignore[operator]
            for t, clock in clocks
        ):
            older = frozenset(age + 1 for age in ages)
            if not formula.always and any(is_past(age) for age in older):
                return True
            later = tuple((t, min(c + 1, (transitions[t].beyond + 1) * STEPS)) for t, c in clocks)
            after.append(at_moment((marking, later, frozenset(age for age in older if not is_past(age)))))
        for t in ready:
            one = transitions[t]
            if one.above & ready:
                continue
            between = list(marking)
            for p, w in one.take.items():
                between[p] -= w
            new = list(between)
            for p, w in one.put.items():
                new[p] += w
            kept = dict(clocks)
            made = tuple(
                (u, kept[u] if u != t and u in kept and transitions[u].is_enabled(tuple(between)) else 0)
                for u in enabled(tuple(new))
            )
            left = fired_ages(formula, looked, began, ages, marking, t, holds, is_of_step, is_in)
            after.append(None if left is None else at_moment((tuple(new), made, left)))
        for there in after:
            if there is None:
                return True
            if there not in known:
                if len(known) > MOST:
                    raise TooLargeError
                known.add(there)
                queue.append(there)
    return False


def fired_ages(  # type: ignore[no-untyped-def]
    formula: Bounded,
    looked,
    began,
    ages: frozenset[int],
    marking: Marking,
    fired: int,
    holds,
    is_of_step,
    is_in,
) -> frozenset[int] | None:
    """Return the obligations after a firing; a new one is looked at in the marking before it, too."""
    if formula.is_after_step:
        left = looked(ages, marking, fired)
        return None if left is None else began(left, marking, fired)
    with_new = began(ages, marking, fired)
    if with_new != ages or 0 in ages:
        is_new = bool(began(frozenset(), marking, fired))
        if is_new and not is_of_step(formula.condition) and is_in(0):
            is_met = holds(formula.condition, marking, None)
            if formula.always and not is_met:
                return None
            if not formula.always and is_met:
                with_new = ages
    return looked(with_new, marking, fired)  # type: ignore[no-any-return]


CONDITIONS = ("p0 >= 1", "p1 >= 1", "p2 >= 1", "fired(t0)", "fired(t1)", "fired(t2)")
WINDOWS = ("[<=1]", "[<2]", "[<=2]", "[<=0]", "[1,2]", "[1,1]", "(0,1]", "[1,3)")


def formulas(random: Random, count: int) -> list[str]:
    """Return formulas; times are those of the random nets, whose unit is a seventh."""
    made = []
    for _ in range(count):
        trigger, condition = random.choice(CONDITIONS), random.choice(CONDITIONS)
        window, operator = random.choice(WINDOWS), random.choice("FFG")
        if operator == "G" and random.random() < 0.5:
            condition = f"!({condition})"
        own = f"{operator}{window} ({condition})"
        shape = random.choice(("{}", "G ({trigger} -> {})", "G ({trigger} -> {})", "G ({trigger} -> X {})"))
        if "X" in shape and "fired" not in trigger:
            shape = "G ({trigger} -> {})"
        made.append(shape.format(own, trigger=trigger))
    return made


@pytest.mark.long
@pytest.mark.parametrize("seed", range(30))
def test_random_nets(seed: int) -> None:
    random = Random(seed)
    net = lively_net(random, has_priorities=seed % 5 == 0, is_closed=True, most=250)
    timed = slowed(net.net)
    seen = set()
    for text in formulas(random, 14):
        if "p2" in text and len(net.initial) < 3:
            continue
        formula = read_bounded(text)
        assert formula is not None
        try:
            expected = is_violated(net, formula)
        except TooLargeError:
            continue
        found = decide_bounded(timed, formula)
        assert found.status == ("violated" if expected else "holds"), text
        seen.add(found.status)
    assert seen


def slowed(net: TimedNet) -> TimedNet:
    """Return a net with a unit of time of one instead of a seventh."""
    from dataclasses import replace

    def times(one: Interval) -> Interval:
        latest = None if one.latest is None else one.latest * 7
        return Interval(one.earliest * 7, latest, one.is_open_below, one.is_open_above)

    return replace(net, intervals=tuple(times(one) for one in net.intervals))


def handler(slowest: int) -> TimedNet:
    """Return a net in which a request is asked every 10, and answered after 3 to the slowest."""
    steps = [
        Transition("ask", {"clock": 1}, {"clock": 1, "asked": 1}),
        Transition("answer", {"asked": 1}, {"answered": 1}),
        Transition("forget", {"answered": 1}, {}),
    ]
    times = {
        "ask": Interval(Fraction(10), Fraction(10)),
        "answer": Interval(Fraction(3), Fraction(slowest)),
        "forget": Interval(Fraction(0), Fraction(0)),
    }
    return TimedNet.build({"clock": 1, "asked": 0, "answered": 0}, steps, times)


def answer(text: str, slowest: int = 5) -> str:
    formula = read_bounded(text)
    assert formula is not None
    return decide_bounded(handler(slowest), formula).status


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("G (fired(ask) -> F[<=5] fired(answer))", "holds"),
        ("G (fired(ask) -> F[<5] fired(answer))", "violated"),
        ("G (asked >= 1 -> F[<=5] answered >= 1)", "holds"),
        ("G (asked >= 1 -> F[<=4.9] answered >= 1)", "violated"),
        ("G (fired(ask) -> F[3,5] fired(answer))", "holds"),
        ("G (fired(ask) -> F(3,5] fired(answer))", "violated"),
        ("G (fired(ask) -> F[4,5] fired(answer))", "violated"),
        ("F[<=10] fired(ask)", "holds"),
        ("F[<10] fired(ask)", "violated"),
        ("F[10,10] fired(ask)", "holds"),
        ("G[<10] asked == 0", "holds"),
        ("G[<=10] asked == 0", "violated"),
        ("G (fired(ask) -> X G[<3] asked >= 1)", "holds"),
        ("G (fired(ask) -> X G[<=3] asked >= 1)", "violated"),
        ("G (fired(ask) -> X F[<=10] fired(ask))", "holds"),
        ("G (fired(ask) -> X F[<10] fired(ask))", "violated"),
        ("G (fired(ask) -> F[<=0] fired(ask))", "holds"),
    ],
)
def test_bounds_are_exact(text: str, expected: str) -> None:
    assert answer(text) == expected


def test_a_violation_has_the_times_that_show_it() -> None:
    formula = read_bounded("G (fired(ask) -> F[<=4] fired(answer))")
    assert formula is not None
    found = decide_bounded(handler(5), formula)
    assert found.trace == (0,)
    assert found.times[0] == (10.0, 10.0, 10.0)
    assert found.reason == "fired(answer) does not come in [<=4], counted from 10"


@pytest.mark.parametrize(
    "text",
    [
        "F[<=5] F (p >= 1)",
        "p >= 1 U F[<=5] (q >= 1)",
        "G (p >= 1 -> F[<=5] (q >= 1) | F[<=2] (q >= 1))",
        "F[3,2] (p >= 1)",
        "F[2,2) (p >= 1)",
        "F[<0] (p >= 1)",
        "F[<=1/0] (p >= 1)",
        "F[<=5]",
        "F (G (p >= 1 -> F[<=5] (q >= 1)))",
        "F[<=NaN] (q >= 1)",
        "F[<=-1] (q >= 1)",
        "F[>=2] (q >= 1)",
        "F[2,w[ (q >= 1)",
        "G (p >= 1 -> F[<=1e30] (q >= 1))",
    ],
)
def test_what_cannot_be_read(text: str) -> None:
    with pytest.raises(FormulaError):
        read_bounded(text)


def test_formulas_are_written_as_they_are_read() -> None:
    for text in formulas(Random(7), 40):
        formula = read_bounded(text)
        assert formula is not None
        assert read_bounded(str(formula)) == formula
    assert read_bounded("G (p >= 1 -> F (q >= 1))") is None
    for plain in ('"F[<=5] p" >= 1', "F[1] >= 1", "G [] (p >= 1)", "F (G[2] == 1)"):
        assert read_bounded(plain) is None
