"""Decision diagrams of all reachable markings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import fairly
from dineros.analysis.logic.language.syntax import Exists, Finally
from dineros.analysis.portfolio.count import Count
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import NO_BOUNDS, Question, Satisfies

if TYPE_CHECKING:
    from dineros.analysis.portfolio.sheet import Sheet
    from dineros.analysis.symbolic.engine import SymbolicStateSpace

DIAGRAMS = "decision diagrams"


class DecisionDiagrams(Method):
    """Build the diagram of all markings, and search it for one that fulfils the condition."""

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Decide whether some marking fulfils the condition, and find a trace to it."""
        from dineros.analysis.logic.ctl.checking import symbolically

        if isinstance(question, Count):
            return None
        net, bound = question.net, question.bound
        if isinstance(question, Satisfies):
            found = symbolically(net, question.formula, bound, budget, question.orders, question.seed)
            return found or Outcome("unknown", states=0, reason=NO_BOUNDS)
        return _reached(question, symbolically(net, Exists(Finally(question.condition)), bound, budget))

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Decide bounds, questions about the whole net, and CTL subformulas on one diagram.

        If the diagram existed before, its first use is over: then subformulas get all the remaining time.
        """
        from dineros.analysis.properties.normal_form import is_linear

        has_parts = any(not is_linear(part) for part in sheet.open_parts())
        if not (has_parts or sheet.open_limits() or sheet.open_globals()):
            return
        is_first = known.space is None
        known.graph = None
        space = known.space = known.space or _made(known, budget.share(memory=0.5))
        if space is None:
            return
        for limits in sheet.open_limits().values():
            weights, constant = space.encoding.weights_of(limits.factors)
            limits.most = limits.least = constant + space.counts.largest(weights)
        sheet.settle("symbolic")
        if sheet.open_globals():
            sheet.whole.by_diagram(space, sheet.budget.at_most(2 * sheet.patience))
        _branch(sheet, space, is_first)


class DiagramAtHand(Method):
    """Ask the diagram of all markings that another question about the net has made.

    What is computed for the question is released afterwards.
    """

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Decide the question; None without a diagram, or if time or memory runs out."""
        from dineros.analysis.logic.ctl.checking import on_diagram

        if isinstance(question, Count) or known.space is None:
            return None
        wanted = question.formula if isinstance(question, Satisfies) else Exists(Finally(question.condition))
        pinned = known.space.diagram.pinned
        before = len(pinned)
        try:
            answer = on_diagram(known.space, wanted, question.bound, budget)
        finally:
            del pinned[before:]
        if answer.status == "unknown":
            return None
        return answer if isinstance(question, Satisfies) else _reached(question, answer)


def _reached(question: Reach, answer: Outcome | None) -> Outcome | None:
    """Return what an answer about EF says of a condition; None if it has no trace that shows it."""
    if answer is None:
        return None
    if answer.status == "holds" and answer.trace is not None and not answer.reason.startswith("a run"):
        return question.reached(answer.trace, DIAGRAMS)
    if answer.status == "violated":
        return Outcome("unreachable", states=answer.states, by=DIAGRAMS)
    return None


def _made(known: Known, budget: Budget) -> SymbolicStateSpace | None:
    """Return all markings as a diagram."""
    from dineros.analysis.portfolio.budgets import GIVEN_UP, told
    from dineros.analysis.symbolic.engine import symbolic_state_space

    try:
        space = symbolic_state_space(known.net, told(budget, budget.memory))
    except GIVEN_UP:
        return None
    return space if space.complete else None


def _branch(sheet: Sheet, space: SymbolicStateSpace, is_first: bool) -> None:
    """Decide CTL subformulas on a diagram, each within its time."""
    from dineros.analysis.logic.ctl.fixpoints import basic, initially
    from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
    from dineros.analysis.logic.language.atoms import BoundAtoms
    from dineros.analysis.logic.language.syntax import TRUE, And
    from dineros.analysis.portfolio.budgets import GIVEN_UP, told
    from dineros.analysis.properties.normal_form import is_linear

    parts = [part for part in sheet.open_parts() if not is_linear(part)]
    atoms = BoundAtoms(sheet.net, And((TRUE, *parts)), sheet.names)
    pinned, sets = len(space.diagram.pinned), None
    for part, share in fairly(parts, sheet.budget):
        # In the first round, none takes more than its own share.
        own = told(share.at_most(sheet.patience) if is_first else share).begun()
        try:
            # Subformulas share intermediate results; if these take too much memory, they are computed again.
            if sets is None:
                sets = SymbolicSets(space, atoms, own)
            sets.sets.budget = own
            sheet.known[part] = initially(basic(part), sets)
        except BudgetExceededError:
            continue
        except GIVEN_UP:
            del space.diagram.pinned[pinned:]
            sets = None
            continue
        sheet.settle("symbolic")


class LedByDiagram(Method):
    """Follow the existing diagram of all markings to one that enables a transition.

    So distant markings are found; the trace may not be a shortest one. One of the markings that enable the
    transition is chosen: the predecessors of all of them could take far more nodes.
    """

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Return a trace, if the question is about one transition and memory suffices."""
        from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
        from dineros.analysis.symbolic.saturation import DiagramMemoryError
        from dineros.analysis.symbolic.vector_sets import Scope

        space = known.space
        if not isinstance(question, Reach) or question.transition is None or space is None:
            return None
        ways, everything = SymbolicSets(space), space.diagram.root
        try:
            with Scope(space.diagram) as scope:
                others = ways.sets.without_boxes(everything, space.event_masks(question.transition))
                scope.hold(others)
                enabling = ways.sets.difference(everything, others)
                scope.hold(enabling)
                goal = ways.sets.some(enabling)
                scope.hold(goal)
                way = ways.way_to(goal)
        except DiagramMemoryError:
            return None
        return question.reached(way, DIAGRAMS)
