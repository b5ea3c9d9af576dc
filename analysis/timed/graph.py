"""Graphs of state classes as arrays, for questions about runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.logic.language.atoms import Condition, Linear, NoneEnabled, SomeEnabled, SomeFired
from dineros.analysis.logic.language.syntax import (
    OPERATORS,
    And,
    Atom,
    Constant,
    Equivalent,
    Formula,
    Implies,
    Not,
    Or,
)
from dineros.analysis.nets.compiled import CompiledNet, Int64Array
from dineros.analysis.timed.atomic import AtomicSearch
from dineros.analysis.timed.classes import ClassGraph, Kind
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.search import ClassSearch

Flags = NDArray[np.bool_]

WAITING = -1
"""Label of an edge that fires nothing: time passes forever."""


def holding(tree: Formula, evaluate: Callable[[Atom], Flags], size: int) -> Flags:
    """Return where a boolean combination of atoms is true, given where each atom is.

    Raises
    ------
    TypeError
        There is a temporal operator.
    """
    values: dict[Formula, Flags] = {}
    for part in tree.subformulas():
        rows = [values[operand] for operand in part.operands]
        match part:
            case Constant(value):
                values[part] = np.full(size, value)
            case Atom():
                values[part] = evaluate(part)
            case Not():
                values[part] = ~rows[0]
            case And():
                values[part] = np.logical_and.reduce(rows)
            case Or():
                values[part] = np.logical_or.reduce(rows)
            case Implies():
                values[part] = ~rows[0] | rows[1]
            case Equivalent():
                values[part] = rows[0] == rows[1]
            case _:
                raise TypeError(f"no condition on a marking: {part}")
    return values[tree]


def marked_so(net: TimedNet, condition: Linear | SomeEnabled, markings: Int64Array) -> Flags:
    """Return by marking (a row) whether it has a property."""
    if isinstance(condition, Linear):
        sums = np.zeros(len(markings), dtype=np.int64)
        for place, factor in condition.factors.items():
            sums += factor * markings[:, place]
        return np.asarray(OPERATORS[condition.operator](sums, condition.bound))  # type: ignore[arg-type]
    some = np.zeros(len(markings), dtype=np.bool_)
    for transition in condition.transitions:
        some |= enabling(net.untimed, net, transition, markings)
    return some


@dataclass(frozen=True)
class TimedGraph:
    """Classes, numbered from 0, the initial one, and edges.

    Attributes
    ----------
    net : TimedNet
    marking_of : int64 array, shape (classes,)
        By class its marking, a row of `markings`.
    markings : int64 array, shape (markings, places)
    source, target, label : int64 arrays, shape (edges,)
        The edges, sources ascending; the label is the transition, or `WAITING` where a run may stay in a
        class forever: then nothing that is enabled has a latest bound.
    """

    net: TimedNet
    marking_of: Int64Array
    markings: Int64Array
    source: Int64Array
    target: Int64Array
    label: Int64Array

    @property
    def classes(self) -> int:
        """Number of classes."""
        return len(self.marking_of)

    def where(self, condition: Condition) -> Flags:
        """Return by class whether its marking has a property.

        ``deadlock`` is a class in which nothing can fire any more, however long one waits.
        """
        if isinstance(condition, NoneEnabled):
            fires = np.zeros(self.classes, dtype=np.bool_)
            fires[self.source[self.label != WAITING]] = True
            return ~fires
        if isinstance(condition, Linear | SomeEnabled):
            return marked_so(self.net, condition, self.markings)[self.marking_of]
        raise TypeError(f"no property of a marking: {condition}")

    def fired(self, condition: SomeFired) -> Flags:
        """Return by edge whether it fires one of some transitions."""
        return np.isin(self.label, list(condition.transitions))


def enabling(net: CompiledNet, timed: TimedNet, transition: int, markings: Int64Array) -> Flags:
    """Return by marking whether it has enough tokens for a transition, and few enough for inhibitor arcs."""
    held = np.ones(len(markings), dtype=np.bool_)
    for place, weight in timed.test.row(transition):
        held &= markings[:, place] >= weight
    for place, weight in net.inhibitor.row(transition):
        held &= markings[:, place] < weight
    return held


def nothing_enabled(net: TimedNet, markings: Int64Array) -> Flags:
    """Return by marking whether it enables nothing; further columns of other places are left out."""
    some = np.zeros(len(markings), dtype=np.bool_)
    for transition in range(len(net.untimed.transitions)):
        some |= enabling(net.untimed, net, transition, markings)
    return ~some


def class_graph(net: TimedNet, kind: Kind = "W", budget: Budget = UNLIMITED) -> ClassGraph:
    """Build the graph of all state classes.

    Parameters
    ----------
    net
        The net. W and M do not know priorities.
    kind
        Which classes; see `dineros.analysis.timed.classes`.
    budget
        Limits; a share of the free memory unless one is given.

    Raises
    ------
    DinerosError
        The net has priorities and the classes are linear, or a bound is too large.
    """
    search = AtomicSearch(net, budget) if kind == "A" else ClassSearch(net, kind, budget)
    search.run()
    return search.graph()


def timed_graph(net: TimedNet, kind: Kind, budget: Budget) -> TimedGraph:
    """Build the graph of all state classes: W, S or A.

    Raises
    ------
    BudgetExceededError
        A limit was hit before it is complete.
    """
    return first_classes(net, kind, budget, None)[0]


def first_classes(net: TimedNet, kind: Kind, budget: Budget, most: int | None) -> tuple[TimedGraph, bool]:
    """Build the graph of the state classes that are found first: W, S or A.

    Parameters
    ----------
    net, kind, budget
        The net, which classes, and limits.
    most
        Classes with which the search ends, about; None: all of them, as A needs.

    Returns
    -------
    graph : TimedGraph
        Of these. A class that was not looked into has no edge.
    is_complete : bool
        Whether these are all.

    Raises
    ------
    BudgetExceededError
        A limit was hit before.
    """
    share = budget if most is None else replace(budget, states=most)
    search = AtomicSearch(net, share) if kind == "A" else ClassSearch(net, kind, share, keeps_edges=True)
    search.run()
    is_complete = search.reason is None
    if not is_complete and (most is None or search.reason != "states"):
        reason = str(search.reason)
        raise BudgetExceededError(RAN_OUT.get(reason, reason))
    budget.check_memory(search.memory_bytes + 6 * 8 * search.edges)
    marking_of, source, target, label = search.arrays()
    markings = search.markings()
    waits = np.ones(len(markings), dtype=np.bool_)
    for transition, interval in enumerate(net.intervals):
        if interval.latest is not None:
            waits &= ~enabling(net.untimed, net, transition, markings)
    waiting = np.flatnonzero(waits[marking_of])
    source = np.concatenate([source, waiting])
    target = np.concatenate([target, waiting])
    label = np.concatenate([label, np.full(len(waiting), WAITING)])
    order = np.argsort(source, kind="stable")
    made = TimedGraph(net, marking_of, markings, source[order], target[order], label[order])
    return made, is_complete
