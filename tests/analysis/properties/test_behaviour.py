"""Liveness, reversibility and home markings against a search over the whole graph."""

from __future__ import annotations

import networkx as nx
import pytest
from hypothesis import HealthCheck, given, settings

from case_study.build import build
from dineros.analysis.answers.budget import Budget
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.properties.behaviour import Behaviour, TooMuchWorkError, behaviour
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.metamodel.settings import apply
from tests.analysis import classic_nets as classic
from tests.analysis.reference_search import reachability_graph, reference_search
from tests.analysis.strategies import nets


def reference(net: CompiledNet) -> Behaviour:
    """By the components of the stored graph."""
    graph = reachability_graph(net)
    ends = list(nx.attracting_components(graph))
    fired = [{t for m in end for _, _, t in graph.out_edges(m, keys=True)} for end in ends]
    not_live = tuple(t for t in range(len(net.transitions)) if not all(t in some for some in fired))
    home = len(ends[0]) if len(ends) == 1 else 0
    return Behaviour(len(ends[0]) == len(graph), home, not_live)


@pytest.mark.long
@given(nets())
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_generated_nets(net: CompiledNet) -> None:
    if reference_search(net, 1_000) is not None:
        assert behaviour(symbolic_state_space(net, Budget(1 << 24))) == reference(net)


@pytest.mark.parametrize(
    "net",
    [
        classic.philosophers(4),
        classic.kanban(1),
        classic.round_robin_mutex(4),
        # Two ways to end, in none of which everything fires.
        CompiledNet.build(
            {"s": 1, "a": 0, "b": 0},
            [
                ("left", {"s": 1}, {"a": 1}),
                ("right", {"s": 1}, {"b": 1}),
                ("x", {"a": 1}, {"a": 1}),
                ("y", {"b": 1}, {"b": 1}),
            ],
        ),
    ],
)
def test_classic_nets(net: CompiledNet) -> None:
    assert behaviour(symbolic_state_space(net)) == reference(net)


def test_more_ways_to_end_than_are_looked_at_one_by_one() -> None:
    ways = range(40)
    net = CompiledNet.build(
        {"s": 1, **{f"p{i}": 0 for i in ways}},
        [
            *((f"go{i}", {"s": 1}, {f"p{i}": 1}) for i in ways),
            *((f"stay{i}", {f"p{i}": 1}, {f"p{i}": 1}) for i in ways),
        ],
    )
    assert behaviour(symbolic_state_space(net)) == reference(net)


def sorting(objects: int) -> SymbolicStateSpace:
    model = build()
    for color in ("Red", "Blue", "Green"):
        apply(model, f"{color}Objects.tokens={objects}")
    return symbolic_state_space(base_subject(model).net)


@pytest.mark.parametrize("objects", [1, 2])
def test_the_case_study(objects: int) -> None:
    answer = behaviour(sorting(objects))
    # The sensor is asked again and again when all objects are sorted.
    assert (answer.reversible, answer.home_markings) == (False, 8)


def test_work_that_is_too_much_is_not_done() -> None:
    with pytest.raises(TooMuchWorkError):
        behaviour(sorting(2), work=1_000)


def test_a_deadlock_beside_a_terminal_part() -> None:
    net = CompiledNet.build(
        {"s": 1, "a": 0, "b": 0, "end": 0},
        [
            ("stop", {"s": 1}, {"end": 1}),
            ("go", {"s": 1}, {"a": 1}),
            ("to", {"a": 1}, {"b": 1}),
            ("fro", {"b": 1}, {"a": 1}),
        ],
    )
    assert behaviour(symbolic_state_space(net)) == reference(net) == Behaviour(False, 0, (0, 1, 2, 3))
