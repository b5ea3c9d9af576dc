"""Calls are proposed as services tell of them, and the narrowed model explains those events, too."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.observation.explaining import explain
from dineros.observation.importing.building import to_model
from dineros.observation.importing.flows.labels import Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.observation.narrowing import Proposal, narrowed, proposals, verbs_of
from dineros.observation.systems import (
    SERVICE_EVENTS,
    Endpoint,
    ObservedNode,
    ObservedSystem,
    RecordedTopic,
    TopicEndpoint,
    event_name,
)
from tests.support.ros2_systems.blocking_callbacks import some_waits_for_ever

MILLISECOND = 1_000_000
TEXT = "std_msgs/msg/String"
Message = tuple[str, int]
SENT, RECEIVED, ANSWERED, TAKEN = range(4)


def topic(name: str) -> TopicEndpoint:
    return TopicEndpoint(name, TEXT, depth=3)


def service(name: str) -> Endpoint:
    return Endpoint(name, "std_srvs/srv/Trigger")


ROBOT = ObservedSystem(
    "a test",
    (
        ObservedNode("/commander", publishers=(topic("/mission"),), clients=(service("/plan"),)),
        ObservedNode("/localizer", publishers=(topic("/log"),), servers=(service("/where"),)),
        ObservedNode(
            "/planner",
            publishers=(topic("/path"),),
            subscribers=(topic("/map"),),
            servers=(service("/plan"),),
            clients=(service("/where"),),
        ),
        ObservedNode("/mapper", publishers=(topic("/map"),)),
    ),
)
TWO_THREADS = Given(
    {
        "/planner": GivenNode(
            threads=2, groups={"others": "exclusive"}, callbacks={"/plan": GivenCallback(group="others")}
        )
    }
)


def recorded(*, events: bool = True) -> list[RecordedTopic]:
    names = ["/map", "/mission", "/path", "/log"]
    if events:
        names += [event_name(each, kind) for each in ("/plan", "/where") for kind in SERVICE_EVENTS]
    return [RecordedTopic(name, TEXT, (), 1) for name in names]


def recording(rounds: int = 12) -> list[Message]:
    """Return what is told: every half a second a plan, for which is asked where the robot is; and maps."""
    messages: list[Message] = []
    for number in range(rounds):
        start = number * 500 * MILLISECOND
        story = [
            (0, "/plan", SENT),
            (2, "/plan", RECEIVED),
            (3, "/where", SENT),
            (5, "/where", RECEIVED),
            *([(6, "/log", None)] if number % 3 else []),
            (8, "/where", ANSWERED),
            (10, "/where", TAKEN),
            (12, "/path", None),
            (14, "/plan", ANSWERED),
            (16, "/plan", TAKEN),
            (18, "/mission", None),
        ]
        messages += [
            (name if kind is None else event_name(name, SERVICE_EVENTS[kind]), start + time * MILLISECOND)
            for time, name, kind in story
        ]
        messages.append(("/map", start + (200 + 37 * (number % 5)) * MILLISECOND))
    return messages


def found(given: Given | None = None, within: float = 0.1) -> list[Proposal]:
    return proposals(ROBOT, recording(), verbs=verbs_of(ROBOT, recorded(), given), within=within)


def test_calls_and_what_services_lead_to() -> None:
    kinds = {(each.node, each.trigger, each.verb, each.topic): each.kind for each in found(TWO_THREADS)}
    assert {key: kind for key, kind in kinds.items() if kind != "never"} == {
        ("/commander", "", "send", "/plan"): "timer",
        ("/commander", "/plan (response received)", "publish", "/mission"): "always",
        ("/localizer", "/where (request received)", "publish", "/log"): "sometimes",
        ("/mapper", "", "publish", "/map"): "timer",
        ("/planner", "/plan (request received)", "call", "/where"): "always",
        ("/planner", "/plan (request received)", "publish", "/path"): "always",
    }
    assert kinds["/planner", "/map", "call", "/where"] == "never"


def test_what_comes_after_the_answer_is_no_consequence_of_the_request() -> None:
    messages = [each for each in recording() if each[0] != "/log"]
    late = [("/log", time + MILLISECOND) for name, time in messages if name == "/where (response sent)"]
    mixed = sorted([*messages, *late], key=lambda message: message[1])
    seen = proposals(ROBOT, mixed, within=0.1)
    assert [each.kind for each in seen if each.topic == "/log"] == ["timer", "never"]


def test_who_goes_on_while_a_service_works_is_seen_by_its_one_thread() -> None:
    assert verbs_of(ROBOT, recorded(), TWO_THREADS) == {("/commander", "/plan"): "send"}
    assert verbs_of(ROBOT, recorded(events=False)) == {}
    awaits = Given({"/commander": GivenNode(callbacks={"timer": GivenCallback(awaits=True)})})
    assert ("/commander", "/plan") not in verbs_of(ROBOT, recorded(), awaits)
    twins = replace(ROBOT, nodes=(*ROBOT.nodes, ObservedNode("/other", clients=(service("/plan"),))))
    assert ("/commander", "/plan") not in verbs_of(twins, recorded())
    assert not [each for each in proposals(twins, recording()) if each.topic == "/plan"]


@pytest.mark.long
def test_the_narrowed_model_explains_messages_and_events() -> None:
    made = narrowed(ROBOT, recorded(), recording, found(TWO_THREADS), given=TWO_THREADS)
    assert (made.verdict.status, made.verdict.messages, made.dropped) == ("conforms", len(recording()), ())
    said = made.given.nodes
    assert said["/commander"].callbacks["/plan"].does == (Step("publish", "/mission"),)
    assert said["/planner"].callbacks["/plan"].does == (Step("call", "/where"), Step("publish", "/path"))

    whole = recording(3)
    events = [number for number in range(12, 24) if whole[number][0].endswith(")")]
    for number in events:
        lost = [*whole[:number], *whole[number + 1 :]]
        assert explain(made.imported.model, recorded(), lost).status == "violated"
    for number in events[:4]:
        doubled = [*whole[: number + 1], *whole[number:]]
        assert explain(made.imported.model, recorded(), doubled).status == "violated"


def test_what_no_node_with_one_thread_can_do_takes_nothing_back() -> None:
    """The planner takes an answer while it works on a request: more threads than are assumed."""
    accepted = found()
    made = narrowed(ROBOT, recorded(), recording, accepted)
    assert (made.verdict.status, made.accepted, made.dropped) == ("violated", tuple(accepted), ())
    assert made.verdict.unexplained is not None
    assert made.verdict.unexplained.topic == "/where (response received)"


def test_a_call_that_gets_no_answer_is_a_deadlock_of_the_narrowed_model() -> None:
    """With one thread, the planner waits forever: that is recorded, explained, and found."""
    system = ObservedSystem(
        "a test",
        (
            ObservedNode("/commander", clients=(service("/plan"),)),
            ObservedNode("/localizer", servers=(service("/where"),)),
            ObservedNode(
                "/planner",
                publishers=(TopicEndpoint("/path", TEXT, depth=1),),
                servers=(service("/plan"),),
                clients=(service("/where"),),
            ),
        ),
    )
    hung = recording()[:5]  # the answer of where it is, which nobody takes
    told = {name for name, _ in hung}
    seen = [replace(each, messages=int(each.name in told)) for each in recorded()]
    assert verbs_of(system, seen) == {}
    calls = Proposal("/planner", "/plan", "/where", "always", 1, 1, 1, 1, 0, 0, 0, 0.7, "call")
    sends = GivenNode(timers={"tick": 0.5}, callbacks={"tick": GivenCallback((Step("send", "/plan"),))})
    made = narrowed(system, seen, lambda: hung, [calls], given=Given({"/commander": sends}))
    assert (made.verdict.status, made.accepted) == ("conforms", (calls,))
    assert some_waits_for_ever(made.imported.model)


def test_goals_stay_open() -> None:
    """A node with a client of an action: what it sends there, no recording shows."""
    drives = ObservedNode(
        "/driver",
        (topic("/speed"),),
        (topic("/path"),),
        action_clients=(Endpoint("/go", "a_msgs/action/Go"),),
    )
    system = ObservedSystem("a test", (drives, ObservedNode("/planner", (topic("/path"),))))
    messages = [
        (each, (number * 100 + late) * MILLISECOND)
        for number in range(9)
        for late, each in ((0, "/path"), (5, "/speed"))
    ]
    names = [RecordedTopic(each, TEXT) for each in ("/path", "/speed")]
    made = narrowed(system, names, lambda: messages, proposals(system, messages))
    assert made.verdict.status == "conforms"
    goals = Step("goal", "/go", "*"), Step("cancel", "/go", "*")
    does = (*goals, Step("publish", "/speed"), *goals)
    assert made.given.nodes["/driver"].callbacks["/path"].does == does


@settings(max_examples=4, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_whatever_is_accepted_the_model_explains_the_events(data: st.DataObject) -> None:
    """By construction: however much of it is recorded, whichever proposals are accepted."""
    messages = recording(6)[: data.draw(st.integers(1, 70))]
    seen = proposals(ROBOT, messages, verbs=verbs_of(ROBOT, recorded(), TWO_THREADS))
    accepted = data.draw(st.lists(st.sampled_from(seen), unique=True)) if seen else []
    made = narrowed(ROBOT, recorded(), lambda: messages, accepted, given=TWO_THREADS)
    assert made.verdict.status == "conforms"


def test_a_callback_of_two_threads_gets_its_answer() -> None:
    """The step by which it is taken changes nothing of the threads, and needs a free one."""
    said = replace(
        TWO_THREADS,
        nodes={
            "/planner": replace(
                TWO_THREADS.nodes["/planner"],
                timers={},
                callbacks={
                    "/plan": GivenCallback((Step("call", "/where"), Step("publish", "/path")), "others")
                },
            ),
            "/commander": GivenNode(
                timers={"tick": 0.5},
                callbacks={
                    "tick": GivenCallback((Step("send", "/plan"),)),
                    "/plan": GivenCallback((Step("publish", "/mission"),)),
                },
            ),
        },
    )
    assert explain(to_model(ROBOT, said).model, recorded(), recording()).status == "conforms"
    one = {**said.nodes, "/planner": replace(said.nodes["/planner"], threads=1)}
    verdict = explain(to_model(ROBOT, replace(said, nodes=one)).model, recorded(), recording())
    assert verdict.unexplained is not None and verdict.unexplained.topic == "/where (response received)"
