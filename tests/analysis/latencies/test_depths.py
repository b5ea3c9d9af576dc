"""The least depths with which nothing is lost: a history of one less overflows."""

from __future__ import annotations

import copy
import os
from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies
from dineros.analysis.latencies.depths import LARGEST, Depth, least_depths
from dineros.metamodel import sym
from dineros.metamodel.elements import channels
from tests.analysis.latencies.test_reaction_and_age import drawn
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.executors import Explorer
from tests.support.timed_systems.models import model_of
from tests.support.timed_systems.threads import Threads


def depths_of(model: sym.SystemModel) -> dict[str, Depth]:
    return least_depths(model, Budget(seconds=100))


def readers(model: sym.SystemModel) -> dict[str, sym.SubscriberPort]:
    return {port.place.id: port for topic in channels(model, sym.TopicChannel) for port in topic.subscribers}


@pytest.mark.parametrize("number", [1, 3, 5, 6, 11, 14])
def test_nothing_is_lost_with_the_least_depth_and_something_with_one_less(number: int) -> None:
    model = model_of(COUNTED[number].system, 0.01)
    before = {name: port.limit for name, port in readers(model).items()}
    found = depths_of(model)
    assert {name: port.limit for name, port in readers(model).items()} == before
    assert {name: each.depth for name, each in found.items()} == before
    for name, port in readers(model).items():
        least = found[name].least
        assert least is not None
        port.limit = least
    assert not any(loses for _, loses in Latencies(model, Budget(seconds=100)).everything().readers.values())
    for name, port in readers(model).items():
        if port.limit > 1:
            port.limit -= 1
            assert Latencies(model, Budget(seconds=100)).everything().readers[name][1] is True
            port.limit += 1


def test_a_chain_of_overflows_is_deepened_until_nothing_is_lost() -> None:
    """As a program without nets finds with depths that are large enough."""
    system: dict[str, Any] = {
        "nodes": {name: {"threads": 1} for name in "abc"},
        "latency": {"scan": (0, 3), "pose": (0, 4)},
        "chains": [],
        "callbacks": [
            {"name": "sense", "node": "a", "group": "default", "period": 4, "offset": 0,
             "script": [["work", 0, 2], ["publish", "scan"]]},
            {"name": "locate", "node": "b", "group": "default", "topic": "scan", "depth": 1,
             "script": [["work", 1, 3], ["publish", "pose"]]},
            {"name": "act", "node": "c", "group": "default", "topic": "pose", "depth": 1,
             "script": [["work", 1, 3]]},
        ],
    }  # fmt: skip
    found = depths_of(model_of(system))
    for each in system["callbacks"]:
        if "depth" in each:
            each["depth"] = 20
    facts = Explorer(system).explore()
    assert not facts.lost
    assert {name.partition(".")[0]: each.least for name, each in found.items()} == facts.longest
    assert max(facts.longest.values()) > 1


@pytest.mark.long
def test_random_systems_need_the_depths_that_a_plain_program_counts() -> None:
    """It gives each history so much room that nothing is lost, and counts what waits."""
    compared = deeper = 0
    for seed in range(40 * int(os.environ.get("DINEROS_EXAMPLES", "1"))):
        system, _ = drawn(seed)
        deep = copy.deepcopy(system)
        for each in deep["callbacks"]:
            if "depth" in each:
                each["depth"] = 12
        try:
            facts = Threads(deep).explore(6_000)
        except TooManyStatesError:
            continue
        found = least_depths(model_of(system, 0.01), Budget(seconds=20))
        for place, depth in found.items():
            longest = max(1, facts.longest[place.removesuffix(".heard")])
            if not facts.lost and (not depth.reason or "suffice" in depth.reason):
                assert depth.least == longest, (seed, place)
                compared += 1
                deeper += longest > 1
    assert compared > 8 and deeper > 2, (compared, deeper)


def test_a_reader_that_is_too_slow_has_no_depth() -> None:
    found = depths_of(model_of(COUNTED[1].system | {"callbacks": [
        {"name": "tick", "node": "a", "group": "default", "period": 4, "offset": 0,
         "script": [["work", 0, 0], ["publish", "t"]]},
        {"name": "log", "node": "b", "group": "default", "topic": "t", "depth": 2,
         "script": [["work", 5, 5]]},
    ]}, 0.01))  # fmt: skip
    assert found == {"log.heard": Depth(2, None, f"a depth of {LARGEST} does not suffice")}
