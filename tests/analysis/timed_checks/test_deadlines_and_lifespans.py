"""Random systems whose messages have lifespans and whose readers have deadlines: against a plain program.

A reader's deadline runs from the moment at which its callback takes a message, and begins again with the next
one. Whether it can end must be the same, next to what overflows, is too old, and which ticks are lost.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from random import Random

import pytest

from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import place, step
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import channels, node_net_of
from tests.analysis.timed_checks.test_random_systems import (
    CLASSES,
    MOST_STATES,
    Facts,
    by_classes,
    drawn_with_lifespans,
    fired,
)
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.aging import Aging
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.threads import _State, _with

SEEDS = 40 * int(os.environ.get("DINEROS_EXAMPLES", "1"))

Watches = tuple[int, ...]
"""By reader how long its deadline runs, or -1."""


class Watching(Aging):
    """Explores a system whose topics may have a `deadline`, too.

    Attributes
    ----------
    late : set of str
        Readers whose deadline can end.
    """

    def __init__(self, system: System) -> None:
        super().__init__(system)
        self.deadlines = [system["deadline"].get(reader["topic"]) for reader in self.readers]
        self.late: set[str] = set()

    def _starts(self) -> list[_State]:
        return [state._replace(beside=(-1,) * len(self.readers)) for state in super()._starts()]

    def _successors(self, state: _State) -> Iterator[_State]:
        is_over = False
        for number, runs in enumerate(state.beside):
            if runs >= 0 and runs == self.deadlines[number]:
                is_over = True
                self.late.add(self.readers[number]["name"])
                yield state._replace(beside=_with(state.beside, number, -1))
        for after in super()._successors(state):
            if not (is_over and after == self._later(state)):
                yield after

    def _begun(self, state: _State) -> Iterator[_State]:
        for after in super()._begun(state):
            watches: Watches = after.beside
            for number, deadline in enumerate(self.deadlines):
                if deadline is not None and len(after.queues[number]) < len(state.queues[number]):
                    watches = _with(watches, number, 0)
            yield after._replace(beside=watches)

    def _later(self, state: _State) -> _State:
        older = tuple(runs + (runs >= 0) for runs in state.beside)
        return super()._later(state)._replace(beside=older)


def drawn(seed: int) -> System:
    """Return nodes of up to three threads, timers in step; topics may have a lifespan and a deadline."""
    system, draw = drawn_with_lifespans(seed), Random(seed)
    for each in system["callbacks"]:
        if "period" in each:
            each |= {"offset": 0, "jitter": 0}
    system["deadline"] = {topic: draw.randint(3, 20) for topic in system["latency"] if draw.random() < 0.7}
    return system


def model(system: System) -> sym.SystemModel:
    """Return the model; the node of a reader with a deadline has a place for what it misses."""
    made = model_of(system)
    for topic in channels(made, sym.TopicChannel):
        span, deadline = (system[name].get(topic.topic) for name in ("lifespan", "deadline"))
        topic.qos = sym.QualityOfService(lifespan=span, deadline=deadline)
        for reader in topic.subscribers if deadline is not None else ():
            node = node_net_of(reader.place)
            assert node is not None
            reader.missed = place(node, f"{reader.place.id}.missed")
            reader.missed.capacity = 1
            step(node, f"{reader.place.id}.complain", [reader.missed], [])
    assert [str(each) for each in validate(made) if each.severity == "error"] == []
    return made


def compared(seed: int) -> tuple[int, int] | None:
    """Compare a system; return how many readers lose old messages, and are late; None if it is too large."""
    system = drawn(seed)
    program = Watching(system)
    try:
        seen = program.explore(MOST_STATES)
    except TooManyStatesError:
        return None
    subject = timed_base_subject(model(system))
    found = explore_timed(subject.timed, CLASSES)
    if not found.is_complete:
        return None
    assert by_classes(subject, found) == Facts(seen.longest, seen.lost, seen.missed, program.expired)
    late = {
        name.split(".deadline.")[1].removesuffix(".heard.missed.miss")
        for name in fired(subject, found)
        if ".deadline." in name and name.endswith(".miss")
    }
    assert late == program.late, (late, program.late)
    return len(program.expired), len(late)


@pytest.mark.parametrize("seed", [1, 4, 9])
def test_a_few(seed: int) -> None:
    compared(seed)


def test_a_message_that_expires_in_a_wait_result_stops_no_executor() -> None:
    """The executor goes on with what else is ready: ticks come every 5, and no run takes longer than 3."""
    node = {"node": "n", "group": "default"}
    timer = {"name": "tick", **node, "period": 5, "offset": [0, 3], "jitter": 1}
    reader = {"name": "hears", **node, "topic": "t", "depth": 2}
    system: System = {
        "nodes": {"n": {"threads": 1, "order": "rclcpp"}},
        "latency": {"t": (1, 1)},
        "lifespan": {"t": 2},
        "deadline": {},
        "chains": [],
        "callbacks": [
            {**timer, "script": [["work", 2, 2], ["publish", "t"]]},
            {**reader, "script": [["work", 1, 3]]},
        ],
    }
    program = Watching(system)
    seen = program.explore(MOST_STATES)
    assert seen.missed == set() and program.expired == {"hears"}
    subject = timed_base_subject(model(system))
    found = by_classes(subject, explore_timed(subject.timed, CLASSES))
    assert found == Facts(seen.longest, seen.lost, seen.missed, program.expired)


@pytest.mark.long
def test_many() -> None:
    found = [facts for seed in range(SEEDS) if (facts := compared(seed)) is not None]
    assert len(found) > SEEDS / 3
    assert any(expired for expired, _ in found) and any(late for _, late in found)
