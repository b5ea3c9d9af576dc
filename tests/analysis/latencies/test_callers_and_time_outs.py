"""Callbacks that call services, on any threads, with and without time-outs: against a plain program.

Groups and threads of callers, servers, and what shares their executors are random, and up to two clients call
one service. What is exact must be the same; what is not must never exclude what happens.
"""

from __future__ import annotations

import os
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Everything, Latencies, Latency
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.threads import TooManyStatesError
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

    def place(*groups: str) -> dict[str, str]:
        return {"node": random.choice(sorted(nodes)), "group": random.choice(groups)}

    any_group = ("default", "default", "g", "reentrant")
    server = {"name": "s", "service": "look", "depth": 10, "script": [["work", *span(3, 2)]]}
    callbacks = [{**server, **place(*any_group)}]
    for number in range(random.choice([1, 1, 2])):
        answers = random.choice(["answers", "answers", "reentrant", "default"])
        call: list[object] = ["call", "look", answers]
        call += [random.randint(3, 7)] if random.random() < 0.65 else []
        script = [["work", *span(1, 1)], call, ["work", *span(1, 1)], ["publish", f"t{number}"]]
        timer = {"period": random.randint(5, 13), "offset": random.choice([0, 0, 2])}
        callbacks.append({"name": f"a{number}", **timer, "script": script, **place("default", "g")})
    for number in range(random.randint(0, 2)):
        other = {"name": f"c{number}", "script": [["work", *span(2, 1)]], **place(*any_group)}
        timer = {"period": random.randint(4, 12), "offset": 0}
        reader = {"topic": "t0", "depth": random.randint(1, 2)}
        callbacks.append({**other, **random.choice([timer, reader])})
    latency = {"look": random.choice([(0, 0), (0, 1), (1, 1), (1, 2)]), "t0": random.choice([(0, 0), (0, 2)])}
    return {"nodes": nodes, "latency": latency, "chains": [], "callbacks": callbacks}


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


def compared(seed: int) -> int:
    """Compare a system, if it is small enough; return how many of its answers are exact."""
    system = drawn(seed)
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
    assert compared(seed) >= 0


@pytest.mark.long
def test_many() -> None:
    exact = [number for seed in range(SEEDS) if (number := compared(seed))]
    assert len(exact) > SEEDS / 8
