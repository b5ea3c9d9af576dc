"""Conditions on markings, searched for directly, against their definition."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit import Order
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.asking import find_firing, find_marking
from tests.analysis import classic_nets as classic
from tests.analysis.strategies import nets

LIMIT = 500
MEMORY = Budget(1 << 24)


def conditions(net: CompiledNet) -> st.SearchStrategy[str]:
    """Conditions on the markings of a net, as text."""
    comparison = st.builds(
        "{0} {1} {2}".format,
        st.sampled_from([*net.places, f"{net.places[0]} + {net.places[-1]}"]),
        st.sampled_from(["<", "<=", "==", "!=", ">=", ">"]),
        st.integers(0, 4),
    )
    enabled = st.builds("enabled({0})".format, st.sampled_from(net.transitions))
    atoms = st.one_of(comparison, enabled, st.sampled_from(["deadlock", "true", "false"]))
    return st.recursive(
        atoms,
        lambda inner: st.one_of(
            st.builds("!({0})".format, inner),
            st.builds("({0}) {1} ({2})".format, inner, st.sampled_from(["&", "|", "->", "<->"]), inner),
        ),
        max_leaves=4,
    )


@given(st.data())
@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much]
)
def test_conditions_hold_where_their_definition_says(data: st.DataObject) -> None:
    net = data.draw(nets())
    text = data.draw(conditions(net))
    condition = parse(text, "state")
    bound = BoundAtoms(net, condition, NetNames(net))

    def holds(marking: tuple[int, ...]) -> bool:
        return holds_on_lasso(condition, [], [Step(marking, None)], bound.is_true)

    start = tuple(net.initial.tolist())
    distance, frontier = {start: 0}, [start]
    for marking in frontier:
        for t in range(len(net.transitions)):
            if net.is_enabled(t, marking):
                successor = tuple(net.fire(t, marking))
                if successor not in distance:
                    distance[successor] = distance[marking] + 1
                    frontier.append(successor)
        assume(len(frontier) <= LIMIT)
    order: Order = data.draw(st.sampled_from(["breadth-first", "depth-first"]))
    answer = find_marking(net, text, NetNames(net), MEMORY, order=order)
    best = min((steps for marking, steps in distance.items() if holds(marking)), default=None)
    if best is None:
        assert answer.status == "unreachable"
        return
    assert answer.trace is not None
    assert holds(tuple(replay(net, answer.trace)[-1]))
    if order == "breadth-first" and "deadlock" not in text:
        assert len(answer.trace) == best


def test_what_would_be_too_many_conjunctions_is_asked_of_temporal_logic() -> None:
    net = classic.philosophers(9)
    text = " & ".join(f"(eat{i} == 1 | left{i} == 1)" for i in range(9))
    answer = find_marking(net, text, NetNames(net), Budget(1 << 26))
    assert answer.trace is not None
    last = dict(zip(net.places, replay(net, answer.trace)[-1], strict=True))
    assert all(last[f"eat{i}"] or last[f"left{i}"] for i in range(9))


def test_an_interruption_ends_all_searches(monkeypatch: pytest.MonkeyPatch) -> None:
    from dineros.analysis import reductions
    from dineros.analysis.explicit import search

    monkeypatch.setattr(search, "PROGRESS_SECONDS", 0.0)
    monkeypatch.setattr(reductions, "reduce", None)
    told: list[Any] = []

    def stop(progress: Any) -> None:
        told.append(progress)
        raise KeyboardInterrupt

    net = CompiledNet.build(
        {"a": 300, "b": 0, "c": 0, "d": 0},
        [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"c": 1}), ("v", {"a": 200, "c": 150}, {})],
    )
    answer = find_firing(net, 2, Budget(1 << 30, progress=stop))
    assert (answer.status, answer.reason, len(told)) == ("unknown", "interrupted", 1)
    assert answer.states
