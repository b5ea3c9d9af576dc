"""Watching a run: its traces are followed, until a condition holds, time is over, or somebody interrupts."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from dineros.cli.console import note, warn

if TYPE_CHECKING:
    from dineros.analysis.conformance import Monitor
    from dineros.runtime.application.observer import FolderObserver

Ending = Literal["reached", "ended", "idle", "timeout", "interrupted", "deviated", "failed"]
"""How a run ends: the condition holds; all processes have ended; nothing can happen any more; time is over;
Ctrl-C; a step that the model does not allow; a process that cannot start, or fails again and again."""

PERIOD = 0.05

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
    watched : threading.Event
        Set while somebody looks at `interrupted`.
    """

    until: Condition | None
    timeout: float | None
    folder: Path
    seed: int | None
    watchdog: float | None
    is_resumed: bool
    monitor: Monitor | None
    interrupted: threading.Event = field(default_factory=threading.Event)
    watched: threading.Event = field(default_factory=threading.Event)

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
        if not self.watched.is_set():
            raise KeyboardInterrupt


def watch(wanted: Wanted, observer: FolderObserver, look_after: Callable[[], bool]) -> Ending:
    """Follow a run until it ends.

    Parameters
    ----------
    wanted : Wanted
        What ends it.
    observer : FolderObserver
        Follows the traces.
    look_after : callable
        Called several times a second; False: all processes have ended.
    """
    end = None if wanted.timeout is None else time.monotonic() + wanted.timeout
    wanted.watched.set()
    try:
        while True:
            if wanted.interrupted.is_set():
                return "interrupted"
            goes_on = look_after()
            if not observe(wanted, observer):
                return "deviated"
            if wanted.until is not None and wanted.until(observer.marking, observer.signals):
                return "reached"
            if not goes_on:
                return "ended"
            if end is not None and time.monotonic() >= end:
                return "timeout"
            time.sleep(PERIOD)
    except KeyboardInterrupt:
        return "interrupted"
    finally:
        wanted.watched.clear()


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
