"""Watches a run: follows its traces until a condition holds, the time is over, or the user interrupts."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol

from dineros.cli.console import note, warn
from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.files.watching import FolderWatch, wait_readable

if TYPE_CHECKING:
    from dineros.analysis.conformance import Monitor
    from dineros.runtime.application.observer import FolderObserver
    from dineros.runtime.ros.process.environment import Reach

Ending = Literal["reached", "ended", "idle", "timeout", "interrupted", "deviated", "failed"]
"""How a run ends: the condition holds; all processes have ended; nothing can happen any more; time is over;
Ctrl-C; a step that the model does not allow; a process that cannot start, or fails again and again."""

PERIOD = 0.05
"""Least seconds between two reads of traces that are written continuously."""

CALM_PERIOD = 0.5
"""The same if the end of the run does not depend on them."""

Condition = Callable[[Mapping[str, int], Mapping[str, SignalSetting]], bool]


@dataclass(frozen=True)
class RosOptions:
    """Options of an application on ROS 2."""

    domain: int
    reach: Reach
    programs: tuple[str, ...]
    """Command lines of further programs that run as long as the application."""
    restarts: int
    """Restarts per minute and node."""


@dataclass(frozen=True)
class Options:
    """Options of a run."""

    until: str | None = None
    """The condition that ends it."""
    timeout: float | None = None
    """Seconds after which it ends."""
    trace: Path | None = None
    """Folder for the traces; None: they are removed after the run."""
    seed: int | None = None
    """Seed of the firing selections."""
    watchdog: float | None = None
    """Seconds after which a handler that blocks its node is named; 0: never, None: as the nodes themselves
    say.
    """
    is_resumed: bool = False
    is_monitored: bool = False
    is_shown: bool = False
    """`is_resumed`, `is_monitored`, `is_shown`: whether it continues from the traces, is replayed on the
    model meanwhile, has a page that follows it.
    """
    ros: RosOptions | None = None
    """How it runs on ROS; None: in this process."""
    is_simulated: bool = False
    """In this process: whether time is simulated."""
    speed: float | None = None
    """Simulated seconds in a second, at most; None: as many as can."""


@dataclass(frozen=True)
class Wanted:
    """The goals of a run."""

    until: Condition | None
    """The condition that ends it, given marking and signals."""
    folder: Path
    monitor: Monitor | None
    """Replays the records on the model when they arrive."""
    options: Options
    interrupted: threading.Event = field(default_factory=threading.Event)
    """Set by `interrupt`, which handles signals."""
    _listening: list[int] = field(default_factory=list)

    def interrupt(self, *_: object) -> None:
        """End the run soon.

        An exception that a signal raises, for example in a destructor, would be lost: so the watching code is
        not interrupted, but reads `interrupted`.

        Raises
        ------
        KeyboardInterrupt
            The run is not watched yet, or no longer.
        """
        self.interrupted.set()
        if not self._listening:
            raise KeyboardInterrupt
        with contextlib.suppress(BlockingIOError):
            os.write(self._listening[0], b"!")

    @contextlib.contextmanager
    def heard(self) -> Iterator[int]:
        """Give a descriptor that becomes readable when the run is interrupted."""
        reading, writing = os.pipe()
        os.set_blocking(writing, False)
        self._listening.append(writing)
        try:
            yield reading
        finally:
            self._listening.clear()
            os.close(writing)
            os.close(reading)


class Running(Protocol):
    """The processes or threads of a run."""

    def poll(self) -> bool:
        """Service them; False: all have ended."""

    @property
    def descriptors(self) -> Sequence[int]:
        """A descriptor that is readable when they need service."""

    @property
    def longest(self) -> float:
        """Seconds after which they need service without an event."""


def watch(wanted: Wanted, observer: FolderObserver, running: Running) -> Ending:
    """Follow a run until it ends, and sleep between events."""
    end = None if wanted.options.timeout is None else time.monotonic() + wanted.options.timeout
    period = CALM_PERIOD if wanted.until is None and wanted.monitor is None else PERIOD
    try:
        with FolderWatch(wanted.folder) as traces, wanted.heard() as interrupt:
            while True:
                looked = time.monotonic()
                traces.forget()
                if wanted.interrupted.is_set():
                    return "interrupted"
                goes_on = running.poll()
                if (ending := _look(wanted, observer)) is not None:
                    return ending
                if not goes_on:
                    return "ended"
                if end is not None and time.monotonic() >= end:
                    return "timeout"
                if observer.is_behind:
                    continue
                until = looked + min(traces.longest, running.longest)
                _sleep(
                    until if end is None else min(until, end),
                    [interrupt, *running.descriptors],
                    traces,
                    looked + period,
                )
    except KeyboardInterrupt:
        return "interrupted"


def _sleep(until: float, descriptors: Sequence[int], traces: FolderWatch, next_look: float) -> None:
    """Sleep until an event; for traces alone, at least until the next read."""
    told = wait_readable([*descriptors, *traces.descriptors], until - time.monotonic())
    if told and told.isdisjoint(descriptors):
        wait_readable(descriptors, min(until, next_look) - time.monotonic())


def _look(wanted: Wanted, observer: FolderObserver) -> Ending | None:
    """Process new records of the traces; return how they end the run."""
    if not observe(wanted, observer):
        return "deviated"
    if wanted.until is not None and wanted.until(observer.marking, observer.signals):
        return "reached"
    return None


def observe_all(wanted: Wanted, observer: FolderObserver) -> bool:
    """Process all new records, such as those that nodes wrote while they ended; see `observe`."""
    conforms = observe(wanted, observer)
    while observer.is_behind:
        conforms = observe(wanted, observer) and conforms
    return conforms


def observe(wanted: Wanted, observer: FolderObserver) -> bool:
    """Process new records, or a batch; False: the monitor has found a step that the model does not allow."""
    records = observer.look()
    for record in records:
        if record.event == "error":
            note(f"{record.node}: {getattr(record, 'error', '')}")
    if wanted.monitor is None:
        return True
    deviations = wanted.monitor.add(records)
    for deviation in deviations:
        warn(f"{deviation.location}: {deviation}")
    return not deviations
