"""Random systems that mix features: no answer excludes what a plain program finds.

Executors with an order, several threads and reentrant groups stand next to engines. Callbacks call a service,
some with a time-out; messages have lifespans, readers have deadlines. State classes allow at least what
happens, where an order or a time-out is left open more than that. Bounds are never below it.
"""

from __future__ import annotations

import os
from random import Random
from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import Latencies
from dineros.analysis.latencies.results import Everything
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import channels, node_net_of
from tests.analysis.timed_checks.test_random_systems import by_classes, fired, require_possible
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.mixed import Mixed, Mixture
from tests.support.timed_systems.models import System, model_of

SEEDS = 40 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 8_000
CLASSES = Budget(seconds=60, states=15_000)
UNIT = 0.01


def drawn(seed: int) -> System:
    """Return two or three executors, perhaps an engine, a server with up to two callers, and readers."""
    random = Random(seed)
    orders = ("any", "rclcpp", "rclpy")
    nodes: dict[str, dict[str, Any]] = {
        f"n{number}": {"threads": random.choice([1, 1, 2, 3]), "order": random.choice(orders)}
        for number in range(random.randint(2, 3))
    }

    def span(most: int, wider: int) -> list[int]:
        least = random.randint(0, most)
        return [least, least + random.randint(0, wider)]

    def home(*groups: str) -> dict[str, str]:
        node = random.choice(sorted(each for each in nodes if each != "e"))
        return {"node": node, "group": random.choice(groups)}

    def reader(*topics: str) -> dict[str, Any]:
        return {"topic": random.choice(topics), "depth": random.randint(1, 2)}

    def timer() -> dict[str, Any]:
        jitter = random.choice([0, 0, 0, 2])
        return {"period": random.randint(5, 13), "offset": random.choice([0, 0, 2]), "jitter": jitter}

    callbacks: list[dict[str, Any]] = []
    topics = ["t0"]
    has_service = random.random() < 0.7
    if has_service:
        server = {"name": "s", "service": "look", "depth": 10, "script": [["work", *span(3, 2)]]}
        callbacks.append({**server, **home("default", "g", "reentrant")})
    for number in range(random.choice([1, 1, 2])):
        name, topic = f"a{number}", f"t{number}"
        script: list[list[Any]] = [["work", *span(1, 1)], ["publish", topic]]
        if has_service and random.random() < 0.8:
            call: list[Any] = ["call", "look", random.choice(["answers", "answers", "reentrant", "default"])]
            call += [random.randint(3, 7)] if random.random() < 0.5 else []
            script = [["work", *span(1, 1)], call, ["work", *span(1, 1)], ["publish", topic]]
        elif random.random() < 0.3:
            script = [["open", *span(1, 2), topic]]
        callbacks.append({"name": name, **timer(), "script": script, **home("default", "g", "reentrant")})
        topics = [f"t{each}" for each in range(number + 1)]
    if random.random() < 0.6:
        nodes["e"] = {"threads": 1, "reaction": span(1, 2)}
        of_engine = {"name": "x", "node": "e", "group": "default", "script": [["publish", "u"]]}
        callbacks.append(of_engine | reader(*topics))
        topics.append("u")
    for number in range(random.randint(0, 2)):
        other = {"name": f"c{number}", "script": [["work", *span(2, 1)]], **home("default", "g", "reentrant")}
        callbacks.append(other | (timer() if random.random() < 0.3 else reader(*topics)))
    ways = [(0, 0), (0, 1), (1, 1), (1, 2), (0, 3)]
    latency = {name: random.choice(ways) for name in ("look", *topics)}
    system = {"nodes": nodes, "latency": latency, "chains": [], "callbacks": callbacks}
    system["lifespan"] = {topic: random.randint(1, 9) for topic in topics if random.random() < 0.3}
    system["deadline"] = {topic: random.randint(3, 15) for topic in topics if random.random() < 0.2}
    return system


