"""The first round: what walks meet, with the ways to it, against plain searches."""

from __future__ import annotations

from time import process_time
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dineros.analysis.walks.first_round as walks
from dineros.analysis.answers.budget import Budget
from dineros.analysis.covering.firings import firings
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.coverability import can_repeat, coverability
from dineros.analysis.nets.witness import replay
from dineros.analysis.walks import firing_counts
from dineros.analysis.walks.first_round import first_round
from dineros.analysis.walks.scouting import Scout, short_pumping, short_way
from tests.analysis.reference_case_study import reference_case_study
from tests.analysis.strategies import nets

LIMITS = Budget(1 << 26, seconds=60)
QUICK = Budget(1 << 26, seconds=3)


def move(name: str, here: str, there: str) -> Transition:
    return Transition(name, {here: 1}, {there: 1})


def far(rounds: int, others: int) -> CompiledNet:
    """A shift that ends after some rounds, beside others that never end: far away, and not rare."""
    tokens = {"rest": 1, "work": 0, "done": 0} | {f"a{k}": 1 for k in range(others)}
    rows = [
        move("begin", "rest", "work"),
        Transition("end", {"work": 1}, {"rest": 1, "done": 1}, {"done": rounds}),
        Transition("home", {"done": rounds}, {}),
    ]
    for k in range(others):
        rows += [
            Transition(f"go{k}", {f"a{k}": 1}, {f"b{k}": 1}),
            Transition(f"back{k}", {f"b{k}": 1}, {f"a{k}": 1}),
        ]
        tokens[f"b{k}"] = 0
    return CompiledNet.build(tokens, rows)


def test_what_is_far_away_among_many_markings_is_met() -> None:
    net = far(rounds=40, others=24)
    home = net.transitions.index("home")
    found = first_round(net, LIMITS, [home])
    way = short_way(net, found.ways[home])
    assert [net.transitions[t] for t in way] == [*["begin", "end"] * 40, "home"]


