"""Explicit search on the fly: one marking after another, until one fulfils the condition."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Attempt, first_result
from dineros.analysis.explicit import Order, find
from dineros.analysis.explicit.answers import Reduction
from dineros.analysis.explicit.engine import NO_END
from dineros.analysis.explicit.goals import Goal, excludes
from dineros.analysis.logic.language.syntax import Globally, Not
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import EXPLICIT, INTERRUPTED, Reach
from dineros.analysis.portfolio.satisfies import Question

QUICK = 256 << 20
"""Memory for the search for a shortest trace before the net is reduced, in bytes."""

NEAR_IF_UNBOUNDED = 1_000_000
"""Number of markings of a search for a shortest trace in a net found to be unbounded."""

_REASONS = {
    "memory": "memory ran out",
    "time": "time ran out",
    "states": "the limit of markings was reached",
    "unbounded": "the net is unbounded, and memory ran out",
    "interrupted": INTERRUPTED,
}


@dataclass(frozen=True)
class ExplicitSearch(Method):
    """Store markings one by one.

    Attributes
    ----------
    is_near : bool
        Whether only near markings are searched: then the trace is a shortest one, and nothing more is tried
        on an unbounded net.
    order : {"breadth-first", "depth-first"}, optional
        Order of the search, if it differs from that of the question.
    """

    is_near: bool = False
    order: Order | None = None

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Search for each goal, or for a run that never meets the condition."""
        if not isinstance(question, Reach):
            return None
        if question.goals is None:
            return _by_temporal_logic(question, budget)
        order = self.order or question.order
        is_shortest = order == "breadth-first" if self.is_near else question.is_shortest
        answers = (
            search(question.net, goal, budget, order, is_shortest, is_near=self.is_near)
            for goal in question.goals
        )
        return nearest(answers, EXPLICIT)


def _by_temporal_logic(question: Reach, budget: Budget) -> Outcome:
    """Search for a run on which the condition never holds: a counterexample leads to it."""
    from dineros.analysis.logic.ltl.verification import verify_ltl

    never = Globally(Not(question.condition))
    answer = verify_ltl(question.net, never, question.names, budget=budget)
    if answer.status == "violated":
        return question.reached(answer.stem + answer.loop, EXPLICIT)
    return replace(answer, status="unreachable", by=EXPLICIT) if answer.status == "holds" else answer


def nearest(answers: Iterable[Outcome], by: str) -> Outcome:
    """Return the best of the answers for several goals, any of which suffices."""
    known: list[Outcome] = []
    for answer in answers:
        known.append(answer)
        if answer.reason == INTERRUPTED:
            break
    best = replace(min(known, key=_rank, default=Outcome("unreachable", states=0)), by=by)
    states = [answer.states for answer in known if answer.states is not None]
    return best if best.status == "reachable" else replace(best, states=max(states, default=None))


def _rank(answer: Outcome) -> tuple[int, int]:
    """Order answers: short traces first, then unknown, then unreachable."""
    return ["reachable", "unknown", "unreachable"].index(answer.status), len(answer.stem)


def search(
    net: CompiledNet,
    goal: Goal,
    budget: Budget = UNLIMITED,
    order: Order = "breadth-first",
    is_shortest: bool = True,
    *,
    is_near: bool = False,
) -> Outcome:
    """Search for a goal: for a shortest trace first, on an unbounded net also for a proof.

    If no shortest trace is required, the first one found is returned. With `is_near`, only near markings are
    searched.
    """

    def explore(share: Budget) -> Outcome:
        reduction: Reduction | None = "stubborn" if goal.is_deadlock else None
        return find(
            net,
            goal,
            share,
            reduction=reduction,
            order=order,
            is_shortest=is_shortest,
            most_if_unbounded=most_if_unbounded,
        )

    most_if_unbounded = NEAR_IF_UNBOUNDED
    answer = explore(budget.share(most_bytes=QUICK))
    # In an unbounded net, more markings would prove nothing; the maximal ones may.
    if answer.reason == "unbounded" and not is_near:
        from dineros.analysis.covering.goals import decide_goal
        from dineros.analysis.nets.coverability import coverability

        def by_tree(share: Budget) -> Outcome | None:
            is_excluded = excludes(net, coverability(net, budget=share), goal)
            return Outcome("unreachable", states=answer.states) if is_excluded else None

        attempts = (
            Attempt(lambda share: decide_goal(net, goal, share), time=0.5),
            Attempt(by_tree, time=0.3),
        )
        found = first_result(attempts, budget)
        if found is not None:
            return found
    if answer.reason in ("memory", "unbounded") and budget.memory > QUICK and not is_near:
        most_if_unbounded = NO_END
        answer = explore(budget.share(most_bytes=budget.memory))
    if answer.trace is None or order == "breadth-first":
        return replace(answer, reason=_REASONS.get(answer.reason, answer.reason))
    return Outcome("reachable", way_without_detours(net, goal, answer.trace))


def way_without_detours(net: CompiledNet, goal: Goal, trace: Sequence[int]) -> tuple[int, ...]:
    """Remove firings from a trace that the goal does not need."""
    return shortened(net, trace, partial(goal.holds, net))
