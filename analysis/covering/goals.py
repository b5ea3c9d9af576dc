"""Goals of a search as transitions: one that is enabled exactly where a goal is met.

Then all that is known of transitions answers for goals too: places that only grow stop where the goal cannot
tell more apart, the state equation leads to it, and trees prove it out of reach.
"""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.covering.firings import firings
from dineros.analysis.explicit.goals import Comparison, Goal
from dineros.analysis.nets.compiled import CompiledNet, Transition, unused

_Limits = tuple[dict[int, int], dict[int, int]]
"""By place: at least so many tokens; fewer than so many."""


def decide_goal(net: CompiledNet, goal: Goal, budget: Budget) -> Outcome | None:
    """Find out whether a goal can be met, where markings may have no end.

    Parameters
    ----------
    net : CompiledNet
        The net.
    goal : Goal
        The goal.
    budget : Budget
        What it may cost.

    Returns
    -------
    Outcome or None
        ``reachable`` with a trace, ``unreachable``, or None where it is not known.
    """
    count = len(net.transitions)
    if goal.is_deadlock:
        found = firings(net, budget, [])
        if found.deadlock is not None:
            return Outcome("reachable", found.deadlock)
        return Outcome("unreachable") if found.has_no_deadlock else None
    asked, wanted = net, list(goal.transitions)
    if goal.conjunctions:
        limits = [_limits(conjunction) for conjunction in goal.conjunctions]
        kept = [each for each in limits if each is not None]
        if len(kept) < len(limits):
            return None
        asked, wanted = _with_transitions(net, kept), list(range(count, count + len(kept)))
    known = firings(asked, budget, wanted, asks_deadlock=False)
    traces = [known.traces[t][:-1] for t in wanted if t in known.traces]
    if traces:
        return Outcome("reachable", min(traces, key=len))
    return Outcome("unreachable") if known.dead.issuperset(wanted) else None


def _limits(conjunction: Sequence[Comparison]) -> _Limits | None:
    """Return what a conjunction asks of single places; None where it asks for something else."""
    least: dict[int, int] = {}
    below: dict[int, int] = {}
    for weights, relation, value in conjunction:
        factors = {place: factor for place, factor in weights.items() if factor}
        if list(factors.values()) != [1] or relation == "!=":
            return None
        (place,) = factors
        if relation in (">=", ">", "="):
            least[place] = max(least.get(place, 0), value + (relation == ">"))
        if relation in ("<=", "<", "="):
            most = value + (relation != "<")
            below[place] = min(below.get(place, most), most)
    return least, below


def _with_transitions(net: CompiledNet, goals: Sequence[_Limits]) -> CompiledNet:
    """Return the net with a transition for each goal, which changes nothing, behind all others."""
    names, (tokens, rows) = net.places, net.by_names()
    never = unused("never", tokens)
    for number, (least, below) in enumerate(goals):
        reads = {names[p]: tokens_there for p, tokens_there in least.items() if tokens_there > 0}
        name = unused(f"goal {number}", net.transitions)
        if min(below.values(), default=1) <= 0:
            tokens[never] = 0
            reads = {never: 1}
        inhibitors = {names[p]: w for p, w in below.items() if w > 0}
        rows.append(Transition(name, {}, {}, inhibitors, reads))
    return CompiledNet.build(tokens, rows)
