"""Errors inside a question leave that question open, and all others are answered."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks import boundedness, goals, overflow, properties
from dineros.analysis.checks.check import QUESTIONS, check
from dineros.analysis.requirements import asking
from dineros.analysis.requirements.asking import question_of
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, step
from dineros.metamodel.errors import ModelFileError
from tests.support.systems.talker import talker

LIMITS = Budget(1 << 28, seconds=60)


def model(text: str = "never Heard >= 2") -> sym.SystemModel:
    """A timer that publishes, and a reader that counts what it hears."""
    made = sym.SystemModel(id="counting", middleware="ros2")
    talker, listener = node_net(made, "talker"), node_net(made, "listener")
    out, read = place(talker, "Out"), place(listener, "In")
    tick = callback(talker, "OnTimer", "timer", timer=0.1)
    step(tick, "Send", [], [out])
    hear = callback(listener, "OnMessage", "subscriber")
    step(hear, "Hear", [read], [place(listener, "Heard")])
    sym.TopicChannel(
        id="Number",
        topic="/number",
        publishers=[sym.PublisherPort(place=out, limit=2)],
        subscribers=[sym.SubscriberPort(place=read, limit=2)],
        model=made,
    )
    made.properties.append(sym.Property(id="NotTwice", text=text))
    made.properties.append(sym.Property(id="Possible", text="Heard >= 1 stays possible"))
    return made


def fails(*_: object, **__: object) -> Any:
    raise AssertionError("an engine is\nwrong")


REASON = "an internal error: AssertionError: an engine is wrong (please report it"


def test_a_violated_never_where_every_way_on_must_grow() -> None:
    report = check(model(), LIMITS)
    found = {finding.rule: finding for finding in report.findings}
    assert found["property-violated"].elements == ("NotTwice",)
    assert "unbounded" in found
    assert "queue-overflow" in found


def without(report: Report, words: str) -> set[str]:
    """What a report says, but for what is about something."""
    said = [finding.message for finding in report.findings] + report.proved
    return {text for text in said if words not in text}


@pytest.mark.long
@pytest.mark.parametrize(
    ("where", "name", "words"),
    [
        (overflow, "firing_witness", "overflow"),
        (asking, "question_of", "property"),
        (goals, "_clients", "goal"),
    ],
)
def test_what_fails_inside_is_left_open_alone(
    where: Any, name: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = check(model(), LIMITS)
    monkeypatch.setattr(where, name, fails)
    report = check(model(), LIMITS)
    assert without(report, words) == without(expected, words)
    reasons = [str(each) for each in report.unknown if REASON in each.reason]
    assert reasons
    assert all(words in reason for reason in reasons)
    assert len(report.failures) == len(reasons)


@pytest.mark.long
def test_each_queue_and_each_property_fails_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails_once(property: sym.Property, *rest: Any) -> Any:
        return fails() if property.id == "NotTwice" else question_of(property, *rest)

    monkeypatch.setattr(asking, "question_of", fails_once)
    report = check(model(), LIMITS)
    assert [each.question for each in report.unknown if REASON in each.reason] == [
        "whether property NotTwice holds"
    ]
    assert any("property Possible" in text for text in report.proved)


@pytest.mark.long
def test_without_a_state_space_the_questions_are_answered_on_the_way(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = check(talker(), LIMITS)
    monkeypatch.setattr(boundedness, "symbolic_state_space", fails)
    report = check(talker(), LIMITS)
    assert report.failures and any(f"not counted: {REASON}" in text for text in report.proved)
    queues = {text for text in expected.proved if "never overflows" in text}
    assert queues and queues <= set(report.proved)
    errors = [{each.rule for each in one.findings if each.severity == "error"} for one in (expected, report)]
    assert errors[0] == errors[1]


def test_every_question_may_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    for question in QUESTIONS:
        monkeypatch.setattr(type(question), "ask_first", fails)
        monkeypatch.setattr(type(question), "ask", fails)
    report = check(model(), LIMITS)
    assert not report.findings
    assert report.unknown
    assert all(REASON in each.reason for each in report.unknown)


def test_only_properties_without_an_answer_are_left_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """All are answered before other questions; then one is not, and time is up."""
    monkeypatch.setattr(properties.Properties, "ask", fails)
    report = check(model(), LIMITS)
    assert not any("propert" in each.question for each in report.unknown)

    def all_but_one(property: sym.Property, *rest: Any) -> Any:
        return fails() if property.id == "NotTwice" else question_of(property, *rest)

    monkeypatch.setattr(asking, "question_of", all_but_one)
    report = check(model(), LIMITS)
    left = [each.question for each in report.unknown if "propert" in each.question]
    assert left == ["whether property NotTwice holds"]


@pytest.mark.parametrize("ends", [KeyboardInterrupt, SystemExit])
def test_what_ends_the_process_passes(
    ends: Callable[[], BaseException], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise ends()

    monkeypatch.setattr(properties.Properties, "ask", interrupted)
    with pytest.raises(BaseException) as raised:
        check(model(), LIMITS)
    assert raised.type is ends


def test_what_is_wrong_with_the_model_ends_the_check(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(_: pn.Net) -> Any:
        raise ModelFileError("it cannot be flattened")

    monkeypatch.setattr("dineros.analysis.checks.question.base_subject", refused)
    with pytest.raises(ModelFileError):
        check(model(), LIMITS)
