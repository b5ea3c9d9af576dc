"""Coverability against plain search and the plain tree of Karp and Miller."""

from __future__ import annotations

from math import inf

import pytest
from hypothesis import given, settings

from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.coverability import coverability
from tests.analysis.covering.plain import plain_karp_miller
from tests.analysis.reductions.brute_force import Graph
from tests.analysis.reductions.generated_nets import nets


def _without_inhibitors(net: CompiledNet) -> CompiledNet:
    return CompiledNet.build(
        dict(zip(net.places, net.initial.tolist(), strict=True)),
        [
            Transition(
                name,
                {net.places[p]: w for p, w in net.pre.row(t)},
                {net.places[p]: w for p, w in net.post.row(t)},
            )
            for t, name in enumerate(net.transitions)
        ],
    )


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(nets())
def test_the_minimal_coverability_set_is_that_of_the_plain_tree(net: CompiledNet) -> None:
    net = _without_inhibitors(net)
    expected = plain_karp_miller(net)
    if expected is not None:
        answer = coverability(net)
        assert answer.maximal is not None and set(answer.maximal) == expected
        assert answer.is_bounded == (not any(inf in marking for marking in expected))


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(nets())
def test_bounds_and_verdict_agree_with_plain_search(net: CompiledNet) -> None:
    answer = coverability(net)
    graph = Graph.of(net)
    if graph.is_complete:
        assert answer.is_bounded is not False
        if answer.bounds is not None:
            assert answer.bounds == tuple(max(column) for column in zip(*graph.successors, strict=True))
    if answer.is_bounded is False:
        assert answer.pumping is not None and answer.pumping.places
        marking = net.initial.tolist()
        for t in [*answer.pumping.prefix, *answer.pumping.suffix * 5]:
            marking = net.fire(t, marking)
        assert all(marking[p] >= 5 for p in answer.pumping.places)


PRODUCER = Transition("produce", {"ready": 1}, {"ready": 1, "buffer": 1})


def test_a_producer_pumps_its_buffer() -> None:
    net = CompiledNet.build(
        {"begin": 1, "ready": 0, "buffer": 0}, [Transition("start", {"begin": 1}, {"ready": 1}), PRODUCER]
    )
    answer = coverability(net)
    assert (answer.is_bounded, answer.bounds) == (False, (1, 1, inf))
    assert answer.pumping is not None
    assert (answer.pumping.prefix, answer.pumping.suffix, answer.pumping.places) == ((0,), (1,), (2,))


def test_an_inhibitor_arc_that_limits_the_buffer_leaves_the_answer_open() -> None:
    limited = Transition("produce", {"ready": 1}, {"ready": 1, "buffer": 1}, {"buffer": 3})
    answer = coverability(CompiledNet.build({"ready": 1, "buffer": 0}, [limited]))
    assert answer.is_bounded is None and "inhibitor" in str(answer.reason)


def test_an_inhibitor_arc_elsewhere_does_not_hide_the_pumping() -> None:
    other = Transition("produce", {"ready": 1}, {"ready": 1, "buffer": 1}, {"off": 1})
    answer = coverability(CompiledNet.build({"ready": 1, "buffer": 0, "off": 0}, [other]))
    assert answer.is_bounded is False and answer.pumping is not None and answer.pumping.places == (1,)


def test_bounded_without_inhibitor_arcs_is_bounded_with_them() -> None:
    net = CompiledNet.build({"p": 1, "q": 0}, [Transition("t", {"p": 1}, {"q": 1}, {"q": 1})])
    assert coverability(net).is_bounded is True


def test_the_limit_on_nodes_leaves_the_answer_open() -> None:
    tokens = {f"p{k}": 1 for k in range(8)} | {f"q{k}": 0 for k in range(8)}
    net = CompiledNet.build(tokens, [Transition(f"t{k}", {f"p{k}": 1}, {f"q{k}": 1}) for k in range(8)])
    answer = coverability(net, limit=20)
    assert answer.is_bounded is None and "20 nodes" in str(answer.reason)
    assert coverability(net).is_bounded is True
