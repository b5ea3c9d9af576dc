"""Merged events have the same steps as the events themselves, and each step as often."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import product

from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.symbolic.merging import merged

Event = dict[int, tuple[int, ...]]
WIDTHS = (3, 2, 4)


@st.composite
def tables(draw: st.DrawFn, width: int) -> tuple[int, ...]:
    sources = draw(st.lists(st.integers(0, width - 1), min_size=1, unique=True))
    targets = draw(st.permutations(range(width)))
    return tuple(targets[i] if i in sources else -1 for i in range(width))


@st.composite
def events(draw: st.DrawFn) -> Event:
    levels = draw(st.lists(st.integers(0, len(WIDTHS) - 1), min_size=1, unique=True))
    return {level: draw(tables(WIDTHS[level])) for level in levels}


def steps(all_events: Iterable[Mapping[int, tuple[int, ...]]]) -> Counter[tuple[tuple[int, ...], ...]]:
    found: Counter[tuple[tuple[int, ...], ...]] = Counter()
    for event in all_events:
        for vector in product(*map(range, WIDTHS)):
            target = tuple(event[k][i] if k in event else i for k, i in enumerate(vector))
            if -1 not in target:
                found[vector, target] += 1
    return found


@given(st.lists(events(), max_size=8))
def test_steps_stay_the_same(given_events: list[Event]) -> None:
    found = merged(given_events)
    assert steps(found) == steps(given_events)
    assert len(found) <= len(given_events)
    for event in found:
        assert event
        for table in event.values():
            reached = [j for j in table if j >= 0]
            assert len(reached) == len(set(reached))


def test_a_counter_that_is_read_and_moved_is_one_event() -> None:
    size = 100
    moves: list[Event] = [
        {0: tuple(i + 1 if i == at else -1 for i in range(size)), 1: (1, -1)} for at in range(size - 1)
    ]
    reads: list[Event] = [
        {0: tuple(i if i == at else -1 for i in range(size)), 1: (-1, 0)} for at in range(size)
    ]
    assert merged([*moves, *reads]) == [{0: (*range(1, size), -1), 1: (1, -1)}, {1: (-1, 0)}]


def test_two_levels_are_merged_one_after_the_other() -> None:
    both: list[Event] = [
        {level: tuple(i if i == at[level] else -1 for i in range(3)) for level in range(2)} | {2: (1, -1)}
        for at in product(range(3), repeat=2)
    ]
    assert merged(both) == [{2: (1, -1)}]
