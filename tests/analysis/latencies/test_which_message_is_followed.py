"""Which message an observer follows: several are on their way and wait at once, against a plain program.

Periods are shorter than latencies and than the work of readers, so that messages gather on their way and in
histories, and are displaced. An observer that followed the one before or after it would measure other times.
"""

from __future__ import annotations

import os
from random import Random
from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies, end_of
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.threads import Threads

SEEDS = 30 * int(os.environ.get("DINEROS_EXAMPLES", "1"))


def drawn(seed: int) -> System:
    """Return a fast timer and a reader; its thread can have another reader, and a timer that works for long.

    In half of the systems, work and latencies are fixed: then each place in a history has times of its own.
    """
    random = Random(seed)
    least = random.randint(0, 5)
    work = random.randint(0, 3)
    is_fixed = random.random() < 0.5

    def more(most: int) -> int:
        return 0 if is_fixed else random.randint(0, most)

    callbacks = [
        {
            "name": "sends",
            "node": "n0",
            "group": "default",
            "period": random.randint(2, 4),
            "offset": 0,
            "script": [["work", 0, more(1)], ["publish", "t0"]],
        },
        {
            "name": "reads",
            "node": "n1",
            "group": "default",
            "topic": "t0",
            "depth": random.randint(1, 5),
            "script": [["work", work, work + more(2)], ["publish", "t1"]],
        },
    ]
    if random.random() < 0.4:
        last = {
            "name": "ends",
            "node": "n1",
            "group": "default",
            "topic": "t1",
            "depth": random.randint(1, 2),
        }
        callbacks.append({**last, "script": [["work", 0, more(1)]]})
    if random.random() < 0.5:
        busy = random.randint(4, 8)
        beside = {"name": "beside", "node": "n1", "group": "default", "offset": random.randint(0, 3)}
        callbacks.append({**beside, "period": random.randint(9, 16), "script": [["work", busy, busy]]})
    others = random.choice([0, 0, 2, 3])
    if others:  # bursts, in which the last message waits longest
        callbacks[0]["period"] = random.randint(6, 9)
        for number in range(others):
            sender: dict[str, Any] = {"name": f"other{number}", "node": f"o{number}", "group": "default"}
            sender |= {"period": callbacks[0]["period"], "offset": random.choice([0, 0, 1])}
            callbacks.append({**sender, "script": [["work", 0, 0], ["publish", "t0"]]})
    latency = {"t0": (least, least + more(4)), "t1": (0, more(1))}
    nodes = {each["node"]: {"threads": 1} for each in callbacks}
    return {"nodes": nodes, "latency": latency, "chains": [], "callbacks": callbacks}


@pytest.mark.long
def test_chains_with_many_messages() -> None:
    compared = lossy = 0
    for seed in range(SEEDS):
        system = drawn(seed)
        try:
            facts = Threads(system).explore(20_000)
        except TooManyStatesError:
            continue
        model = model_of(system, 0.01)
        latencies = Latencies(model, Budget(seconds=10))
        last = [each["name"] for each in system["callbacks"] if "topic" in each][-1]
        found = latencies.between(end_of(model, "sends"), end_of(model, last), with_ages=False)
        if found.reason or not found.is_exact or found.least is None or found.greatest is None:
            continue
        compared += 1
        lossy += bool(facts.lost)
        span = int(found.least.value * 100), int(found.greatest.value * 100)
        assert span == facts.chains["sends", last], (seed, system)
        assert facts.lost or not found.is_lost, (seed, system)
    assert compared > SEEDS / 3 and lossy, (compared, lossy)
