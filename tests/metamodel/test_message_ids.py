"""Ids that anybody may have written, and numbers that came before."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel.message_ids import (
    NUMBER_LIMIT,
    RANGE_LIMIT,
    MessageIdError,
    Numbers,
    Senders,
    parse_id,
)


@pytest.mark.parametrize("text", ["", "hello", "a/b", "a/b/"])
def test_no_number(text: str) -> None:
    assert parse_id(text) is None


@pytest.mark.parametrize("number", ["0", "-1", "+1", "007", "9" * 5000, str(NUMBER_LIMIT + 1), "٣", "１"])
def test_implausible_number(number: str) -> None:
    with pytest.raises(MessageIdError):
        parse_id(f"a/p/{number}")


def test_other_implausible_ids() -> None:
    assert parse_id(f"a/p/{NUMBER_LIMIT}") == ("a/p", NUMBER_LIMIT)
    for text in ("x" * 2000, "a\nb/p/1", "a\0/p/1"):
        with pytest.raises(MessageIdError) as caught:
            parse_id(text)
        assert len(str(caught.value)) < 60


@given(st.lists(st.tuples(st.integers(1, 60), st.integers(0, 5)), max_size=40))
def test_numbers_are_a_set(steps: list[tuple[int, int]]) -> None:
    numbers, expected = Numbers(limit=None), set[int]()
    for number, lost in steps:
        numbers.add(number, lost)
        expected |= set(range(max(1, number - lost), number + 1))
    assert {number for number in range(1, 70) if number in numbers} == expected
    ranges = numbers.ranges()
    assert all(first <= last for first, last in ranges)
    assert all(one[1] + 1 < other[0] for one, other in pairwise(ranges))
    assert Numbers(ranges, limit=None) == numbers
    assert numbers.highest == max(expected, default=0)
    for number in range(70):
        ends = [last for _, last in ranges if last <= number]
        assert numbers.highest_up_to(number) == max(ends, default=0)


def test_forged_numbers_silence_nobody() -> None:
    """However many forged ids come, the sender's own continue to count."""
    senders = Senders()
    for number in range(1, 11):
        senders.add("a/p", number)
    for number in range(10 * RANGE_LIMIT):
        senders.add("a/p", 10**9 + 3 * number)
        senders.add(f"stranger{number}/p", 1)
    for number in range(11, 200):
        assert not senders.had("a/p", number)
        senders.add("a/p", number)


def test_numbers_survive_being_saved() -> None:
    senders = Senders()
    senders.add("a/p", 5, 4)
    senders.add("a/p", 9)
    senders.add("b/p", 7)
    again = Senders(*senders.saved())
    assert senders.saved() == again.saved() == ({"a/p": 5}, {"a/p": [[9, 9]], "b/p": [[7, 7]]})
    assert [number for number in range(1, 12) if again.had("a/p", number)] == [1, 2, 3, 4, 5, 9]
