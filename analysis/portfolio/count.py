"""The question how many states a net has, and the figures of a state space."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit import Order
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.memory import peak_memory

if TYPE_CHECKING:
    from dineros.analysis.nets.coverability import Pumping
    from dineros.analysis.symbolic.order_cache import OrderCache

LevelOrder = tuple[tuple[str, ...], ...]
_NOT_OF_EVERY_NET = ("pumping", "levels", "reduced_states", "without", "rest")


@dataclass(frozen=True)
class StateSpace:
    """Exact figures of a state space; None: an engine cannot count it.

    Attributes
    ----------
    states, arcs, deadlocks : int or None
        Reachable markings, arcs between them, and deadlocks; for an incomplete exploration, the counts so
        far.
    max_tokens_in_place, max_tokens_in_marking : int or None
        The largest number of tokens of a place, and of a whole marking.
    reason : str
        Why not: memory, an unbounded net.
    seconds : float
        Wall-clock time, including the search for a variable order.
    peak_memory_bytes : int
        Peak memory of the process so far.
    pumping : Pumping or None
        For an unbounded net, a sequence that makes places grow forever. Then there are no counts, since there
        are infinitely many markings.
    without : tuple of str
        For an unbounded net: the places from which no transition takes tokens and that no invariant bounds,
        such as counters and logs.
    rest : StateSpace or None
        The figures without those: of the net in which they are removed, or limited to the largest number with
        which a transition compares them. It has the same runs; the most tokens are counted only if all are
        removed.
    levels : tuple of tuple of str
        Groups of places by level, if decision diagrams were used.
    reduced_states : int or None
        Markings of the reduced net, if the net was reduced for counting.
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
    pumping: Pumping | None = None
    levels: LevelOrder = ()
    reduced_states: int | None = None
    without: tuple[str, ...] = ()
    rest: StateSpace | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the figures for JSON."""
        return {name: value for name, value in asdict(self).items() if name not in _NOT_OF_EVERY_NET}


@dataclass(frozen=True)
class Counted(Outcome):
    """The outcome of counting: ``counted`` (exact figures, or an unbounded net) or ``unknown``."""

    space: StateSpace | None = None


@dataclass(frozen=True)
class Count:
    """How many states, arcs and deadlocks a net has.

    Attributes
    ----------
    began : float
        When the question was asked, by `time.perf_counter`.
    """

    net: CompiledNet
    orders: OrderCache | None = None
    order: Order = "breadth-first"
    began: float = field(default_factory=time.perf_counter)

    def counted(
        self,
        engine: str,
        counts: tuple[int | None, int | None, int | None],
        tokens: tuple[int | None, int | None] = (None, None),
        reason: str = "",
    ) -> Counted:
        """Return the outcome with these figures; see `figures_of`."""
        return self.outcome_of(figures_of(self.net, engine, self.began, counts, tokens, reason))

    def nothing(self, engine: str, reason: str) -> Counted:
        """Return the outcome without counts, with the reason."""
        return self.counted(engine, (None, None, None), reason=reason)

    def outcome_of(self, space: StateSpace) -> Counted:
        """Return figures as an outcome."""
        is_answer = space.complete or space.pumping is not None
        return Counted("counted" if is_answer else "unknown", reason=space.reason, space=space)

    def is_answer(self, outcome: Outcome) -> bool:
        """Return whether an outcome answers the question."""
        return outcome.status != "unknown"

    def ends_others(self, outcome: Outcome) -> bool:
        """Return whether an outcome ends methods that run side by side."""
        return self.is_answer(outcome)


def figures_of(
    net: CompiledNet,
    engine: str,
    began: float,
    counts: tuple[int | None, int | None, int | None] = (None, None, None),
    tokens: tuple[int | None, int | None] = (None, None),
    reason: str = "",
) -> StateSpace:
    """Return counts (states, arcs, deadlocks) and largest tokens as figures; complete without a reason."""
    return StateSpace(
        len(net.places),
        len(net.transitions),
        *counts,
        *tokens,
        engine,
        not reason,
        reason,
        time.perf_counter() - began,
        peak_memory(),
    )
