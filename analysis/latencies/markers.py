"""The places by which an observer records the progress of the instance that it follows."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Literal, TypeVar

from dineros.analysis.latencies.sampling import NotFollowedError
from dineros.analysis.timed.nets import Interval

IDLE, ARMED, WATCHING, SHOWN, DONE, LOST, OVER, GO = (
    f"observer {word}" for word in ("idle", "armed", "watching", "shown", "done", "lost", "over", "go")
)
T = TypeVar("T")
Asks = Literal["latency", "age", "reaction"]
NOW = Interval(latest=Fraction(0))


def only(found: Sequence[T]) -> T:
    """Return the only one of some things.

    Raises
    ------
    NotFollowedError
        There are several, or none.
    """
    if len(found) != 1:
        raise NotFollowedError
    return found[0]


def some(put: dict[str, int], place: str, number: int) -> dict[str, int]:
    """Return the tokens to put, with a number of further tokens on a place."""
    return {**put, place: number} if number else put


def exactly(place: str, number: int) -> dict[str, Any]:
    """Return conditions that a place holds exactly a number of tokens."""
    return {"inhibit": {place: number + 1}, **({"read": {place: number}} if number else {})}
