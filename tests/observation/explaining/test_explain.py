"""Recordings are explained exactly where a plain search over all markings and orders explains them."""

from __future__ import annotations

import itertools
from collections import Counter

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import transitions
from dineros.metamodel.files import load
from dineros.observation.explaining import Explainer, RecordingVerdict, explain
from dineros.observation.explaining.commuting import Commuting
from dineros.observation.importing.building import to_model
from dineros.observation.importing.given import Given, GivenNode
from dineros.observation.systems import (
    SERVICE_EVENTS,
    Endpoint,
    ObservedNode,
    ObservedSystem,
    RecordedTopic,
    TopicEndpoint,
    event_name,
)
from tests.observation.explaining.reference import MILLISECOND, Message, Reference, TooLargeError, mutants
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.history_models import history_models
from tests.support.systems.chatty_systems import chatty_systems
from tests.support.systems.small_systems import small_system_models


def recorded(*topics: str) -> list[RecordedTopic]:
    return [RecordedTopic(topic, "std_msgs/msg/String") for topic in topics]


def number(verdict: RecordingVerdict) -> int | None:
    assert verdict.status != "unknown"
    assert (verdict.status == "violated") == (verdict.unexplained is not None)
    return None if verdict.unexplained is None else verdict.unexplained.number


def shown(verdict: RecordingVerdict, model: sym.SystemModel) -> list[str]:
    """Return the topics that the run of a verdict shows a message on, in its order."""
    assert verdict.run is not None
    names = {
        f"{each.id}.": f"/{each.topic.strip('/')}"
        for each in model.channels
        if isinstance(each, sym.TopicChannel)
    }
    return [
        topic
        for step in verdict.run.steps
        for prefix, topic in names.items()
        if step.transition == f"{prefix}transport"
        or (step.transition.startswith(f"{prefix}publisher.") and step.transition.endswith(".publish"))
    ]


MODELS = st.one_of(small_system_models(), history_models(), executor_models(), chatty_systems())


@pytest.mark.long
@settings(max_examples=6, deadline=None, suppress_health_check=list(HealthCheck))
@given(MODELS, st.integers(0, 999), st.sampled_from([0, 5, 30]), st.booleans(), st.booleans(), st.booleans())
def test_as_a_plain_search_does(
    model: sym.SystemModel, seed: int, tolerance: int, hides: bool, events: bool, midway: bool
) -> None:
    """Recordings of random runs conform; their mutants do exactly where the model has such a run."""
    assume(not any(each.overrides for each in transitions(model)))  # which no engine obeys
    topics = sorted(set(Reference(model).topics.values()))
    hidden = topics[:1] if hides and len(topics) > 1 else []
    reference = Reference(model, hidden=hidden, events=events)
    topics = reference.names
    messages = reference.recording(seed, 6)
    assume(topics and messages)
    for _, mutant in [("none", messages), *mutants(messages, topics, seed)]:
        try:
            expected = reference.first_unexplained(mutant, tolerance * MILLISECOND, midway=midway)
        except TooLargeError:
            return
        verdict = explain(model, recorded(*topics), mutant, tolerance=tolerance / 1000, midway=midway)
        assert number(verdict) == expected
        if mutant is messages:
            assert expected is None


def talking(reliable: bool, answers: bool) -> sym.SystemModel:
    """Return a camera that shoots and a filter that answers each frame; the camera may wait for that."""
    camera, filter_ = sym.NodeNet(id="camera"), sym.NodeNet(id="filter")
    frame, edges = sym.Place(id="Frame", page=camera), sym.Place(id="Edges", page=filter_)
    seen, told = sym.Place(id="Seen", page=filter_), sym.Place(id="Told", page=camera)
    shoot = sym.Transition(id="Shoot", page=camera)
    flow(seen, sym.Transition(id="Filter", page=filter_), edges)
    flow(shoot, frame)
    if answers:
        ready = sym.Place(id="Ready", tokens=1, page=camera)
        flow(told, sym.Transition(id="Note", page=camera), ready)
        flow(ready, shoot)
    else:
        flow(told, sym.Transition(id="Note", page=camera))
    quality = sym.QualityOfService(reliability="reliable" if reliable else "bestEffort")
    channels = [
        sym.TopicChannel(
            id=f"{topic}Topic",
            topic=topic,
            publishers=[sym.PublisherPort(place=sent, limit=1, qos=quality)],
            subscribers=[sym.SubscriberPort(place=heard, limit=1)],
        )
        for topic, sent, heard in (("frames", frame, seen), ("edges", edges, told))
    ]
    return sym.SystemModel(id="talking", middleware="ros2", pages=[camera, filter_], channels=channels)


