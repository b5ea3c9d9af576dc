"""Reaching a goal: a transition enabled, or a condition on the marking (paper, Alg. 5).

A condition becomes a disjunction of conjunctions of comparisons, which the explicit engine searches for
directly, all at once and on the fly; only what would make too many of them goes to the automata of temporal
logic.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from dineros.analysis.explicit import Found, Order, Unknown, Unreachable, find
from dineros.analysis.explicit.goals import Goal, excludes
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.disjunctions import goals_of
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import Constant, Formula, Globally, Not
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.logic.verdicts.answer import Answer
from dineros.analysis.logic.verdicts.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import coverability
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.reductions import Property, reduce
from dineros.analysis.symbolic.engine import SymbolicStateSpace
from dineros.analysis.symbolic.vector_sets import Scope

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


def find_enabled(
    net: CompiledNet,
    name: str,
    names: Names,
    memory: int,
    progress: Callable[[Any], None] | None = None,
    order: Order = "breadth-first",
    seconds: float | None = None,
) -> Answer:
    """Find a trace that ends with a transition; of several of the name, whichever is nearest.

    Raises
    ------
    FormulaError
        No transition has the name.
    """
    limits = _Limits.of(memory, progress, order, seconds)
    answers: list[Answer] = []
    for transition in names.transitions(name):
        answers.append(_find_firing(net, transition, limits))
        if answers[-1].reason == INTERRUPTED:
            break
    return min(answers, key=_rank)


def find_firing(
    net: CompiledNet,
    transition: int,
    memory: int,
    progress: Callable[[Any], None] | None = None,
    order: Order = "breadth-first",
    seconds: float | None = None,
) -> Answer:
    """Find a trace that ends with a transition: a shortest one, unless only the reduced net is small enough.

    Reduction by rules that preserve LTL without next keeps whether the transition ever fires; a trace of the
    reduced net is mapped back, and what it does not need is left out.
    """
    return _find_firing(net, transition, _Limits.of(memory, progress, order, seconds))


def _find_firing(net: CompiledNet, transition: int, limits: _Limits) -> Answer:
    name = net.transitions[transition]
    quickly = replace(limits, memory=min(limits.memory, QUICK))
    answer = _search(net, Goal.enabled(net, transition), quickly)
    if answer.trace is not None:
        return replace(answer, trace=(*answer.trace, transition))
    if answer.status != "unknown" or answer.reason == INTERRUPTED or limits.is_over:
        return answer
    reduction = reduce(net, {Property.LTL_WITHOUT_NEXT}, observed_transitions=[name])
    smaller = reduction.net
    answer = _search(smaller, Goal.enabled(smaller, name), limits)
    if answer.trace is None:
        return answer
    index = {name: number for number, name in enumerate(net.transitions)}
    names = reduction.expand([*(smaller.transitions[number] for number in answer.trace), name])
    trace = _to_goal(net, Goal.enabled(net, transition), [index[name] for name in names[:-1]])
    return Answer("reachable", (*trace, transition))


def way_to_firing(space: SymbolicStateSpace, names: Names, transition: int) -> tuple[int, ...]:
    """Return a firing sequence that ends with a transition, where some reachable marking enables it.

    It is led by the diagram of all reachable markings, so that it is found however far away it is; a shortest
    one it need not be. Of the markings that enable the transition one is chosen: what leads to any of them
    can take far more nodes.

    Raises
    ------
    DiagramMemoryError
        If memory runs out.
    """
    ways = SymbolicSets(space, BoundAtoms(space.net, Constant(True), names))
    sets, all_of_them = ways.sets, space.diagram.root
    with Scope(space.diagram) as scope:
        others = sets.without_boxes(all_of_them, space.event_masks(transition))
        scope.hold(others)
        enabling = sets.difference(all_of_them, others)
        scope.hold(enabling)
        goal = sets.some(enabling)
        scope.hold(goal)
        way = ways.way_to(goal)
    return (*_to_goal(space.net, Goal.enabled(space.net, transition), way), transition)


def find_deadlock(
    net: CompiledNet,
    memory: int,
    progress: Callable[[Any], None] | None = None,
    order: Order = "breadth-first",
    seconds: float | None = None,
) -> Answer:
    """Find a trace to a marking that enables nothing; stubborn sets leave out needless interleavings."""
    return _search(net, Goal.deadlock(), _Limits.of(memory, progress, order, seconds))


def find_marking(
    net: CompiledNet,
    text: str,
    names: Names,
    memory: int,
    progress: Callable[[Any], None] | None = None,
    order: Order = "breadth-first",
    seconds: float | None = None,
) -> Answer:
    """Find a trace to a marking that fulfils a condition, a shortest one if the search goes breadth first.

    Raises
    ------
    FormulaError
        The text is no condition on markings, or names something unknown.
    """
    condition = parse(text, "state")
    goals = goals_of(net, condition, names)
    limits = _Limits.of(memory, progress, order, seconds)
    if goals is None:
        return _by_temporal_logic(net, condition, names, limits)
    answers: list[Answer] = []
    for goal in goals:
        answers.append(_search(net, goal, limits))
        if answers[-1].reason == INTERRUPTED:
            break
    if not answers:
        return Answer("unreachable", states=0)
    states = [answer.states for answer in answers if answer.states is not None]
    best = min(answers, key=_rank)
    return best if best.status == "reachable" else replace(best, states=max(states, default=None))


def _by_temporal_logic(net: CompiledNet, condition: Formula, names: Names, limits: _Limits) -> Answer:
    """Ask for a run on which a condition never holds: a counterexample leads to it."""
    budget = Budget(limits.memory, seconds=limits.left)
    verdict = verify_ltl(net, Globally(Not(condition)), names, budget=budget, progress=limits.progress)
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


@dataclass(frozen=True)
class _Limits:
    """What a question may cost, who is told how far it is, and in which order it searches."""

    memory: int
    progress: Callable[[Any], None] | None
    order: Order
    until: float | None

    @classmethod
    def of(
        cls, memory: int, progress: Callable[[Any], None] | None, order: Order, seconds: float | None
    ) -> _Limits:
        return cls(memory, progress, order, None if seconds is None else time.perf_counter() + seconds)

    @property
    def left(self) -> float | None:
        """Seconds left."""
        return None if self.until is None else max(0.0, self.until - time.perf_counter())

    @property
    def is_over(self) -> bool:
        """Whether time is up."""
        return self.left == 0


def _search(net: CompiledNet, goal: Goal, limits: _Limits) -> Answer:
    memory, order = limits.memory, limits.order

    def tell(markings: int, rate: float, size: int) -> None:
        if limits.progress is not None:
            limits.progress(Seen(markings, rate, size))

    def search(share: int) -> Found | Unreachable | Unknown:
        reduction: Literal["stubborn"] | None = "stubborn" if goal.is_deadlock else None
        return find(
            net,
            goal,
            memory=share,
            seconds=limits.left,
            progress=tell,
            reduction=reduction,
            order=order,
        )

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
