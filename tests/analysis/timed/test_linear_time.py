"""LTL with time against runs through the clock regions of random nets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from random import Random
from typing import Any

import pytest

from dineros.analysis.logic.language.names import TableNames
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.timed.linear_time import TIME_PASSES, verify_timed_ltl
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.runs.product import ClassProduct, LassoRun
from tests.analysis.timed.time_nets import RandomNet, lively_net
from tests.support.references.regions import TimedTransition

TICK = TimedTransition("tick", {}, {}, {}, {}, 1, 1)
"""Fires once in each unit of time."""


def region_net(net: RandomNet) -> tuple[CompiledNet, TableNames]:
    """Return the regions as a net with one token, and names by which formulas speak of the time net.

    The time net gets a transition that fires in each unit of time: a run takes infinite time if it fires
    infinitely often.
    """
    net = replace(net, transitions=[*net.transitions, TICK])
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


def hasty_net(random: Random, has_priorities: bool) -> RandomNet:
    """Return a net in which most transitions may fire at once, so that many firings may take no time."""
    while True:
        net = lively_net(random, has_priorities, most=150)
        made = [replace(one, earliest=0, is_open_below=False) for one in net.transitions]
        net = replace(net, transitions=made)
        try:
            net.regions(400)
        except OverflowError:
            continue
        return net


@pytest.mark.parametrize("make", [partial(lively_net, most=150), hasty_net])
@pytest.mark.parametrize("seed", range(20))
def test_formulas_on_random_nets(seed: int, make: Callable[[Random, bool], RandomNet]) -> None:
    net = make(Random(seed), seed % 4 == 0)
    regions, names = region_net(net)
    plain, timed = net.net, replace(net.net, time_passes=True)
    higher = {high for high, _ in net.pairs}
    stopping = [t.name for n, t in enumerate(net.transitions) if t.latest == 0 or n in higher]
    stops = " | ".join(f"fired({t})" for t in stopping) or "false"
    for formula in FORMULAS:
        expected = verify_ltl(regions, f"(G F fired(tick) | F G ({stops})) -> ({formula})", names).status
        assert verify_timed_ltl(timed, formula).status == expected, formula
        assert verify_timed_ltl(plain, formula).status == verify_ltl(regions, formula, names).status, formula


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


def toggled(latest: Fraction | None) -> TimedNet:
    """Return a net in which a signal changes at any time, and what was begun has to end by a moment."""
    steps = [
        Transition("set", {"off": 1}, {"on": 1}),
        Transition("reset", {"on": 1}, {"off": 1}),
        Transition("begin", {"idle": 1}, {"busy": 1}),
        Transition("end", {"busy": 1}, {"idle": 1}),
    ]
    places = {"off": 1, "on": 0, "idle": 1, "busy": 0}
    net = TimedNet.build(places, steps, {"end": Interval(Fraction(0), latest)})
    return replace(net, time_passes=True)


@pytest.mark.parametrize(("latest", "expected"), [(Fraction(5), "holds"), (None, "violated")])
def test_endless_changes_of_a_signal_in_no_time_are_no_run(latest: Fraction | None, expected: str) -> None:
    answer = verify_timed_ltl(toggled(latest), "G (fired(begin) -> F fired(end))")
    assert answer.status == expected
    assert answer.reason == (TIME_PASSES if expected == "holds" else "")
    plain = replace(toggled(latest), time_passes=False)
    assert verify_timed_ltl(plain, "G (fired(begin) -> F fired(end))").status == "violated"
    assert verify_timed_ltl(toggled(latest), "F G (busy == 0)").status == "violated"


@pytest.mark.parametrize(
    "formula", ["G (fired(begin) -> F fired(end))", "G (fired(end) -> busy == 0 | busy == 1)"]
)
def test_the_product_of_a_plain_net_is_searched_once(formula: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """All runs of a plain net count, so none has to take infinite time."""
    searches = []
    accepted = ClassProduct.accepted

    def counting(product: ClassProduct, *arguments: Any, **options: Any) -> LassoRun | None:
        searches.append((arguments, options))
        return accepted(product, *arguments, **options)

    monkeypatch.setattr(ClassProduct, "accepted", counting)
    verify_timed_ltl(replace(toggled(Fraction(5)), time_passes=False), formula)
    assert searches == [((), {})]


@pytest.mark.parametrize("interval", [Interval(), Interval(Fraction(0), Fraction(1))])
def test_a_run_that_may_take_time_takes_time(interval: Interval) -> None:
    """The loop has no earliest bound; the violation needs infinite time, and takes it."""
    steps = [Transition("there", {"a": 1}, {"b": 1}), Transition("back", {"b": 1}, {"a": 1})]
    net = TimedNet.build(
        {"a": 1, "b": 0}, steps, {"there": interval, "back": Interval(Fraction(0), Fraction(1))}
    )
    net = replace(net, time_passes=True)
    assert verify_timed_ltl(net, "F G (a == 1)").status == "violated"
    expected = "violated" if interval.latest is None else "holds"
    assert verify_timed_ltl(net, "G F (b == 1)").status == expected


def test_a_model_that_stops_time_violates_what_it_keeps_from_happening() -> None:
    steps = [
        Transition("there", {"a": 1}, {"b": 1}),
        Transition("back", {"b": 1}, {"a": 1}),
        Transition("strike", {"clock": 1}, {"struck": 1}),
    ]
    now, later = Interval(Fraction(0), Fraction(0)), Interval(Fraction(1), Fraction(1))
    net = TimedNet.build(
        {"a": 1, "b": 0, "clock": 1, "struck": 0}, steps, {"there": now, "back": now, "strike": later}
    )
    answer = verify_timed_ltl(replace(net, time_passes=True), "F (struck == 1)")
    assert (answer.status, set(answer.loop)) == ("violated", {0, 1})
