"""CTL with time against its definition on the clock regions of random nets."""

from __future__ import annotations

from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import Atom, Comparison, Enabled
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.timed.branching_time import check_timed_ctl
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.schedules import schedule
from tests.analysis.timed.time_nets import RandomNet, lively_net
from tests.support.references.regions import Marking
from tests.support.references.timed_ctl import FiringGraph


def random_formula(random: Random, net: RandomNet, depth: int) -> str:
    """Return a formula of CTL of at most so many operators, one inside the other."""
    if depth == 0 or random.random() < 0.1:
        place, one = random.randrange(len(net.initial)), random.choice(net.transitions)
        return random.choice(
            (f"(p{place} >= 1)", f"(p{place} >= 1)", f"(p{place} == 0)", f"enabled({one.name})", "deadlock")
        )
    left, right = (random_formula(random, net, depth - 1) for _ in range(2))
    return random.choice(
        (
            f"(!{left})",
            f"({left} & {right})",
            f"({left} -> {right})",
            *(f"({quantifier}{operator} {left})" for quantifier in "AE" for operator in "XFGXFG"),
            *(f"({quantifier}[{left} {operator} {right}])" for quantifier in "AE" for operator in "URW"),
        )
    )


def is_true(net: RandomNet, atom: Atom, marking: Marking) -> bool:
    if isinstance(atom, Enabled):
        return net.transitions[int(atom.name.text[1:])].is_enabled(marking)
    assert isinstance(atom, Comparison)
    tokens = sum(factor * marking[int(name.text[1:])] for factor, name in atom.terms)
    return tokens >= atom.bound if atom.operator == ">=" else tokens == atom.bound


@pytest.mark.parametrize("seed", range(30))
def test_random_formulas_on_random_nets(seed: int) -> None:
    random = Random(seed)
    net = lively_net(random, has_priorities=seed % 3 == 0, most=600)
    regions, timed = FiringGraph(net.regions()), net.net
    for _ in range(12):
        formula = random_formula(random, net, 3)
        expected = regions.holds(parse(formula, "ctl"), lambda atom, marking: is_true(net, atom, marking))
        answer = check_timed_ctl(timed, formula)
        assert (answer.status == "holds") == expected, formula
        if answer.trace:
            schedule(timed, [*answer.trace, *answer.loop])


def choice(first: Interval, second: Interval) -> TimedNet:
    steps = [Transition("left", {"p": 1}, {"a": 1}), Transition("right", {"p": 1}, {"b": 1})]
    return TimedNet.build({"p": 1, "a": 0, "b": 0}, steps, {"left": first, "right": second})


def test_who_may_wait_for_ever_is_its_own_next_state() -> None:
    lazy = choice(Interval(Fraction(1)), Interval(Fraction(2)))
    urgent = choice(Interval(Fraction(1), Fraction(3)), Interval(Fraction(2)))
    for net, is_urgent in ((lazy, False), (urgent, True)):
        for formula in ("AF (p == 0)", "AX (p == 0)", "AF deadlock"):
            assert (check_timed_ctl(net, formula).status == "holds") == is_urgent, formula
        assert check_timed_ctl(net, "EX (a == 1) & EX (b == 1)").status == "holds"
        assert check_timed_ctl(net, "AG (deadlock -> AX deadlock)").status == "holds"


def test_linear_classes_would_not_do() -> None:
    """After `go`, early or late: only early may `left` be first, and only late may `right`."""
    steps = [
        Transition("go", {"s": 1}, {"p": 1, "q": 1}),
        Transition("left", {"p": 1}, {"a": 1}),
        Transition("right", {"r": 1}, {"b": 1}),
    ]
    times = {
        "go": Interval(Fraction(0), Fraction(4)),
        "left": Interval(Fraction(2), Fraction(2)),
        "right": Interval(Fraction(4), Fraction(5)),
    }
    net = TimedNet.build({"s": 1, "r": 1, "p": 0, "q": 0, "a": 0, "b": 0}, steps, times)
    may_both = "AG (q == 1 & p == 1 & r == 1 -> EX (a == 1) & EX (b == 1))"
    assert check_timed_ctl(net, may_both).status == "violated"
    assert check_timed_ctl(net, "EF (q == 1 & AX (a == 1))").status == "holds"
    assert check_timed_ctl(net, "EF (q == 1 & AX (b == 1))").status == "holds"


def test_a_limit_is_said() -> None:
    net = choice(Interval(), Interval())
    answer = check_timed_ctl(net, "AF (p == 0)", budget=Budget(seconds=0.0))
    assert (answer.status, answer.reason) == ("unknown", "time ran out")
