"""Signals with several values: flattened nets, clauses and running nodes do what an interpreter says."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace
from functools import partial

import pytest

from dineros.analysis.conformance import conform
from dineros.analysis.model.satisfiability import unsatisfiable_clauses
from dineros.analysis.model.subject import base_subject
from dineros.metamodel import sym
from dineros.metamodel.clauses import evaluate
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import transitions
from dineros.metamodel.records import Signal
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.node import Node
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.flattening.split import split
from dineros.transformations.rules.signals import ENABLED
from tests.analysis.conformance.recording import recorded
from tests.support.isomorphism import are_isomorphic
from tests.support.reachability import ReachabilityGraph
from tests.support.references.flattening import plain_net_of, reference_flattening
from tests.support.references.valued_signals import SIGNALS, Drawn, drawn

SEEDS = range(12)


def _flattened_states(found: Drawn, variant: str) -> set[tuple[tuple[int, ...], tuple[bool | str, ...]]]:
    """Return the reachable markings of the flattened net, as tokens of places and values of signals."""
    graph = ReachabilityGraph(plain_net_of(flatten(found.model, variant).net))  # type: ignore[arg-type]
    number = {str(name): index for index, name in enumerate(graph.places)}
    states = set()
    for marking in {graph.start, *(after for _, _, after in graph.firings(5000))}:
        values: list[bool | str] = []
        for signal in sorted(found.used()):
            if not SIGNALS[signal]:
                values.append(marking[number[f"{signal}.true"]] == 1)
                continue
            (value,) = (each for each in SIGNALS[signal] if marking[number[f"{signal}.{each}"]])
            values.append(value)
        states.add((tuple(marking[number[name]] for name in found.tokens), tuple(values)))
    return states


@pytest.mark.parametrize("seed", SEEDS)
def test_the_flattened_net_has_the_states_of_the_interpreter(seed: int) -> None:
    found = drawn(seed)
    assert [each for each in validate(found.model) if each.severity == "error"] == []
    for variant in ENABLED:
        assert _flattened_states(found, variant) == found.states(variant), variant
    variant = ENABLED[seed % len(ENABLED)]
    net = flatten(found.model, variant).net
    assert are_isomorphic(plain_net_of(net), reference_flattening(found.model, variant, "weighted"))


@pytest.mark.parametrize("seed", SEEDS)
def test_normal_forms_and_satisfiability(seed: int) -> None:
    found = drawn(seed)
    everything = [found.settings(signal) for signal in SIGNALS]
    settings = [dict(zip(SIGNALS, each, strict=True)) for each in itertools.product(*everything)]
    never = {str(each.transition.id) for each in unsatisfiable_clauses(found.model)}
    for transition in transitions(found.model):
        assert isinstance(transition, sym.Transition) and transition.clause is not None
        meaning = found.clauses[str(transition.id)]
        assert [evaluate(transition.clause, each) for each in settings] == [
            meaning(each) for each in settings
        ]
        assert (transition.id in never) is not any(map(meaning, settings))
        for disjunction in transition.clause.disjunctions:
            excluded = [
                each.signal for each in disjunction.literals if each.negated and each.value is not None
            ]
            for signal in excluded:
                assert sum(each.signal is signal for each in disjunction.literals) == 1


@pytest.mark.parametrize("seed", SEEDS)
def test_the_net_without_signals_has_the_same_places(seed: int) -> None:
    found = drawn(seed)
    subject = base_subject(found.model)
    assert {str(each) for each in subject.net.transitions} == {
        name
        for name in found.steps
        if name not in {str(each.transition.id) for each in unsatisfiable_clauses(found.model)}
    }
    with_signals = {tokens for tokens, _ in found.states("fully-enabled")}
    assert with_signals == _tokens_without_signals(found)


def _tokens_without_signals(found: Drawn) -> set[tuple[int, ...]]:
    subject = base_subject(found.model)
    net = subject.net
    start = tuple(int(tokens) for tokens in net.initial)
    order = [net.places.index(name) for name in found.tokens]
    seen, todo = {start}, [start]
    while todo:
        marking = todo.pop()
        for transition in range(len(net.transitions)):
            if not net.is_enabled(transition, marking):
                continue
            after = list(marking)
            for place, change in net.delta[transition].items():
                after[place] += change
            if tuple(after) not in seen:
                seen.add(tuple(after))
                todo.append(tuple(after))
    return {tuple(marking[place] for place in order) for marking in seen}


@pytest.mark.parametrize("seed", SEEDS)
def test_a_running_node_has_the_transitions_of_the_interpreter(seed: int) -> None:
    found, draw = drawn(seed), random.Random(seed)
    net = Net(split(found.model)[0], seed=seed)
    node = Node(net)
    net.halt("the test fires by itself")
    node.open()
    for _ in range(60):
        signal = draw.choice(list(SIGNALS))
        net.signal(signal).set(draw.choice(found.settings(signal)))
        node.run_until_idle()
        seen = net.inspect()
        tokens = {place: len(seen.marking.get(place, ())) for place in found.tokens}
        assert set(seen.enabled) == found.enabled(tokens, dict(seen.signals))
    node.close()


@pytest.mark.parametrize("seed", range(8))
def test_runs_conform_and_values_that_are_none_do_not(seed: int) -> None:
    found = drawn(seed)
    records = recorded(found.model, seed, 40)["node"]
    assert conform(found.model, {"node": partial(iter, records)}).status == "conforms"
    for number, record in enumerate(records):
        if isinstance(record, Signal) and isinstance(record.value, str):
            wrong = [*records[:number], replace(record, value="elsewhere")]
            verdict = conform(found.model, {"node": partial(iter, wrong)})
            assert "has no value 'elsewhere'" in str(verdict.violations[0])
            return