def test_a_busy_machine_gives_the_same_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is met, and the way to it, must not depend on how long each walk takes."""
    net = reference_case_study((1, 1, 1), "none")
    asked = range(len(net.transitions))
    quiet = first_round(net, Budget(), asked, asks_deadlock=True)
    walk = Scout.walk

    def slow_walk(*args: Any, **options: Any) -> bool:
        until = process_time() + 0.005
        while process_time() < until:
            pass
        return walk(*args, **options)

    monkeypatch.setattr(Scout, "walk", slow_walk)
    assert first_round(net, Budget(), asked, asks_deadlock=True) == quiet


def test_more_time_gives_the_same_runs_and_more(monkeypatch: pytest.MonkeyPatch) -> None:
    """What little time finds is shown by the same run with more time, and without a limit."""
    # Each "never" needs both of two places that share a token with others: only the state equation allows it.
    tokens = {"rest": 1, "work": 0, "done": 0, "left": 1, "right": 1, "flag": 0}
    rows = [
        move("begin", "rest", "work"),
        Transition("end", {"work": 1}, {"rest": 1, "done": 1}, {"done": 60}),
        Transition("home", {"done": 30}, {}),
        *[Transition(f"go{k}", {f"a{k}": 1}, {f"b{k}": 1}) for k in range(30)],
        *[Transition(f"back{k}", {f"b{k}": 1}, {f"a{k}": 1}) for k in range(30)],
        *[Transition(f"never{k}", {f"b{k}": 1, "flag": 1}, {"flag": 1}, {"left": 1}) for k in range(20)],
        Transition("mark", {"left": 2}, {"flag": 1, "left": 2}),
        Transition("swap", {"left": 1, "right": 1}, {"left": 1, "right": 1}, reads={"done": 61}),
    ]
    for k in range(30):
        tokens |= {f"a{k}": 1, f"b{k}": 0}
    net = CompiledNet.build(tokens, rows)
    asked = range(len(net.transitions))
    # So few firings leave time for one turn in an hour, which no busy machine makes too short.
    monkeypatch.setattr(walks, "FIRINGS_PER_SECOND", 1_000)
    little, more = (first_round(net, limits, asked) for limits in (Budget(seconds=3_600), Budget()))
    home = net.transitions.index("home")
    assert home in little.ways
    assert little.ways == {t: way for t, way in more.ways.items() if t in little.ways}


def test_a_place_that_grows_only_by_a_long_loop_is_met() -> None:
    # The loop takes from ten places in turn; random walks go astray among the others.
    tokens = {"p0": 1, "log": 0} | {f"p{k}": 0 for k in range(1, 10)} | {f"a{k}": 1 for k in range(12)}
    rows = [move(f"t{k}", f"p{k}", f"p{k + 1}") for k in range(9)]
    rows.append(Transition("t9", {"p9": 1}, {"p0": 1, "log": 1}))
    rows += [Transition("take", {"log": 2}, {"log": 1})]
    for k in range(12):
        tokens[f"b{k}"] = 0
        rows += [
            Transition(f"go{k}", {f"a{k}": 1}, {f"b{k}": 1}),
            Transition(f"back{k}", {f"b{k}": 1}, {f"a{k}": 1}),
        ]
    net = CompiledNet.build(tokens, rows)
    log = net.places.index("log")
    assert place_bounds(net)[log] is None
    (pumping,) = first_round(net, LIMITS, growing=[log]).pumpings
    assert pumping.places == (log,)
    assert [net.transitions[t] for t in pumping.suffix] == [f"t{k}" for k in range(10)]
    assert not pumping.prefix


def test_no_queue_is_filled_for_a_loop_that_does_without() -> None:
    """A full queue loses messages, which makes a shorter loop; but the way to it would be long."""
    net = CompiledNet.build(
        {"ready": 1, "message": 0, "queue": 0, "room": 10, "log": 0},
        [
            Transition("make", {"ready": 1}, {"message": 1, "log": 1}),
            Transition("enter", {"message": 1, "room": 1}, {"queue": 1, "ready": 1}),
            Transition("lose", {"message": 1}, {"ready": 1}, reads={"queue": 10}),
            Transition("take", {"queue": 1}, {"room": 1}),
        ],
    )
    (pumping,) = first_round(net, LIMITS, growing=[net.places.index("log")]).pumpings
    assert len(pumping.prefix) <= 2
    assert sorted(net.transitions[t] for t in pumping.suffix) == ["enter", "make", "take"]


def test_a_loop_takes_away_what_inhibits_one_of_its_firings() -> None:
    # "ask" needs work under way, "dock" needs that there is none: only a loop with "end" and "begin" repeats.
    rows = [
        Transition("ask", {"work": 1, "low": 1}, {"work": 1, "leaving": 1, "asked": 1}),
        Transition("dock", {"leaving": 1}, {"docked": 1}, {"work": 1}),
        *[move(f"t{k}", f"p{k}", f"p{k + 1}") for k in range(12)],
        Transition("ready", {"docked": 1, "p12": 1}, {"low": 1, "p0": 1}),
        move("end", "work", "rest"),
        move("begin", "rest", "work"),
        Transition("hear", {"asked": 2}, {"asked": 1}),
    ]
    tokens = {"work": 0, "rest": 1, "low": 1, "leaving": 0, "docked": 0, "asked": 0, "p0": 1}
    net = CompiledNet.build(tokens | {f"p{k}": 0 for k in range(1, 13)}, rows)
    asked = net.places.index("asked")
    nothing = net.with_initial(dict.fromkeys(net.places, 0))
    counts = firing_counts.firings(nothing, [({asked: 1}, 1)], is_loop=True)
    assert counts is not None
    fired = {net.transitions[t] for t, count in enumerate(counts.tolist()) if count}
    assert fired >= {"ask", "dock", "end", "begin"}
    (pumping,) = first_round(net, LIMITS, growing=[asked]).pumpings
    assert pumping.places == (asked,)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(nets())
def test_what_is_met_can_be_fired(net: CompiledNet) -> None:
    growing = [p for p, bound in enumerate(place_bounds(net)) if bound is None]
    found = first_round(net, QUICK, range(len(net.transitions)), True, growing)
    for t, way in found.ways.items():
        for each in (way, short_way(net, way)):
            assert each[-1] == t
            replay(net, each)
    if found.deadlock is not None:
        last = replay(net, found.deadlock)[-1]
        assert not any(net.is_enabled(t, last) for t in range(len(net.transitions)))
    known = coverability(net, 500)
    for pumping in found.pumpings:
        assert can_repeat(net, pumping)
        assert known.is_bounded is not True
    wanted = range(len(net.transitions))
    proved = firings(net, QUICK, wanted)
    assert proved.dead.isdisjoint(found.ways)
    assert not (proved.has_no_deadlock and found.deadlock is not None)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(nets())
def test_a_loop_is_made_shorter_and_still_repeats(net: CompiledNet) -> None:
    scout, growing = Scout(net), range(len(net.places))
    for _ in range(20):
        scout.walk(growing=growing)
        for pumping in scout.taken():
            short = short_pumping(net, pumping, pumping.places)
            assert can_repeat(net, short)
            assert set(short.places) & set(pumping.places)
            assert len(short.suffix) <= len(pumping.suffix)


@given(nets(), st.data())
@settings(max_examples=200, deadline=None)
def test_a_short_way_fires_the_same_transition(net: CompiledNet, data: st.DataObject) -> None:
    marking, trace = net.initial.tolist(), []
    for _ in range(data.draw(st.integers(1, 40))):
        enabled = [t for t in range(len(net.transitions)) if net.is_enabled(t, marking)]
        if not enabled:
            break
        trace.append(data.draw(st.sampled_from(enabled)))
        marking = net.fire(trace[-1], marking)
    if trace:
        way = short_way(net, trace)
        assert len(way) <= len(trace)
        assert way[-1] == trace[-1]
        replay(net, way)


def test_a_short_way_does_not_try_what_is_elsewhere() -> None:
    # Among 400 places, 20 000 firings have nothing to do with the last one: trying them takes minutes.
    net = far(rounds=3, others=200)
    index = {name: t for t, name in enumerate(net.transitions)}
    others = [index[f"{kind}{k}"] for k in range(200) for kind in ("go", "back")] * 16
    own = [index[name] for name in ("begin", "end")]
    trace = [*others, *own, *others, *own, *others, *own, index["home"]]
    began = process_time()
    assert short_way(net, trace) == (*own * 3, index["home"])
    assert process_time() - began < 5
