"""A recorder that was started in the middle of a run: it conforms where some reachable marking explains
it."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.metamodel import sym
from dineros.observation.explaining import RecordingVerdict, explain, midway
from dineros.observation.importing.building import to_model
from dineros.observation.importing.flows.labels import Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.observation.systems import (
    REQUEST_RECEIVED,
    REQUEST_SENT,
    RESPONSE_RECEIVED,
    RESPONSE_SENT,
    SERVICE_EVENTS,
    Endpoint,
    ObservedNode,
    ObservedSystem,
    event_name,
)
from tests.observation.explaining.reference import MILLISECOND, Reference
from tests.observation.explaining.test_explain import number, recorded, talking

CALL = [
    event_name("/level", each) for each in (REQUEST_SENT, REQUEST_RECEIVED, RESPONSE_SENT, RESPONSE_RECEIVED)
]


def asking(group: str | None) -> sym.SystemModel:
    """Return a node whose timer calls a service and waits; in the default group, it waits forever."""
    system = ObservedSystem(
        "",
        nodes=(
            ObservedNode("/base", servers=(Endpoint("/level", "std_srvs/srv/Trigger"),)),
            ObservedNode("/mission", clients=(Endpoint("/level", "std_srvs/srv/Trigger"),)),
        ),
    )
    callbacks = {"tick": GivenCallback(does=(Step("call", "/level"),))}
    if group is not None:
        callbacks["/level"] = GivenCallback(group=group)
    groups = {} if group is None else {group: "exclusive"}
    given = Given(
        {"/mission": GivenNode(timers={"tick": 1.0}, callbacks=callbacks, groups=groups, threads=4)}
    )
    return to_model(system, given).model


def calls(times: int) -> list[tuple[str, int]]:
    return [(event, 100 * n * MILLISECOND) for n, event in enumerate(CALL * times)]


def explained(model: sym.SystemModel, messages: list[tuple[str, int]]) -> RecordingVerdict:
    topics = recorded(*(event_name("/level", event) for event in SERVICE_EVENTS))
    return explain(model, topics, messages, midway=True)


@pytest.fixture(params=["exact", "by invariants"])
def known(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """How the first markings are known."""
    if request.param != "exact":
        monkeypatch.setattr(midway, "WHOLE_NODES", 0)
    return str(request.param)


def test_no_answer_comes_to_a_callback_that_waits_for_itself(known: str) -> None:
    verdict = explained(asking(None), calls(10))
    assert (verdict.status, verdict.messages) == ("violated", 3)
    assert verdict.unexplained is not None and verdict.unexplained.topic == CALL[-1]


@pytest.mark.parametrize("first", range(4))
def test_answered_calls_conform_if_the_client_has_a_group(known: str, first: int) -> None:
    verdict = explained(asking("calls"), calls(10)[first:])
    assert verdict.status == "conforms", str(verdict.unexplained)


def test_no_call_is_answered_without_a_request(known: str) -> None:
    assert explained(asking("calls"), [(CALL[3], 0), (CALL[3], MILLISECOND)]).status == "violated"


@pytest.mark.parametrize("reliable", [True, False])
def test_what_no_marking_leads_to_does_not_conform(reliable: bool) -> None:
    """The camera waits for the edges of a frame before it shoots the next one."""
    model = talking(reliable, answers=True)
    reference = Reference(model, most=20_000)
    for topics in (
        ["/frames"] * 2,
        ["/edges"] * 2,
        ["/edges", "/frames", "/edges"],
        ["/frames", "/edges"] * 3,
    ):
        messages = [(topic, 100 * n * MILLISECOND) for n, topic in enumerate(topics)]
        verdict = explain(model, recorded("/frames", "/edges"), messages, tolerance=0, midway=True)
        assert number(verdict) == reference.first_unexplained(messages, midway=True)
        assert verdict.untold == ()


@pytest.mark.parametrize("limit", ["WHOLE_NODES", "WHOLE_SECONDS"])
def test_what_cannot_be_told_of_a_large_model_is_said(monkeypatch: pytest.MonkeyPatch, limit: str) -> None:
    monkeypatch.setattr(midway, limit, 0)
    messages = [("/frames", 0), ("/frames", 100 * MILLISECOND)]
    verdict = explain(talking(True, answers=True), recorded("/frames", "/edges"), messages, midway=True)
    assert verdict.status == "conforms"  # though no marking leads to it
    assert verdict.untold == ("/edges", "/frames")
    assert verdict.to_dict("")["untold"] == ["/edges", "/frames"]
    from_the_start = explain(talking(True, answers=True), recorded("/frames", "/edges"), messages)
    assert (from_the_start.status, from_the_start.untold) == ("violated", ())


@pytest.mark.parametrize("is_midway", [False, True])
def test_if_time_runs_out_over_the_markings_the_answer_is_unknown(is_midway: bool) -> None:
    topics, messages = recorded("/frames", "/edges"), [("/frames", 0)]
    verdict = explain(
        talking(True, answers=True), topics, messages, midway=is_midway, budget=Budget(seconds=0)
    )
    assert (verdict.status, verdict.messages) == ("unknown", 0)
    assert verdict.reason == "time ran out: not all markings of a part of the model were found"
