"""Times of random systems, against a plain program that explores them in whole units of time.

The systems have several threads, groups and wait results, jitter, first strikes within an interval, several
publishers of a topic, and callbacks that publish in the middle of their work. Exact times must be equal, and
no bound may be below them. With ``DINEROS_EXAMPLES=20``, more than a hundred systems are drawn.
"""

from __future__ import annotations

import os
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import Latencies, end_of
from dineros.analysis.latencies.results import Latency
from tests.analysis.bounds.test_no_bound_is_too_low import drawn, require_above, require_kept
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.threads import Threads

SEEDS = 16 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 2_500


def varied(seed: int) -> System:
    """Return a random system with all that executors of callbacks do."""
    random = Random(seed)
    system = drawn(seed, orders=("any", "rclcpp", "rclpy"), most_threads=random.choice([1, 1, 2, 3]))
    for node in system["nodes"].values():
        if node["threads"] > 1:
            node["order"] = "any"
    for number, each in enumerate(system["callbacks"]):
        if "period" in each:
            each["jitter"] = random.choice([0, 0, 1, 3])
            if random.random() < 0.4:
                least = random.randint(0, 3)
                each["offset"] = [least, least + random.randint(0, 3)]
        (_, least, most), (_, topic) = each["script"]
        if random.random() < 0.3:
            each["script"] = [["open", least, most, topic]]
        elif random.random() < 0.25:
            each["script"][1][1] = f"t{random.randint(0, number)}"
    return system


def require_exactly(found: Latency, least: int, greatest: int) -> bool:
    """Require that exact times are these, in hundredths of a second; tell whether they were found."""
    if not found.is_exact or found.reason:
        return False
    assert found.least is not None and found.greatest is not None
    assert found.least.value * 100 == least and found.greatest.value * 100 == greatest
    return True


@pytest.mark.long
def test_times_are_those_of_a_plain_program() -> None:
    systems = exact = chains = 0
    for seed in range(SEEDS):
        system = varied(seed)
        try:
            facts = Threads(system).explore(MOST_STATES)
        except TooManyStatesError:
            continue
        systems += 1
        model = model_of(system, 0.01)
        latencies, bounds = Latencies(model, Budget(seconds=20)), Bounds(model)
        everything, bounded = latencies.everything(), bounds.everything()
        require_kept(bounded, facts.longest, facts.lost, facts.missed)
        for name, span in facts.response.items():
            if name in everything.callbacks:  # else time ran out
                exact += require_exactly(everything.callbacks[name], *span)
            require_above(bounded.callbacks[name], *span)
        if everything.is_exact:
            longest = {place.removesuffix(".heard"): each for place, each in everything.readers.items()}
            assert {name: most for name, (most, _) in longest.items()} == facts.longest, seed
            assert {name for name, (_, loses) in longest.items() if loses} == facts.lost, seed
            assert {name for name, loses in everything.timers.items() if loses} == facts.missed, seed
        for (first, last), span in facts.chains.items():
            if first != last:
                ends = end_of(model, first), end_of(model, last)
                chains += require_exactly(latencies.between(*ends), *span)
                require_above(bounds.between(*ends), *span)
    assert systems > SEEDS / 6 and exact > systems and chains > 0, (systems, exact, chains)