@pytest.mark.long
def test_two_hundred_mutants_are_caught_exactly_where_the_model_does_not_allow_them() -> None:
    models = [talking(True, False), talking(False, False), talking(True, True)]
    counts: Counter[tuple[str, bool]] = Counter()
    for model, tolerance in itertools.product(models, (0, 15)):
        reference = Reference(model, most=20_000)
        topics = sorted(reference.topics.values())
        for seed in range(10):
            messages = reference.recording(seed, 8)
            for kind, mutant in mutants(messages, topics, seed):
                expected = reference.first_unexplained(mutant, tolerance * MILLISECOND)
                verdict = explain(model, recorded(*topics), mutant, tolerance=tolerance / 1000)
                assert number(verdict) == expected
                counts[kind, expected is not None] += 1
    assert counts.total() >= 200
    assert {kind for kind, caught in counts if caught} == {"swapped", "dropped", "doubled", "invented"}
    assert {kind for kind, caught in counts if not caught} == {"swapped", "dropped", "doubled", "invented"}


def sensor() -> tuple[sym.SystemModel, list[Message]]:
    """Return a sensor with three scans under way at most, and what it and the mapper say in turn."""
    turns = ["/scans", "/dones"] * 200
    messages = [(topic, 100 * MILLISECOND * count) for count, topic in enumerate(turns)]
    model = load("examples/callbacks/sensor_fixed.sym.xmi")
    assert isinstance(model, sym.SystemModel)
    return model, messages


def test_the_first_message_without_an_explanation_is_named_with_what_was_possible() -> None:
    model, messages = sensor()
    messages[100:100] = [("/dones", messages[99][1])]
    verdict = explain(model, recorded("/scans", "/dones"), messages)
    assert verdict.status == "violated" and verdict.messages == 100
    assert str(verdict.unexplained) == (
        "message 101, on /dones, 9.900 s after the first: no run of the model explains it; "
        "the next message could only be on /scans"
    )
    assert verdict.unexplained is not None and verdict.unexplained.publishers == ("mapper",)


@pytest.mark.parametrize("before", [10, 300])
def test_the_run_that_is_drawn_shows_the_last_messages(before: int) -> None:
    """It begins with the initial marking where all messages are remembered, else with a possible one."""
    model, messages = sensor()
    messages[before:before] = [("/dones", messages[before - 1][1])]
    verdict = explain(model, recorded("/scans", "/dones"), messages)
    topics = shown(verdict, model)
    assert topics == [topic for topic, _ in messages[before - len(topics) : before]]
    assert len(topics) == before if before < 100 else 60 < len(topics) < 200
    assert verdict.cause is not None


def test_nodes_may_have_run_before_the_recorder_came() -> None:
    model, messages = sensor()
    late = messages[1:]
    assert number(explain(model, recorded("/scans", "/dones"), late)) == 1
    assert number(explain(model, recorded("/scans", "/dones"), late, midway=True)) is None


def test_messages_close_to_each_other_may_have_been_published_in_any_order() -> None:
    model, _ = sensor()
    messages = [("/dones", 0), ("/scans", 8 * MILLISECOND)]
    assert number(explain(model, recorded("/scans", "/dones"), messages, tolerance=0.008)) is None
    assert number(explain(model, recorded("/scans", "/dones"), messages, tolerance=0.007)) == 1


