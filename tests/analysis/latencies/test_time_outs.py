"""Callbacks that wait for a response until a time-out: against a program that knows no nets."""

from __future__ import annotations

import os
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from tests.support.timed_systems.giving_up import Calling, explored

SEEDS = 30 * int(os.environ.get("DINEROS_EXAMPLES", "1"))


def drawn(seed: int) -> Calling:
    random = Random(seed)

    def span(most: int) -> tuple[int, int]:
        least = random.randint(0, most)
        return least, least + random.randint(0, 2)

    beside = (random.randint(4, 9), random.randint(1, 3)) if random.random() < 0.5 else None
    return Calling(random.randint(4, 12), random.randint(1, 6), span(1), span(1), span(2), span(4), beside)


def model_of(system: Calling) -> sym.SystemModel:
    """Return the system as a model, a unit of a hundredth of a second."""

    def interval(span: tuple[int, int]) -> pn.TimeInterval:
        return seconds(span[0] / 100, span[1] / 100)

    model = sym.SystemModel(id="calling", middleware="ros2")
    asking = node_net(model, "asking", execution="callbacks", threads=2)
    asks = callback(asking, "asks", "timer")
    asks.timer, asks.offset = system.period / 100, seconds(0, 0)
    request, response, late = place(asks, "request"), place(asks, "response"), place(asks, "late")
    sends = step(asks, "sends", [], [request])
    sends.interval = interval(system.before)
    for name, source in (("ok", response), ("tired", late)):
        step(asks, name, [source], []).interval = interval(system.after)
    serving = node_net(model, "serving", execution="callbacks")
    serves = callback(serving, "serves", "server")
    entry, exit_ = place(serves, "entry"), place(serves, "exit")
    step(serves, "serve", [entry], [exit_])
    serves.duration = interval(system.serves)
    if system.beside is not None:
        beside = callback(serving, "beside", "timer")
        beside.timer, beside.offset = system.beside[0] / 100, seconds(0, 0)
        beside.duration = seconds(system.beside[1] / 100, system.beside[1] / 100)
        step(beside, "spins", [], [])
    service = sym.ServiceChannel(id="service", service="/service", depth=10, model=model)
    service.latency = interval(system.latency)
    service.server = sym.ServerPort(page=serves, entry=entry, exit=exit_)
    group = sym.CallbackGroup(id="answers")
    asking.callbackGroups.append(group)
    service.clients.append(
        sym.ClientPort(
            client="asks",
            request=request,
            response=response,
            group=group,
            timeout=system.timeout / 100,
            timedOut=late,
        )
    )
    assert not [each for each in validate(model) if each.severity == "error"]
    return model


@pytest.mark.long
def test_random_calls() -> None:
    compared = 0
    for seed in range(SEEDS):
        system = drawn(seed)
        seen = explored(system)
        if seen is None or system.latency[1] >= system.timeout:
            continue  # its time-out has no rule if a request can be on its way so long
        latencies = Latencies(model_of(system), Budget(seconds=20))
        found = latencies.everything()
        if latencies.reason:
            continue
        compared += 1
        asks = found.callbacks["asks"]
        assert asks.least is not None and asks.greatest is not None and asks.is_exact, (seed, asks)
        span = int(asks.least.value * 100), int(asks.greatest.value * 100)
        assert span == (min(seen.asks), max(seen.asks)), (seed, system, asks)
        assert found.readers["entry"] == (max(seen.longest), "requests" in seen.lost), (seed, system)
        lost = {name for name, loses in found.timers.items() if loses}
        assert lost == seen.lost - {"requests"}, (seed, system)
        subject = latencies.subject
        fired = {subject.transition_element(t) for t in latencies.explored.ways}
        assert {way for way, name in (("ok", "ok"), ("late", "tired")) if name in fired} == seen.ways, seed
        assert "can give up" in found.callbacks["serves"].reason
    assert compared > SEEDS / 4, compared
