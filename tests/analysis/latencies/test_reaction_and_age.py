"""Reaction times and data ages of random systems, against a plain program that knows no nets.

The systems have short histories that displace messages, several publishers of a topic, values that a timer
reads, jitter, threads, and executors with an order. What is found must be equal, and no bound may be below
it. With ``DINEROS_EXAMPLES=20``, some hundred systems are compared.
"""

from __future__ import annotations

import os
from random import Random
from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import Latencies, end_of
from dineros.analysis.latencies.paths import paths_between
from dineros.analysis.latencies.results import Latency
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.reacting import Ages, Reacting

SEEDS = 40 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 3_000
LATENCIES = [(0, 0), (0, 1), (1, 1), (2, 4), (0, 5)]


def called(name: str, node: str, *script: list[Any], **more: Any) -> dict[str, Any]:
    return {"name": name, "node": node, "group": "default", "script": list(script), **more}


class _Drawing:
    """Draws a system by a seed."""

    def __init__(self, seed: int) -> None:
        self.random = random = Random(seed)
        self.nodes: dict[str, dict[str, Any]] = {}
        for number in range(random.randint(1, 3)):
            threads = random.choice([1, 1, 2])
            order = random.choice(["any", "any", "rclcpp", "rclpy"]) if threads == 1 else "any"
            self.nodes[f"n{number}"] = {"threads": threads, "order": order}

    def one(self, name: str, *script: list[Any], node: str = "", **more: Any) -> dict[str, Any]:
        node = node or self.random.choice(sorted(self.nodes))
        groups = ["default", "default", "g", "reentrant"] if self.nodes[node]["threads"] > 1 else ["default"]
        return called(name, node, *script, **more) | {"group": self.random.choice(groups)}

    def work(self, most: int) -> list[Any]:
        least = self.random.randint(0, most)
        return ["work", least, least + self.random.choice([0, 0, 1, 2])]

    def timer(self, name: str, periods: tuple[int, int], *script: list[Any], **more: Any) -> dict[str, Any]:
        random = self.random
        made = self.one(name, *script, period=random.randint(*periods), offset=random.choice([0, 1, 3]))
        return made | ({"jitter": random.choice([1, 2])} if random.random() < 0.15 else {}) | more


def drawn(seed: int) -> tuple[System, str]:
    """Return a chain that begins at the timer ``c0``, and the callback at which it ends."""
    draw = _Drawing(seed)
    random = draw.random
    callbacks = [draw.timer("c0", (3, 8), draw.work(2), ["publish", "t0"])]
    for number in range(1, random.randint(1, 2) + 1):
        script = [draw.work(4), ["publish", f"t{number}"]]
        if random.random() < 0.15:
            script = [["open", *script[0][1:], f"t{number}"]]
        depth = random.choice([1, 1, 2, 3])
        callbacks.append(draw.one(f"c{number}", *script, topic=f"t{number - 1}", depth=depth))
    last, end = callbacks[-1], callbacks[-1]["name"]
    match random.choice(["sampled", "shared", "shared", "busy"]):
        case "sampled":
            last["script"], last["stores"] = [["work", *last["script"][0][1:3]]], "v"
            last["group"], end = "default", "s"
            sampler = draw.timer("s", (3, 9), draw.work(2), samples=["v"])
            callbacks.append(sampler | {"node": last["node"], "group": "default"})
        case "shared":
            topic = random.choice([each["topic"] for each in callbacks if "topic" in each])
            callbacks.append(draw.timer("other", (3, 9), draw.work(2), ["publish", topic]))
        case _:
            callbacks.append(draw.timer("other", (5, 12), draw.work(5)))
    used = {each["node"]: draw.nodes[each["node"]] for each in callbacks}
    latency = {f"t{number}": random.choice(LATENCIES) for number in range(3)}
    return {"nodes": used, "latency": latency, "chains": [], "callbacks": callbacks}, end


