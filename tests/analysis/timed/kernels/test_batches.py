"""State classes are the same, however many of them are expanded together."""

from __future__ import annotations

import os
from dataclasses import replace
from random import Random

import numpy as np
import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.timed import search
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.search import ClassSearch
from tests.analysis.timed.time_nets import RandomNet, random_net

TIMES = int(os.environ.get("DINEROS_EXAMPLES", "1"))
SMALL_BUDGET = Budget(3 << 20, states=2_000)


def beside(one: RandomNet, other: RandomNet) -> RandomNet:
    """Return a net of two that share nothing: it has many more classes than each."""
    places, count = len(one.initial), len(one.transitions)

    def moved(row: dict[int, int]) -> dict[int, int]:
        return {place + places: weight for place, weight in row.items()}

    steps = [
        replace(
            step,
            name=f"t{number}",
            take=moved(step.take),
            put=moved(step.put),
            read=moved(step.read),
            inhibitor=moved(step.inhibitor),
            above=frozenset(high + count for high in step.above),
        )
        for number, step in enumerate(other.transitions, count)
    ]
    pairs = tuple((high + count, low + count) for high, low in other.pairs)
    return RandomNet(one.initial + other.initial, [*one.transitions, *steps], one.pairs + pairs)


def drawn(seed: int) -> TimedNet:
    random = Random(31_000 + seed)
    one, other = (random_net(random, has_priorities=seed % 3 == 0) for _ in range(2))
    return beside(one, other).net


def found(
    net: TimedNet, kind: Kind, workers: int = 1, budget: Budget = SMALL_BUDGET
) -> tuple[object, ...] | None:
    """Return all that a search finds, by threads from the first class on; None if that is too much."""
    made = ClassSearch(
        net,
        kind,
        budget,
        keeps_edges=True,
        keeps_parents=True,
        workers=workers,
        least_for_threads=0,
    )
    made.run()
    if made.reason is not None:
        return None
    known, classes, edges = made.known, made.classes, made.edges
    arrays = [
        known.class_marking[:classes],
        known.record_start[: classes + 1],
        known.codes[: known.record_start[classes]],
        *(known.parent[:classes], known.via[:classes]),
        *(known.edge_first[:classes], known.edge_last[:classes]),
        *(known.edge_target[:edges], known.edge_label[:edges]),
        made.markings(),
    ]
    graph = replace(made.graph(), memory_bytes=0)
    return graph, *(np.asarray(array).tobytes() for array in arrays)


def test_a_batch_finds_what_single_classes_find(monkeypatch: pytest.MonkeyPatch) -> None:
    compared = large = 0
    for seed in range(100 * TIMES):
        net = drawn(seed)
        kinds: tuple[Kind, ...] = ("S", "E") if net.has_priorities else ("W", "M", "S", "E")
        for kind in kinds:
            together = found(net, kind)
            if together is None:
                continue
            with monkeypatch.context() as patch:
                patch.setattr(ClassSearch, "_slice", lambda *_: 1)
                assert found(net, kind) == together, (seed, kind)
            with monkeypatch.context() as patch:
                patch.setattr(search, "FIRST_ITEMS", 1 + seed % 40)
                patch.setattr(search, "FIRST_WORDS", 1)
                assert found(net, kind) == together, (seed, kind)
            compared += 1
            large += together[0].classes > 50  # type: ignore[attr-defined]
    assert compared > 150 * TIMES
    assert large > 15 * TIMES
