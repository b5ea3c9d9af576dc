"""Firings under way: while a long handler runs, the tokens of its firing are reserved.

A handler may outlive its firing: a thread cannot be stopped, and a coroutine that is cancelled may have to
tidy up. Then its transition waits for its end, so that it never runs twice at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from dineros.runtime.firing.handlers import Firing, Handler
from dineros.runtime.nets.engine import Engine, Tokens
from dineros.runtime.nets.ports import Data
from dineros.runtime.scheduling.timers import IDLE, Timer


@dataclass(eq=False)
class Flight:
    """A firing under way.

    Attributes
    ----------
    transition : int
        What fires.
    taken : list
        The tokens it takes, by place.
    handlers, position : tuple of Handler and int
        All handlers, and which of them is next.
    firing : Firing
        What they see.
    data, given : mapping
        What continues so far, and what they gave to single places.
    started : float
        When it began, by the net's clock.
    status : list of bool
        Its one element tells the handlers whether the firing could commit now.
    is_reserved : bool
        Whether it is among the `Flights`: a handler runs elsewhere.
    is_over : bool
        Whether it has committed, failed or been given up.
    cancel : callable
        Ends the handler that runs elsewhere, where that is possible.
    timer : Timer
        When that handler has taken too long.
    sent : float
        When it began, by the machine's clock.
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
    """The firings whose handlers run elsewhere."""

    def __init__(self) -> None:
        self._flights: list[Flight] = []
        self._full: set[int] = set()  # transitions with as many firings in flight as they may have
        self._outliving: list[Flight] = []

    def __iter__(self) -> Iterator[Flight]:
        return iter(self._flights)

    def __len__(self) -> int:
        return len(self._flights)

    def add(self, engine: Engine, flight: Flight) -> None:
        """Reserve the tokens of a firing; hold its transition where no more may be in flight."""
        engine.reserve(flight.transition, flight.taken)
        flight.is_reserved = True
        self._flights.append(flight)
        if self._is_full(flight):
            self._full.add(flight.transition)
            engine.hold(flight.transition)

    def remove(self, engine: Engine, flight: Flight) -> None:
        """Give up the reservation of a firing."""
        flight.is_reserved = False
        self._flights.remove(flight)
        engine.release(flight.transition, flight.taken)
        if flight.transition in self._full and not self._is_full(flight):
            self._full.remove(flight.transition)
            engine.unhold(flight.transition)

    @property
    def outliving(self) -> tuple[Flight, ...]:
        """The firings that are over, but whose handlers still run."""
        return tuple(self._outliving)

    def outlive(self, engine: Engine, flight: Flight) -> None:
        """Keep the transition of a firing that is given up from beginning another one, until `outlived`."""
        self._outliving.append(flight)
        engine.hold(flight.transition)

    def outlived(self, engine: Engine, flight: Flight) -> None:
        """Let the transition fire again: the handler of the firing has ended at last."""
        if flight in self._outliving:
            self._outliving.remove(flight)
            engine.unhold(flight.transition)

    def refresh(self, engine: Engine) -> None:
        """Let the handlers know whether their firings could still commit."""
        for flight in self._flights:
            flight.status[0] = engine.is_allowed(flight.transition)

    def _is_full(self, flight: Flight) -> bool:
        """Return whether as many firings of a transition are in flight as its handlers allow."""
        same = sum(other.transition == flight.transition for other in self._flights)
        return same >= min(handler.parallel for handler in flight.handlers)
