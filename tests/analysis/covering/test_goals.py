"""Goals in nets without bounds, against plain search."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.covering.goals import decide_goal
from dineros.analysis.explicit.goals import Comparison, Goal, Relation
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.asking import find_marking
from tests.analysis.covering.plain import plain_search
from tests.analysis.strategies import nets
from tests.support.systems.unbounded_systems import timer_and_logger

RELATIONS: list[Relation] = ["<", "<=", "=", ">=", ">"]


@st.composite
def goals(draw: st.DrawFn, net: CompiledNet) -> Goal:
    """One or two conjunctions of comparisons of single places."""
    places = st.integers(0, len(net.places) - 1)
    comparison = st.builds(
        lambda place, relation, value: Comparison({place: 1}, relation, value),
        places,
        st.sampled_from(RELATIONS),
        st.integers(-1, 4),
    )
    conjunction = st.lists(comparison, min_size=1, max_size=3).map(tuple)
    return Goal(conjunctions=tuple(draw(st.lists(conjunction, min_size=1, max_size=2))))


@pytest.mark.long
@settings(max_examples=50, deadline=None)
@given(st.data())
def test_goals_are_met_where_plain_search_meets_them(data: st.DataObject) -> None:
    net = data.draw(nets())
    goal = data.draw(goals(net))
    found, seen = decide_goal(net, goal, Budget(seconds=20)), plain_search(net, 3_000)
    is_met = any(goal.holds(net, marking) for marking in seen.markings)
    if is_met:
        assert found is not None and found.status == "reachable"
    elif seen.is_complete:
        assert found is not None and found.status == "unreachable"
    if found is not None and found.trace is not None:
        assert goal.holds(net, replay(net, found.trace)[-1])


@pytest.mark.long
def test_questions_about_a_counter_stop_at_what_they_compare_it_with() -> None:
    subject = base_subject(timer_and_logger(counter=True))
    budget = Budget(memory_bytes=1 << 29)
    for text, status in [
        ("counted >= 25 & heard >= 1", "reachable"),
        ("counted == 7 & timer_said >= 3", "reachable"),
        ("counted >= 1 & timer_clock == 0", "unreachable"),
        ("deadlock", "unreachable"),
    ]:
        answer = find_marking(subject.net, text, subject.names, budget)
        assert answer.status == status, text
