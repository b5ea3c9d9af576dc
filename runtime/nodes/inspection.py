"""A snapshot of a running net, for users, tests and web pages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from dineros.runtime.firing.flights import Flight
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.passing import Tokens
from dineros.runtime.nets.sources import SourceState
from dineros.runtime.nets.tokens import Token, copy_data
from dineros.runtime.nodes.core import Core
from dineros.runtime.nodes.status import ErrorReport


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


@dataclass(frozen=True)
class Inspection:
    """The state of a net at one moment; later changes do not affect it.

    Attributes
    ----------
    marking : mapping of str to tuple of Token
        Tokens of every place, the oldest first, reserved ones included.
    signals : mapping of str to bool or str
        Values of the signals.
    enabled : tuple of str
        Transitions that may fire by the net's firing rule.
    in_flight : tuple of InFlight
        Firings under way.
    outliving : tuple of InFlight
        Handlers that still run although their firings were released; their transitions wait for their end.
    aside : mapping of str to mapping of str to tuple of int
        Transition -> place -> ids of the tokens put aside after a failure.
    waiting_requests : int
        Requests that wait for a server instance, and goals of actions that wait for a slot.
    drops : mapping of (str, str) to int
        Messages lost, by channel and queue.
    refused : mapping of str to int
        Messages refused because of implausible ids, by channel.
    firings, failures : int
        Number of committed firings, and of failed firings.
    errors : tuple of ErrorReport
        The last failures, the oldest first.
    halted : str or None
        Why the net is halted; None: it is not.
    stale : tuple of str
        Signals whose source is silent for longer than expected.
    sources : tuple of SourceState
        The bridges that set signals from outside.
    """

    marking: Mapping[str, tuple[Token, ...]]
    signals: Mapping[str, Any]  # a boolean, or the name of a value
    enabled: tuple[str, ...]
    in_flight: tuple[InFlight, ...]
    outliving: tuple[InFlight, ...]
    aside: Mapping[str, Mapping[str, tuple[int, ...]]]
    waiting_requests: int
    drops: Mapping[tuple[str, str], int]
    refused: Mapping[str, int]
    firings: int
    failures: int
    errors: tuple[ErrorReport, ...]
    halted: str | None
    stale: tuple[str, ...]
    sources: tuple[SourceState, ...]

    def count(self, place: str) -> int:
        """Return the number of tokens on a place."""
        return len(self.marking[place])


def inspected(core: Core) -> Inspection:
    """Return a snapshot of a net; on the node's thread."""
    engine, execution, exchange = core.engine, core.execution, core.exchange
    places, transitions = core.structure.places, core.structure.transitions
    now = core.loop.clock()

    def shown(flight: Flight, taken: Tokens) -> InFlight:
        return InFlight(
            transitions[flight.transition],
            flight.handlers[flight.position].name,
            now - flight.started,
            MappingProxyType({places[place]: tuple(token.id for token in tokens) for place, tokens in taken}),
        )

    return Inspection(
        marking=MappingProxyType(
            {
                id: tuple(Token(token.id, copy_data(token.data)) for token in engine.tokens(place))
                for place, id in enumerate(places)
            }
        ),
        signals=MappingProxyType(dict(zip(core.structure.signals, engine.signals, strict=True))),
        enabled=_enabled(engine),
        in_flight=tuple(shown(flight, flight.taken) for flight in execution.in_flight),
        outliving=tuple(shown(flight, []) for flight in execution.in_flight.outliving),
        aside=MappingProxyType(
            {
                transitions[transition]: MappingProxyType(
                    {places[place]: tuple(sorted(ids)) for place, ids in by_place.items()}
                )
                for transition, by_place in engine.aside.tokens().items()
            }
        ),
        waiting_requests=exchange.waiting_requests if exchange is not None else 0,
        drops=MappingProxyType(dict(exchange.traffic.drops) if exchange is not None else {}),
        refused=MappingProxyType(dict(exchange.traffic.refused) if exchange is not None else {}),
        firings=execution.firings,
        failures=core.observers.failures,
        errors=tuple(core.observers.errors),
        halted=execution.halted,
        stale=core.expectations.stale,
        sources=tuple(source.state for source in core.sources),
    )


def outlook(core: Core) -> tuple[dict[str, Any], list[str]]:
    """Return signals, and what could fire; on the node's thread, and much quicker than `inspected`."""
    signals = zip(core.structure.signals, core.engine.signals, strict=True)
    return dict(signals), list(_enabled(core.engine))


def _enabled(engine: Engine) -> tuple[str, ...]:
    """Return the transitions that may fire now by the firing rule, in model order."""
    return tuple(
        id
        for number, id in enumerate(engine.structure.transitions)
        if engine.is_enabled(number) and not engine.is_overridden(number)
    )
