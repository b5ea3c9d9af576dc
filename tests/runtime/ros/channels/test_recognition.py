"""Messages without ids are told from each other by what was announced: no ROS needed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.runtime.ros.channels.companions import Announcement, AnnouncementError, read_announcement
from dineros.runtime.ros.channels.recognition import (
    ANNOUNCEMENT_LIMIT,
    HELD_LIMIT,
    WINDOW,
    Recognition,
    content_of,
)

PATIENCE = 5.0
MILLISECOND = 1_000_000


class Bench:
    """A recognition, what it has handed on, and a clock."""

    def __init__(self, patience: Callable[[], float] = lambda: PATIENCE) -> None:
        self.now = 0.0
        self.ids: list[tuple[str, str]] = []
        self.strangers: list[str] = []
        self.recognition: Recognition[str] = Recognition(
            lambda item, id: self.ids.append((item, id)),
            self.strangers.append,
            patience,
            clock=lambda: self.now,
        )

    def announce(self, content: str, sent: int, id: str, number: int = 1) -> None:
        self.recognition.announced(content_of({"text": content}, number), sent, id)

    def arrive(self, content: str, sent: int, item: str = "", number: int = 1) -> None:
        key = content_of({"text": content}, number)
        if not self.recognition.recognise(key, sent, item or content):
            self.recognition.hold(key, sent, item or content)

    def wait(self, seconds: float = PATIENCE) -> None:
        self.now += seconds
        self.recognition.look()


CONTENTS = st.sampled_from("ab")
"""Few, so that many messages are equal."""

Way = list[Callable[[], None]]


def sender(bench: Bench, name: str, contents: list[str], skew: int) -> tuple[Way, Way]:
    """Return what a sender announces, and its messages themselves."""
    announcements: Way = []
    messages: Way = []
    for number, content in enumerate(contents):
        sent = (skew + 10 * number) * MILLISECOND
        announcements.append(partial(bench.announce, content, sent, f"{name}/{number}"))
        messages.append(partial(bench.arrive, content, sent + MILLISECOND))
    return announcements, messages


@given(
    st.lists(st.tuples(st.lists(CONTENTS, max_size=6), st.integers(-400, 400)), max_size=3),
    st.lists(CONTENTS, max_size=6),
    st.lists(CONTENTS, max_size=4),
    st.randoms(use_true_random=False),
)
def test_every_order_of_arrival(
    senders: list[tuple[list[str], int]], strangers: list[str], abandoned: list[str], draw: Random
) -> None:
    """Announcements and messages come two ways, clocks differ, and some messages never follow."""
    bench = Bench()
    ways: list[Way] = [[partial(bench.arrive, content, 5 * MILLISECOND) for content in strangers]]
    for number, (contents, skew) in enumerate(senders):
        ways += sender(bench, str(number), contents, skew)
    for content in abandoned:  # long ago: kept for those who come late, or of a sender that was killed
        bench.announce(content, -2 * WINDOW, "abandoned/1")
    while waiting := [way for way in ways if way]:
        draw.choice(waiting).pop(0)()
    bench.wait()
    announced = {
        f"{number}/{count}": content
        for number, (contents, _) in enumerate(senders)
        for count, content in enumerate(contents)
    }
    assert sorted((id, content) for content, id in bench.ids) == sorted(announced.items())
    assert Counter(bench.strangers) == Counter(strangers)


@given(st.lists(st.sampled_from("abcd"), max_size=20), st.lists(st.integers(0, 3), max_size=20))
def test_strangers_keep_their_order(contents: list[str], patiences: list[int]) -> None:
    remaining = iter(patiences)
    bench = Bench(lambda: next(remaining, 0))
    for number, content in enumerate(contents):
        bench.arrive(content, number)
    bench.wait(9)
    assert bench.strangers == contents
    assert not bench.recognition.is_waiting


@given(st.lists(st.booleans(), max_size=9), st.integers(0, 3), st.randoms(use_true_random=False))
def test_a_flood_of_equal_messages(is_lost: list[bool], gap: int, draw: Random) -> None:
    """Times say nothing in a flood, nor does the order of arrival: each message bears its own id."""
    bench = Bench()
    announcements = [partial(bench.announce, "a", 0, f"n/p/{n}", n) for n in range(1, len(is_lost) + 1)]
    arrivals = [
        partial(bench.arrive, "a", gap, str(number), number)
        for number, lost in enumerate(is_lost, 1)
        if not lost
    ]
    ways: list[Way] = [list(announcements), list(arrivals)]
    while waiting := [way for way in ways if way]:
        draw.choice(waiting).pop(0)()
    bench.wait()
    assert not bench.strangers
    assert {(item, id) for item, id in bench.ids} == {
        (str(number), f"n/p/{number}") for number, lost in enumerate(is_lost, 1) if not lost
    }


def test_where_nobody_announces_nothing_waits() -> None:
    bench = Bench(lambda: 0.0)
    bench.arrive("a", 1)
    assert bench.strangers == ["a"]


def test_an_announcement_that_comes_late_is_waited_for() -> None:
    bench = Bench()
    bench.arrive("a", 1000)
    bench.wait(PATIENCE / 2)
    assert (bench.ids, bench.strangers) == ([], [])
    bench.announce("a", 0, "n/p/1")
    assert (bench.ids, bench.strangers) == ([("a", "n/p/1")], [])


def test_what_is_kept_is_bounded() -> None:
    bench = Bench()
    for number in range(2 * ANNOUNCEMENT_LIMIT):
        bench.announce(str(number), 0, f"n/p/{number}")
    for number in range(2 * ANNOUNCEMENT_LIMIT):
        bench.arrive(str(number), 0)
    assert len(bench.ids) == ANNOUNCEMENT_LIMIT  # the last ones
    assert len(bench.strangers) == ANNOUNCEMENT_LIMIT - HELD_LIMIT
    for number in range(HELD_LIMIT):
        bench.arrive(f"more {number}", 0)
    assert bench.strangers == [str(number) for number in range(ANNOUNCEMENT_LIMIT)]


def test_announcements_are_read_as_they_are_written() -> None:
    for announcement in (Announcement("n@r/p/1", b"\x00\x01\xff", 7), Announcement("", b"", 0)):
        assert read_announcement(announcement.text()) == announcement


@pytest.mark.parametrize(
    "said",
    [
        "",
        "[]",
        "{}",
        "1",
        "null",
        '"text"',
        "[" * 100_000,
        '{"id": "a/b/1"}',
        '{"id": 1, "content": ""}',
        '{"id": "a/b/1", "content": null}',
        '{"id": "a/b/1", "content": ""}',
        '{"id": "a/b/1", "content": "?", "number": 1}',
        '{"id": "a/b/1", "content": "\u00fc", "number": 1}',
        '{"id": "a/b/1", "content": "", "number": true}',
        '{"id": "a/b/1", "content": "", "number": 1.0}',
    ],
)
def test_what_announces_nothing_is_refused(said: str) -> None:
    with pytest.raises(AnnouncementError, match="no id and content"):
        read_announcement(said)
