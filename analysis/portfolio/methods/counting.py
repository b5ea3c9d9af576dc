"""Three ways to count a state space: decision diagrams, explicit search, and TINA of LAAS."""

from __future__ import annotations

from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.portfolio.count import Count, figures_of
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.satisfies import Question

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


def _by_diagrams(question: Count, budget: Budget) -> Outcome:
    from dineros.analysis.symbolic.engine import symbolic_state_space

    try:
        space = symbolic_state_space(question.net, budget, orders=question.orders)
        if not space.complete:
            return question.nothing("symbolic", RAN_OUT[space.reason])
        states = space.markings
    except BudgetExceededError as limit:
        return question.nothing("symbolic", str(limit))
    try:
        budget.stage("counting arcs, deadlocks and tokens")
        space.sets.budget = budget
        counts = states, space.arcs(), space.deadlocks()
    except BudgetExceededError as limit:
        reason = f"{limit}; these are all states, and the rest is not counted"
        return question.counted("symbolic", (states, None, None), reason=reason)
    tokens = max(space.largest_place(), default=0), space.largest_total()
    figures = figures_of(question.net, "symbolic", question.began, counts, tokens)
    return question.outcome_of(replace(figures, levels=space.order))
