"""Formulas on unbounded nets, decided on nets in which the growing places are limited.

In the *open* net, a full place represents any number of tokens from the limit on. It can do everything that
the net can, and more: markings that it never reaches, the net never reaches. Without the firings in which a
full place stays full although tokens are taken from it, it is *lossy*: tokens above the limit are lost. Each
run of the lossy net is a run of the net, with more tokens there, if no inhibitor arc tests a growing place.

So a condition can always become true again (``AG EF``) if the lossy net reaches it from all markings that the
open net reaches. It cannot if some run of the net leads to a marking from which the open net cannot reach it.

References
----------
P. Godefroid, M. Huth, R. Jagadeesan, *Abstraction-based model checking using modal transition systems*,
CONCUR 2001, LNCS 2154.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.covering.bounded_part import unbounded_places
from dineros.analysis.covering.growing import Limited, largest_weights, limited
from dineros.analysis.logic.ctl.fixpoints import basic, satisfying
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import LimitedNames, Names
from dineros.analysis.logic.language.syntax import (
    QUANTIFIERS,
    TEMPORAL,
    Comparison,
    Constant,
    Exists,
    Finally,
    ForAll,
    Formula,
    Globally,
    Not,
)
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.saturation import DiagramMemoryError

BY = "decision diagrams of a net with limits"

ROOM = 1
"""Number of tokens of a place beyond the largest weight of an input or inhibitor arc at it."""


def decide_with_limits(
    net: CompiledNet, tree: Formula, names: Names, budget: Budget, most_work: int | None = None
) -> Outcome | None:
    """Decide ``EF p``, ``AG p`` or ``AG EF p`` on a net without proved bounds; None: that failed.

    Parameters
    ----------
    tree : Formula
        A CTL formula whose conditions are comparisons of places with proved bounds.
    most_work : int, optional
        Cache misses of saturation after which it gives up; about three million per second.

    Raises
    ------
    FormulaError
        The formula has an unknown name.
    BudgetExceededError
        The time is over.
    """
    asked = _asked(tree)
    growing = set() if asked is None else unbounded_places(net)
    if asked is None or not growing or len(growing) == len(net.places):
        return None
    condition, is_everywhere = asked
    if not _is_about_others(condition, names, growing):
        return None
    work = _Work(net, names, condition, growing, budget.begun(), most_work)
    try:
        answer = work.stays_possible() if is_everywhere else work.is_reached()
    except (UnknownBoundError, LevelSizeError, DiagramMemoryError, _TooMuchWorkError):
        return None
    if answer is None or is_everywhere or isinstance(tree, Exists):
        return answer
    return work.answer({"holds": "violated", "violated": "holds"}[answer.status], answer.trace)


def _asked(tree: Formula) -> tuple[Formula, bool] | None:
    """Return the condition to be reached, and whether from every marking."""
    match tree:
        case Exists(Finally(condition)):
            found, is_everywhere = condition, False
        case ForAll(Globally(Exists(Finally(condition)))):
            found, is_everywhere = condition, True
        case ForAll(Globally(condition)):
            found, is_everywhere = Not(condition), False
        case _:
            return None
    return (found, is_everywhere) if _is_of_comparisons(found) else None


def _is_of_comparisons(condition: Formula) -> bool:
    if isinstance(condition, (Comparison, Constant)):
        return True
    is_temporal = isinstance(condition, (*TEMPORAL, *QUANTIFIERS))
    return bool(condition.operands) and not is_temporal and all(map(_is_of_comparisons, condition.operands))


def _is_about_others(condition: Formula, names: Names, growing: set[int]) -> bool:
    """Whether no comparison includes tokens of growing places."""
    return all(
        growing.isdisjoint(names.places(name.text))
        for part in condition.subformulas()
        if isinstance(part, Comparison)
        for _, name in part.terms
    )


class _TooMuchWorkError(Exception):
    """The state space needs more work than allowed."""


@dataclass(frozen=True)
class _Work:
    net: CompiledNet
    names: Names
    condition: Formula
    growing: set[int]
    budget: Budget
    most_work: int | None

    @cached_property
    def limits(self) -> Mapping[int, int]:
        weights = largest_weights(self.net)
        return {place: weights[place] and weights[place] + ROOM for place in sorted(self.growing)}

    @cached_property
    def open(self) -> Limited:
        return limited(self.net, self.limits, is_open=True)

    @cached_property
    def lossy(self) -> frozenset[int]:
        """Transitions of the lossy net."""
        return frozenset(range(len(self.open.net.transitions))) - self.open.added

    @cached_property
    def is_inhibited(self) -> bool:
        return not self.growing.isdisjoint(self.net.inhibitor.place.tolist())

    @cached_property
    def space(self) -> SymbolicStateSpace:
        """All markings of the open net."""
        space = symbolic_state_space(self.open.net, self.budget, between=self._look)
        if not space.complete:
            raise DiagramMemoryError
        return space

    def _look(self, work: int) -> None:
        if self.most_work is not None and work > self.most_work:
            raise _TooMuchWorkError

    @cached_property
    def sets(self) -> SymbolicSets:
        names = LimitedNames(self.names, self.open.place, self.open.images())
        return SymbolicSets(self.space, BoundAtoms(self.open.net, self.condition, names), self.budget)

    @cached_property
    def goal(self) -> int:
        wanted = basic(self.condition)
        return self._held(satisfying(wanted, self.sets)[wanted])

    def _held(self, states: int) -> int:
        self.space.diagram.pinned.append(states)
        return states

    def is_reached(self) -> Outcome | None:
        """Decide whether the condition is true in some reachable marking."""
        if self.goal == 0:
            return self.answer("violated")
        way = None if self.is_inhibited else self._way_to(self.goal)
        return None if way is None else self.answer("holds", way)

    def stays_possible(self) -> Outcome | None:
        """Decide whether the condition can become true from every reachable marking."""
        if self.is_inhibited:
            return None
        sets, lossy = self.sets.sets, self.sets.sets.restricted(self.lossy)
        everything = self.sets.everything
        surely = self._held(lossy.closure(self.goal, everything, backwards=True))
        if sets.difference(everything, surely) == 0:
            return self.answer("holds")
        maybe = self._held(sets.closure(self.goal, everything, backwards=True))
        stuck = self._held(sets.difference(everything, maybe))
        for wanted in (stuck, sets.intersection(stuck, self._full)):
            way = self._way_to(self._held(wanted))
            if way is not None and self.sets.contains(stuck, self._seen(replay(self.net, way)[-1])):
                return self.answer("violated", way)
        return None

    @property
    def _full(self) -> int:
        """The markings in which growing places are full: the net may have more tokens there."""
        sets, found = self.sets.sets, self.sets.everything
        for place, limit in self.limits.items():
            if limit:
                weights, constant = self.space.encoding.weights_of({self.open.place[place]: 1})
                full = self._held(sets.sums(weights, limit - constant, None))
                found = self._held(sets.intersection(found, full))
        return found

    def _seen(self, marking: Sequence[int]) -> tuple[int, ...]:
        """Return the marking of the open net for a marking."""
        tokens = [0] * len(self.open.net.places)
        complements = iter(range(len(self.open.place), len(tokens)))
        for place, here in self.open.place.items():
            limit = self.limits.get(place)
            tokens[here] = marking[place] if limit is None else min(marking[place], limit)
        for place in (place for place, limit in self.limits.items() if limit):
            tokens[next(complements)] = self.limits[place] - tokens[self.open.place[place]]
        return tuple(tokens)

    def _way_to(self, wanted: int) -> tuple[int, ...] | None:
        """Return a run of the net that leads the lossy net to some of these markings; None: there is none."""
        sets, lossy = self.sets.sets, self.sets.sets.restricted(self.lossy)
        start = self._held(self.sets.single(tuple(self.open.net.initial.tolist())))
        reached = self._held(lossy.closure(start, self.sets.everything, backwards=False))
        there = self._held(sets.intersection(reached, wanted))
        if there == 0:
            return None
        marking = tuple(self.space.marking_of(sets.some_vector(there)))
        net = limited(self.net, self.limits)
        space = symbolic_state_space(net.net, self.budget)
        if not space.complete:
            raise DiagramMemoryError
        ways = SymbolicSets(space, budget=self.budget)
        way = net.back(ways.way_to(ways.single(marking)))
        replay(self.net, way)  # it is a run of the net
        return way

    def answer(self, status: str, trace: Sequence[int] | None = None) -> Outcome:
        """Return an answer, with the run that shows it."""
        shown = None if trace is None else tuple(trace)
        return Outcome(status, shown, states=self.space.markings, seconds=self.budget.spent, by=BY)
