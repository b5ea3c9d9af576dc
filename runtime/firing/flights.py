"""Firings in flight: while a long handler runs, the tokens of its firing are reserved.

A handler may outlive its firing: a thread cannot be stopped, and a cancelled coroutine may have cleanup to
do. Then the transition waits for the end of the handler, so that no two runs of the handler overlap.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from dineros.runtime.firing.handlers import Firing, Handler
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.passing import Tokens
from dineros.runtime.nets.ports import Data
from dineros.runtime.scheduling.timers import IDLE, Timer


@dataclass(eq=False)
class Flight:
    """A firing that has begun.

    Attributes
    ----------
    transition : int
        The transition that fires.
    taken : list
        The tokens it takes, by place.
    handlers, position : tuple of Handler and int
        All handlers, and the index of the next one.
    firing : Firing
        The object that handlers get.
    data, given : mapping
        The data passed to the outputs so far, and data given to single places.
    started : float
        Start time, by the net's clock.
    status : list of bool
        One element, shared with the handlers: whether the firing could commit now.
    is_reserved : bool
        Whether it is in `Flights`, because a handler runs elsewhere.
    is_over : bool
        Whether it has committed, failed or been released.
    cancel : callable
        Cancels the handler that runs elsewhere, if possible.
    timer : Timer
        Timer for the time-out of that handler.
    sent : float
        Start time of that handler, by the machine's clock.
    """

    transition: int
    taken: Tokens
    handlers: tuple[Handler, ...]
    firing: Firing
    data: Data
    started: float
    status: list[bool]
    given: dict[int, list[Data]] | None = None
    position: int = 0
    is_reserved: bool = False
    is_over: bool = False
    cancel: Callable[[], None] = field(default=lambda: None)
    timer: Timer = IDLE
    sent: float = 0.0


class Flights:
    """The firings whose handlers run on other threads or on the event loop."""

    def __init__(self) -> None:
        self._flights: list[Flight] = []
        self._full: set[int] = set()  # transitions whose maximum number of firings is in flight
        self._outliving: list[Flight] = []

    def __iter__(self) -> Iterator[Flight]:
        return iter(self._flights)

    def __len__(self) -> int:
        return len(self._flights)

    def add(self, engine: Engine, flight: Flight) -> None:
        """Reserve the tokens of a firing; hold its transition at its maximum number of firings in flight."""
        engine.reserve(flight.transition, flight.taken)
        flight.is_reserved = True
        self._flights.append(flight)
        if self._is_full(flight):
            self._full.add(flight.transition)
            engine.hold(flight.transition)

    def remove(self, engine: Engine, flight: Flight) -> None:
        """Release the reservation of a firing."""
        flight.is_reserved = False
        self._flights.remove(flight)
        engine.release(flight.transition, flight.taken)
        if flight.transition in self._full and not self._is_full(flight):
            self._full.remove(flight.transition)
            engine.unhold(flight.transition)

    @property
    def outliving(self) -> tuple[Flight, ...]:
        """Firings that are over but whose handlers still run."""
        return tuple(self._outliving)

    def outlive(self, engine: Engine, flight: Flight) -> None:
        """Hold the transition of a released firing until `outlived`."""
        self._outliving.append(flight)
        engine.hold(flight.transition)

    def outlived(self, engine: Engine, flight: Flight) -> None:
        """Let the transition fire again: the handler of the firing has ended."""
        if flight in self._outliving:
            self._outliving.remove(flight)
            engine.unhold(flight.transition)

    def refresh(self, engine: Engine) -> None:
        """Update the status of each firing: whether it could commit now."""
        for flight in self._flights:
            flight.status[0] = engine.is_allowed(flight.transition)

    def _is_full(self, flight: Flight) -> bool:
        """Return whether as many firings of a transition are in flight as its handlers allow."""
        same = sum(other.transition == flight.transition for other in self._flights)
        return same >= min(handler.parallel for handler in flight.handlers)
