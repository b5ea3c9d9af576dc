"""Checks of models without bounds."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.covering.bounded_part import without_places
from dineros.analysis.covering.growth import growth_of, remedy_of, with_credits
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel import sym
from tests.analysis.covering.plain import plain_karp_miller, plain_search
from tests.analysis.covering.unbounded_models import compare
from tests.analysis.strategies import nets
from tests.support.systems.unbounded_systems import timer_and_logger, unbounded_systems


@pytest.mark.long
@settings(max_examples=6, deadline=None)
@given(unbounded_systems())
def test_nothing_stays_unknown_that_plain_searches_find(model: sym.SystemModel) -> None:
    compare(model, check(model), 3_000)


@pytest.mark.parametrize("counter", [False, True])
def test_a_timer_that_publishes_for_ever(counter: bool) -> None:
    report = check(timer_and_logger(counter))
    overflows = [finding for finding in report.findings if finding.rule == "queue-overflow"]
    assert [finding.elements for finding in overflows] == [
        ("ticks", "timer_said"),
        ("ticks", "logger"),
        ("ticks", "heard"),
    ]
    for finding in overflows:
        assert finding.witness is not None
        assert finding.witness.steps[-1].text == finding.message.replace(
            "can overflow: a message is lost", "loses a message"
        )
    assert [finding.rule for finding in report.findings if finding not in overflows] == ["unbounded"]
    assert {"no deadlock", "every transition can fire, every channel is used"} <= set(report.proved)
    (remedy,) = (text for text in report.proved if text.startswith("the net would be bounded"))
    assert "timer_tick waiting for log or the loss of a message, 1 at a time" in remedy
    assert ("without the counters that grow forever: counted" in remedy) == counter
    assert not any(unknown.may_be_fault for unknown in report.unknown)


def test_one_place_that_grows_needs_a_capacity() -> None:
    net = CompiledNet.build(
        {"on": 1, "buffer": 0, "spare": 0},
        [
            ("make", {"on": 1}, {"on": 1, "buffer": 1}),
            ("use", {"buffer": 3}, {}),
            ("never", {"spare": 1}, {}),
        ],
    )
    remedy = remedy_of(net)
    assert remedy is not None
    assert (remedy.weights, remedy.waiting, remedy.acknowledging) == ({1: 1}, (0,), (1,))


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(nets())
def test_a_remedy_makes_the_net_bounded(net: CompiledNet) -> None:
    remedy = remedy_of(net)
    if remedy is None:
        return
    left = [p for p in range(len(net.places)) if p not in remedy.counters]
    small = without_places(net, remedy.counters)
    weights = {left.index(place): weight for place, weight in remedy.weights.items()}
    fixed = with_credits(small, weights, remedy.credits)
    maximal = plain_karp_miller(fixed)
    assert maximal is None or all(max(marking) < float("inf") for marking in maximal)
    assert growth_of(fixed, Budget(seconds=5)) is None


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(nets())
def test_growth_is_found_where_it_is(net: CompiledNet) -> None:
    pumping = growth_of(net, Budget(seconds=10))
    if pumping is not None:
        marking = net.initial.tolist()
        for t in [*pumping.prefix, *pumping.suffix * 4]:
            marking = net.fire(t, marking)
        assert all(marking[place] >= 4 for place in pumping.places) and pumping.places
        assert not plain_search(net, 2_000).is_complete
