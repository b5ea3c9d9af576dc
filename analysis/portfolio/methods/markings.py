"""Markings stored with their successors: all markings, the first ones, or distant ones.

On a part of the graph, questions have three truth values (`dineros.analysis.properties.part_of_graph`).
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share, fairly
from dineros.analysis.explicit.layout import layout
from dineros.analysis.logic.ctl.fixpoints import basic, satisfying
from dineros.analysis.logic.graphs.predicates import Int64Array, total
from dineros.analysis.logic.language.syntax import And, Exists, ForAll, Formula
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.budgets import GIVEN_UP
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.satisfies import Question, Satisfies
from dineros.analysis.properties.normal_form import everywhere, goal_of, is_linear
from dineros.analysis.properties.part_of_graph import PartialSets, PartOfGraph

if TYPE_CHECKING:
    from dineros.analysis.portfolio.sheet import Sheet

PROBE_STATES = 2_000
"""Number of markings evaluated from the end of a random walk on."""

PROBE = Share(time=0.5, memory=0.125)
"""Share of this evaluation."""

WALKS_TRIED = 5
"""Number of walks from whose ends a formula is evaluated."""

KEPT = ("delta", "changing")
"""Derived data of a net that does not depend on its initial marking."""


@dataclass(frozen=True)
class StoredMarkings(Method):
    """Store markings breadth first, and decide questions on them.

    Attributes
    ----------
    memory : float
        Share of the memory for them.
    """

    most_states: int | None = None
    memory: float = 1.0

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Decide a CTL formula on all markings."""
        from dineros.analysis.logic.ctl.checking import explicitly

        if not isinstance(question, Satisfies):
            return None
        return explicitly(question.net, question.formula, question.bound, budget)

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Store markings, unless all are stored already, and evaluate each open question."""
        graph = known.graph
        if graph is None or not graph.is_complete:
            known.graph = None  # release its memory for the next graph
            share = Share(time=0.5, memory=self.memory).share(budget)
            graph = known.graph = _part(known, share, self.most_states)
            if graph is None:
                return
            known.cells = graph.layout
            # Stored markings are worth some time, even if storing took all of it.
            left = max(budget.left or 0.0, sheet.patience / 2)
            budget = replace(budget, started=None, seconds=left).begun()
        _look_at(sheet, graph, budget)


class FarMarkings(Method):
    """Search distant markings that refute ``AG f`` or show ``EF f``, if f is not just a condition."""

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Walk to markings in which the operand of ``AG``, such as ``EF p``, is certainly false."""
        if not isinstance(question, Satisfies):
            return None
        formula = question.formula
        for part in formula.operands if isinstance(formula, And) else (formula,):
            inner = everywhere(part) if isinstance(part, ForAll) else None
            way = None if inner is None else _way_against(question, inner, known, budget)
            if way is not None:
                return Outcome("violated", way, by="walks")
        return None

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Store some markings from the end of each walk on."""
        known.graph = None
        for start, own in fairly(known.walker.ends, budget):
            parts = [(part, inner) for part in sheet.open_parts() if (inner := everywhere(part)) is not None]
            if not parts or budget.is_over:
                return
            graph = _part(known, PROBE.share(own), PROBE_STATES, start)
            if graph is None:
                return
            sets = PartialSets(graph, sheet.conditions, own.check_time)
            with contextlib.suppress(BudgetExceededError):
                for part, inner in parts:
                    wanted = basic(inner)
                    sure, possible = satisfying(wanted, sets)[wanted]
                    if isinstance(part, Exists) and sure.any():
                        sheet.known[part] = True
                    elif isinstance(part, ForAll) and not possible.all():
                        sheet.known[part] = False
            sheet.settle("explicit, from a random walk")


def _way_against(question: Satisfies, inner: Formula, known: Known, budget: Budget) -> tuple[int, ...] | None:
    """Return a walk to a marking in which a formula is certainly false, by the markings that follow it."""
    from dineros.analysis.walks.scouting import Scout

    net, wanted, conditions = known.net, basic(inner), question.bound.conditions
    scout = Scout(net)
    known.cells = known.cells or net.once(layout)  # else each graph would compute its own
    for _ in range(WALKS_TRIED):
        budget.check_time()
        scout.walk()
        end = _end(net, scout.last)
        graph = _part(known, PROBE.share(budget), PROBE_STATES, end)
        if graph is None:
            return None
        known.cells = graph.layout
        _, possible = satisfying(wanted, PartialSets(graph, conditions, budget.check_time))[wanted]
        if not possible[0]:
            return _way_to(net, scout.last.tolist(), end)
    return None


def _end(net: CompiledNet, firings: Int64Array) -> list[int]:
    """Return the marking after some firings, regardless of their order."""
    end: list[int] = net.initial.tolist()
    counts = np.bincount(firings, minlength=len(net.transitions))
    for t in counts.nonzero()[0].tolist():
        for place, tokens in net.delta[t].items():
            end[place] += tokens * int(counts[t])
    return end


def _way_to(net: CompiledNet, way: Sequence[int], end: list[int]) -> tuple[int, ...]:
    """Return a replayed trace to a marking without unnecessary firings."""
    found = shortened(net, way, lambda marking: marking == end)
    replay(net, found)
    return found


def _part(
    known: Known, budget: Budget, states: int | None, start: Sequence[int] | None = None
) -> PartOfGraph | None:
    """Return the first markings of a net, all if there are few; from another marking if one is given."""
    net: CompiledNet = known.net
    if start is not None:
        derived: dict[str, Any] = {name: net.__dict__[name] for name in KEPT if name in net.__dict__}
        net = replace(net, initial=np.array(start, dtype=np.int64))
        net.__dict__.update(derived)
    try:
        return PartOfGraph(net, replace(budget, states=states, progress=None, stages=None), known.cells)
    except GIVEN_UP:
        return None


def _look_at(sheet: Sheet, graph: PartOfGraph, budget: Budget) -> None:
    """Decide questions on a part of the graph, as far as time allows."""
    for limits in sheet.open_limits().values():
        limits.least = max(limits.least, int(total(graph, limits.factors).max()))
        if graph.is_complete:
            limits.most = limits.least
    sheet.settle("explicit")
    if sheet.open_globals():
        sheet.whole.by_graph(graph)
    sets = PartialSets(graph, sheet.conditions, budget.check_time)
    parts = [part for part in sheet.open_parts() if not is_linear(part)]
    # Goals first: they are the cheapest.
    for part in sorted(parts, key=lambda part: goal_of(part) is None):
        wanted = basic(part)
        value = sets.value(satisfying(wanted, sets)[wanted])
        if value is not None:
            sheet.known[part] = value
            sheet.settle("explicit")
