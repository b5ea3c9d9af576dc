"""What a smaller net proves of a net that always comes back, against a search over the whole graph."""

from __future__ import annotations

import random

import networkx as nx
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.properties.recurrence import recurrence
from tests.analysis import classic_nets as classic
from tests.analysis.reductions import generated_nets
from tests.analysis.reference_search import reachability_graph, reference_search
from tests.analysis.strategies import nets


def turning_net(seed: int) -> CompiledNet:
    """Make a net of circles of places, most of which are turned by steps that some share; few are stuck."""
    chance = random.Random(seed)
    places: dict[str, int] = {}
    steps: list[tuple[dict[str, int], dict[str, int]]] = []
    for circle in range(chance.randint(1, 3)):
        size, tokens = chance.randint(1, 4), chance.choice([1, 1, 1, 2])
        names = [f"p{circle}_{at}" for at in range(size)]
        places |= {name: tokens if at == 0 else 0 for at, name in enumerate(names)}
        for at, name in enumerate(names):
            for _ in range(chance.choice([1, 1, 1, 2])):
                after = names[(at + 1) % size] if chance.random() < 0.9 else chance.choice(names)
                steps.append(({name: 1}, {after: 1}))
    for number in range(chance.randint(0, 2)):
        # A buffer that one step fills and another one empties.
        buffer, space = f"buffer{number}", f"space{number}"
        places |= {buffer: 0, space: chance.randint(1, 2)}
        filling, emptying = chance.choice(steps), chance.choice(steps)
        for (inputs, outputs), (taken, put) in ((filling, (space, buffer)), (emptying, (buffer, space))):
            inputs[taken], outputs[put] = inputs.get(taken, 0) + 1, outputs.get(put, 0) + 1
    while len(steps) > 2 and chance.random() < 0.5:
        (one, other), (more, others) = steps.pop(chance.randrange(len(steps))), chance.choice(steps)
        for row, added in ((more, one), (others, other)):
            row.update({place: row.get(place, 0) + weight for place, weight in added.items()})
    transitions = []
    for number, (inputs, outputs) in enumerate(steps):
        row = {chance.choice(list(places)): chance.randint(1, 2)} if chance.random() < 0.15 else {}
        inhibitors, reads = (row, {}) if chance.random() < 0.5 else ({}, row)
        transitions.append(Transition(f"t{number}", inputs, outputs, inhibitors, reads))
    return CompiledNet.build(places, transitions)


def is_right(net: CompiledNet) -> bool | None:
    """Whether the answer is a proof, each part of which the graph confirms; None where the graph is large."""
    found, counts = recurrence(net), reference_search(net, 1_000)
    if counts is None:
        return None
    if found is None:
        return False
    graph = reachability_graph(net)
    assert nx.is_strongly_connected(graph)
    assert counts.deadlocks == 0
    fired = {t for _, _, t in graph.edges(keys=True)}
    assert found.dead == set(range(len(net.transitions))) - fired
    assert all(most <= bound for most, bound in zip(counts.largest_place, found.bounds, strict=True))
    return True


@pytest.mark.long
def test_nets_of_circles() -> None:
    come_back, seen = 0, 0
    for seed in range(300):
        net = turning_net(seed)
        answer = is_right(net)
        if answer is not None:
            graph = reachability_graph(net)
            come_back += len(graph.edges) > 0 and nx.is_strongly_connected(graph)
            seen += answer
    assert 50 <= come_back <= 250
    assert seen >= 0.8 * come_back


@pytest.mark.long
@given(st.one_of(nets(), generated_nets.nets()))
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_generated_nets(net: CompiledNet) -> None:
    is_right(net)


@pytest.mark.parametrize("net", [classic.kanban(1), classic.round_robin_mutex(4)])
def test_classic_nets_that_come_back(net: CompiledNet) -> None:
    assert is_right(net)


def test_a_net_with_a_deadlock_does_not() -> None:
    assert recurrence(classic.philosophers(3)) is None


def test_a_live_net_that_does_not_come_back() -> None:
    # Both tokens never come to lie in `a` again, as `join` moves one of them and the other on, and out.
    net = CompiledNet.build(
        {"start": 1, "a": 0, "b": 0},
        [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"a": 1}), ("v", {"start": 1}, {"a": 1})],
    )
    assert recurrence(net) is None
    turning = CompiledNet.build(
        {"a": 2, "b": 0, "c": 0},
        [("t", {"a": 2}, {"b": 1, "c": 1}), ("u", {"b": 1}, {"c": 1}), ("v", {"c": 1}, {"b": 1})],
    )
    assert recurrence(turning) is None


def test_a_transition_that_never_fires_is_named_and_takes_nothing_away() -> None:
    net = CompiledNet.build(
        {"a": 1, "b": 0},
        [("t", {"a": 1}, {"b": 1}), ("never", {"a": 1, "b": 1}, {"a": 2}), ("u", {"b": 1}, {"a": 1})],
    )
    found = recurrence(net)
    assert found is not None and found.dead == {1} and found.bounds == (1, 1)


def test_an_unbounded_net_is_none() -> None:
    assert recurrence(CompiledNet.build({"a": 0}, [("t", {}, {"a": 1}), ("u", {"a": 1}, {})])) is None
