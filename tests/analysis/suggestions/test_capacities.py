"""Capacities of queues where markings have no end, against plain search and the plain tree."""

from __future__ import annotations

import re
from math import inf

import pytest
from hypothesis import given, settings

from dineros.analysis.answers.budget import Budget
from dineros.analysis.covering.largest import largest_beside, loop_raising
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.suggestions import capacities
from dineros.analysis.suggestions.capacities import Capacity, suggest_capacities
from dineros.metamodel import sym
from tests.analysis.covering.plain import plain_search
from tests.analysis.strategies import nets
from tests.support.systems.talker import talker
from tests.support.systems.unbounded_systems import timer_and_logger, unbounded_systems

pytestmark = pytest.mark.usefixtures("own_time")

MOST = 3_000
ENOUGH = Budget(seconds=6)
"""Each stage may take a share of it, also where the next one answers at once."""

LOST = re.compile(r" loses a message(?: of instance [0-9]+ of service \S+)?$")


def keeps_its_word(model: sym.SystemModel, found: Capacity) -> None:
    """Compare an answer with plain searches."""
    subject = base_subject(model, overflow="inhibitor")
    drops = {subject.transition_index[drop] for drop in found.queue.drops}

    def loses(capacity: int) -> bool:
        net = subject.net.with_initial({found.queue.capacity: capacity})
        return not drops.isdisjoint(plain_search(net, MOST).enabled)

    if found.needed is not None:
        assert not loses(found.needed) and not found.grows
        if found.needed > 1 and drops:
            assert found.witness is not None
            assert LOST.search(found.witness.steps[-1].text)
        else:
            assert found.witness is None
    elif found.grows:
        # The loop, fired at a small capacity, comes to where a message is lost.
        number = subject.net.places.index(found.queue.load)
        endless = capacities._without_limit(subject.net, found.queue.drops, found.queue.capacity)
        loop = None if found.witness is None else loop_raising(endless, number, Budget(seconds=20))
        assert (loop is None) == (found.witness is None)
        net = subject.net.with_initial({found.queue.capacity: 2})
        marking = net.initial.tolist()
        for t in [] if loop is None else [*loop.prefix, *loop.suffix * 4]:
            if not net.is_enabled(t, marking):
                assert any(net.is_enabled(drop, marking) for drop in drops)
                break
            marking = net.fire(t, marking)
        else:
            assert loop is None
    else:
        assert found.reason
        assert "time" in found.reason or not any(
            loses(capacity) for capacity in (capacities.LARGEST_TRIED, capacities.LARGEST)
        )


@pytest.mark.long
@settings(max_examples=4, deadline=None)
@given(unbounded_systems())
def test_each_queue_has_an_answer_of_its_own(model: sym.SystemModel) -> None:
    for found in suggest_capacities(model, ENOUGH):
        keeps_its_word(model, found)


@pytest.mark.long
@settings(max_examples=2, deadline=None)
@given(unbounded_systems())
def test_trying_the_tree_and_loops_say_the_same(model: sym.SystemModel) -> None:
    answers = suggest_capacities(model, Budget(seconds=60))  # a busy machine must not decide
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(capacities, "loop_raising", lambda *_: None)
        patch.setattr(capacities, "LARGEST_TRIED", 4)
        without_loops = suggest_capacities(model, ENOUGH)
    for one, other in zip(answers, without_loops, strict=True):
        if other.needed is not None or other.grows:
            assert (one.needed, one.grows) == (other.needed, other.grows)
        else:
            assert one.grows or (one.needed or 0) > 4 or not one.needed or "time" in other.reason


@pytest.mark.long
def test_without_the_state_space_the_answers_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    model = talker()
    expected = [(each.needed, each.grows) for each in suggest_capacities(model, ENOUGH)]
    monkeypatch.setattr(capacities, "FIRST_WORK", -1)
    assert [(each.needed, each.grows) for each in suggest_capacities(model, ENOUGH)] == expected
    assert any(needed for needed, _ in expected)


def test_what_grows_far_away_is_found_by_walks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(capacities, "loop_raising", lambda *_: None)
    found = suggest_capacities(timer_and_logger(), ENOUGH)
    assert [(each.grows, each.reason) for each in found] == [(True, capacities.GROWS)] * 3
    for each in found:
        assert each.witness is not None and each.witness.loop is not None


@pytest.mark.parametrize("counter", [False, True])
def test_a_timer_without_end_fills_all_three_queues(counter: bool) -> None:
    found = suggest_capacities(timer_and_logger(counter))
    assert [(each.needed, each.grows, each.reason) for each in found] == [(None, True, capacities.GROWS)] * 3
    for each in found:
        assert each.witness is not None and each.witness.loop is not None
        assert each.witness.steps[-1].text.endswith("takes a message")
        assert "timer_tick waiting for log" in each.fix


def test_without_time_the_reason_is_told() -> None:
    found = suggest_capacities(timer_and_logger(), Budget(seconds=1e-9))
    assert len(found) == 3
    assert all(each.needed is None and not each.grows and each.reason for each in found)


@settings(max_examples=30, deadline=None)
@given(nets())
def test_the_largest_beside_is_what_plain_search_sees(net: CompiledNet) -> None:
    seen = plain_search(net, MOST)
    for place in range(len(net.places)):
        other = (place + 1) % len(net.places)
        most = largest_beside(net, place, [other], Budget(seconds=0.5))
        shown = max((m[place] for m in seen.markings if m[other] >= 1), default=-1)
        if most is not None:
            assert most >= shown
            if seen.is_complete:
                assert most == shown


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(nets())
def test_loops_repeat(net: CompiledNet) -> None:
    for place in range(len(net.places)):
        loop = loop_raising(net, place, Budget(seconds=0.3))
        if loop is None:
            continue
        marking = net.initial.tolist()
        for t in [*loop.prefix, *loop.suffix * 4]:
            assert net.is_enabled(t, marking)
            marking = net.fire(t, marking)
        assert marking[place] >= 4 and place in loop.places
        most = largest_beside(net, place, [place], Budget(seconds=0.5))
        assert most in (None, inf)