def greeting() -> sym.SystemModel:
    """Return two nodes that greet once each; whoever hears the other before it greets may thank for that."""
    pages, channels = [], []
    heard: dict[str, sym.Place] = {}
    said: list[tuple[str, str, sym.Place]] = []
    for name, other in (("one", "two"), ("two", "one")):
        node = sym.NodeNet(id=name)
        places = {each: sym.Place(id=f"{name}{each}", page=node) for each in ("Greeting", "Thanks", "Heard")}
        start = sym.Place(id=f"{name}Start", tokens=1, page=node)
        flow(start, sym.Transition(id=f"{name}Greet", page=node), places["Greeting"])
        answer = sym.Transition(id=f"{name}Answer", page=node)
        flow(start, answer)
        flow(places["Heard"], answer, places["Greeting"])
        flow(answer, places["Thanks"])
        heard[f"{other}/greets"] = places["Heard"]
        pages.append(node)
        said += [(name, "greets", places["Greeting"]), (name, "thanks", places["Thanks"])]
    for name, kind, place in said:
        hearer = heard.get(f"{name}/{kind}")
        channels.append(
            sym.TopicChannel(
                id=f"{name}{kind}",
                topic=f"{name}/{kind}",
                publishers=[sym.PublisherPort(place=place)],
                subscribers=[sym.SubscriberPort(place=hearer)] if hearer is not None else [],
            )
        )
    return sym.SystemModel(id="greeting", middleware="ros2", pages=pages, channels=channels)


@pytest.mark.long
@pytest.mark.parametrize(("late", "other"), [("one", "two"), ("two", "one")])
@pytest.mark.parametrize("first", ["one", "two"])
def test_what_came_later_may_fit_to_another_order_than_the_one_that_is_remembered(
    late: str, other: str, first: str
) -> None:
    """Both greetings came at once, and one order only lets a node thank: what is drawn fits."""
    second = "two" if first == "one" else "one"
    model = greeting()
    topics = [f"/{node}/{kind}" for node in ("one", "two") for kind in ("greets", "thanks")]
    messages = [(f"/{first}/greets", 0), (f"/{second}/greets", MILLISECOND), (f"/{late}/thanks", 10**9)]
    assert number(explain(model, recorded(*topics), messages, tolerance=0.01)) is None
    assert number(explain(model, recorded(*topics), messages, tolerance=0)) == (3 if first == late else None)
    for wrong in (f"/{late}/thanks", f"/{other}/thanks"):  # nobody thanks twice, and not both do
        verdict = explain(model, recorded(*topics), [*messages, (wrong, 2 * 10**9)], tolerance=0.01)
        assert number(verdict) == 4
        drawn = shown(verdict, model)
        assert drawn
        assert drawn == [f"/{other}/greets", f"/{late}/greets", f"/{late}/thanks"][-len(drawn) :]


def test_what_was_not_recorded_may_come_at_any_time_and_what_the_model_lacks_is_left_out() -> None:
    model, _ = sensor()
    messages = [("/dones", n) for n in range(30)] + [("/elsewhere", 5)]
    others = [*recorded("/dones", "/elsewhere"), RecordedTopic("/rosout", "rcl_interfaces/msg/Log")]
    verdict = explain(model, others, messages)
    assert (verdict.status, verdict.messages) == ("conforms", 30)
    assert (verdict.hidden, verdict.others) == (("/scans",), ("/elsewhere",))


def test_events_of_several_clients_count_where_the_server_tells_of_all() -> None:
    """Two nodes ask one service; who alone tells of it, no event says."""
    endpoint = (Endpoint("/ask", "std_srvs/srv/Trigger"),)
    nodes = [ObservedNode("/a", (TopicEndpoint("/x", "std_msgs/msg/String"),), servers=endpoint)]
    nodes += [ObservedNode(name, clients=endpoint) for name in ("/b", "/c")]
    said = Given({"/a": GivenNode(timers={})})
    model = to_model(ObservedSystem("a test", tuple(nodes)), said).model
    sent, received, answered, _ = (event_name("/ask", event) for event in SERVICE_EVENTS)
    alone = explain(model, recorded("/x", sent), [("/x", 0)])
    assert (alone.status, alone.others) == ("conforms", (sent,))
    messages = [(sent, 0), (received, 10**9), ("/x", 2 * 10**9), (answered, 3 * 10**9)]
    both = recorded("/x", sent, received, answered)
    assert number(explain(model, both, messages)) is None
    assert number(explain(model, both, messages[1:])) == 1
    late = explain(model, both, [*messages, (received, 5 * 10**9)])
    assert late.unexplained is not None and late.unexplained.publishers == ("a",)
    assert sent in late.unexplained.possible and answered not in late.unexplained.possible