def require_times(found: Latency, wanted: Ages, bound: Latency) -> tuple[bool, bool]:
    """Require that known times are these, in hundredths of a second; tell which are known."""
    for name, known, least in (
        ("reaction", found.reaction, wanted.reaction),
        ("age", found.age, wanted.age),
    ):
        assert known is not None or found.reason or found.reasons[name]
        assert known is None or (known.value * 100 == least and not wanted.is_unbounded)
    for safe, least in ((bound.reaction, wanted.reaction), (bound.age, wanted.age)):
        assert safe is None or least is None or safe.value * 100 >= least
    return found.reaction is not None, found.age is not None


def between(system: System, first: str, last: str) -> tuple[Latency, Latency]:
    model = model_of(system, 0.01)
    ends = end_of(model, first), end_of(model, last)
    return Latencies(model, Budget(seconds=60)).between(*ends), Bounds(model).between(*ends)


@pytest.mark.long
def test_random_systems_react_as_a_plain_program_finds() -> None:
    reactions = ages = 0
    for seed in range(SEEDS):
        system, end = drawn(seed)
        model = model_of(system, 0.01)
        if len(paths_between(model, end_of(model, "c0"), end_of(model, end))) != 1:
            continue
        try:
            wanted = Reacting(system, "c0", end).ages(MOST_STATES)
        except TooManyStatesError:
            continue
        found, bound = between(system, "c0", end)
        reacts, grows_old = require_times(found, wanted, bound)
        reactions += reacts
        ages += grows_old
    assert reactions > SEEDS / 8 and ages > SEEDS / 8, (reactions, ages)


def shared(*nodes: str) -> System:
    """Return two timers of two nodes that publish on a topic; its reader keeps one message."""
    timers = [
        called("c0", nodes[0], ["work", 0, 0], ["publish", "t0"], period=3, offset=0),
        called("other", nodes[1], ["work", 0, 0], ["publish", "t0"], period=9, offset=3),
    ]
    reads = called("c1", "reader", ["work", 2, 3], topic="t0", depth=1)
    threads = {each: {"threads": 1} for each in [*nodes, "reader"]}
    return {"nodes": threads, "latency": {"t0": (0, 0)}, "chains": [], "callbacks": [*timers, reads]}


def test_what_another_publisher_sends_is_no_reaction() -> None:
    """It displaces the message that is followed, and its data does not come from the chain."""
    system = shared("a", "b")
    wanted = Reacting(system, "c0", "c1").ages(MOST_STATES)
    found, bound = between(system, "c0", "c1")
    require_times(found, wanted, bound)
    assert wanted.reaction is not None and wanted.age is not None
    assert found.is_lost and found.reaction is None and found.age is not None
    assert wanted.reaction > wanted.age
    told = found.to_dict()["reasons"]
    assert told == {"reaction": "data on the way can be displaced by other data than that of the chain"}


def test_what_the_same_timer_sends_is_newer() -> None:
    system = shared("a", "b")
    del system["callbacks"][1]
    wanted = Reacting(system, "c0", "c1").ages(MOST_STATES)
    found, bound = between(system, "c0", "c1")
    assert require_times(found, wanted, bound) == (True, True)
    assert found.is_lost is False or found.reaction is not None


def sampling(order: str) -> System:
    """Return a thread that stores what a sensor sends, and reads it by a timer."""
    callbacks = [
        called("c0", "n", ["work", 0, 0], ["publish", "t0"], period=4, offset=2),
        called("c1", "n", ["work", 0, 2], topic="t0", depth=3, stores="v"),
        called("s", "n", ["work", 2, 2], period=6, offset=1, samples=["v"]),
    ]
    nodes = {"n": {"threads": 1, "order": order}}
    return {"nodes": nodes, "latency": {"t0": (2, 4)}, "chains": [], "callbacks": callbacks}


@pytest.mark.parametrize(("order", "age"), [("any", 27), ("rclcpp", 25), ("rclpy", 25)])
def test_a_timer_that_reads_a_value_keeps_the_order_of_its_executor(order: str, age: int) -> None:
    wanted = Reacting(sampling(order), "c0", "s").ages(30_000)
    assert wanted == Ages(age, age)
    found, bound = between(sampling(order), "c0", "s")
    assert require_times(found, wanted, bound) == (True, True)
