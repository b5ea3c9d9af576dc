"""Response times of callbacks at run time, and late or lost ticks of timers.

A response time is measured from the release of a callback (the tick of its timer, or the arrival of its
message) to the end of the callback. Tokens determine which firings belong to one run of a callback. If a
message waited in the history of the middleware and the middleware reports this, the callback was released
when the middleware received the message.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from dineros.runtime.nets.ports import CallbackPort, Ports

LATE = 0.005
"""Seconds, in addition to its jitter, after which a tick is late if its callback has not begun."""
_MOST_OPEN = 10_000
"""Maximum number of tokens of unfinished runs; the oldest are removed."""

_Key = tuple[str, object]


@dataclass(slots=True)
class ResponseTime:
    """Measured times of a callback, in seconds, with the times that its model declares.

    Attributes
    ----------
    callback : str
        Its id.
    declared : tuple of (float, float or None), or None
        Declared duration: minimum and maximum.
    period, jitter : float
        Of its timer; without a timer: 0.
    runs : int
        Number of completed runs.
    mean, longest, greatest : float
        Response times: the mean of all, the longest since the last look, and the longest of all.
    work : float
        The longest time spent in the transitions of one run.
    over : int
        Number of runs that spent more time in transitions than the declared duration.
    longest_run : float
        The longest time in the transitions of one run, since the last look.
    late, lost : int
        Number of ticks whose callback began late, and of ticks before the previous callback had begun.
    lost_lately : int
        Lost ticks since the last look.
    """

    callback: str
    declared: tuple[float, float | None] | None = None
    period: float = 0.0
    jitter: float = 0.0
    runs: int = 0
    mean: float = 0.0
    longest: float = 0.0
    greatest: float = 0.0
    work: float = 0.0
    over: int = 0
    late: int = 0
    lost: int = 0
    longest_run: float = 0.0
    lost_lately: int = 0

    def note(self, response: float, work: float) -> None:
        """Add a completed run."""
        self.runs += 1
        self.mean += (response - self.mean) / self.runs
        self.longest = max(self.longest, response)
        self.greatest = max(self.greatest, response)
        self.work = max(self.work, work)
        self.longest_run = max(self.longest_run, work)
        if self.declared is not None and self.declared[1] is not None:
            self.over += work > self.declared[1]


@dataclass(eq=False, slots=True)
class _Run:
    callback: str
    released: float
    keys: set[_Key]
    work: float = 0.0


class Responses:
    """Measures the callbacks of one node; on its thread, except for `struck`.

    Parameters
    ----------
    ports : Ports
        The ports of the node.
    clock : callable
        Returns the time in seconds.
    waited : callable
        Returns how long the message that is put onto a place now has waited in the middleware.
    """

    def __init__(self, ports: Ports, clock: Callable[[], float], waited: Callable[[str], float]) -> None:
        self._clock = clock
        self._waited = waited
        self._of: dict[str, CallbackPort] = {}
        self.times: dict[str, ResponseTime] = {}
        for port in ports.callbacks:
            self.times[port.callback] = ResponseTime(port.callback, port.duration, port.period, port.jitter)
            self._of.update(dict.fromkeys(port.transitions, port))
        self._open: dict[_Key, _Run] = {}
        self._arrived: dict[_Key, float] = {}
        self._struck: dict[str, float] = {}

    def struck(self, callback: str, moment: float, missed: int = 0) -> None:
        """Record a tick of a timer, and the number of ticks missed since the previous one."""
        time = self.times.get(callback)
        if time is not None:
            lost = missed + (callback in self._struck)
            time.lost += lost
            time.lost_lately += lost
            self._struck.setdefault(callback, moment)

    def note(self, event: str, fields: Mapping[str, Any]) -> None:
        """Process a record of the node."""
        if event == "fire":
            self._fired(fields)
        elif event in ("take", "serve"):
            key = fields["place"], fields["token"]
            waited = self._waited(fields["place"]) if event == "take" else 0.0
            _bounded(self._arrived)[key] = self._clock() - waited
        elif event == "request":
            self._move((fields["place"], fields["token"]), (fields["channel"], fields["message"]))
        elif event == "response":
            self._move((fields["channel"], fields["message"]), (fields["place"], fields["token"]))

    def _fired(self, fields: Mapping[str, Any]) -> None:
        id = fields["transition"].rpartition("].")[2]  # without the instance of a server
        port = self._of.get(id)
        taken: list[_Key] = [(place, token) for place, ids in fields["taken"].items() for token in ids]
        arrivals = [moment for key in taken if (moment := self._arrived.pop(key, None)) is not None]
        if port is None:
            return
        now, took = self._clock(), float(fields["duration"])
        runs = (self._open.pop(key, None) for key in taken)
        run = next((each for each in list(runs) if each is not None and each.callback == port.callback), None)
        if run is None:
            run = _Run(port.callback, self._released(port, id, arrivals, now - took), set())
        run.work += took
        if id in port.ends:
            for key in run.keys:
                self._open.pop(key, None)
            self.times[port.callback].note(now - run.released, run.work)
            return
        for place, tokens in fields["made"].items():
            for token, _ in tokens:
                _bounded(self._open)[place, token] = run
                run.keys.add((place, token))

    def _released(self, port: CallbackPort, id: str, arrivals: Iterable[float], begun: float) -> float:
        if id in port.begins and port.callback in self._struck:
            struck = self._struck.pop(port.callback)
            self.times[port.callback].late += begun - struck > port.jitter + LATE
            return min(struck, begun)
        return min([*arrivals, begun])

    def _move(self, key: _Key, other: _Key) -> None:
        run = self._open.pop(key, None)
        if run is not None:
            run.keys.discard(key)
            run.keys.add(other)
            _bounded(self._open)[other] = run

    def forget_longest(self) -> None:
        """Reset `ResponseTime.longest` of all callbacks."""
        for time in self.times.values():
            time.longest = time.longest_run = 0.0
            time.lost_lately = 0


def _bounded(kept: dict[_Key, Any]) -> dict[_Key, Any]:
    if len(kept) >= _MOST_OPEN:
        del kept[next(iter(kept))]
    return kept
