"""Response times of callbacks while they run, and ticks of timers that were late or lost.

A response time goes from the release of a callback, a strike of its timer or the arrival of its message, to
its end. Which firings belong to one run is known by their tokens. A message that waited in the history of the
middleware was released when the middleware received it, where the middleware tells that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from dineros.runtime.nets.ports import CallbackPort, Ports

LATE = 0.005
"""Seconds, beside its jitter, after which a tick whose callback has not begun is late."""
_MOST_OPEN = 10_000
"""Tokens of runs that have not ended; the oldest are forgotten."""

_Key = tuple[str, object]


@dataclass(slots=True)
class ResponseTime:
    """What was measured of a callback, in seconds, beside what its model declares.

    Attributes
    ----------
    callback : str
        Its id.
    declared : tuple of (float, float or None), or None
        Its duration: at least and at most.
    period, jitter : float
        Of its timer; no timer: 0.
    runs : int
        How many have ended.
    mean, longest, greatest : float
        Response times: of all, the longest since the last look, and the greatest of all.
    work : float
        The greatest time in the transitions of one run.
    over : int
        Runs whose time in transitions was longer than the declared duration.
    longest_run : float
        The longest time in the transitions of one run since the last look.
    late, lost : int
        Ticks after which the callback began late, and ticks that came before the callback had begun.
    lost_lately : int
        Of these, since the last look.
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
        """Note a run that has ended."""
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
    """Measures the callbacks of one node; on its thread, but for `struck`.

    Parameters
    ----------
    ports : Ports
        The node's.
    clock : callable
        Returns seconds.
    waited : callable
        Returns for how long the message that comes to a place now has waited in the middleware.
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
        """Note that a timer strikes, and how many strikes it has missed since the one before."""
        time = self.times.get(callback)
        if time is not None:
            lost = missed + (callback in self._struck)
            time.lost += lost
            time.lost_lately += lost
            self._struck.setdefault(callback, moment)

    def note(self, event: str, fields: Mapping[str, Any]) -> None:
        """Take what a node records."""
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
        """Begin a new stretch for `ResponseTime.longest`."""
        for time in self.times.values():
            time.longest = time.longest_run = 0.0
            time.lost_lately = 0


def _bounded(kept: dict[_Key, Any]) -> dict[_Key, Any]:
    if len(kept) >= _MOST_OPEN:
        del kept[next(iter(kept))]
    return kept