def model(system: System) -> sym.SystemModel:
    """Return the model: executors as elsewhere, and an engine that passes messages on."""
    engines = {name for name, node in system["nodes"].items() if "reaction" in node}
    rest = [each for each in system["callbacks"] if each["node"] not in engines]
    nodes = {name: node for name, node in system["nodes"].items() if name not in engines}
    made = model_of({**system, "nodes": nodes, "callbacks": rest}, UNIT)
    topics = {str(topic.topic): topic for topic in channels(made, sym.TopicChannel)}

    def topic_of(name: str) -> sym.TopicChannel:
        if name not in topics:
            topics[name] = sym.TopicChannel(id=name, topic=name, model=made)
            topics[name].latency = interval(*system["latency"][name])
        return topics[name]

    for name in engines:
        node = node_net(made, name)
        node.reaction = interval(*system["nodes"][name]["reaction"])
        for each in (one for one in system["callbacks"] if one["node"] == name):
            page = callback(node, each["name"])
            heard = place(page, f"{each['name']}.heard")
            outs = []
            for _, topic in each["script"]:
                outs.append(place(page, f"{topic}.out"))
                topic_of(topic).publishers.append(sym.PublisherPort(place=outs[-1], limit=10))
            step(page, f"{each['name']}.do", [heard], outs)
            topic_of(each["topic"]).subscribers.append(sym.SubscriberPort(place=heard, limit=each["depth"]))
    for name, topic in topics.items():
        span, deadline = (system[what].get(name) for what in ("lifespan", "deadline"))
        if span is None and deadline is None:
            continue
        topic.qos = sym.QualityOfService(
            lifespan=None if span is None else round(span * UNIT, 9),
            deadline=None if deadline is None else round(deadline * UNIT, 9),
        )
        for reader in topic.subscribers if deadline is not None else ():
            home = node_net_of(reader.place)
            assert home is not None
            reader.missed = place(home, f"{reader.place.id}.missed")
            reader.missed.capacity = 1
            step(home, f"{reader.place.id}.complain", [reader.missed], [])
    assert [str(each) for each in validate(made) if each.severity == "error"] == []
    return made


def interval(least: float, most: float) -> pn.TimeInterval:
    return seconds(round(least * UNIT, 9), round(most * UNIT, 9))


def require_classes_allow(system: System, made: sym.SystemModel, seen: Mixture) -> bool:
    """Require that classes exclude nothing; return whether they end."""
    subject = timed_base_subject(made)
    found = explore_timed(subject.timed, CLASSES)
    if not found.is_complete:
        return False
    facts = by_classes(subject, found)
    require_possible(subject, found)
    happens = fired(subject, found)
    for name, most in facts.longest.items():
        assert most >= seen.longest[name], name
    readers = {each["name"] for each in system["callbacks"] if "topic" in each}
    assert facts.lost >= seen.lost & readers
    assert facts.missed >= seen.missed
    assert facts.expired >= seen.expired
    late = {name for name in readers if f"{name}.heard.complain" in happens}
    engines = {each["name"] for each in system["callbacks"] if "reaction" in system["nodes"][each["node"]]}
    assert late >= seen.overdue - engines
    return True


def require_known(found: Everything, seen: Mixture) -> int:
    """Require that times contain what is seen, and exact ones are that; return how many have a bound."""
    given = 0
    for name, (least, greatest) in seen.response.items():
        answer = found.callbacks.get(name)
        if answer is None:
            continue
        if answer.least is None:
            assert answer.reason, name
        else:
            assert answer.least.value * 100 <= least, (name, answer, least)
        if answer.greatest is not None:
            given += 1
            assert answer.greatest.value * 100 >= greatest, (name, answer, greatest)
        else:
            assert answer.reason, name
        if answer.is_exact and not answer.reason:
            assert answer.least is not None and answer.greatest is not None
            assert answer.least.value * 100 == least and answer.greatest.value * 100 == greatest, name
    for place_, (most, overflows) in found.readers.items():
        name = str(place_).removesuffix(".heard").removesuffix(".entry")
        if name in seen.longest:
            assert most >= seen.longest[name], name
            assert overflows is not False or name not in seen.lost, name
    for name, loses in found.timers.items():
        assert loses is not False or name not in seen.missed, name
    return given


def compared(seed: int) -> tuple[int, int] | None:
    """Compare a system; return how many times are bounded, and exact; None if it is too large."""
    system = drawn(seed)
    try:
        seen = Mixed(system).explore(MOST_STATES)
    except TooManyStatesError:
        return None
    made = model(system)
    require_classes_allow(system, made, seen)
    if system["lifespan"]:
        return 0, 0  # no latency is asked then
    bounded = require_known(Bounds(made).everything(), seen)
    latencies = Latencies(made, CLASSES)
    return bounded, 0 if latencies.reason else require_known(latencies.everything(), seen)


def test_a_few() -> None:
    found = [compared(seed) for seed in (2, 5, 11)]
    assert any(found)


@pytest.mark.long
def test_many() -> None:
    found = [each for seed in range(SEEDS) if (each := compared(seed)) is not None]
    assert len(found) > SEEDS / 5
    assert sum(bounded for bounded, _ in found) > 0 and sum(exact for _, exact in found) > 0
