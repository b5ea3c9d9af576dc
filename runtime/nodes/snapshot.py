"""The state of a node at one moment, from which inspections, health reports and outlooks are made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from dineros.runtime.firing.flights import Flight
from dineros.runtime.nets.passing import Tokens
from dineros.runtime.nodes.core import Core
from dineros.runtime.nodes.status import Status


@dataclass(frozen=True)
class InFlight:
    """A firing whose handler is running.

    Attributes
    ----------
    transition, handler : str
        The transition and the running handler.
    seconds : float
        How long it has been running.
    tokens : mapping of str to tuple of int
        Ids of the reserved tokens by place.
    """

    transition: str
    handler: str
    seconds: float
    tokens: Mapping[str, tuple[int, ...]]


@dataclass(frozen=True, kw_only=True)
class Snapshot:
    """The state of a node at one moment; later changes do not affect it.

    Attributes
    ----------
    status : Status
        Its status.
    halted : str or None
        Why its net is halted; None: it is not.
    signals : mapping of str to bool or str
        Values of the signals.
    in_flight : tuple of InFlight
        Firings under way.
    firings : int
        Number of committed firings.
    drops : mapping of (str, str) to int
        Messages lost, by channel and queue.
    refused : mapping of str to int
        Messages refused because of implausible ids, by channel.
    """

    status: Status
    halted: str | None
    signals: Mapping[str, Any]  # a boolean, or the name of a value
    in_flight: tuple[InFlight, ...]
    firings: int
    drops: Mapping[tuple[str, str], int]
    refused: Mapping[str, int]

    @property
    def failures(self) -> int:
        """Number of failed firings."""
        return self.status.failures


def snapshot(core: Core) -> Snapshot:
    """Return the state of a node; on its thread."""
    traffic = None if core.exchange is None else core.exchange.traffic
    return Snapshot(
        status=core.status(),
        halted=core.execution.halted,
        signals=MappingProxyType(dict(zip(core.structure.signals, core.engine.signals, strict=True))),
        in_flight=tuple(in_flight(core, flight, flight.taken) for flight in core.execution.in_flight),
        firings=core.execution.firings,
        drops=MappingProxyType({} if traffic is None else dict(traffic.drops)),
        refused=MappingProxyType({} if traffic is None else dict(traffic.refused)),
    )


def in_flight(core: Core, flight: Flight, taken: Tokens) -> InFlight:
    """Return a firing under way with the tokens that it holds; on the node's thread."""
    structure = core.structure
    return InFlight(
        structure.transitions[flight.transition],
        flight.handlers[min(flight.position, len(flight.handlers) - 1)].name,
        core.loop.clock() - flight.started,
        MappingProxyType(
            {structure.places[place]: tuple(token.id for token in tokens) for place, tokens in taken}
        ),
    )


def enabled(core: Core) -> tuple[str, ...]:
    """Return the transitions that may fire now by the firing rule, in model order; on the node's thread."""
    return tuple(
        id
        for number, id in enumerate(core.structure.transitions)
        if core.engine.is_enabled(number) and not core.engine.is_overridden(number)
    )
