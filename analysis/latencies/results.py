"""Response times and latencies as results: bounds, what is open, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from dineros.analysis.latencies.measuring import Bound

_CHAIN_KEYS = ("lost", "reaction", "age", "reasons")
_WHY_NOT = {"lost": "a history on the way may overflow", "reaction": "it is asked of chains only"}
_WHY_NOT["age"] = _WHY_NOT["reaction"]


@dataclass(frozen=True)
class Latency:
    """How long something takes.

    Attributes
    ----------
    least, greatest : Bound or None
        In seconds. `least` is None if no instance ends; `greatest` also if nothing bounds it.
    is_lost : bool or None
        Whether an instance can be lost in a full history; None if that is not known.
    is_exact : bool
        Whether the bounds are attained, or come as near as wanted; else they are safe.
    reason : str
        Why something is open; empty if nothing is.
    states : int
        State classes that were built.
    reaction, age : Bound or None
        Of a chain: the longest time until something that happens just after a release shows in an output,
        and the longest time for which an output is the newest one. None if nothing bounds it, or if it is
        not known.
    reasons : dict of str to str
        Why `reaction` and `age` are None, by name, where `reason` does not say it.
    """

    least: Bound | None
    greatest: Bound | None
    is_lost: bool | None = False
    is_exact: bool = True
    reason: str = ""
    states: int = 0
    reaction: Bound | None = None
    age: Bound | None = None
    reasons: Mapping[str, str] = field(default_factory=dict)

    def to_dict(self) -> dict[str, object]:
        """Return it for JSON: seconds."""
        found: dict[str, object] = {
            "least": _seconds(self.least),
            "greatest": _seconds(self.greatest),
            "lost": self.is_lost,
            "reaction": _seconds(self.reaction),
            "age": _seconds(self.age),
            "exact": self.is_exact,
        }
        why = {name: self._why(name) for name, value in found.items() if value is None}
        return found | ({"reason": self.reason} if self.reason else {}) | ({"reasons": why} if why else {})

    def _why(self, name: str) -> str:
        """Return why something is not known."""
        return self.reasons.get(name) or self.reason or _WHY_NOT.get(name, "no instance ends")


def _seconds(bound: Bound | None) -> float | None:
    return None if bound is None else float(bound.value)


@dataclass(frozen=True)
class Everything:
    """All response times, histories and timers of a model."""

    callbacks: dict[str, Latency] = field(default_factory=dict)
    """Response times by the id of a callback."""
    readers: dict[str, tuple[int, bool | None]] = field(default_factory=dict)
    """By history of a reader, server, client or action (`histories_of`): the greatest number of messages in
    it, and whether it can overflow; None if that is not known.
    """
    timers: dict[str, bool | None] = field(default_factory=dict)
    """By the id of a timer's callback, whether it can lose ticks; None if that is not known."""
    starved: dict[str, bool | None] = field(default_factory=dict)
    """By the id of a callback, whether it can be ready forever without beginning, because other callbacks are
    taken first; None if that is not known.
    """
    is_exact: bool = True
    """Whether `readers` and `timers` are; else they are safe bounds."""
    reasons: dict[str, str] = field(default_factory=dict)
    """By the name of a reader or the id of a timer, why it is not known whether it loses anything."""

    def to_dict(self) -> dict[str, object]:
        """Return it for JSON. An entry that is null has a `reason`."""
        return {
            "callbacks": {name: self._response(name, each) for name, each in self.callbacks.items()},
            "readers": {
                name: {"longest": longest, "overflow": overflow} | self._why(name, overflow)
                for name, (longest, overflow) in self.readers.items()
            },
            "timers": {
                name: {"lostTicks": loses} | self._why(name, loses) for name, loses in self.timers.items()
            },
            "exact": self.is_exact,
        }

    def _response(self, name: str, found: Latency) -> dict[str, object]:
        told = {key: value for key, value in found.to_dict().items() if key not in _CHAIN_KEYS}
        if found.least is None and not found.reason:
            told["reason"] = "it never ends"
        if name in self.starved:
            told["starves"] = self.starved[name]
            if self.starved[name] is None:
                told.setdefault("reason", "the search of all state classes has not ended")
        return told

    def _why(self, name: str, answer: bool | None) -> dict[str, str]:
        return {"reason": self.reasons[name]} if answer is None and name in self.reasons else {}
