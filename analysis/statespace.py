"""State spaces: the engine chosen, and everything that is counted in one object."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Literal

from dineros.analysis.compiled import CompiledNet

Engine = Literal["auto", "explicit", "symbolic"]
DEFAULT_MEMORY = 2 << 30


@dataclass(frozen=True)
class StateSpace:
    """Exact figures of a state space; None where an engine cannot count something.

    Attributes
    ----------
    places, transitions : int
        Size of the net explored.
    states, arcs, deadlocks : int or None
        Reachable markings, arcs between them, markings that enable nothing; of an incomplete exploration,
        what was seen.
    max_tokens_in_place, max_tokens_in_marking : int or None
        The largest number of tokens of a place, and of a whole marking.
    engine : str
        The engine that answered.
    complete : bool
        Whether these are all markings.
    reason : str
        Why not: memory, an unbounded net.
    seconds : float
        Wall-clock time, order search included.
    peak_memory_bytes : int
        Peak memory of the process so far.
    """

    places: int
    transitions: int
    states: int | None
    arcs: int | None
    deadlocks: int | None
    max_tokens_in_place: int | None
    max_tokens_in_marking: int | None
    engine: str
    complete: bool
    reason: str
    seconds: float
    peak_memory_bytes: int

    def to_dict(self) -> dict[str, Any]:
        """Return the figures for JSON."""
        return asdict(self)


def state_space(
    net: CompiledNet,
    engine: Engine = "auto",
    memory: int = DEFAULT_MEMORY,
    progress: Callable[[Any], None] | None = None,
) -> StateSpace:
    """Count the state space of a net.

    ``auto`` takes decision diagrams, and the explicit engine where bounds of places are not known.

    Parameters
    ----------
    net : CompiledNet
        The net.
    engine : {"auto", "explicit", "symbolic"}
        Which engine.
    memory : int
        Bytes it may take.
    progress : callable, optional
        Told now and then how far it is.
    """
    from dineros.analysis.levels import UnknownBoundError

    began = time.perf_counter()
    if engine != "explicit":
        try:
            return _symbolic(net, memory, progress, began)
        except UnknownBoundError as error:
            if engine == "symbolic":
                return _nothing(net, "symbolic", str(error), began)
    return _explicit(net, memory, progress, began)


def _symbolic(
    net: CompiledNet, memory: int, progress: Callable[[Any], None] | None, began: float
) -> StateSpace:
    from dineros.analysis.symbolic import symbolic_state_space

    space = symbolic_state_space(net, memory, progress)
    if not space.complete:
        return _nothing(net, "symbolic", space.reason, began)
    return _of(
        net,
        (space.markings, space.arcs(), space.deadlocks()),
        (max(space.largest_place(), default=0), space.largest_total()),
        "symbolic",
        "",
        began,
    )


def _explicit(
    net: CompiledNet, memory: int, progress: Callable[[Any], None] | None, began: float
) -> StateSpace:
    from dineros.analysis.explicit import explore
    from dineros.analysis.goals import Seen

    def tell(markings: int, rate: float, size: int) -> None:
        if progress is not None:
            progress(Seen(markings, rate, size))

    space = explore(net, memory=memory, progress=tell)
    return _of(
        net,
        (space.markings, space.arcs, space.deadlocks),
        (max(space.largest_place, default=0), space.largest_total),
        "explicit",
        "" if space.complete else space.reason or "unknown",
        began,
    )


def _nothing(net: CompiledNet, engine: str, reason: str, began: float) -> StateSpace:
    return _of(net, (None, None, None), (None, None), engine, reason, began)


def _of(
    net: CompiledNet,
    counts: tuple[int | None, int | None, int | None],
    tokens: tuple[int | None, int | None],
    engine: str,
    reason: str,
    began: float,
) -> StateSpace:
    return StateSpace(
        len(net.places),
        len(net.transitions),
        *counts,
        *tokens,
        engine,
        not reason,
        reason,
        time.perf_counter() - began,
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
    )
