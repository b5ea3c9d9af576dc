"""What follows what is found with its numbers, and the narrowed model explains the recording."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.metamodel.constraints import validate
from dineros.observation.explaining import explain
from dineros.observation.importing.building import to_model
from dineros.observation.importing.flows.labels import Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.observation.narrowing import Proposal, narrowed, proposals
from dineros.observation.systems import Endpoint, ObservedNode, ObservedSystem, RecordedTopic, TopicEndpoint

MILLISECOND = 1_000_000
TEXT = "std_msgs/msg/String"


def node(name: str, hears: str = "", says: str = "", servers: tuple[Endpoint, ...] = ()) -> ObservedNode:
    def ends(topics: str) -> tuple[TopicEndpoint, ...]:
        return tuple(TopicEndpoint(f"/{topic}", TEXT, depth=3) for topic in topics.split())

    return ObservedNode(f"/{name}", publishers=ends(says), subscribers=ends(hears), servers=servers)


ROBOT = ObservedSystem(
    "a test",
    (
        node("camera", says="image"),
        node("detector", hears="image odometry", says="obstacles"),
        node("driver", hears="obstacles path", says="speed"),
        node("planner", says="path", servers=(Endpoint("/plan", "std_srvs/srv/Trigger"),)),
        node("wheels", hears="speed", says="odometry"),
    ),
)


def recording(seconds: int = 20, seed: int = 1) -> list[tuple[str, int]]:
    """Return what the robot says: each fourth image shows an obstacle, a path comes now and then."""
    drawn = random.Random(seed)
    messages = []

    def drive(time: int) -> None:
        messages.append(("/speed", time + drawn.randrange(1, 5) * MILLISECOND))
        messages.append(("/odometry", time + drawn.randrange(6, 9) * MILLISECOND))

    for number in range(10 * seconds):
        time = number * 100 * MILLISECOND + drawn.randrange(2) * MILLISECOND
        messages.append(("/image", time))
        if not drawn.randrange(4):
            messages.append(("/obstacles", time + 10 * MILLISECOND))
            drive(time + 11 * MILLISECOND)
        if not drawn.randrange(15):
            messages.append(("/path", time + 50 * MILLISECOND))
            drive(time + 51 * MILLISECOND)
    return sorted(messages, key=lambda message: message[1])


def recorded(system: ObservedSystem) -> list[RecordedTopic]:
    topics = {endpoint.topic for _, endpoint in system.publishers()}
    return [RecordedTopic(topic, TEXT) for topic in sorted(topics)]


def found() -> dict[tuple[str, str, str], Proposal]:
    return {(each.node, each.callback, each.topic): each for each in proposals(ROBOT, recording())}


def test_what_follows_always_sometimes_and_never() -> None:
    kinds = {key: each.kind for key, each in found().items()}
    assert kinds == {
        ("/camera", "/image", "/image"): "timer",
        ("/detector", "/image", "/obstacles"): "sometimes",
        ("/detector", "/odometry", "/obstacles"): "never",
        ("/driver", "/obstacles", "/speed"): "always",
        ("/driver", "/path", "/speed"): "always",
        ("/wheels", "/speed", "/odometry"): "always",
    }


def test_the_evidence_is_numbers() -> None:
    messages = recording()
    images, obstacles = (sum(topic == name for topic, _ in messages) for name in ("/image", "/obstacles"))
    seen = found()["/detector", "/image", "/obstacles"]
    assert (seen.triggers, seen.followed, seen.messages, seen.explained) == (
        images,
        obstacles,
        obstacles,
        obstacles,
    )
    assert (seen.least, seen.most) == (0.01, 0.01)
    # 10 ms after an image are a fifth of what chance would make of images 100 ms apart.
    assert seen.confidence == pytest.approx(0.8 * (obstacles + 1) / (obstacles + 2), rel=0.01)
    assert str(seen) == (
        f"{seen.confidence:.2f}  /detector: /image sometimes leads to /obstacles "
        f"({obstacles} of {images} followed, within 10 ms to 10 ms; {obstacles} of {obstacles} messages "
        "explained)"
    )
    timer = found()["/camera", "/image", "/image"]
    assert timer.mean == pytest.approx(0.1, rel=0.01) and timer.confidence > 0.9


def test_confidence_grows_with_what_was_seen() -> None:
    few = {each.topic: each for each in proposals(ROBOT, recording(10)) if each.node == "/wheels"}
    many = {each.topic: each for each in proposals(ROBOT, recording(100)) if each.node == "/wheels"}
    assert few["/odometry"].confidence < many["/odometry"].confidence < 1


def test_nothing_is_proposed_where_a_recording_does_not_say_who_it_was() -> None:
    twins = ObservedSystem("a test", (*ROBOT.nodes, node("other", says="speed")))
    assert not [each for each in proposals(twins, recording()) if each.topic == "/speed"]


def test_the_narrowed_model_explains_the_recording_and_little_else() -> None:
    messages = recording()
    made = narrowed(ROBOT, recorded(ROBOT), lambda: messages, proposals(ROBOT, messages))
    assert (made.verdict.status, made.dropped) == ("conforms", ())
    assert not [each for each in validate(made.imported.model) if each.severity == "error"]
    assert made.given.nodes["/driver"].callbacks["/path"].does == (Step("publish", "/speed"),)
    assert made.given.nodes["/wheels"].timers == {}
    assert made.given.nodes["/planner"].callbacks == {} if "/planner" in made.given.nodes else True
    invented = sorted([*messages, ("/odometry", 5_030 * MILLISECOND)], key=lambda message: message[1])
    opened = to_model(ROBOT).model
    assert explain(opened, recorded(ROBOT), invented).status == "conforms"
    assert explain(made.imported.model, recorded(ROBOT), invented).status == "violated"


@pytest.mark.long
def test_what_was_accepted_and_does_not_hold_is_weakened() -> None:
    messages = recording()
    never = Proposal("/driver", "/path", "/speed", "never", 9, 0, 9, 9, 0, 0, 0, 0.8)
    right = Proposal("/driver", "/obstacles", "/speed", "always", 9, 9, 9, 9, 0, 0, 0, 0.9)
    made = narrowed(ROBOT, recorded(ROBOT), lambda: messages, [never, right])
    assert (made.verdict.status, made.accepted, made.dropped) == ("conforms", (right,), (never,))
    unlike = replace(never, callback="/obstacles", kind="always", confidence=0.7)
    made = narrowed(ROBOT, recorded(ROBOT), lambda: messages, [unlike, replace(never, confidence=0.9)])
    assert made.verdict.status == "conforms" and made.dropped


def test_what_people_say_is_kept() -> None:
    said = Given(
        {"/driver": GivenNode(callbacks={"/path": GivenCallback((Step("publish", "/speed", "*"),))})}
    )
    messages = recording()
    made = narrowed(ROBOT, recorded(ROBOT), lambda: messages, proposals(ROBOT, messages), given=said)
    assert made.given.nodes["/driver"].callbacks["/path"].does == (Step("publish", "/speed", "*"),)


@pytest.mark.long
@settings(max_examples=8, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_whatever_is_accepted_the_model_explains_the_recording(data: st.DataObject) -> None:
    """By construction: of any recording of the topics, whichever proposals are accepted."""
    topics = [f"/{name}" for name in ("image", "obstacles", "path", "speed", "odometry")]
    kinds = data.draw(st.lists(st.sampled_from(topics), min_size=5, max_size=25))
    messages = [(topic, number * 30 * MILLISECOND) for number, topic in enumerate(kinds)]
    seen = proposals(ROBOT, messages)
    accepted = data.draw(st.lists(st.sampled_from(seen), unique=True)) if seen else []
    made = narrowed(ROBOT, recorded(ROBOT), lambda: messages, accepted)
    assert made.verdict.status == "conforms"
