"""Counts of timed state spaces: classes and what leads from one to another, or markings by counted time."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from typing import Any, Literal

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.nets.memory import peak_memory
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.graph import class_graph
from dineros.analysis.timed.nets import TimedNet

TimedEngine = Literal["classes", "integer"]
_REASONS = {
    **RAN_OUT,
    "states": "the limit of states was reached",
    "tokens": "a place holds too many tokens: the net may be unbounded",
    "interrupted": "interrupted",
}


@dataclass(frozen=True)
class TimedStateSpace:
    """Exact figures of a timed state space; None if an engine does not count something.

    Attributes
    ----------
    construction : {"W", "M", "S", "E"} or None
        Which state classes; None if time was counted in units.
    classes, edges, deadlocks : int or None
        State classes, firings from one to another, and classes in which nothing can fire any more.
    unit : str
        The length of time of which every bound is a multiple.
    complete : bool
        Whether these are all.
    peak_memory_bytes : int
        Peak memory of the process so far.
    """

    construction: Kind | None
    places: int
    transitions: int
    classes: int | None
    edges: int | None
    markings: int | None
    deadlocks: int | None
    unit: str
    engine: str
    complete: bool
    reason: str
    seconds: float
    peak_memory_bytes: int

    def to_dict(self) -> dict[str, Any]:
        """Return the figures for JSON."""
        return asdict(self)


def timed_state_space(
    net: TimedNet, kind: Kind = "W", engine: TimedEngine = "classes", budget: Budget = UNLIMITED
) -> TimedStateSpace:
    """Count the state classes of a net, or, with the integer engine, its markings.

    Raises
    ------
    DinerosError
        The construction or the engine does not know something that the net has.
    """
    budget = budget.begun()
    return _by_classes(net, kind, budget) if engine == "classes" else _by_counting(net, budget)


def _by_classes(net: TimedNet, kind: Kind, budget: Budget) -> TimedStateSpace:
    graph = class_graph(net, kind, budget)
    counts = graph.classes, graph.edges, graph.markings, graph.deadlocks
    return figures(net, kind, counts, "classes", graph.reason, budget)


def _by_counting(net: TimedNet, budget: Budget) -> TimedStateSpace:
    from dineros.analysis.timed.integers.counting import count_markings
    from dineros.analysis.timed.integers.net import integer_net

    made = integer_net(net)
    reason, markings = None, None
    try:
        markings = count_markings(made, budget)
    except BudgetExceededError as limit:
        reason = str(limit)
    return figures(net, None, (None, None, markings, None), "integer", reason, budget)


def figures(
    net: TimedNet,
    kind: Kind | None,
    counts: tuple[int | None, int | None, int | None, int | None],
    engine: str,
    reason: str | None,
    budget: Budget,
) -> TimedStateSpace:
    """Return what was found: the counts are those of classes, edges, markings and deadlocks."""
    return TimedStateSpace(
        kind,
        len(net.untimed.places),
        len(net.untimed.transitions),
        *counts,
        str(net.unit),
        engine,
        reason is None,
        _REASONS.get(reason or "", reason or ""),
        time.perf_counter() - (budget.started or time.perf_counter()),
        peak_memory(),
    )


def unfinished_timed(
    net: TimedNet, kind: Kind, engine: str, seen: int | None, reason: str, seconds: float
) -> TimedStateSpace:
    """Return what is known of a count that has to end before it is complete."""
    counts = (seen, None, None, None) if engine == "classes" else (None, None, None, None)
    began = Budget(started=time.perf_counter() - seconds)
    return figures(net, kind if engine == "classes" else None, counts, engine, reason, began)
