"""The inspection of a running net, for users, tests and web pages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from dineros.runtime.nets.sources import SourceState
from dineros.runtime.nets.tokens import Token, copy_data
from dineros.runtime.nodes.core import Core
from dineros.runtime.nodes.snapshot import InFlight, Snapshot, enabled, in_flight, snapshot
from dineros.runtime.nodes.status import ErrorReport


@dataclass(frozen=True, kw_only=True)
class Inspection(Snapshot):
    """The complete state of a node at one moment: its `Snapshot`, its tokens, and its enabled transitions.

    Attributes
    ----------
    marking : mapping of str to tuple of Token
        Tokens of every place, the oldest first, reserved ones included.
    enabled : tuple of str
        Transitions that may fire by the net's firing rule.
    outliving : tuple of InFlight
        Handlers that still run although their firings were released; their transitions wait for their end.
    aside : mapping of str to mapping of str to tuple of int
        Transition -> place -> ids of the tokens put aside after a failure.
    waiting_requests : int
        Requests that wait for a server instance, and goals of actions that wait for a slot.
    errors : tuple of ErrorReport
        The last failures, the oldest first.
    stale : tuple of str
        Signals whose source is silent for longer than expected.
    sources : tuple of SourceState
        The bridges that set signals from outside.
    """

    marking: Mapping[str, tuple[Token, ...]]
    enabled: tuple[str, ...]
    outliving: tuple[InFlight, ...]
    aside: Mapping[str, Mapping[str, tuple[int, ...]]]
    waiting_requests: int
    errors: tuple[ErrorReport, ...]
    stale: tuple[str, ...]
    sources: tuple[SourceState, ...]

    def count(self, place: str) -> int:
        """Return the number of tokens on a place."""
        return len(self.marking[place])


def inspected(core: Core) -> Inspection:
    """Return the inspection of a net; on the node's thread."""
    engine, execution = core.engine, core.execution
    places, transitions = core.structure.places, core.structure.transitions
    return Inspection(
        **vars(snapshot(core)),
        marking=MappingProxyType(
            {
                id: tuple(Token(token.id, copy_data(token.data)) for token in engine.tokens(place))
                for place, id in enumerate(places)
            }
        ),
        enabled=enabled(core),
        outliving=tuple(in_flight(core, flight, []) for flight in execution.in_flight.outliving),
        aside=MappingProxyType(
            {
                transitions[transition]: MappingProxyType(
                    {places[place]: tuple(sorted(ids)) for place, ids in by_place.items()}
                )
                for transition, by_place in engine.aside.tokens().items()
            }
        ),
        waiting_requests=0 if core.exchange is None else core.exchange.waiting_requests,
        errors=tuple(core.observers.errors),
        stale=core.expectations.stale,
        sources=tuple(source.state for source in core.sources),
    )
