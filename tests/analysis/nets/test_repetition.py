"""Transitions that can be repeated, against the cycles of stored graphs."""

from __future__ import annotations

import networkx as nx
import pytest
from hypothesis import HealthCheck, given, settings

from case_study.build import build
from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.linear_programs import LinearProgram
from dineros.analysis.nets.repetition import repeatable_transitions
from tests.analysis import classic_nets as classic
from tests.analysis.reference_search import reachability_graph, reference_search
from tests.analysis.strategies import nets


def on_cycles(net: CompiledNet) -> set[int]:
    """Return the transitions on cycles of the stored graph."""
    graph = reachability_graph(net)
    part = {m: number for number, some in enumerate(nx.strongly_connected_components(graph)) for m in some}
    return {t for source, target, t in graph.edges(keys=True) if part[source] == part[target]}


@pytest.mark.long
@given(nets())
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_whatever_is_on_a_cycle_is_repeatable(net: CompiledNet) -> None:
    if reference_search(net, 1_000) is not None:
        assert on_cycles(net) <= repeatable_transitions(net)


@pytest.mark.parametrize("net", [classic.philosophers(4), classic.kanban(1), classic.round_robin_mutex(4)])
def test_nets_that_go_round(net: CompiledNet) -> None:
    assert repeatable_transitions(net) == frozenset(range(len(net.transitions)))


def test_weights_other_than_one_are_found() -> None:
    net = CompiledNet.build(
        {"a": 6, "b": 0, "c": 0},
        [("t", {"a": 3}, {"b": 2}), ("u", {"b": 1}, {"a": 1}), ("v", {"b": 1}, {"c": 1})],
    )
    assert repeatable_transitions(net) == frozenset()


def test_a_proposal_that_does_not_stand_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"a": 1})])
    monkeypatch.setattr(LinearProgram, "solve", lambda *_: [0.0, 1.0, 1.0, 1.0])
    assert repeatable_transitions(net) == {0, 1}


def test_of_the_case_study_only_asking_the_sensor() -> None:
    subject = subject_of(build(), "none")
    again = {subject.transition_text(t).split(" of server")[0] for t in repeatable_transitions(subject.net)}
    assert {name for name in again if " " not in name} == {"TSense", "TRetry", "TSafe", "TUnsafe", "TStop"}
    assert len(again) == 9
