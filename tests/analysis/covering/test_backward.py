"""Backward search, against a plain one, the plain tree of Karp and Miller and plain search."""

from __future__ import annotations

from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.covering import firings as stages
from dineros.analysis.covering.backward import Backward
from dineros.analysis.covering.goals import decide_goal
from dineros.analysis.covering.tree import tree_of, without_inhibitors
from dineros.analysis.explicit.goals import Comparison, Goal
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.structure import never_possible
from dineros.analysis.nets.witness import replay
from tests.analysis.covering.plain import (
    covers,
    plain_backward,
    plain_karp_miller,
    plain_search,
)
from tests.analysis.strategies import nets


def random_net(seed: int) -> CompiledNet:
    """A net without inhibitor arcs; half of them keep the number of tokens or lose some."""
    random = Random(seed)
    names = [f"p{number}" for number in range(random.randint(2, 6))]
    rows = []
    for number in range(random.randint(2, 7)):
        inputs = {name: random.randint(1, 3) for name in random.sample(names, random.randint(1, 2))}
        if seed % 2:
            outputs = {name: random.randint(1, 3) for name in random.sample(names, random.randint(0, 2))}
        else:
            outputs = {}
            for _ in range(sum(inputs.values()) - random.randint(0, 1)):
                name = random.choice(names)
                outputs[name] = outputs.get(name, 0) + 1
        rows.append(Transition(f"t{number}", inputs, outputs))
    return CompiledNet.build({name: random.randint(0, 3) for name in names}, rows)


def agrees(net: CompiledNet, target: tuple[int, ...]) -> bool | None:
    """Compare with the plain ones; return what these say, as far as they end."""
    trace, is_complete = Backward(net).covering(dict(enumerate(target)), Budget())
    plain, tree = plain_backward(net, target), plain_karp_miller(net)
    if trace is not None:
        assert is_complete and covers(tuple(map(float, replay(net, trace)[-1])), target)
    verdict = plain
    if tree is not None:
        verdict = any(covers(marking, target) for marking in tree)
        assert plain in (None, verdict)
    if verdict is not None and is_complete:
        assert (trace is not None) == verdict
    # What a plain search ends with, one that stores less has to end with too.
    assert plain is None or is_complete
    return verdict


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(nets(), st.data())
def test_what_can_be_covered_is_what_the_plain_ones_say(net: CompiledNet, data: st.DataObject) -> None:
    agrees(without_inhibitors(net), data.draw(st.tuples(*[st.integers(0, 5) for _ in net.places])))


@pytest.mark.long
def test_seeded_nets_of_all_kinds_agree() -> None:
    counts: dict[tuple[bool, bool | None], int] = {}
    for seed in range(300):
        net, random = random_net(seed), Random(seed)
        verdict = agrees(net, tuple(random.choice([0, 0, 1, 2, 5]) for _ in net.places))
        tree = plain_karp_miller(net)
        is_bounded = tree is not None and all(max(marking) < float("inf") for marking in tree)
        counts[is_bounded, verdict] = counts.get((is_bounded, verdict), 0) + 1
    # Both answers occur, in nets with and without bounds: the comparison says something.
    assert all(
        counts.get((bounded, verdict), 0) >= 10 for bounded in (False, True) for verdict in (False, True)
    )


@pytest.mark.long
@settings(max_examples=80, deadline=None)
@given(nets())
def test_with_inhibitor_arcs_nothing_wrong_is_said(net: CompiledNet) -> None:
    seen, backward = plain_search(net, 3_000), Backward(net)
    for t in range(len(net.transitions)):
        trace, is_complete = backward.way_to(t, Budget())
        if trace is not None:
            assert trace[-1] == t and replay(net, trace)
        elif is_complete:
            assert t not in seen.enabled


@settings(max_examples=80, deadline=None)
@given(nets())
def test_only_what_never_fires_is_left_out_beforehand(net: CompiledNet) -> None:
    assert plain_search(net, 3_000).enabled.isdisjoint(never_possible(net))


def shared_lock(users: int) -> CompiledNet:
    """Users of one lock beside a place without bound: Karp and Miller's tree grows as 2 to the users."""
    places = {"noise": 0, "lock": 1}
    rows = [Transition("hum", {}, {"noise": 1}), Transition("hush", {"noise": 1}, {})]
    for n in range(users):
        places |= {f"idle {n}": 1, f"busy {n}": 0, f"done {n}": 0}
        rows += [
            Transition(f"take {n}", {f"idle {n}": 1, "lock": 1}, {f"busy {n}": 1}),
            Transition(f"give {n}", {f"busy {n}": 1}, {f"done {n}": 1, "lock": 1}),
            Transition(f"again {n}", {f"done {n}": 1}, {f"idle {n}": 1}),
        ]
    rows.append(Transition("never", {"busy 0": 1, "busy 1": 1, "noise": 2}, {}))
    return CompiledNet.build(places, rows)


@pytest.mark.long
def test_it_decides_where_the_tree_is_too_large() -> None:
    net = shared_lock(13)
    never = len(net.transitions) - 1
    assert tree_of(net, Budget()).maximal is None
    assert Backward(net).way_to(never, Budget()) == (None, True)
    search = stages._FiringSearch(net, [never], False)
    search.look_back(Budget())
    assert search.found.dead == {never}


def test_conjunctions_of_lower_bounds_are_decided_by_it() -> None:
    for tokens, status in [(1, "reachable"), (2, "unreachable")]:
        bounds = tuple(Comparison({p: 1}, ">=", w) for p, w in ((0, 3), (4, 1), (4, tokens)))
        with pytest.MonkeyPatch.context() as patch:
            for stage in ("look_near", "look_at_bounds", "make_tree"):
                patch.setattr(stages._FiringSearch, stage, lambda search: None)
            patch.setattr(stages._FiringSearch, "look_far", lambda search, most: None)
            known = decide_goal(shared_lock(8), Goal(conjunctions=(bounds,)), Budget())
        assert known is not None and known.status == status


def test_what_it_is_told_limits_it() -> None:
    net = random_net(1)
    target = dict.fromkeys(range(len(net.places)), 1 << 62)
    assert Backward(net).covering(target, Budget()) == (None, False)


@pytest.mark.long
@pytest.mark.parametrize("budget", [Budget(seconds=0.0).begun(), Budget(states=3), Budget(memory_bytes=1)])
def test_a_budget_that_is_spent_leaves_it_open(budget: Budget) -> None:
    net = far()
    assert Backward(net).way_to(2, budget) == (None, False)
    told: list[Progress] = []
    trace, is_complete = Backward(net).way_to(2, Budget(progress=told.append))
    assert trace is not None and is_complete and len(trace) == 1_201
    assert told and told[0].unit == "markings"


def far() -> CompiledNet:
    """A target that only many firings reach."""
    rows = [
        Transition("tick", {"on": 1}, {"on": 1, "work": 1}),
        Transition("do", {"work": 1}, {"done": 1}),
        Transition("goal", {"done": 600}, {}),
    ]
    return CompiledNet.build({"on": 1, "work": 0, "done": 0}, rows)


def test_the_answer_is_always_the_same() -> None:
    for seed in range(20):
        net = random_net(seed)
        target = dict.fromkeys(range(len(net.places)), 1)
        assert Backward(net).covering(target, Budget()) == Backward(net).covering(target, Budget())
