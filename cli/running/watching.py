"""Watching a run: its traces are followed, until a condition holds, time is over, or somebody interrupts."""

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
from dineros.metamodel.files.watching import FolderWatch, wait_readable

if TYPE_CHECKING:
    from dineros.analysis.conformance import Monitor
    from dineros.runtime.application.observer import FolderObserver

Ending = Literal["reached", "ended", "idle", "timeout", "interrupted", "deviated", "failed"]
"""How a run ends: the condition holds; all processes have ended; nothing can happen any more; time is over;
Ctrl-C; a step that the model does not allow; a process that cannot start, or fails again and again."""

PERIOD = 0.05
"""Seconds between two looks at traces that are written without a pause, at least."""

CALM_PERIOD = 0.5
"""The same where the end of the run does not depend on them."""

Condition = Callable[[Mapping[str, int], Mapping[str, bool]], bool]


@dataclass(frozen=True)
class Wanted:
    """What a run is to do.

    Attributes
    ----------
    until : callable or None
        The condition that ends it, given marking and signals.
    timeout : float or None
        Seconds after which it ends.
    folder : Path
        Takes the traces.
    seed : int or None
        Seed of the firing selections.
    watchdog : float or None
        Seconds after which a handler is named that keeps its node from all else; 0: never, None: as the nodes
        themselves say.
    is_resumed : bool
        Whether the nodes go on where an earlier run ended.
    monitor : Monitor or None
        Replays the records on the model as they come.
    interrupted : threading.Event
        Set by `interrupt`, which handles signals.
    """

    until: Condition | None
    timeout: float | None
    folder: Path
    seed: int | None
    watchdog: float | None
    is_resumed: bool
    monitor: Monitor | None
    interrupted: threading.Event = field(default_factory=threading.Event)
    _listening: list[int] = field(default_factory=list)

    def interrupt(self, *_: object) -> None:
        """End the run soon.

        An exception that a signal raises within a destructor, say, comes to nobody: whoever watches is not
        interrupted, but looks at `interrupted`.

        Raises
        ------
        KeyboardInterrupt
            Nobody watches yet, or any more.
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
        """Look after them; False: all have ended."""

    @property
    def descriptors(self) -> Sequence[int]:
        """What is readable when there is something to look after."""

    @property
    def longest(self) -> float:
        """Seconds after which to look after them although nothing was told."""


def watch(wanted: Wanted, observer: FolderObserver, running: Running) -> Ending:
    """Follow a run until it ends, and sleep while nothing happens.

    Parameters
    ----------
    wanted : Wanted
        What ends it.
    observer : FolderObserver
        Follows the traces.
    running : Running
        What runs.
    """
    end = None if wanted.timeout is None else time.monotonic() + wanted.timeout
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
    """Sleep until something is to be looked after; for traces alone, until the next look at least."""
    told = wait_readable([*descriptors, *traces.descriptors], until - time.monotonic())
    if told and told.isdisjoint(descriptors):
        wait_readable(descriptors, min(until, next_look) - time.monotonic())


def _look(wanted: Wanted, observer: FolderObserver) -> Ending | None:
    """Take in what is new in the traces; return how the run ends by it."""
    if not observe(wanted, observer):
        return "deviated"
    if wanted.until is not None and wanted.until(observer.marking, observer.signals):
        return "reached"
    return None


def observe(wanted: Wanted, observer: FolderObserver) -> bool:
    """Take in what is new; False: the monitor has found a step that the model does not allow."""
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
