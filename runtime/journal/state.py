"""The state of a node, rebuilt from its records."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.lifecycles.states import State
from dineros.metamodel.message_ids import MessageIdError, Senders, parse_id
from dineros.metamodel.records import (
    EVENTS,
    Aside,
    Checkpoint,
    Data,
    Drop,
    Fire,
    Lifecycle,
    Publish,
    Record,
    Release,
    Signal,
    Start,
    StoredToken,
    Take,
    Timeout,
)
from dineros.runtime.journal.calls import Calls
from dineros.runtime.journal.goals import Goals
from dineros.runtime.journal.saved import SavedState


class JournalStateError(DinerosError):
    """A record does not fit the records before it."""


class JournalState:
    """The state of a node after the records so far.

    Attributes
    ----------
    marking : dict of str to dict of int to Data
        Tokens of each place by their id, the oldest first; places without tokens are left out.
    signals : dict of str to bool or str
        Values of the signals.
    next_sequence : int
        Sequence number of the next record.
    has_begun : bool
        Whether a record with the complete state was applied.
    """

    def __init__(self) -> None:
        self.marking: dict[str, dict[int, Data]] = {}
        self.signals: dict[str, SignalSetting] = {}
        self.next_sequence = 0
        self.has_begun = False
        self._next_token = 0
        self._numbers: dict[str, int] = {}
        self._history: dict[str, deque[tuple[int, Data]]] = {}
        self._queues: dict[str, int] = {}
        self._kept: dict[str, Any] = {}
        self._seen: dict[str, Senders] = {}
        self._missing: dict[str, int] = {}  # of a subscriber: messages lost since the last one received
        self._now = 0.0  # time of the last record that has one, in seconds since the epoch
        self._calls = Calls()
        self._goals = Goals()
        self._aside: dict[str, dict[str, list[int]]] = {}
        self._run = ""
        self.lifecycle: State | None = None

    def counts(self) -> dict[str, int]:
        """Return the number of tokens of each marked place."""
        return {place: len(tokens) for place, tokens in self.marking.items()}

    def checkpoint(self) -> SavedState:
        """Return the saved state with which a node can continue."""
        seen, apart = {}, {}
        for port, senders in self._seen.items():
            seen[port], apart[port] = senders.saved()
        made: SavedState = {
            "marking": {
                place: [[id, data] for id, data in tokens.items()] for place, tokens in self.marking.items()
            },
            "signals": dict(self.signals),
            "next_token": self._next_token,
            "numbers": dict(self._numbers),
            "history": {
                place: [[number, data] for number, data in messages]
                for place, messages in self._history.items()
            },
            "queues": dict(self._queues),
            "kept": dict(self._kept),
            "seen": {port: numbers for port, numbers in seen.items() if numbers},
            "seen_apart": {port: ranges for port, ranges in apart.items() if ranges},
            "missing": {port: count for port, count in self._missing.items() if count},
            **self._calls.save(self._now),
            **self._goals.save(),  # type: ignore[typeddict-item]  # without the lifecycle
            "aside": {
                transition: {place: list(ids) for place, ids in tokens.items()}
                for transition, tokens in self._aside.items()
            },
            "run": self._run,
        }
        if self.lifecycle is not None:
            made["lifecycle"] = self.lifecycle
        return made

    def apply(self, record: Record) -> None:
        """Apply a record.

        Raises
        ------
        JournalStateError
            It takes a token that is not there, or answers a request that is not being served.
        """
        self.next_sequence = record.sequence + 1
        self._now = self._now if record.time is None else record.time
        apply = _APPLY.get(type(record))
        if apply is not None:
            apply(self, record)

    def _start(self, record: Start) -> None:
        self.has_begun = True
        self.marking = {place: dict(tokens) for place, tokens in record.marking.items() if tokens}
        self.signals = dict(record.signals)
        for tokens in self.marking.values():
            self._next_token = max(self._next_token, *(id + 1 for id in tokens))

    def _checkpoint(self, record: Checkpoint) -> None:
        self._start(record)
        self._next_token = record.next_token
        self._numbers = dict(record.numbers)
        self._queues = dict(record.queues)
        self._history = {
            place: deque(((token.id, token.data) for token in messages), self._queues.get(place, 1))
            for place, messages in record.history.items()
        }
        self._kept = dict(record.kept)
        self._seen = {
            port: Senders(record.seen.get(port), record.seen_apart.get(port))
            for port in {**record.seen, **record.seen_apart}
        }
        self._missing = dict(record.missing)
        self._calls.begin(record, self._now)
        self._goals.begin(record)
        self._aside = {transition: dict(tokens) for transition, tokens in record.aside.items()}
        self._run = record.run
        self.lifecycle = record.lifecycle or None

    def _fire(self, record: Fire) -> None:
        for place, ids in record.taken.items():
            for id in ids:
                self._remove(record, place, id)
        for place, tokens in record.made.items():
            for token in tokens:
                self._add(place, token)
        for name, value in record.kept.items():
            if value is None:
                self._kept.pop(name, None)
            else:
                self._kept[name] = value

    def _signal(self, record: Signal) -> None:
        self.signals[record.signal] = record.value

    def _publish(self, record: Publish) -> None:
        data = self._move(record)
        known = self._count(record)
        if known is not None:
            place, number = known
            limit = self._queues.get(place, 1)
            history = self._history.setdefault(place, deque(maxlen=limit))
            history.append((number, data))

    def _take(self, record: Take) -> None:
        self._move(record)
        port = f"{record.channel}/{record.place}"
        missing = self._missing.pop(port, 0)
        known = _parts(record, record.message)
        if known is not None:
            self._seen.setdefault(port, Senders()).add(*known, missing)

    def _call(self, record: Any) -> None:
        """Apply a step of a service call, as its kind declares it."""
        data = self._move(record)
        if record.declared.call == "begins":
            self._count(record)
        if not self._calls.happen(record, data, self._now):
            raise JournalStateError(
                f"reply to {record.message or ''!r}, which no instance serves", location=record.location
            )

    def _timeout(self, record: Timeout) -> None:
        key, message = f"{record.channel}/{record.client}", record.message or ""
        self._calls.failed(key, message, record.attempt)
        self._goals.failed(key, message, record.attempt)

    def _drop(self, record: Drop) -> None:
        if record.place is None or record.queue == "request":
            return
        if record.change.get(record.place, 0) < 0:
            self._remove(record, record.place, _token(record, record.token))
        elif record.queue not in ("restart", "feedback"):
            port = f"{record.channel}/{record.place}"
            self._missing[port] = self._missing.get(port, 0) + record.count

    def _change_state(self, record: Lifecycle) -> None:
        self.lifecycle = record.state

    def _goal(self, record: Any) -> None:
        """Apply a step of a goal, as its kind declares it."""
        data = self._move(record)
        if record.declared.goal == "is sent":
            self._numbers[record.place or ""] = self._numbers.get(record.place or "", 0) + 1
        unheeded = getattr(record, "unheeded", None)
        if unheeded is not None:
            for place in [place for place in record.change if place != record.place]:
                self._remove(record, place, unheeded)
        if not self._goals.happen(record, data):
            raise JournalStateError(
                f"goal {record.message!r} ends, which no slot works on", location=record.location
            )

    def _move(self, record: Any) -> Data:
        """Move the token of a record, as its kind declares it; return its data if the token leaves."""
        move = record.declared.token
        if move == "leaves":
            return self._remove(record, record.place or "", _token(record, record.token))
        if move == "arrives" or (move == "may arrive" and record.place is not None):
            self._add(record.place, StoredToken(_token(record, record.token), record.data))
        return {}

    def _put_aside(self, record: Aside) -> None:
        aside = self._aside.setdefault(record.transition, {})
        for place, ids in record.tokens.items():
            known = aside.setdefault(place, [])
            known.extend(id for id in ids if id not in known)

    def _release(self, record: Release) -> None:
        aside = self._aside.get(record.transition, {})
        for place, ids in record.tokens.items():
            self._forget(aside, place, ids)
        if not aside:
            self._aside.pop(record.transition, None)

    def _add(self, place: str, token: StoredToken) -> None:
        self.marking.setdefault(place, {})[token.id] = token.data
        self._next_token = max(self._next_token, token.id + 1)

    def _remove(self, record: Record, place: str, id: int) -> Data:
        tokens = self.marking.get(place, {})
        if id not in tokens:
            raise JournalStateError(
                f"token {id} is not in place {place!r}",
                location=record.location,
                hint="a part or a line of the trace is missing",
            )
        data = tokens.pop(id)
        if not tokens:
            del self.marking[place]
        for transition, aside in list(self._aside.items()):
            self._forget(aside, place, [id])
            if not aside:
                del self._aside[transition]
        return data

    @staticmethod
    def _forget(aside: dict[str, list[int]], place: str, ids: Iterable[int]) -> None:
        left = [id for id in aside.get(place, ()) if id not in set(ids)]
        if left:
            aside[place] = left
        else:
            aside.pop(place, None)

    def _count(self, record: Any) -> tuple[str, int] | None:
        """Count a message for the place in its id; on a server page, all instances share that place."""
        known = _parts(record, record.message)
        if known is None:
            return None
        place, number = known[0].rpartition("/")[2], known[1]
        self._numbers[place] = number
        return place, number


def _parts(record: Record, message: str | None) -> tuple[str, int] | None:
    try:
        return parse_id(message or "")
    except MessageIdError as error:
        raise JournalStateError(
            f"{record.event} record with a wrong message: {error}", location=record.location
        ) from None


def _token(record: Record, token: int | None) -> int:
    if token is None:
        raise JournalStateError(f"{record.event} record without a token", location=record.location)
    return token


_APPLY: Mapping[type[Record], Callable[..., object]] = {
    **{kind: JournalState._move for kind in EVENTS.values() if kind.declared.token},
    **{kind: JournalState._call for kind in EVENTS.values() if kind.declared.call},
    **{kind: JournalState._goal for kind in EVENTS.values() if kind.declared.goal},
    Start: JournalState._start,
    Checkpoint: JournalState._checkpoint,
    Fire: JournalState._fire,
    Signal: JournalState._signal,
    Publish: JournalState._publish,
    Take: JournalState._take,
    Drop: JournalState._drop,
    Timeout: JournalState._timeout,
    Lifecycle: JournalState._change_state,
    Aside: JournalState._put_aside,
    Release: JournalState._release,
}
