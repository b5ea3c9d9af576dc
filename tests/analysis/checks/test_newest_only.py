"""Readers that need the newest message only: an older one that is displaced is a note, not a fault."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks import question
from dineros.analysis.checks.check import check
from dineros.analysis.suggestions.capacities import suggest_capacities
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from tests.support.systems.talker import talker


def news(middleware: str = "ros2", newest: bool = True) -> sym.SystemModel:
    """Return a model whose three words go through histories of one message."""
    model = talker()
    model.middleware = middleware
    (channel,) = model.channels
    assert isinstance(channel, sym.TopicChannel)
    channel.publishers[0].limit = channel.subscribers[0].limit = 1
    channel.subscribers[0].newestOnly = newest
    return model


def found(model: sym.SystemModel) -> list[tuple[str, str, str]]:
    rules = ("queue-overflow", "sample-lost", "message-displaced")
    return [
        (each.rule, each.severity, each.elements[1]) for each in check(model).findings if each.rule in rules
    ]


def test_both_histories_of_the_pair_are_no_fault() -> None:
    assert found(news()) == [("message-displaced", "note", "Heard"), ("message-displaced", "note", "Said")]
    assert found(news(newest=False)) == [
        ("queue-overflow", "error", "Heard"),
        ("queue-overflow", "error", "Said"),
    ]


def test_the_rules_of_ros1_lose_the_newest_message_so_it_is_a_fault() -> None:
    assert found(news("ros1")) == found(news("ros1", newest=False))
    assert {severity for _, severity, _ in found(news("ros1"))} == {"error"}


def test_another_reader_of_the_same_publisher_still_loses_messages() -> None:
    model = news()
    (channel,) = model.channels
    assert isinstance(channel, sym.TopicChannel)
    logger = sym.NodeNet(id="logger")
    page = sym.CallbackPage(id="OnLog", page=logger)
    logged = sym.Place(id="Logged", page=page)
    flow(logged, sym.Transition(id="Log", page=page))
    model.pages.append(logger)
    channel.subscribers.append(sym.SubscriberPort(place=logged, limit=1))
    report = [each for each in check(model).findings if each.rule in ("queue-overflow", "message-displaced")]
    faults = {each.message.partition(" can ")[0] for each in report if each.rule == "queue-overflow"}
    assert faults == {
        "reader history of Logged (topic chatter)",
        "writer history of Said for Logged (topic chatter)",
    }
    notes = {each.message.partition(" can ")[0] for each in report if each.rule == "message-displaced"}
    assert notes == {
        "reader history of Heard (topic chatter)",
        "writer history of Said for Heard (topic chatter)",
    }


@pytest.mark.parametrize(("assumed", "words"), [("limit newestOnly", "(assumed"), ("limit", ""), (None, "")])
def test_the_answer_says_whether_it_is_assumed(assumed: str | None, words: str) -> None:
    model = news()
    (channel,) = model.channels
    assert isinstance(channel, sym.TopicChannel)
    channel.subscribers[0].assumed = assumed
    notes = [each for each in check(model).findings if each.rule == "message-displaced"]
    assert len(notes) == 2
    assert all(("(assumed" in each.message) == bool(words) for each in notes)


def test_one_message_is_enough_for_it() -> None:
    assert [each.needed for each in suggest_capacities(news())] == [1, 1]
    assert all(each.needed != 1 for each in suggest_capacities(news(newest=False)))


def test_an_open_question_about_such_a_queue_could_only_be_a_note(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.analysis.checks.overflow.can_fire", lambda checked, transitions: None)
    for newest in (True, False):
        open_ones = [each for each in check(news(newest=newest)).unknown if "can overflow" in each.question]
        rules = {(each.rule, each.may_be_fault) for each in open_ones}
        assert rules == {("message-displaced", False) if newest else ("queue-overflow", True)}


def test_a_queue_overflows_also_if_there_is_no_time_to_show_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The finding stays, without a run; it is not an open question."""
    monkeypatch.setattr(question, "SHOWN_SHARE", 0.0)
    report = check(news(newest=False), Budget(seconds=600))
    lost = [each for each in report.findings if each.rule == "queue-overflow"]
    assert [each.elements[1] for each in lost] == ["Heard", "Said"]
    assert [each.witness for each in lost] == [None, None]
    assert not any("overflow" in each.question for each in report.unknown)
    shown = check(news(newest=False)).findings
    assert all(each.witness is not None for each in shown if each.rule == "queue-overflow")
