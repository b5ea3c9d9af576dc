"""No bound is below what a program finds that explores every behaviour of small systems.

Sixty systems of each kind are drawn in a run; with ``DINEROS_EXAMPLES=20``, some thousand. The test names the
seed of a system for which a bound is too low.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from random import Random
from typing import Any

import pytest

from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import end_of
from dineros.analysis.latencies.results import Everything, Latency
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.executors import Explorer
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.threads import Threads

SEEDS = 60 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 12_000
LATENCIES = [(0, 0), (0, 1), (1, 1), (2, 4), (0, 7)]


def drawn(seed: int, orders: tuple[str, ...] = ("any",), most_threads: int = 1) -> System:
    """Return up to three nodes with two to five callbacks: timers, and what follows from them."""
    random = Random(seed)
    nodes: dict[str, dict[str, Any]] = {
        f"n{number}": {"threads": random.randint(1, most_threads), "order": random.choice(orders)}
        for number in range(random.randint(1, 3))
    }
    callbacks: list[dict[str, Any]] = []
    for number in range(random.randint(2, 5)):
        least = random.randint(0, 2)
        each: dict[str, Any] = {
            "name": f"c{number}",
            "node": random.choice(sorted(nodes)),
            "group": random.choice(["default", "g", "reentrant"]) if most_threads > 1 else "default",
            "script": [["work", least, least + random.randint(0, 2)], ["publish", f"t{number}"]],
        }
        if number == 0 or random.random() < 0.3:
            each["period"] = random.randint(4, 14)
            each["offset"] = random.choice([0, 2, "any"])
            each["jitter"] = random.choice([0, 0, 0, 1, 3]) if orders == ("any",) else 0
        else:
            each["topic"] = f"t{random.randint(0, number - 1)}"
            each["depth"] = random.randint(1, 3)
        callbacks.append(each)
    latency = {f"t{number}": random.choice(LATENCIES) for number in range(len(callbacks))}
    return {"nodes": nodes, "latency": latency, "chains": [], "callbacks": callbacks}


def require_above(found: Latency, least: int, greatest: int) -> bool:
    """Require that bounds hold, in hundredths of a second; tell whether there are any."""
    assert found.least is not None and found.least.value * 100 <= least
    assert not found.is_exact
    if found.greatest is None:
        assert found.reason
        return False
    assert found.greatest.value * 100 >= greatest
    return True


def require_safe(systems: Iterable[System], explore: Callable[[System], Any]) -> tuple[int, int]:
    """Require that all bounds of systems hold; return how many systems and response times were compared.

    `explore` returns the facts about a system; systems with too many states are left out.
    """
    compared = bounded = 0
    for system in systems:
        try:
            facts = explore(system)
        except ValueError:
            continue
        compared += 1
        found = Bounds(model_of(system, 0.01)).everything()
        require_kept(found, facts.longest, facts.lost, facts.missed)
        for name, span in facts.response.items():
            bounded += require_above(found.callbacks[name], *span)
    return compared, bounded


def require_kept(found: Everything, longest: dict[str, int], lost: set[str], missed: set[str]) -> None:
    """Require that nothing is called impossible that can happen."""
    for place, (most, overflows) in found.readers.items():
        if place.endswith(".response"):
            continue  # the program has no histories of responses
        name = place.removesuffix(".heard").removesuffix(".entry")
        assert most >= longest[name]
        assert overflows is None or (overflows is False and name not in lost)
    for name, loses in found.timers.items():
        assert loses is None or (loses is False and name not in missed)


@pytest.mark.parametrize("most_threads", [1, 3])
def test_in_any_order(most_threads: int) -> None:
    bounded = systems = 0
    for seed in range(SEEDS):
        system = drawn(seed, most_threads=most_threads)
        try:
            facts = Threads(system).explore(MOST_STATES)
        except TooManyStatesError:
            continue
        systems += 1
        model = model_of(system, 0.01)
        bounds = Bounds(model)
        found = bounds.everything()
        require_kept(found, facts.longest, facts.lost, facts.missed)
        for name, span in facts.response.items():
            bounded += require_above(found.callbacks[name], *span)
        for (first, last), span in facts.chains.items():
            chain = bounds.between(end_of(model, first), end_of(model, last))
            bounded += require_above(chain, *span)
            assert chain.is_lost is None or not facts.lost & set(_between(system, first, last))
    assert systems > SEEDS / 2 and bounded > systems, "most systems have bounds"


def _between(system: System, first: str, last: str) -> Iterator[str]:
    """Yield the subscriptions on the way, of which each has one publisher."""
    callbacks = {each["name"]: each for each in system["callbacks"]}
    while last != first:
        yield last
        last = f"c{callbacks[last]['topic'].removeprefix('t')}"


def test_with_wait_results() -> None:
    drawn_systems = (drawn(seed, orders=("any", "rclcpp")) for seed in range(SEEDS))
    systems, bounded = require_safe(drawn_systems, lambda system: Explorer(system).explore(MOST_STATES))
    assert systems > SEEDS / 2 and bounded > systems, "most systems have bounds"


def test_a_bound_that_is_a_unit_lower_is_noticed() -> None:
    timer = {"name": "c0", "node": "n", "group": "default", "period": 9, "offset": 0}
    reader = {"name": "c1", "node": "n", "group": "default", "topic": "t0", "depth": 1}
    system = {
        "nodes": {"n": {"threads": 1}},
        "latency": {"t0": (0, 0)},
        "chains": [],
        "callbacks": [
            {**timer, "script": [["work", 1, 2], ["publish", "t0"]]},
            {**reader, "script": [["work", 3, 3]]},
        ],
    }
    facts = Threads(system).explore(MOST_STATES)
    assert facts.chains["c0", "c1"] == (4, 5) and facts.response == {"c0": (1, 2), "c1": (3, 3)}
    model = model_of(system, 0.01)
    found = Bounds(model).between(end_of(model, "c0"), end_of(model, "c1"))
    assert found.greatest is not None and found.greatest.value == Fraction(5, 100)
    with pytest.raises(AssertionError):
        require_above(found, 4, 6)
