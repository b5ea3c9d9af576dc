"""Systems with managed nodes, against a plain program: what is lost and how, ticks, and response times."""

from __future__ import annotations

import os
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies
from dineros.metamodel import sym
from dineros.metamodel.elements import channels, node_nets
from tests.analysis.bounds.test_no_bound_is_too_low import drawn
from tests.analysis.latencies.test_against_plain_program import require_exactly
from tests.analysis.timed_checks.test_random_systems import by_classes, fired
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.managed import Managed
from tests.support.timed_systems.models import System, model_of

SEEDS = 30 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 4_000
CHANGES = ("deactivates", "cleansUp", "shutsDown", "pauses")


def managed(seed: int) -> System:
    """Return up to three callbacks of nodes of which one or two are managed."""
    draw = Random(seed)
    system = drawn(seed, most_threads=draw.choice([1, 1, 2]))
    system["callbacks"] = system["callbacks"][: draw.randint(1, 3)]
    system["limit"] = 1
    used = sorted({each["node"] for each in system["callbacks"]})
    system["nodes"] = {name: system["nodes"][name] for name in used}
    for name in draw.sample(used, draw.randint(1, min(2, len(used)))):
        system["nodes"][name]["life"] = {change: draw.random() < 0.4 for change in CHANGES}
    return system


def model(system: System) -> sym.SystemModel:
    made = model_of(system, 0.01)
    for node in node_nets(made):
        life = system["nodes"][node.id].get("life")
        node.lifecycle = None if life is None else sym.Lifecycle(**life)
    for topic in channels(made, sym.TopicChannel):
        for writer in topic.publishers:
            writer.limit = system["limit"]
    return made


def lost_otherwise(names: set[str]) -> set[tuple[str, str]]:
    """Return how firings lose messages otherwise than in full reader histories, and whose."""
    found = set()
    for name in names:
        topic, *parts, last = name.split(".")
        of_writer = parts[:1] == ["writer"]
        if last in ("discard", "abandon"):
            found.add(("discarded", topic))
        elif last == "miss" and of_writer:
            found.add(("missed", parts[-2]))
        elif last == "left" or (last == "gone" and of_writer):
            found.add(("left", topic))
        elif last == "drop" and of_writer:
            found.add(("written", topic))
        elif last == "clear":
            found.add(("cleared", parts[-2]))
    return found


def compared(seed: int) -> tuple[int, set[str]] | None:
    """Compare a system; return how many responses are exact, and what happens; None if it is too large."""
    system = managed(seed)
    program = Managed(system)
    try:
        facts = program.explore(MOST_STATES)
    except TooManyStatesError:
        return None
    latencies = Latencies(model(system), Budget(seconds=20, states=20_000))
    if latencies.reason:
        return None
    found = by_classes(latencies.subject, latencies.explored)
    names = fired(latencies.subject, latencies.explored)
    overflows = {name.split(".")[2] for name in names if ".reader." in name and name.endswith(".drop")}
    assert found.longest == facts.longest, seed
    assert overflows == facts.lost, seed
    assert found.missed == facts.missed, seed
    assert lost_otherwise(names) == program.gone, seed
    exact = 0
    responses = latencies.everything().callbacks
    for name, span in facts.response.items():
        assert "starve" not in responses[name].reason, (seed, name)
        exact += require_exactly(responses[name], *span)
    return exact, {how for how, _ in program.gone}


@pytest.mark.parametrize("seed", [15, 21, 34])
def test_a_few(seed: int) -> None:
    found = compared(seed)
    assert found is not None and found[0] > 0


@pytest.mark.long
def test_many() -> None:
    found = [facts for seed in range(SEEDS) if (facts := compared(seed)) is not None]
    assert len(found) > SEEDS / 4
    assert sum(exact for exact, _ in found) > len(found)
    assert set().union(*(ways for _, ways in found)) >= {"discarded", "missed", "left", "cleared"}
