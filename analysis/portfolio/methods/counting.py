"""Three ways to count a state space: decision diagrams, explicit search, and TINA of LAAS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import TYPE_CHECKING, NamedTuple

from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.parts.independent import Independent, independent, shape
from dineros.analysis.portfolio.count import Count, LevelOrder, figures_of
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.satisfies import Question

if TYPE_CHECKING:
    from dineros.analysis.symbolic.order_cache import OrderCache

COVERABILITY_NODES = 2_000
"""Maximum number of nodes of the coverability tree to explain why a net is unbounded."""


@dataclass(frozen=True)
class CountByDiagrams(Method):
    """Count the markings in decision diagrams.

    Attributes
    ----------
    only_if_possible : bool
        Whether another method is asked if places have no known bounds or levels are too large. Otherwise the
        outcome gives the reason.
    """

    only_if_possible: bool = False

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Count; without the arcs, if the budget ends before they are counted."""
        from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError

        if not isinstance(question, Count):
            return None
        try:
            return _by_diagrams(question, budget)
        except (UnknownBoundError, LevelSizeError) as error:
            if self.only_if_possible:
                return None
            if isinstance(error, UnknownBoundError):
                return question.nothing("symbolic", str(error))
            raise


class CountBySearch(Method):
    """Count the markings one after the other."""

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Count; for an unbounded net, find a sequence that makes places grow."""
        from dineros.analysis.explicit import explore
        from dineros.analysis.nets.coverability import coverability

        if not isinstance(question, Count):
            return None
        net = question.net
        space = explore(net, budget.share(most_bytes=budget.memory), order=question.order)
        if space.pumping is not None:
            # The search has found a proof; the coverability tree often has a shorter one.
            others = coverability(net, COVERABILITY_NODES).pumping
            pumping = min(
                [space.pumping, *([others] if others else [])], key=lambda p: len(p.prefix) + len(p.suffix)
            )
            grown = ", ".join(net.places[place] for place in pumping.places)
            reason = f"unbounded: {grown} can grow forever"
            figures = figures_of(net, "explicit", question.began, reason=reason)
            return question.outcome_of(replace(figures, pumping=pumping))
        counts = space.markings, space.arcs, space.deadlocks
        tokens = max(space.largest_place, default=0), space.largest_total
        reason = "" if space.complete else RAN_OUT.get(space.reason or "", space.reason or "unknown")
        return question.counted("explicit", counts, tokens, reason)


class CountByTina(Method):
    """Let TINA count, if it is on the PATH; it uses only the time of the budget."""

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Count; raises `TinaError` if TINA is not available or fails."""
        from dineros.analysis.tina import TinaBudgetError, count

        if not isinstance(question, Count):
            return None
        try:
            counts = count(question.net, budget)
        except TinaBudgetError as limit:
            return question.nothing("tina", limit.why)
        if not counts.is_bounded:
            return question.nothing("tina", "unbounded")
        return question.counted("tina", (counts.states, counts.arcs, counts.deadlocks))


class _Figures(NamedTuple):
    """Exact figures of a net, or of an independent part of it; deadlocks None: not counted."""

    arcs: int
    deadlocks: int | None
    most_in_place: int
    most_in_marking: int


class _Part(NamedTuple):
    """What is counted of a net, or of an independent part of it; figures None: only its markings."""

    states: int
    figures: _Figures | None
    levels: LevelOrder


def _by_diagrams(question: Count, budget: Budget) -> Outcome:
    """Count independent parts of the net one after the other; those of one shape once."""
    net = question.net
    found = independent(net)
    counted: dict[tuple[bytes, ...], _Part] = {}
    parts: list[_Part] = []
    reasons: list[str] = []
    for part in found.parts:
        key = shape(part) if len(found.parts) > 1 else ()
        if key not in counted:
            try:
                counted[key] = _of_diagram(part, question.orders, budget, reasons)
            except BudgetExceededError as limit:
                return question.nothing("symbolic", str(limit))
        parts.append(counted[key])
    whole = parts[0] if len(parts) == 1 else _together(found, parts)
    if whole.figures is None:
        reason = f"{reasons[0]}; these are all states, and the rest is not counted"
        return question.counted("symbolic", (whole.states, None, None), reason=reason)
    arcs, deadlocks, *most = whole.figures
    counts, tokens = (whole.states, arcs, deadlocks), (most[0], most[1])
    figures = figures_of(net, "symbolic", question.began, counts, tokens)
    return question.outcome_of(replace(figures, levels=whole.levels))


def _of_diagram(net: CompiledNet, orders: OrderCache | None, budget: Budget, reasons: list[str]) -> _Part:
    """Count one net; if the budget ends after the markings are counted, add why to the reasons."""
    from dineros.analysis.symbolic.engine import symbolic_state_space

    space = symbolic_state_space(net, budget, orders=orders)
    if not space.complete:
        raise BudgetExceededError(RAN_OUT[space.reason])
    try:
        budget.stage("counting arcs, deadlocks and tokens")
        space.sets.budget = budget
        arcs, deadlocks = space.arcs(), space.deadlocks()
    except BudgetExceededError as limit:
        reasons.append(str(limit))
        return _Part(space.markings, None, space.order)
    most = max(space.largest_place(), default=0), space.largest_total()
    return _Part(space.markings, _Figures(arcs, deadlocks, *most), space.order)


def _together(net: Independent, parts: Sequence[_Part]) -> _Part:
    """Return what is counted of a net from its independent parts.

    A marking of the net is a marking of each part, and it is a deadlock if each of these is one.
    """
    states = prod(part.states for part in parts)
    levels = tuple(level for part in parts for level in part.levels)
    figures = [part.figures for part in parts if part.figures is not None]
    if len(figures) < len(parts):
        return _Part(states, None, levels)
    arcs = sum(states // part.states * own.arcs for part, own in zip(parts, figures, strict=True))
    dead = [own.deadlocks for own in figures if own.deadlocks is not None]
    deadlocks: int | None = None
    if net.always_enabled or 0 in dead:
        deadlocks = 0
    elif len(dead) == len(parts):
        deadlocks = prod(dead)
    together = _Figures(
        arcs + states * net.always_enabled,
        deadlocks,
        max(*(own.most_in_place for own in figures), *net.constant),
        sum(own.most_in_marking for own in figures) + sum(net.constant),
    )
    return _Part(states, together, levels)
