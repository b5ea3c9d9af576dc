"""LTL with time against runs through the clock regions of random nets."""

from __future__ import annotations

from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.logic.language.names import TableNames
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.timed.linear_time import verify_timed_ltl
from dineros.analysis.timed.nets import Interval, TimedNet
from tests.analysis.timed.time_nets import RandomNet, lively_net


def region_net(net: RandomNet) -> tuple[CompiledNet, TableNames]:
    """Return the regions as a net with one token, and names by which formulas speak of the time net.

    A run may stay where nothing has a latest bound any more: by a transition that changes nothing.
    """
    graph = net.regions()
    number = {state: index for index, state in enumerate(graph.fires)}
    transitions: list[Transition] = []
    fired: dict[str, list[int]] = {one.name: [] for one in net.transitions}

    def move(source: int, target: int) -> None:
        transitions.append(Transition(f"m{len(transitions)}", {f"r{source}": 1}, {f"r{target}": 1}))

    for state, index in number.items():
        for t, after in graph.fires[state]:
            fired[net.transitions[t].name].append(len(transitions))
            move(index, number[after])
        if state in graph.waits:
            move(index, number[graph.waits[state]])
        elif all(net.transitions[t].latest is None for t, _, _ in state[1]):
            move(index, index)
    places = {f"r{index}": int(index == number[graph.start]) for index in number.values()}
    tokens = {
        f"p{place}": [index for state, index in number.items() for _ in range(state[0][place])]
        for place in range(len(net.initial))
    }
    return CompiledNet.build(places, transitions), TableNames(tokens, fired, {})


FORMULAS = (
    "G (p0 <= 1)",
    "F (p0 >= 1)",
    "G F (p1 >= 1)",
    "F G (p0 == 0)",
    "G (p0 >= 1 -> F (p1 >= 1))",
    "(p0 <= 1) U (p1 >= 1)",
    "G F fired(t0)",
    "G F fired(t0) -> G F fired(t1)",
    "G (fired(t1) -> F fired(t0))",
)
"""Without next: the regions also have steps in which time passes."""


@pytest.mark.parametrize("seed", range(20))
def test_formulas_on_random_nets(seed: int) -> None:
    net = lively_net(Random(seed), has_priorities=seed % 4 == 0, most=150)
    regions, names = region_net(net)
    timed = net.net
    for formula in FORMULAS:
        expected = verify_ltl(regions, formula, names).status
        assert verify_timed_ltl(timed, formula).status == expected, formula


def test_a_run_may_wait_for_ever_where_nothing_has_to_fire() -> None:
    steps = [Transition("leave", {"p": 1}, {"q": 1})]
    lazy = TimedNet.build({"p": 1, "q": 0}, steps, {"leave": Interval(Fraction(1))})
    urgent = TimedNet.build({"p": 1, "q": 0}, steps, {"leave": Interval(Fraction(1), Fraction(9))})
    assert verify_timed_ltl(lazy, "F (q >= 1)").status == "violated"
    assert verify_timed_ltl(urgent, "F (q >= 1)").status == "holds"
    assert verify_timed_ltl(urgent, "F deadlock").status == "holds"


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        ("fired(leave) | fired(stop) | G (!fired(leave) & !fired(stop))", "holds"),
        ("F (a == 1 & b == 1) -> X X (a == 1 & b == 1)", "holds"),
        ("X (p == 0 | q == 0)", "violated"),
        ("F (a == 1) -> X (a == 1)", "violated"),
        ("G (fired(leave) -> X (a == 1))", "holds"),
    ],
)
def test_a_run_that_waits_for_ever_never_fires_again(formula: str, expected: str) -> None:
    """How long a run waits before it fires is no step of its own: *next* is after the next firing."""
    steps = [Transition("leave", {"p": 1}, {"a": 1}), Transition("stop", {"q": 1}, {"b": 1})]
    times = {"leave": Interval(Fraction(1)), "stop": Interval(Fraction(2))}
    net = TimedNet.build({"p": 1, "q": 1, "a": 0, "b": 0}, steps, times)
    for kind in ("W", "S"):
        assert verify_timed_ltl(net, formula, kind=kind).status == expected


def test_time_decides() -> None:
    steps = [Transition("fast", {"p": 1}, {"a": 1}), Transition("slow", {"p": 1}, {"b": 1})]
    times = {"fast": Interval(Fraction(1), Fraction(2)), "slow": Interval(Fraction(3), Fraction(4))}
    net = TimedNet.build({"p": 1, "a": 0, "b": 0}, steps, times)
    assert verify_ltl(net.untimed, "G (b == 0)").status == "violated"
    assert verify_timed_ltl(net, "G (b == 0)").status == "holds"
    answer = verify_timed_ltl(net, "G (a == 0)")
    assert (answer.status, answer.trace, answer.loop) == ("violated", (0,), ())
