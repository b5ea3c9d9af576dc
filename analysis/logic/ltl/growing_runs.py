"""LTL on nets with an infinite state space: runs that repeat a loop although tokens grow.

Such a net is examined by three derived nets. If only places grow from which no transition takes tokens, these
are limited as far as the formula cannot distinguish, and the answer is exact. If unbounded places are limited
with loss of tokens, a counterexample has a loop that takes nothing in the net itself; so has a loop found at
once by a search of the net itself. It can be repeated forever, and after some rounds every atom keeps its
value, which is computed, so that the formula is evaluated on the run by its definition. If unbounded places
are removed, more runs are possible: a formula that holds for all of them holds for the net.

References
----------
J. Esparza, *On the decidability of model checking for several mu-calculi and Petri nets*, CAAP 1994, LNCS 787
(which formulas are decidable).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Attempt, Share, first_result
from dineros.analysis.covering.bounded_part import (
    bounded_part,
    free_transitions,
    unbounded_places,
    without_places,
)
from dineros.analysis.covering.growing import (
    Limited,
    growing_places,
    largest_weights,
    limited,
    without_growth,
)
from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, SomeEnabled, all_resolved
from dineros.analysis.logic.language.names import LimitedNames, Names
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.logic.ltl.near_lassos import near_lassos
from dineros.analysis.logic.verdicts.verdict import ReplayError, settled, unfair_to
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import Pumping, coverability

MANY_STATES = 300_000
"""Number of states of a product from which on boundedness is checked."""

NODES = 2_000
"""Maximum number of nodes of the tree for this check."""

ROOM = (0, 1, 3)
"""Tokens of an unbounded place beyond the number that a formula can distinguish."""

MOST_STATES = 300_000
"""Maximum number of states of the product with a derived net."""

NEAR_MARKINGS = 2_000
"""Number of markings in which loops are searched that refute the formula directly."""

SMALL_TREE, DEADLOCKS = Share(time=0.1), Share(time=0.5)
"""Shares of this check, and of the proof that the net without unbounded places has no deadlock."""

Verify = Callable[[CompiledNet, Formula, Names, Iterable[str], Iterable[str], Budget], Outcome]
"""`verify_ltl`."""


class EndlessError(Exception):
    """There are infinitely many markings."""

    def __init__(self, pumping: Pumping) -> None:
        super().__init__()
        self.pumping = pumping


def watching(budget: Budget, net: CompiledNet) -> Budget:
    """Return a budget that raises `EndlessError` once there are many states and the net is unbounded."""
    has_looked = False

    def tell(progress: Progress) -> None:
        nonlocal has_looked
        if budget.progress is not None:
            budget.progress(progress)
        if has_looked or progress.count < MANY_STATES:
            return
        has_looked = True
        if unbounded_places(net):
            pumping = coverability(net, NODES, SMALL_TREE.share(budget), only_boundedness=True).pumping
            if pumping is not None:
                raise EndlessError(pumping)

    return replace(budget, progress=tell)


def endless_text(net: CompiledNet, pumping: Pumping) -> str:
    """Describe which places grow, and how."""
    grown = ", ".join(net.places[place] for place in pumping.places)
    loop = ", ".join(net.transitions[t] for t in pumping.suffix)
    return f"there are infinitely many, because {grown} grows whenever these fire again: {loop}"


@dataclass(frozen=True)
class EndlessRuns:
    """A formula and an unbounded net.

    Attributes
    ----------
    verify : callable
        Decides the formula on a bounded net.
    """

    net: CompiledNet
    formula: Formula
    atoms: BoundAtoms
    names: Names
    weak: tuple[str, ...]
    strong: tuple[str, ...]
    verify: Verify

    @property
    def _fair(self) -> tuple[list[int], list[int]]:
        """Transitions that are weakly fair, and those that are strongly fair."""
        return all_resolved(self.names, self.weak), all_resolved(self.names, self.strong)

    def decide(self, budget: Budget) -> Outcome | None:
        """Return the answer; None: it is unknown."""
        attempts = (
            Attempt(self._without_counters),
            Attempt(self._refuted_nearby, time=0.1),
            *(Attempt(partial(self._refuted, room), time=0.3, most_states=MOST_STATES) for room in ROOM),
            Attempt(self._proved),
        )
        return first_result(attempts, budget)

    def _without_counters(self, budget: Budget) -> Outcome | None:
        compared = compared_tokens(self.net, self.atoms)
        if compared is None or set(growing_places(self.net)).isdisjoint(unbounded_places(self.net)):
            return None
        small = without_growth(self.net, compared)
        if small is None or unbounded_places(small.net):
            return None
        answer = self._ask(small, budget)
        if answer.status == "violated":
            return self._shown(small.back(answer.stem), small.back(answer.loop), answer)
        return answer if answer.status == "holds" else None

    def _refuted_nearby(self, budget: Budget) -> Outcome | None:
        for stem, loop in near_lassos(self.net, NEAR_MARKINGS, budget):
            shown = self._shown(stem, loop, Outcome("violated"))
            if shown is not None:
                return shown
        return None

    def _refuted(self, room: int, budget: Budget) -> Outcome | None:
        weights, compared = largest_weights(self.net), compared_tokens(self.net, self.atoms) or {}
        limits = {
            place: max(weights[place], compared.get(place, 0), int(self.net.initial[place]), 1) + room
            for place in unbounded_places(self.net)
        }
        lossy = limited(self.net, limits)
        answer = self._ask(lossy, budget)
        if answer.status != "violated":
            return None
        return self._shown(lossy.back(answer.stem), lossy.back(answer.loop), answer)

    def _proved(self, budget: Budget) -> Outcome | None:
        left_out = unbounded_places(self.net)
        free = set(free_transitions(self.net, left_out))
        for condition in self.atoms.conditions.values():
            if isinstance(condition, Linear) and not left_out.isdisjoint(condition.factors):
                return None
            if isinstance(condition, SomeEnabled) and not free.issuperset(condition.transitions):
                return None
        if not free.issuperset(chain(*self._fair)) or len(left_out) == len(self.net.places):
            return None
        # A run that ends in a deadlock would not be a run of the remaining net.
        if not bounded_part(self.net, DEADLOCKS.share(budget)).has_no_deadlock:
            return None
        kept = [place for place in range(len(self.net.places)) if place not in left_out]
        same = tuple(range(len(self.net.transitions)))
        part = Limited(without_places(self.net, left_out), same, {p: q for q, p in enumerate(kept)})
        answer = self._ask(part, budget)
        return answer if answer.status == "holds" else None

    def _ask(self, small: Limited, budget: Budget) -> Outcome:
        names = LimitedNames(self.names, small.place, small.images())
        return self.verify(small.net, self.formula, names, self.weak, self.strong, budget)

    def _shown(self, stem: tuple[int, ...], loop: tuple[int, ...], answer: Outcome) -> Outcome | None:
        """Return a counterexample that is valid in the net itself; None: it is not."""
        try:
            first, again = settled(self.net, self.atoms, stem, loop)
        except ReplayError:
            return None
        if holds_on_lasso(self.formula, first, again, self.atoms.is_true):
            return None
        unfair = unfair_to(self.net, again, *self._fair)
        return None if unfair else replace(answer, trace=stem, loop=loop)


def compared_tokens(net: CompiledNet, atoms: BoundAtoms) -> Mapping[int, int] | None:
    """For each place, the number of tokens from which on no atom distinguishes more; None: there is none."""
    compared: dict[int, int] = {}
    growing = set(growing_places(net))
    for condition in atoms.conditions.values():
        if isinstance(condition, Linear):
            factors = list(condition.factors.values())
            if len(factors) > 1 and min(factors) < 0 and not growing.isdisjoint(condition.factors):
                return None
            for place, factor in condition.factors.items():
                compared[place] = max(compared.get(place, 0), abs(condition.bound) // abs(factor) + 1)
    return compared
