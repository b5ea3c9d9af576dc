"""Chains over best-effort topics: exact times, against a plain program in which any message may be lost."""

from __future__ import annotations

import os
from collections.abc import Iterator
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies, end_of
from dineros.metamodel import sym
from dineros.metamodel.elements import channels
from tests.analysis.latencies.test_against_plain_program import require_exactly, varied
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.counted import CHAINS, COUNTED
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.threads import Threads, _State, _with

SEEDS = 30 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 2_500


class Losing(Threads):
    """Explores a system; messages of the topics in `bestEffort` may be lost when they are published."""

    def __init__(self, system: System) -> None:
        super().__init__(system)
        self.may_lose = [publisher[1] in system["bestEffort"] for publisher, _ in self.pairs]

    def _successors(self, state: _State) -> Iterator[_State]:
        for after in super()._successors(state):
            found = [after]
            for pair, flight in enumerate(after.flights):
                if self.may_lose[pair] and len(flight) > len(state.flights[pair]):
                    found += [each._replace(flights=_with(each.flights, pair, flight[:-1])) for each in found]
            yield from found


def lossy(model: sym.SystemModel, topics: set[str]) -> sym.SystemModel:
    """Make topics of a model best effort."""
    for topic in channels(model, sym.TopicChannel):
        if topic.topic in topics:
            topic.qos = sym.QualityOfService(reliability="bestEffort")
    return model


@pytest.mark.parametrize("number", [1, 5, 11])
def test_times_are_those_without_losses_and_each_message_may_be_lost(number: int) -> None:
    system, (first, last, least, greatest, _) = COUNTED[number].system, CHAINS[number]
    model = lossy(model_of(system), {"t", "scan", "pose"})
    found = Latencies(model, Budget(seconds=60)).between(end_of(model, first), end_of(model, last))
    assert found.is_exact and found.is_lost
    assert found.least is not None and found.greatest is not None
    assert [found.least.value, found.greatest.value] == [least, greatest]
    assert found.age is None and "best effort" in found.reasons["age"]


def compared(seed: int) -> int:
    """Compare the chains of a random system; return how many have exact times."""
    system, draw = varied(seed), Random(seed)
    used = {step[-1] for each in system["callbacks"] for step in each["script"] if step[0] != "work"}
    system["bestEffort"] = {topic for topic in sorted(used) if draw.random() < 0.6}
    if any(each.get("topic") in used & {step[-1] for step in each["script"]} for each in system["callbacks"]):
        return 0  # data that comes round again counts once
    try:
        facts = Losing(system).explore(MOST_STATES)
    except TooManyStatesError:
        return 0
    model = lossy(model_of(system, 0.01), system["bestEffort"])
    latencies = Latencies(model, Budget(seconds=20))
    exact = 0
    for (first, last), span in facts.chains.items():
        if first != last:
            exact += require_exactly(latencies.between(end_of(model, first), end_of(model, last)), *span)
    return exact


@pytest.mark.long
def test_random_systems() -> None:
    assert sum(compared(seed) for seed in range(SEEDS)) > SEEDS / 10
