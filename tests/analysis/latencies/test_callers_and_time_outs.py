"""Callbacks that call services, on any threads, with and without time-outs: against a plain program.

Groups and threads of callers, servers, and what shares their executors are random, and up to two clients call
one service. What is exact must be the same; what is not must never exclude what happens.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies
from dineros.analysis.latencies.results import Everything, Latency
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, place, step
from dineros.metamodel.elements import find
from dineros.metamodel.times.rates import on_the_way
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.waiting import Waited, Waiters

SEEDS = 40 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 20_000


def drawn(seed: int) -> System:
    """Return up to three nodes: a server, one or two timers that call it, and up to two other callbacks."""
    random = Random(seed)
    nodes = {f"n{number}": {"threads": random.randint(1, 3)} for number in range(random.randint(2, 3))}

    def span(most: int, wider: int) -> list[int]:
        least = random.randint(0, most)
        return [least, least + random.randint(0, wider)]

    def home(*groups: str) -> dict[str, str]:
        return {"node": random.choice(sorted(nodes)), "group": random.choice(groups)}

    any_group = ("default", "default", "g", "reentrant")
    server = {"name": "s", "service": "look", "depth": 10, "script": [["work", *span(3, 2)]]}
    callbacks = [{**server, **home(*any_group)}]
    for number in range(random.choice([1, 1, 2])):
        answers = random.choice(["answers", "answers", "reentrant", "default"])
        call: list[object] = ["call", "look", answers]
        call += [random.randint(3, 7)] if random.random() < 0.65 else []
        script = [["work", *span(1, 1)], call, ["work", *span(1, 1)], ["publish", f"t{number}"]]
        timer = {"period": random.randint(5, 13), "offset": random.choice([0, 0, 2])}
        callbacks.append({"name": f"a{number}", **timer, "script": script, **home("default", "g")})
    for number in range(random.randint(0, 2)):
        other = {"name": f"c{number}", "script": [["work", *span(2, 1)]], **home(*any_group)}
        timer = {"period": random.randint(4, 12), "offset": 0}
        reader = {"topic": "t0", "depth": random.randint(1, 2)}
        callbacks.append({**other, **random.choice([timer, reader])})
    latency = {"look": random.choice([(0, 0), (0, 1), (1, 1), (1, 2)]), "t0": random.choice([(0, 0), (0, 2)])}
    return {"nodes": nodes, "latency": latency, "chains": [], "callbacks": callbacks}


def telling(seed: int) -> System:
    """Return such a system whose server publishes: at its end, at any moment, or after a part of its work."""
    system, random = drawn(seed), Random(f"telling {seed}")
    server, *others = system["callbacks"]
    ((_, least, most),) = server["script"]
    if random.random() < 0.3:
        server["script"] = [["work", least, most], ["publish", "s0"]]
    elif server["group"] == "reentrant" or random.random() < 0.6:
        server["script"] = [["open", least, most, "s0"]]
    else:
        server["script"] = [["work", 0, 1], ["publish", "s0"], ["work", least, most]]
    system["latency"]["s0"] = random.choice([(0, 0), (1, 1), (0, 2)])
    reader = {"name": "r", "topic": "s0", "depth": random.randint(1, 2), "node": random.choice(["n0", "n1"])}
    work = ["work", random.randint(0, 2), 2]
    system["callbacks"] = [server, *others[:2], {**reader, "group": "r", "script": [work]}]
    return system


def require_span(found: Latency, span: tuple[int, int]) -> None:
    """Require that exact times are those of the program, and safe ones are no narrower."""
    least = None if found.least is None else found.least.value * 100
    greatest = None if found.greatest is None else found.greatest.value * 100
    if found.is_exact:
        assert least == span[0] and greatest == span[1]
    else:
        assert least is None or least <= span[0]
        assert greatest is None or greatest >= span[1]
        assert greatest is not None or found.reason


def require_same(found: Everything, seen: Waited) -> None:
    """Require the facts of the program: what can be lost, histories, and response times."""
    assert {name for name, loses in found.timers.items() if loses} == seen.missed
    for name, longest in seen.longest.items():
        reader = found.readers[f"{name}.entry" if name == "s" else f"{name}.heard"]
        assert reader == (longest, name in seen.lost)
    for name, response in found.callbacks.items():
        if name in seen.response:
            require_span(response, seen.response[name])
        else:
            assert response.greatest is None


def compared(system: System) -> int:
    """Compare a system, if it is small enough; return how many of its answers are exact."""
    try:
        seen = Waiters(system).explore(MOST_STATES)
    except TooManyStatesError:
        return 0
    latencies = Latencies(model_of(system, 0.01), Budget(seconds=30))
    if latencies.reason:
        return 0
    found = latencies.everything()
    require_same(found, seen)
    return sum(each.is_exact for each in found.callbacks.values())


@pytest.mark.parametrize("seed", [5, 13, 44])
def test_a_few(seed: int) -> None:
    assert compared(drawn(seed)) >= 0


@pytest.mark.parametrize("script", [[["open", 1, 2, "t"]], [["work", 1, 2], ["publish", "t"]]])
def test_a_server_that_publishes_for_each_request(script: list[object]) -> None:
    """A message for each request of a slow timer finds the reader history of depth 1 empty."""
    calls = [["work", 0, 1], ["call", "look", "answers"], ["work", 0, 1]]
    group = {"group": "default"}
    system = {
        "nodes": {name: {"threads": 2} for name in "abc"},
        "latency": {"t": (2, 2)},
        "chains": [],
        "callbacks": [
            {"name": "a0", "node": "a", **group, "period": 10, "offset": 0, "script": calls},
            {"name": "s", "node": "b", **group, "service": "look", "depth": 10, "script": script},
            {"name": "r", "node": "c", **group, "topic": "t", "depth": 1, "script": [["work", 1, 1]]},
        ],
    }
    found = Latencies(model_of(system, 0.01), Budget(seconds=30)).everything()
    assert found.readers["r.heard"] == (1, False)
    require_span(found.callbacks["r"], (1, 1))


def test_a_server_publishes_at_its_end() -> None:
    """Its work of two units is over by then, so only one unit of its thread is left to wait for."""
    system = {
        "nodes": {"n0": {"threads": 3}, "n1": {"threads": 1}},
        "latency": {"look": (0, 0), "t": (1, 1)},
        "chains": [],
        "callbacks": [
            {"name": "s", "node": "n1", "group": "g", "service": "look", "depth": 10}
            | {"script": [["work", 2, 2], ["publish", "t"]]},
            {"name": "a0", "node": "n0", "group": "g", "period": 11, "offset": 2}
            | {"script": [["work", 0, 1], ["call", "look", "default"], ["work", 0, 1]]},
            {"name": "r", "node": "n1", "group": "r", "topic": "t", "depth": 1, "script": [["work", 0, 2]]},
        ],
    }
    found = Latencies(model_of(system, 0.01), Budget(seconds=60)).everything().callbacks["r"]
    assert found.is_exact and Waiters(system).explore(MOST_STATES).response["r"] == (0, 2)
    require_span(found, (0, 2))


def test_requests_that_gather_have_no_bound() -> None:
    """A client with one request under way that does not wait sends those that gather, one after the other."""
    group, work = {"group": "default"}, [["work", 0, 1]]
    system = {
        "nodes": {"a": {"threads": 1}, "b": {"threads": 1}},
        "latency": {"t": (2, 2)},
        "chains": [],
        "callbacks": [
            {"name": "a0", "node": "a", **group, "period": 10, "offset": 0, "script": work},
            {"name": "s", "node": "b", **group, "service": "look", "script": [["open", 0, 1, "t"]]},
            {"name": "r", "node": "a", **group, "topic": "t", "depth": 1, "script": work},
        ],
    }
    model = model_of(system, 0.01)
    ask = find(model, "a0.do", sym.Transition)
    page, node = find(model, "a0", sym.CallbackPage), find(model, "a", sym.NodeNet)
    request, answered = place(page, "request"), callback(node, "answered", "client")
    response = place(answered, "response")
    flow(ask, request)
    step(answered, "take", [response])
    service = find(model, "look.service", sym.ServiceChannel)
    service.clients.append(sym.ClientPort(client="a0", request=request, response=response))
    topic = find(model, "t", sym.TopicChannel)
    assert on_the_way(topic.publishers[0], topic.subscribers[0]) > 0
    service.clients[0].outstanding = 1
    assert on_the_way(topic.publishers[0], topic.subscribers[0]) == 0


@pytest.mark.long
@pytest.mark.parametrize("draw", [drawn, telling])
def test_many(draw: Callable[[int], System]) -> None:
    exact = [number for seed in range(SEEDS) if (number := compared(draw(seed)))]
    assert len(exact) > SEEDS / 8
