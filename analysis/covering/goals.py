"""Goals of a search as transitions that are enabled exactly in the markings that fulfil a goal.

So all methods for transitions apply to goals: places that only grow are limited as far as the goal cannot
distinguish, the state equation guides the search, and trees prove that a goal is unreachable.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.covering.firings import firings
from dineros.analysis.explicit.goals import Comparison, Goal, Relation
from dineros.analysis.nets.compiled import CompiledNet, Transition, unused

_Sum = frozenset[tuple[int, int]]
"""A weighted sum of tokens: factors by place."""

_Limits = tuple[dict[_Sum, int], dict[_Sum, int]]
"""For each sum of tokens: its least value; and the least value that is too large."""


def decide_goal(net: CompiledNet, goal: Goal, budget: Budget) -> Outcome | None:
    """Decide whether a goal can be reached, even if the state space is infinite.

    Returns
    -------
    Outcome or None
        ``reachable`` with a trace, ``unreachable``, or None if it is unknown.
    """
    if goal.is_deadlock:
        found = firings(net, budget, [])
        if found.deadlock is not None:
            return Outcome("reachable", found.deadlock)
        return Outcome("unreachable") if found.has_no_deadlock else None
    asked = with_goals(net, [goal])
    if asked is None:
        return None
    wanted = asked.transitions
    known = firings(asked.net, budget, wanted, asks_deadlock=False)
    if not known.traces.keys().isdisjoint(wanted):
        return Outcome("reachable", asked.way(known.way_to(wanted)[:-1]))
    return Outcome("unreachable") if known.dead.issuperset(wanted) else None


@dataclass(frozen=True)
class WithGoals:
    """A net with transitions that are enabled exactly in the markings that fulfil a goal.

    Attributes
    ----------
    net : CompiledNet
        The net. Its own transitions keep their numbers.
    transitions : tuple of int
        The transitions for the goals; some may be the net's own transitions.
    own : int
        Number of the net's own transitions.
    """

    net: CompiledNet
    transitions: tuple[int, ...]
    own: int

    def way(self, firings: Iterable[int]) -> tuple[int, ...]:
        """Return the same sequence in the original net; the added transitions change nothing."""
        return tuple(t for t in firings if t < self.own)


def with_goals(net: CompiledNet, goals: Sequence[Goal]) -> WithGoals | None:
    """Return a net with transitions for goals other than deadlocks; None: a goal cannot be expressed."""
    own = [t for goal in goals for t in goal.transitions]
    limits = [_limits(conjunction) for goal in goals for conjunction in goal.conjunctions]
    kept = [each for each in limits if each is not None]
    if len(kept) < len(limits):
        return None
    if not kept:
        return WithGoals(net, tuple(own), len(net.transitions))
    count = len(net.transitions)
    return WithGoals(_with_transitions(net, kept), (*own, *range(count, count + len(kept))), count)


def _limits(conjunction: Sequence[Comparison]) -> _Limits | None:
    """Return the limits of sums of tokens in a conjunction; None: it has another kind of condition.

    All factors of a sum are positive, so that it is the number of tokens on an additional place.
    """
    least: dict[_Sum, int] = {}
    below: dict[_Sum, int] = {}
    for comparison in conjunction:
        relation, value = comparison.relation, comparison.value
        factors = {place: factor for place, factor in comparison.weights.items() if factor}
        if factors and max(factors.values()) < 0:
            factors = {place: -factor for place, factor in factors.items()}
            relation, value = _TURNED.get(relation, relation), -value
        if not factors or min(factors.values()) < 0 or relation == "!=":
            return None
        key = frozenset(factors.items())
        if relation in (">=", ">", "="):
            least[key] = max(least.get(key, 0), value + (relation == ">"))
        if relation in ("<=", "<", "="):
            most = value + (relation != "<")
            below[key] = min(below.get(key, most), most)
    return least, below


_TURNED: dict[Relation, Relation] = {"<=": ">=", ">=": "<=", "<": ">", ">": "<"}


def _with_transitions(net: CompiledNet, goals: Sequence[_Limits]) -> CompiledNet:
    """Return the net with a transition for each goal, which changes no tokens, after all others."""
    tokens, rows = net.by_names()
    never = unused("never", tokens)
    sums = _with_sums(net, {key for limits in goals for part in limits for key in part}, tokens, rows)
    for number, (least, below) in enumerate(goals):
        reads = {sums[key]: wanted for key, wanted in least.items() if wanted > 0}
        name = unused(f"goal {number}", net.transitions)
        if min(below.values(), default=1) <= 0:
            tokens[never] = 0
            reads = {never: 1}
        inhibitors = {sums[key]: w for key, w in below.items() if w > 0}
        rows.append(Transition(name, {}, {}, inhibitors, reads))
    return CompiledNet.build(tokens, rows)


def _with_sums(
    net: CompiledNet, keys: Iterable[_Sum], tokens: dict[str, int], rows: list[Transition]
) -> dict[_Sum, str]:
    """Add a place for each sum of tokens; return their names; a sum of one place is that place."""
    named: dict[_Sum, str] = {}
    for key in sorted(keys, key=sorted):
        factors = dict(key)
        if list(factors.values()) == [1]:
            named[key] = net.places[next(iter(factors))]
            continue
        name = named[key] = unused(f"sum {len(named)}", tokens)
        tokens[name] = sum(factor * int(net.initial[p]) for p, factor in factors.items())
        for t, row in enumerate(rows):
            gain = sum(factors.get(p, 0) * n for p, n in net.delta[t].items())
            if gain > 0:
                rows[t] = row._replace(outputs={**row.outputs, name: gain})
            elif gain < 0:
                rows[t] = row._replace(inputs={**row.inputs, name: -gain})
    return named
