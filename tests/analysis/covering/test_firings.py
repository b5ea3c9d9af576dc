"""What can fire in nets without bounds, against plain search and the plain tree of Karp and Miller."""

from __future__ import annotations

from math import inf

import pytest
from hypothesis import given, settings

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import run_stages
from dineros.analysis.covering import firings as stages
from dineros.analysis.covering.backward import Backward
from dineros.analysis.covering.directed import Directed
from dineros.analysis.covering.distance import CoveringPrograms
from dineros.analysis.covering.firings import Firings, firings
from dineros.analysis.covering.tree import tree_of
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import replay
from dineros.metamodel import sym
from tests.analysis.covering.plain import can_fire_by_karp_miller, plain_karp_miller, plain_search
from tests.analysis.strategies import nets
from tests.support.systems.unbounded_systems import timer_and_logger, unbounded_systems

MOST = 5_000


def agrees(net: CompiledNet, found: Firings, most: int = MOST) -> None:
    """Compare what was found out with plain search, and with what Karp and Miller's tree proves."""
    seen, can_fire = plain_search(net, most), can_fire_by_karp_miller(net)
    everything = set(range(len(net.transitions)))
    assert everything - found.dead >= seen.enabled and set(found.traces) >= seen.enabled
    if seen.is_complete:
        assert set(found.traces) == seen.enabled and found.dead == everything - seen.enabled
        assert (found.deadlock is not None) == seen.has_deadlock
    if can_fire is not None:
        assert found.dead >= everything - can_fire
        if not net.inhibitor.place.size:
            assert set(found.traces) == can_fire
    for t, trace in found.traces.items():
        assert trace[-1] == t and replay(net, trace)
    if seen.has_deadlock:
        assert found.deadlock is not None
    if found.deadlock is not None:
        last = replay(net, found.deadlock)[-1]
        assert not any(net.is_enabled(t, last) for t in everything)
        assert not found.has_no_deadlock


@pytest.mark.long
@settings(max_examples=15, deadline=None)
@given(nets())
def test_all_stages_agree_with_the_plain_ones(net: CompiledNet) -> None:
    agrees(net, firings(net, Budget(seconds=20)))


@pytest.mark.long
@settings(max_examples=15, deadline=None)
@given(nets())
def test_the_stages_behind_the_first_agree_too(net: CompiledNet) -> None:
    search = stages._FiringSearch(net, range(len(net.transitions)), True)
    run_stages(search, [stages.FAR_PLAN[number] for number in (1, 0, 2)], Budget(seconds=20))
    seen = plain_search(net, MOST)
    assert set(search.found.traces) >= seen.enabled and search.found.dead.isdisjoint(seen.enabled)
    assert not (search.found.has_no_deadlock and seen.has_deadlock)


@settings(max_examples=40, deadline=None)
@given(nets())
def test_the_tree_bounds_what_is_seen(net: CompiledNet) -> None:
    tree, seen = tree_of(net, Budget()), plain_search(net, MOST)
    assert tree.dead.isdisjoint(seen.enabled)
    maximal = tree.maximal
    if maximal is not None:
        assert all(
            any(all(a <= b for a, b in zip(m, top, strict=True)) for top in maximal) for m in seen.markings
        )
        if not net.inhibitor.place.size:
            assert set(maximal) == (plain_karp_miller(net, 20_000) or set(maximal))
    if tree.pumping is not None:
        marking = net.initial.tolist()
        for t in [*tree.pumping.prefix, *tree.pumping.suffix * 5]:
            marking = net.fire(t, marking)
        assert maximal is None or all(any(m[p] == inf for m in maximal) for p in tree.pumping.places)
        assert all(marking[p] >= 5 for p in tree.pumping.places)


@settings(max_examples=40, deadline=None)
@given(nets())
def test_what_the_state_equation_excludes_never_fires(net: CompiledNet) -> None:
    equation, seen, initial = CoveringPrograms(net), plain_search(net, MOST), net.initial.tolist()
    assert not any(equation.excluding(initial, dict(net.pre.row(t))) for t in seen.enabled)


@pytest.mark.long
@settings(max_examples=12, deadline=None)
@given(nets())
def test_distances_are_lower_bounds(net: CompiledNet) -> None:
    equation = CoveringPrograms(net)
    for t in range(len(net.transitions)):
        target = dict(net.pre.row(t))
        weights = equation.leading(net.initial.tolist(), target)
        trace, _ = Directed(net).way_to(t, Budget(), most=2_000)
        if weights is not None and trace is not None:
            initial = net.initial.tolist()
            assert (
                sum(w * (target.get(p, 0) - initial[p]) for p, w in enumerate(weights))
                <= len(trace) - 1 + 1e-6
            )


@pytest.mark.long
@settings(max_examples=2, deadline=None)
@given(unbounded_systems())
def test_models_with_timers(model: sym.SystemModel) -> None:
    net = base_subject(model).net
    agrees(net, firings(net, Budget(seconds=30)), 2_000)


@pytest.mark.parametrize("counter", [False, True])
def test_a_timer_without_end_overflows_all_three_queues(counter: bool) -> None:
    subject = base_subject(timer_and_logger(counter))
    found = firings(subject.net, Budget(seconds=60))
    drops = [t for t, name in enumerate(subject.net.transitions) if name.endswith(".drop")]
    assert len(drops) == 3 and all(t in found.traces for t in drops)
    assert found.has_no_deadlock and not found.dead


def test_a_far_target_is_found_by_the_state_equation() -> None:
    net = CompiledNet.build(
        {"on": 1, "work": 0, "done": 0, "noise": 0},
        [
            Transition("tick", {"on": 1}, {"on": 1, "work": 1}),
            Transition("do", {"work": 1}, {"done": 1}),
            Transition("hum", {"on": 1}, {"on": 1, "noise": 1}),
            Transition("rest", {"noise": 1}, {}),
            Transition("goal", {"done": 40}, {}),
        ],
    )
    trace, _ = Directed(net).way_to(4, Budget(), most=5_000)
    assert trace is not None and len(trace) == 81


def test_out_of_time_everything_else_stays_open() -> None:
    subject = base_subject(timer_and_logger())
    found = firings(subject.net, Budget(seconds=1e-6))
    assert not found.dead and found.reason


def test_what_is_open_for_want_of_time_says_so() -> None:
    unbounded = Firings(reason="unbounded", is_late=True)
    assert unbounded.why_open == "there are infinitely many markings, and time ran out"
    assert Firings(reason="time", is_late=True).why_open == Firings(is_late=True).why_open == "time ran out"
    assert Firings().why_open == ""


def test_what_its_share_of_the_time_ends_is_open_for_want_of_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole time is not over then: each search takes a part of what is left."""

    def way_to(search: object, transition: int, share: Budget, most: int = 0) -> tuple[None, bool]:
        while not share.is_over:
            pass
        return None, False

    for engine in (Directed, Backward):
        monkeypatch.setattr(engine, "way_to", way_to)
    net = CompiledNet.build(
        {"a": 0, "b": 0}, [Transition("grow", {}, {"a": 1, "b": 1}), Transition("t", {"b": 1}, {})]
    )
    found = firings(
        net, Budget(seconds=0.5), [1], asks_deadlock=False, known=Firings(reason="states", net=net)
    )
    assert found.is_open(1) and found.why_open == "there are too many markings, and time ran out"
