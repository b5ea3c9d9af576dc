"""The state of a running application, collected from the traces that its nodes write."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.records import Drop, Error, Fire, Record, Signal, Start
from dineros.metamodel.records.following import Follower
from dineros.metamodel.records.schema import Step

BATCH = 8
"""Pieces of each node's trace that are read at a time: 2 MiB."""


class Observer:
    """Marking and signals of all nodes, according to their traces.

    Nodes write at different times, so the combined marking may never have existed at one moment; the part of
    each node did exist.

    Attributes
    ----------
    marking : dict of str to int
        Tokens of each place of the nodes.
    signals : dict of str to bool or str
        Values of the input signals.
    firings, drops, errors : int
        Counts so far.
    restarts : int
        Number of restarts, reported by the supervisor: a node that never began has no trace.
    started : set of str
        Nodes that have recorded their first marking.
    acted : set of str
        Nodes that have recorded a step.
    refused : set of str
        Nodes with a process that could not start, reported by the supervisor.
    halted : dict of str to str
        Nodes halted by a failure, with the failure.
    """

    def __init__(self) -> None:
        self.started: set[str] = set()
        self.acted: set[str] = set()
        self.refused: set[str] = set()
        self.halted: dict[str, str] = {}
        self.marking: dict[str, int] = {}
        self.signals: dict[str, SignalSetting] = {}
        self.firings = self.drops = self.errors = self.restarts = 0
        self._places: dict[str, set[str]] = {}

    def see(self, records: Iterable[Record]) -> None:
        """Apply records; those of each node in order."""
        for record in records:
            if isinstance(record, Start):  # a checkpoint, too
                self._begin(record)
            elif isinstance(record, Step):
                self.acted.add(record.node or "")
                for place, change in record.change.items():
                    self.marking[place] = self.marking.get(place, 0) + change
                    self._places.setdefault(record.node or "", set()).add(place)
                if isinstance(record, Signal):
                    self.signals[record.signal] = record.value
                elif isinstance(record, Fire):
                    self.firings += 1
                elif isinstance(record, Drop):
                    self.drops += record.count
            elif isinstance(record, Error):
                self.errors += 1
                if record.policy == "halt":
                    self.halted.setdefault(record.node or "", _failure(record))

    @property
    def came_up(self) -> set[str]:
        """Nodes that came up; the first marking alone does not show it: ROS may refuse what comes after."""
        return self.started - (self.refused - self.acted)

    def _begin(self, record: Start) -> None:
        """Replace the known state of a node by the state in this record."""
        self.started.add(record.node or "")
        places = self._places.setdefault(record.node or "", set())
        for place in places:
            self.marking[place] = 0
        for place, tokens in record.marking.items():
            self.marking[place] = len(tokens)
            places.add(place)
        self.signals.update(record.signals)


class FolderObserver(Observer):
    """An observer of the traces in a folder, which takes in a batch at a time.

    If nodes write faster than it reads, as in a flood on a busy machine, its memory stays the same.

    Parameters
    ----------
    folder : Path
        The folder to which the nodes write.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self._follower = Follower(folder, BATCH)

    @property
    def is_behind(self) -> bool:
        """Whether there is more to look at than the last look took in."""
        return self._follower.is_behind

    def look(self) -> list[Record]:
        """Take in what is new, or a batch of it, and return it."""
        records = self._follower.new()
        self.see(records)
        return records


def _failure(record: Error) -> str:
    """Return what failed: the error, and the handler and the transition if they are known."""
    if record.handler is None:
        return record.error
    of = "" if record.transition is None else f" of {record.transition}"
    return f"{record.error} (handler {record.handler}{of})"
