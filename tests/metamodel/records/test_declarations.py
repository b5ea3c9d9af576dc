"""What kinds of records declare, and that it is declared in one place."""

from __future__ import annotations

import re
from dataclasses import fields
from string import Formatter
from typing import get_args

import pytest

from dineros.metamodel import sym
from dineros.metamodel.records import EVENTS, Record
from dineros.metamodel.records.declarations import GoalChange
from tests.packaging.test_imports import ROOT

ROOMS = ("metamodel", "transformations", "analysis", "generators", "runtime", "observation", "views", "cli")
CALLS = [kind for kind in EVENTS.values() if kind.declared.call]
GOALS = [kind for kind in EVENTS.values() if kind.declared.goal]


def placeholders(text: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(text) if name}


@pytest.mark.parametrize("kind", EVENTS.values(), ids=list(EVENTS))
def test_words_speak_of_fields_of_the_record(kind: type[Record]) -> None:
    known = {field.name for field in fields(kind)}
    declared = kind.declared
    for words in (declared.does, declared.does_nameless, declared.needs_time):
        assert placeholders(words) <= known
    of_goals = {"client", "slot", "goal", "own", "asked", "ends", "action"}
    assert placeholders(declared.happens) <= (of_goals if declared.goal else {"client", "server", "service"})
    assert bool(declared.does) == bool(declared.does_nameless)
    assert bool(declared.needs_time) == bool(declared.without_it)


def test_each_step_of_a_call_declares_all_that_is_needed() -> None:
    assert [kind.event for kind in CALLS] == ["request", "serve", "reply", "response", "giveUp"]
    for kind in CALLS:
        declared = kind.declared
        assert all((declared.token, declared.end, declared.port, declared.mark, declared.happens))
    assert len({kind.declared.call for kind in CALLS}) == len(CALLS)
    assert len({kind.declared.mark for kind in CALLS}) == len(CALLS)


def test_each_step_of_a_goal_declares_all_that_is_needed() -> None:
    assert {kind.declared.goal for kind in GOALS} == {change for change in get_args(GoalChange) if change}
    assert len({kind.declared.goal for kind in GOALS}) == len(GOALS)
    for kind in GOALS:
        declared = kind.declared
        assert declared.end and declared.happens
        assert bool(declared.token) == ("token" in kind.__dataclass_fields__)
        if declared.goal not in ("ends", "is known to have ended", "is not canceled"):
            assert declared.port  # else the place is that of the outcome, or there is none


@pytest.mark.parametrize("kind", GOALS, ids=lambda kind: kind.event)
def test_each_step_of_a_goal_has_a_place_among_the_ports(kind: type[Record]) -> None:
    port = sym.ActionClientPort if kind.declared.end == "client" else sym.ActionServerPort
    assert not kind.declared.port or port.eClass.findEStructuralFeature(kind.declared.port) is not None


@pytest.mark.parametrize("kind", EVENTS.values(), ids=list(EVENTS))
def test_what_is_received_is_sent_by_a_record_with_an_id(kind: type[Record]) -> None:
    sends = kind.declared.receives
    if sends:
        assert "message" in kind.__dataclass_fields__
        assert "message" in EVENTS[sends].__dataclass_fields__


def test_giving_up_a_call_is_known_in_few_files() -> None:
    """It is declared, listed with the public names, made by a rule, and recorded where it happens."""
    word = re.compile(r"\b(GiveUp|giveUp)\b")
    named = {
        str(path.relative_to(ROOT))
        for room in ROOMS
        for path in (ROOT / room).rglob("*")
        if path.suffix in (".py", ".js", ".ts", ".j2", ".html", ".css")
        and "vendor" not in path.parts
        and word.search(path.read_text("utf-8"))
    }
    assert named - {"metamodel/editing/composed/templates.py"} == {  # which draws a transition of this name
        "metamodel/records/__init__.py",
        "metamodel/records/steps.py",
        "transformations/rules/requests.py",
        "runtime/channels/clients.py",
    }


@pytest.mark.parametrize(
    ("kind", "rules"),
    [
        ("Hear", {"transformations/rules/actions/feedback.py"}),
        ("Accepted", {"transformations/rules/clients/acceptances.py"}),
        ("TooLate", set[str]()),
    ],
)
def test_classes_of_steps_of_goals_are_imported_by_their_rules_alone(kind: str, rules: set[str]) -> None:
    imported = re.compile(
        rf"^from dineros\.metamodel\.records[\w.]* import (\([^)]*|[^(\n]*)\b{kind}\b", re.MULTILINE
    )
    importing = {
        str(path.relative_to(ROOT))
        for room in ROOMS
        for path in (ROOT / room).rglob("*.py")
        if imported.search(path.read_text("utf-8"))
    }
    assert importing == {"metamodel/records/__init__.py", *rules}
