"""Reaching a goal: a transition enabled, or a condition on the marking (paper, Alg. 5)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from dineros.analysis.compiled import CompiledNet
from dineros.analysis.explicit import Found, Unknown, Unreachable, find
from dineros.analysis.explicit_goals import Comparison, Goal, Relation
from dineros.analysis.logic.atoms import BoundAtoms, Linear, Step
from dineros.analysis.logic.budget import Budget
from dineros.analysis.logic.lasso import holds_on_lasso
from dineros.analysis.logic.ltl import verify_ltl
from dineros.analysis.logic.names import Names
from dineros.analysis.logic.parser import parse
from dineros.analysis.logic.syntax import And, Atom, Formula, Globally, Not
from dineros.analysis.reductions import Property, reduce

QUICK = 256 << 20
"""Bytes for the search for a shortest trace, before the net is reduced."""


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
    net: CompiledNet, name: str, names: Names, memory: int, progress: Callable[[Any], None] | None = None
) -> Answer:
    """Find a trace that ends with a transition; of several of the name, whichever is nearest.

    Raises
    ------
    FormulaError
        No transition has the name.
    """
    answers = [find_firing(net, transition, memory, progress) for transition in names.transitions(name)]
    return min(answers, key=_rank)


def find_firing(
    net: CompiledNet, transition: int, memory: int, progress: Callable[[Any], None] | None = None
) -> Answer:
    """Find a trace that ends with a transition: a shortest one, unless only the reduced net is small enough.

    Reduction by rules that preserve LTL without next keeps whether the transition ever fires; a trace of the
    reduced net is mapped back.
    """
    name = net.transitions[transition]
    answer = _search(net, Goal.enabled(net, transition), min(memory, QUICK), (transition,), progress)
    if answer.status != "unknown":
        return answer
    reduction = reduce(net, {Property.LTL_WITHOUT_NEXT}, observed_transitions=[name])
    smaller = reduction.net
    answer = _search(smaller, Goal.enabled(smaller, name), memory, (), progress)
    if answer.trace is None:
        return answer
    index = {name: number for number, name in enumerate(net.transitions)}
    trace = reduction.expand([*(smaller.transitions[number] for number in answer.trace), name])
    return Answer("reachable", tuple(index[name] for name in trace))


def find_deadlock(net: CompiledNet, memory: int, progress: Callable[[Any], None] | None = None) -> Answer:
    """Find a trace to a marking that enables nothing; stubborn sets leave out needless interleavings."""
    return _search(net, Goal.deadlock(), memory, (), progress, stubborn=True)


def find_marking(
    net: CompiledNet, text: str, names: Names, memory: int, progress: Callable[[Any], None] | None = None
) -> Answer:
    """Find a trace to a marking that fulfils a condition; a shortest one where that is a conjunction.

    Raises
    ------
    FormulaError
        The text is no condition on markings, or names something unknown.
    """
    condition = parse(text, "state")
    goal = _conjunction(net, condition, names)
    if goal is not None:
        return _search(net, goal, memory, (), progress)
    # Any condition: a run on which it never holds is wanted, so a counterexample leads to it.
    verdict = verify_ltl(net, Globally(Not(condition)), names, budget=Budget(memory), progress=progress)
    if verdict.status == "violated":
        return Answer("reachable", _shortest_prefix(net, condition, names, verdict.stem + verdict.loop))
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
    last: tuple[int, ...],
    progress: Callable[[Any], None] | None,
    stubborn: bool = False,
) -> Answer:
    def tell(markings: int, rate: float, size: int) -> None:
        if progress is not None:
            progress(Seen(markings, rate, size))

    match find(net, goal, memory=memory, progress=tell, reduction="stubborn" if stubborn else None):
        case Found(trace, _):
            return Answer("reachable", (*trace, *last))
        case Unreachable(states):
            return Answer("unreachable", states=states)
        case Unknown(reason, states):
            return Answer("unknown", states=states, reason=f"{reason} ran out")


@dataclass(frozen=True)
class Seen:
    """How far an explicit search is: markings stored, markings a second, bytes."""

    markings: int
    rate: float
    bytes: int


def _conjunction(net: CompiledNet, condition: Formula, names: Names) -> Goal | None:
    """Return a conjunction of comparisons as a goal; None for any other condition."""
    parts: Sequence[Formula] = condition.operands if isinstance(condition, And) else (condition,)
    bound = BoundAtoms(net, condition, names)
    comparisons: list[Comparison] = []
    for part in parts:
        linear = bound.conditions.get(part) if isinstance(part, Atom) else None
        if not isinstance(linear, Linear):
            return None
        comparisons.append(Comparison(linear.factors, _RELATIONS[linear.operator], linear.bound))
    return Goal(conjunctions=(tuple(comparisons),))


_RELATIONS: dict[str, Relation] = {"<": "<", "<=": "<=", "==": "=", "!=": "!=", ">=": ">=", ">": ">"}


def _shortest_prefix(
    net: CompiledNet, condition: Formula, names: Names, trace: Sequence[int]
) -> tuple[int, ...]:
    """Return the trace up to the first marking that fulfils the condition."""
    bound = BoundAtoms(net, condition, names)
    marking = net.initial.tolist()
    for length, transition in enumerate([*trace, -1]):
        if holds_on_lasso(condition, [], [Step(tuple(marking), None)], bound.is_true):
            return tuple(trace[:length])
        if transition >= 0:
            marking = net.fire(transition, marking)
    raise AssertionError("the counterexample does not reach the condition")
