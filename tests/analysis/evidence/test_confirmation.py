"""Answers that rest on all markings are decided again, and an engine that is wrong is found out."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.evidence.confirmation import (
    Confirmation,
    confirm_answer,
    confirm_counts,
    confirm_properties,
    confirm_space,
    rests_on_markings,
)
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.answering import answer_properties
from dineros.analysis.properties.property import Property, PropertyAnswer
from dineros.analysis.questions.net_questions import Branching, Enabled, Linear, Marking
from dineros.analysis.questions.state_space import state_space
from dineros.analysis.symbolic.engine import symbolic_state_space
from tests.analysis.classic_nets import kanban, philosophers
from tests.analysis.strategies import nets
from tests.support.broken_engines import break_diagrams, break_search

NET = philosophers(4)


@pytest.fixture
def broken_diagrams(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let diagrams miss markings."""
    break_diagrams(monkeypatch)


def test_counts_are_confirmed_by_the_other_engine() -> None:
    for engine, other in (("explicit", "decision diagrams"), ("symbolic", "explicit search")):
        said = confirm_counts(NET, state_space(NET, engine))  # type: ignore[arg-type]
        assert said.agrees and len(said.by) == 1 and said.by[0].startswith(other)


def test_another_order_confirms_where_search_gives_up() -> None:
    net = kanban(3)
    space = symbolic_state_space(net)
    said = confirm_space(space, Budget(states=100))
    assert said.agrees and said.by[0].startswith("decision diagrams in another order")
    said = confirm_counts(net, state_space(net, "symbolic"), Budget(states=100))
    assert said.agrees and said.by[0].startswith("decision diagrams in another order")
    question = Branching(net, NetNames(net), "AG EF enabled(" + net.transitions[0] + ")")
    answer = question.decided(UNLIMITED)
    said = confirm_answer(question, answer, Budget(states=100))
    assert said.agrees and [name.rpartition(" (")[0] for name in said.by] == [
        "decision diagrams",
        "decision diagrams in another order",
    ]


def test_what_nobody_can_count_is_not_confirmed() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"a": 1, "b": 1})])
    question = Marking(net, NetNames(net), "a >= 2")
    said = confirm_answer(question, Outcome("unreachable"), Budget(states=1_000))
    assert said.agrees is None and "states" in str(said)


@pytest.mark.parametrize("seconds", [1e-9])
def test_without_time_nothing_is_confirmed(seconds: float) -> None:
    said = confirm_space(symbolic_state_space(NET), Budget(seconds=seconds))
    assert said.agrees is None and "time" in said.reason


@settings(max_examples=15, deadline=None)
@given(nets(), st.integers(0, 3), st.sampled_from(["AG", "EF", "AF", "EG"]))
def test_right_answers_are_never_contradicted(net: CompiledNet, least: int, operator: str) -> None:
    few = Budget(states=2_000, memory_bytes=64 << 20)
    names, place = NetNames(net), net.places[0]
    for question in (
        Branching(net, names, f"{operator} {place} >= {least}"),
        Linear(net, names, f"G {place} <= {least}"),
        Marking(net, names, f"{place} >= {least}"),
        Enabled(net, names, net.transitions[0]),
    ):
        answer = question.decided(few)
        if rests_on_markings(answer):
            assert confirm_answer(question, answer, few).agrees is not False


def questions() -> list[Any]:
    names, last = NetNames(NET), max(NET.transitions)
    return [
        Branching(NET, names, f"EF enabled({last}) & AG EF enabled({last})"),
        Branching(NET, names, f"EG !enabled({last}) -> EF enabled({last})"),
    ]


@pytest.mark.parametrize("number", range(2))
@pytest.mark.usefixtures("broken_diagrams")
def test_broken_diagrams_disagree(number: int) -> None:
    question = questions()[number]
    said = confirm_answer(question, Outcome("holds"))
    assert_disagreement(said, ["explicit search", "decision diagrams"])


@pytest.mark.usefixtures("broken_diagrams")
def test_broken_counts_disagree() -> None:
    said = confirm_counts(NET, state_space(NET, "explicit"))
    assert_disagreement(said, ["decision diagrams"])
    # What the broken engine counted itself is found out by the other one.
    said = confirm_counts(NET, state_space(NET, "symbolic"))
    assert_disagreement(said, ["explicit search"])
    assert_disagreement(confirm_space(symbolic_state_space(NET)), ["explicit search"])


def test_a_broken_search_disagrees(monkeypatch: pytest.MonkeyPatch) -> None:
    break_search(monkeypatch)
    assert_disagreement(confirm_counts(NET, state_space(NET, "symbolic")), ["explicit search"])


def properties() -> list[Property]:
    fired = min(NET.transitions)
    return [
        Property("eats", "ctl", parse(f"EF enabled({fired}) & !(AG EF enabled({fired}))", "ctl")),
        Property("stuck", "ltl", parse("G !deadlock")),
        Property("settles", "ltl", parse(f"F G !enabled({fired})")),
        Property("held", "bound", places=tuple(NET.places[:3])),
        Property("Liveness", "global", examination="Liveness"),
        Property("OneSafe", "global", examination="OneSafe"),
    ]


def of_markings(said: dict[str, bool | int], technique: str = "symbolic") -> dict[str, PropertyAnswer]:
    return {id: PropertyAnswer(id, value, 0.0, technique) for id, value in said.items()}


def test_properties_are_confirmed_together_and_a_wrong_answer_is_found_out() -> None:
    answers = {one.id: one for one in answer_properties(NET, NetNames(NET), properties())}
    right = {id: answer.value for id, answer in answers.items() if answer.value is not None}
    assert len(right) == 6
    said = confirm_properties(NET, NetNames(NET), properties(), of_markings(right))
    assert {id for id, one in said.items() if one.agrees} == right.keys() - {"settles"}
    assert said["settles"].reason == "only one engine decides this kind of formula"
    for id in right.keys() - {"settles"}:
        wrong = right | {id: right[id] + 1 if id == "held" else not right[id]}
        said = confirm_properties(NET, NetNames(NET), properties(), of_markings(wrong))
        assert [name for name, one in said.items() if one.agrees is False] == [id]


def test_of_properties_what_runs_or_structure_show_is_not_asked_again() -> None:
    answers = of_markings({"stuck": False}, "random walk") | of_markings({"OneSafe": True}, "structure")
    assert confirm_properties(NET, NetNames(NET), properties(), answers) == {}


@pytest.mark.usefixtures("broken_diagrams")
def test_broken_diagrams_disagree_on_properties() -> None:
    one = Property("last", "ctl", parse(f"EF enabled({max(NET.transitions)})", "ctl"))
    said = confirm_properties(NET, NetNames(NET), [one], of_markings({"last": False}))
    assert_disagreement(said["last"], ["explicit search", "decision diagrams"])


def assert_disagreement(said: Confirmation, by: list[str]) -> None:
    assert said.agrees is False
    assert [name.rpartition(" (")[0] for name in said.by] == by
    assert "the answer: " in said.reason and all(f"{name}: " in said.reason for name in by)
