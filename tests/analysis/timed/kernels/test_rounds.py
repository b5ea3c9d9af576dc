"""State classes, edges, markings and all their numbers are the same, whatever the number of threads."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.timed import search
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.kernels.markings import INDEX_BITS, INDEX_MASK, TAG_SHIFT
from dineros.analysis.timed.kernels.records import hash_record
from dineros.analysis.timed.nets import TimedNet, compile_timed_net
from dineros.analysis.timed.search import ClassSearch
from dineros.analysis.timed.threads import rounds
from dineros.metamodel.files import load
from tests.analysis.timed.kernels.test_batches import SMALL_BUDGET, TIMES, drawn, found

FOLDER = Path(__file__).resolve().parents[5] / "shared/tpn/nets"
SMALL = ("abp", "countertrains3", "ifip", "jdeds", "train1", "train3fault", "trains2", "trains3")
LARGE_BUDGET = Budget(memory_bytes=2 << 30)
LARGE = ("countertrains4", "trains4")


def kinds_of(net: TimedNet) -> tuple[Kind, ...]:
    return ("S",) if net.has_priorities else ("W", "S")


@pytest.fixture
def done(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Count rounds that expanded classes, and those that threads left to one thread."""
    counted: Counter[str] = Counter()
    one_round = rounds.Rounds._round

    def count(*given: Any) -> Any:
        result = one_round(*given)
        counted["rounds" if result[0] else "alone"] += 1
        return result

    monkeypatch.setattr(rounds.Rounds, "_round", count)
    return counted


def test_random_nets(monkeypatch: pytest.MonkeyPatch, done: Counter[str]) -> None:
    """Parts have few classes here, so equal records are in different parts."""
    compared = large = 0
    for seed in range(150 * TIMES):
        net = drawn(seed)
        for kind in kinds_of(net):
            alone = found(net, kind)
            if alone is None:
                continue
            with monkeypatch.context() as patch:
                patch.setattr(rounds, "PART", 1 + seed % 7)
                patch.setattr(rounds, "PARTS", 1 + seed % 5)
                patch.setattr(search, "ALONE", 1 + seed % 4)
                if seed % 4 == 1:  # parts soon lack room
                    patch.setattr(rounds, "FIRST_ITEMS", 4)
                    patch.setattr(rounds, "FIRST_WORDS", 1 << 9)
                if seed % 3 == 0:  # room for few records
                    patch.setattr(search, "FIRST_ITEMS", 1 + seed % 40)
                    patch.setattr(search, "FIRST_WORDS", 1)
                assert found(net, kind, 2 + seed % 4) == alone, (seed, kind)
            compared += 1
            large += alone[0].classes > 50  # type: ignore[attr-defined]
    assert compared > 200 * TIMES
    assert large > 25 * TIMES
    assert done["rounds"] > 1500 * TIMES


@pytest.mark.skipif(not FOLDER.exists(), reason="the nets are not beside the project")
@pytest.mark.parametrize("name", [*SMALL, *(pytest.param(name, marks=pytest.mark.long) for name in LARGE)])
def test_nets_of_trains(name: str, done: Counter[str]) -> None:
    net = compile_timed_net(load(FOLDER / f"{name}.net"))
    for kind in kinds_of(net):
        alone = found(net, kind, 1, LARGE_BUDGET)
        assert alone is not None
        for workers in (2, 3):
            assert found(net, kind, workers, LARGE_BUDGET) == alone
    assert done["rounds"] > 4


def test_each_class_is_in_the_table_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rounds, "PART", 3)
    for seed in range(0, 60, 3):
        net = drawn(seed)
        made = ClassSearch(net, "S", SMALL_BUDGET, workers=3, least_for_threads=0)
        made.run()
        known = made.known
        table = known.class_table[known.class_table != 0]
        assert sorted((table & INDEX_MASK) - 1) == list(range(made.classes))
        for entry in table.tolist():
            number = (entry & INDEX_MASK) - 1
            first = int(known.record_start[number])
            length = int(known.record_start[number + 1]) - first
            value = hash_record(int(known.class_marking[number]), known.codes, first, length)
            assert entry >> INDEX_BITS == value >> TAG_SHIFT


def test_a_full_table_is_enlarged(monkeypatch: pytest.MonkeyPatch, done: Counter[str]) -> None:
    net = drawn(next(seed for seed in range(100) if (found(drawn(seed), "S") or [None])[0] is not None))
    alone = found(net, "S")
    monkeypatch.setattr(search, "FIRST_TABLE", 2)
    monkeypatch.setattr(rounds, "FIRST_SEEN", 1)
    assert found(net, "S", 2) == alone
    assert done["rounds"]


def test_threads_end_with_the_search() -> None:
    made = ClassSearch(drawn(1), "S", SMALL_BUDGET, workers=3, least_for_threads=0)
    made.run()
    assert made._rounds is not None
    assert made._rounds._pool is None


def test_by_inclusion_there_is_one_thread() -> None:
    made = ClassSearch(drawn(1), "E", SMALL_BUDGET, workers=3, least_for_threads=0)
    assert made._rounds is None
    assert np.iinfo(made.number_type).bits == 32
