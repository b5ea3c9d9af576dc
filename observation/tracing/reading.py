"""Events of tracing files of ROS 2, in the text that Babeltrace 2 writes, one by one.

Names and fields of the events are those of ros2_tracing's ``tracetools/tp_call.h``.
"""

from __future__ import annotations

import calendar
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from dineros.metamodel.errors import Location
from dineros.observation.tracing.errors import TracingError
from dineros.observation.tracing.lines import LONGEST_LINE, STALLED, Said, lines

FIELDS: dict[str, tuple[str, ...]] = {
    "rcl_node_init": ("node_handle", "node_name", "namespace"),
    "rcl_publisher_init": ("publisher_handle", "node_handle", "topic_name"),
    "rcl_subscription_init": ("subscription_handle", "node_handle", "topic_name"),
    "rclcpp_subscription_init": ("subscription_handle", "subscription"),
    "rclcpp_subscription_callback_added": ("subscription", "callback"),
    "rcl_service_init": ("service_handle", "node_handle", "service_name"),
    "rclcpp_service_callback_added": ("service_handle", "callback"),
    "rcl_timer_init": ("timer_handle", "period"),
    "rclcpp_timer_callback_added": ("timer_handle", "callback"),
    "rclcpp_timer_link_node": ("timer_handle", "node_handle"),
    "rclcpp_callback_register": ("callback", "symbol"),
    "callback_start": ("callback",),
    "callback_end": ("callback",),
    "rcl_publish": ("publisher_handle",),
    "rclcpp_intra_publish": ("publisher_handle",),
    "rclcpp_executor_get_next_ready": (),
    "rclcpp_executor_wait_for_work": (),
}
"""Events that are read, with the fields that are used; others are skipped."""

LONGEST_NAME = 300
"""Limit of the characters of a name; longer signatures of functions are cut."""

_SECOND = 1_000_000_000
_DAY = 24 * 3600 * _SECOND
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_TIME = re.compile(
    r"(?:\[|timestamp = )"
    r"(?:(?P<date>\d{4}-\d\d-\d\d) )?(?:(?P<hours>\d\d):(?P<minutes>\d\d):)?"
    r"(?P<seconds>\d{1,12})\.(?P<part>\d{9})(?:\] ?|, )"
)
"""Pattern of the start of a line."""
_STRING = r'"((?:[^"\\]|\\.)*+)\\?(?:"|\Z)'
_VALUE = re.compile(
    rf"{_STRING}|\b(\w{{1,60}}) = (?:(0x[0-9A-Fa-f]{{1,16}}|-?\d{{1,20}})(?![\w.])|{_STRING})", re.DOTALL
)
"""A field with its value. Strings come first, so that their content is not read as a field."""


class TracedEvent(NamedTuple):
    """An event of ROS 2."""

    time: int
    """In nanoseconds since an unknown origin; never less than the one before."""
    process: str
    thread: str
    """`process`, `thread`: host and numbers. Addresses in an event are valid in its process."""
    name: str
    """One of `FIELDS`."""
    fields: tuple[str, ...]
    """Their values: numbers as they are written, strings without quotation marks."""