def unbounded() -> sym.SystemModel:
    """Return a node that may put any number of tokens on a place, and needs 20 of them for a message."""
    node, ears = sym.NodeNet(id="node"), sym.NodeNet(id="ears")
    place, out = sym.Place(id="Place", page=node), sym.Place(id="Out", page=node)
    flow(sym.Transition(id="More", page=node), place)
    say = sym.Transition(id="Say", page=node)
    flow(place, say, weight=20)
    flow(say, out)
    heard = sym.Place(id="Heard", page=ears)
    flow(heard, sym.Transition(id="Hear", page=ears))
    talk = sym.TopicChannel(
        id="Talk",
        topic="talk",
        publishers=[sym.PublisherPort(place=out)],
        subscribers=[sym.SubscriberPort(place=heard)],
    )
    return sym.SystemModel(id="unbounded", middleware="ros2", pages=[node, ears], channels=[talk])


def test_what_is_not_followed_is_not_claimed() -> None:
    """Nothing bounds the place, so it is followed up to so many tokens only; 20 are more."""
    verdict = explain(unbounded(), recorded("/talk"), [("/talk", 0)])
    assert verdict.status == "unknown" and "no place holds more than 16 tokens" in verdict.reason


def test_too_many_orders_are_unknown() -> None:
    model, _ = sensor()
    explainer = Explainer(model, recorded("/scans", "/dones"), tolerance=1000)
    crowd = [("/scans", n) for n in range(200)]
    verdict = explain(model, recorded("/scans", "/dones"), crowd, tolerance=0.1)
    assert verdict.status in ("unknown", "violated")
    assert explainer.is_certain


def test_what_was_forgotten_is_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    model, messages = sensor()
    monkeypatch.setattr("dineros.observation.explaining.following.MOST_STATES", 1)
    monkeypatch.setattr("dineros.observation.explaining.marking_sets.MOST_KEPT", 12)
    assert number(explain(model, recorded("/scans", "/dones"), messages)) is None
    messages[100:100] = [("/dones", messages[99][1])]
    assert number(explain(model, recorded("/scans", "/dones"), messages)) == 101


def test_what_was_forgotten_of_orders_is_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    model, messages = sensor()
    messages[100:100] = [("/dones", messages[99][1])]
    expected = number(explain(model, recorded("/scans", "/dones"), messages, tolerance=0.15))
    assert expected is not None and expected > 101
    monkeypatch.setattr("dineros.observation.explaining.following.MOST_STATES", 1)
    monkeypatch.setattr("dineros.observation.explaining.marking_sets.MOST_ANSWERS", 1)
    monkeypatch.setattr("dineros.observation.explaining.commuting.MOST_KNOWN", 1)
    assert number(explain(model, recorded("/scans", "/dones"), messages, tolerance=0.15)) == expected


def test_orders_that_allow_no_more_are_not_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing is to be done yet, a scan comes first; else the order that was seen will do."""
    model, _ = sensor()
    follower = Explainer(model, recorded("/scans", "/dones"))._follower
    commuting = Commuting(follower)
    start = follower.start()
    assert commuting.needed(start, "/dones", (("/scans", 1),)) == (
        "/dones",
        "/scans",
    )  # nothing is to be done
    assert commuting.needed(start, "/scans", (("/dones", 1),)) == ("/scans",)
    begun = follower.step(start, "/scans")
    assert commuting.needed(begun, "/scans", (("/dones", 1),)) == ("/scans",)
    monkeypatch.setattr("dineros.observation.explaining.commuting.FREE_LOOKS", -1)
    assert Commuting(follower).needed(begun, "/scans", (("/dones", 1),)) == ("/scans", "/dones")
