"""Reaching a goal: a transition enabled, or a condition on the marking (paper, Alg. 5).

A condition becomes a disjunction of conjunctions of comparisons, which the explicit engine searches for
directly, all at once and on the fly; only what would make too many of them goes to the automata of temporal
logic.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from dineros.analysis.compiled import CompiledNet
from dineros.analysis.coverability import coverability
from dineros.analysis.explicit import Found, Order, Unknown, Unreachable, find
from dineros.analysis.explicit.goals import Goal, excludes
from dineros.analysis.logic.atoms import BoundAtoms, Step
from dineros.analysis.logic.budget import Budget
from dineros.analysis.logic.disjunctions import goals_of
from dineros.analysis.logic.lasso import holds_on_lasso
from dineros.analysis.logic.ltl import verify_ltl
from dineros.analysis.logic.names import Names
from dineros.analysis.logic.parser import parse
from dineros.analysis.logic.syntax import Formula, Globally, Not
from dineros.analysis.reductions import Property, reduce
from dineros.analysis.shortening import shortened

QUICK = 256 << 20
"""Bytes for the search for a shortest trace, before the net is reduced."""

INTERRUPTED = "interrupted"
_REASONS = {
    "memory": "memory ran out",
    "time": "time ran out",
    "states": "the limit of markings was reached",
    "unbounded": "the net is unbounded, and memory ran out",
    "interrupted": INTERRUPTED,
}


@dataclass(frozen=True)
class Answer:
    """How a goal is reached.

    Attributes
    ----------
    status : {"reachable", "unreachable", "unknown"}
    trace : tuple of int or None
        Transitions from the initial marking to the goal, replayed by the plain firing rule; where a
        transition is to be enabled, that transition comes last.
    states : int or None
        Markings visited; None where the search stopped at the goal.
    reason : str
        Why the answer is unknown.
    """

    status: Literal["reachable", "unreachable", "unknown"]
    trace: tuple[int, ...] | None = None
    states: int | None = None
    reason: str = ""


def find_enabled(
    net: CompiledNet,
    name: str,
    names: Names,
    memory: int,
    progress: Callable[[Any], None] | None = None,
    order: Order = "breadth-first",
) -> Answer:
    """Find a trace that ends with a transition; of several of the name, whichever is nearest.

    Raises
    ------
    FormulaError
        No transition has the name.
    """
    answers: list[Answer] = []
    for transition in names.transitions(name):
        answers.append(find_firing(net, transition, memory, progress, order))
        if answers[-1].reason == INTERRUPTED:
            break
    return min(answers, key=_rank)


def find_firing(
    net: CompiledNet,
    transition: int,
    memory: int,
    progress: Callable[[Any], None] | None = None,
    order: Order = "breadth-first",
) -> Answer:
    """Find a trace that ends with a transition: a shortest one, unless only the reduced net is small enough.

    Reduction by rules that preserve LTL without next keeps whether the transition ever fires; a trace of the
    reduced net is mapped back, and what it does not need is left out.
    """
    name = net.transitions[transition]
    answer = _search(net, Goal.enabled(net, transition), min(memory, QUICK), progress, order)
    if answer.trace is not None:
        return replace(answer, trace=(*answer.trace, transition))
    if answer.status != "unknown" or answer.reason == INTERRUPTED:
        return answer
    reduction = reduce(net, {Property.LTL_WITHOUT_NEXT}, observed_transitions=[name])
    smaller = reduction.net
    answer = _search(smaller, Goal.enabled(smaller, name), memory, progress, order)
    if answer.trace is None:
        return answer
    index = {name: number for number, name in enumerate(net.transitions)}
    names = reduction.expand([*(smaller.transitions[number] for number in answer.trace), name])
    trace = _to_goal(net, Goal.enabled(net, transition), [index[name] for name in names[:-1]])
    return Answer("reachable", (*trace, transition))


def find_deadlock(
    net: CompiledNet,
    memory: int,
    progress: Callable[[Any], None] | None = None,
    order: Order = "breadth-first",
) -> Answer:
    """Find a trace to a marking that enables nothing; stubborn sets leave out needless interleavings."""
    return _search(net, Goal.deadlock(), memory, progress, order)


def find_marking(
    net: CompiledNet,
    text: str,
    names: Names,
    memory: int,
    progress: Callable[[Any], None] | None = None,
    order: Order = "breadth-first",
) -> Answer:
    """Find a trace to a marking that fulfils a condition, a shortest one if the search goes breadth first.

    Raises
    ------
    FormulaError
        The text is no condition on markings, or names something unknown.
    """
    condition = parse(text, "state")
    goals = goals_of(net, condition, names)
    if goals is None:
        return _by_temporal_logic(net, condition, names, memory, progress)
    answers: list[Answer] = []
    for goal in goals:
        answers.append(_search(net, goal, memory, progress, order))
        if answers[-1].reason == INTERRUPTED:
            break
    if not answers:
        return Answer("unreachable", states=0)
    states = [answer.states for answer in answers if answer.states is not None]
    best = min(answers, key=_rank)
    return best if best.status == "reachable" else replace(best, states=max(states, default=None))


def _by_temporal_logic(
    net: CompiledNet, condition: Formula, names: Names, memory: int, progress: Callable[[Any], None] | None
) -> Answer:
    """Ask for a run on which a condition never holds: a counterexample leads to it."""
    verdict = verify_ltl(net, Globally(Not(condition)), names, budget=Budget(memory), progress=progress)
    if verdict.status == "violated":
        bound = BoundAtoms(net, condition, names)

        def is_goal(marking: list[int]) -> bool:
            return holds_on_lasso(condition, [], [Step(tuple(marking), None)], bound.is_true)

        return Answer("reachable", shortened(net, verdict.stem + verdict.loop, is_goal))
    if verdict.status == "holds":
        return Answer("unreachable", states=verdict.states)
    return Answer("unknown", states=verdict.states, reason=verdict.reason)


def _rank(answer: Answer) -> tuple[int, int]:
    """Order answers: short traces first, then unknown, then unreachable."""
    return (
        ["reachable", "unknown", "unreachable"].index(answer.status),
        len(answer.trace) if answer.trace is not None else 0,
    )


def _search(
    net: CompiledNet,
    goal: Goal,
    memory: int,
    progress: Callable[[Any], None] | None,
    order: Order,
) -> Answer:
    def tell(markings: int, rate: float, size: int) -> None:
        if progress is not None:
            progress(Seen(markings, rate, size))

    def search(share: int) -> Found | Unreachable | Unknown:
        reduction: Literal["stubborn"] | None = "stubborn" if goal.is_deadlock else None
        return find(net, goal, memory=share, progress=tell, reduction=reduction, order=order)

    answer = search(min(memory, QUICK))
    if (
        isinstance(answer, Unknown)
        and answer.reason == "unbounded"
        # More markings would prove nothing; the largest ones may.
        and excludes(net, coverability(net), goal)
    ):
        return Answer("unreachable", states=answer.states)
    if isinstance(answer, Unknown) and answer.reason in ("memory", "unbounded") and memory > QUICK:
        answer = search(memory)
    match answer:
        case Found(trace, _):
            return Answer("reachable", trace if order == "breadth-first" else _to_goal(net, goal, trace))
        case Unreachable(states):
            return Answer("unreachable", states=states)
        case Unknown(reason, states):
            return Answer("unknown", states=states, reason=_REASONS.get(reason, reason))


def _to_goal(net: CompiledNet, goal: Goal, trace: Sequence[int]) -> tuple[int, ...]:
    """Leave out of a trace what the goal does not need."""
    if len(goal.transitions) == 1:
        needs, inhibitors = net.pre.row(goal.transitions[0]), net.inhibitor.row(goal.transitions[0])

        def is_goal(marking: list[int]) -> bool:
            return all(marking[place] >= weight for place, weight in needs) and all(
                marking[place] < weight for place, weight in inhibitors
            )
    else:

        def is_goal(marking: list[int]) -> bool:
            return goal.holds(net, marking)

    return shortened(net, trace, is_goal)


@dataclass(frozen=True)
class Seen:
    """How far an explicit search is: markings stored, markings a second, bytes."""

    markings: int
    rate: float
    bytes: int