class Tracing:
    """Tracing files.

    Parameters
    ----------
    path : Path
        A folder in the format CTF, which the program ``babeltrace2`` reads, or the text that it writes.
    stalled : float
        Seconds that the program may take without output.

    Attributes
    ----------
    read : int
        Events of ROS 2 in the last reading, including skipped ones.
    foreign : int
        Other events: of the kernel, or of other programs.
    odd : int
        Lines that are not an event, or lack fields of the event.
    discarded : int
        Events that the tracer discarded because its buffer was full.
    """

    def __init__(self, path: Path, stalled: float = STALLED) -> None:
        self.path = path
        self._stalled = stalled
        self.read = self.foreign = self.odd = self.discarded = 0

    def events(self) -> Iterator[TracedEvent]:
        """Yield the events that are in `FIELDS`, in order; each call reads the files again.

        Raises
        ------
        TracingError
            There are no files, they cannot be read, hold no event of ROS 2, or lack processes and threads;
            or their times go back.
        """
        self.read = self.foreign = self.odd = self.discarded = 0
        said = Said()
        number, clock = 0, _Clock()
        for number, raw in enumerate(lines(self.path, said, self._stalled), 1):
            line = raw.decode(errors="replace")
            if "\x1b" in line:
                line = _COLOUR.sub("", line)
            head = _TIME.match(line)
            named = None if head is None else _named(line[head.end() :].partition("{")[0])
            if head is None or named is None:
                self.odd += 1
                if not self.read and not self.foreign and self.odd * LONGEST_LINE > 1 << 26:
                    break  # whatever it is
                continue
            time = clock.time(head)
            if time is None:
                raise self._wrong(
                    "is earlier than the event before", number, "give one trace, sorted by time"
                )
            where, name = named
            provider, _, name = name.partition(":")
            if provider != "ros2":
                self.foreign += 1
                continue
            if not raw.endswith((b"}\n", b"}\r\n")):  # cut off
                self.odd += 1
                continue
            self.read += 1
            wanted = FIELDS.get(name)
            if wanted is None:
                continue
            event = self._event(line[head.end() :], where, time, name, wanted, number)
            if event is None:
                self.odd += 1
            else:
                yield event
        self.discarded = said.discarded
        if not self.read:
            raise self._nothing(number)

    def _event(
        self, line: str, where: str, time: int, name: str, wanted: tuple[str, ...], number: int
    ) -> TracedEvent | None:
        values: dict[str, str] = {}
        for found in _VALUE.finditer(line):
            if found[2] is not None:
                values[found[2]] = found[3] if found[3] is not None else found[4][:LONGEST_NAME]
        if "vpid" not in values or "vtid" not in values:
            raise self._wrong(
                "an event has no process and thread (vpid, vtid)",
                number,
                "`ros2 trace` adds these contexts; so does `lttng add-context -u -t vpid -t vtid`",
            )
        if any(each not in values for each in wanted):
            return None
        process = f"{where} {values['vpid']}"
        thread = f"{process} {values['vtid']}"
        return TracedEvent(time, process, thread, name, tuple(values[each] for each in wanted))

    def _wrong(self, message: str, number: int, hint: str) -> TracingError:
        # The lines of a folder come from a program, so users do not see them.
        line = None if self.path.is_dir() else number
        return TracingError(message, location=Location(self.path, line), hint=hint)

    def _nothing(self, number: int) -> TracingError:
        location = Location(self.path)
        if not number:
            return TracingError("is empty: it holds no event", location=location)
        if self.foreign:
            return TracingError(
                "holds no event of ROS 2", location=location, hint="their names begin with ros2:"
            )
        return TracingError(
            "is not a trace: not the text that babeltrace2 writes",
            location=location,
            hint="`babeltrace2 FOLDER > trace.txt`, with times in seconds and names of fields, which is the "
            "default",
        )


def _named(head: str) -> tuple[str, str] | None:
    """Return the context of an event, and its name: the text between time and first brace; None: no event."""
    if len(head) > LONGEST_NAME * 4 or '"' in head:
        return None
    if head.startswith("(+"):
        head = head.partition(") ")[2]
    elif head.startswith("delta = "):
        head = head.partition(", ")[2]
    # With --names=all, the name has one itself.
    before, names, after = f", {head}".rpartition(", name = ")
    if names:
        return before.strip(", "), after.partition(",")[0].strip()
    where, _, name = head.rstrip().rpartition(" ")
    return (where, name[:-1]) if name.endswith(":") else None


class _Clock:
    """Times of lines; if they have no date, midnight starts the next day."""

    def __init__(self) -> None:
        self._last = self._days = 0

    def time(self, head: re.Match[str]) -> int | None:
        """Return the time of a line in nanoseconds; None: it goes back."""
        seconds = int(head["seconds"])
        if head["hours"] is not None:
            seconds += 3600 * int(head["hours"]) + 60 * int(head["minutes"])
        if head["date"] is not None:
            year, month, day = map(int, head["date"].split("-"))
            seconds += calendar.timegm((year or 1, min(max(month, 1), 12), day, 0, 0, 0))
        time = seconds * _SECOND + int(head["part"]) + self._days
        if head["hours"] is not None and head["date"] is None and time < self._last - _DAY // 2:
            self._days += _DAY
            time += _DAY
        if time < self._last:
            return None
        self._last = time
        return time
