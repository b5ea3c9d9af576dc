"""Proofs by the net without its times, used if there are too many state classes.

Times remove runs and add none. So what never happens without times never happens with times, and a bounded
net stays bounded. A marking that enables a transition is not a deadlock with times either, unless transitions
have priority over each other in a circle.

A weighted sum of tokens proves that time continues: each transition that fires at once makes the sum smaller.

References
----------
P. Gordan, *Ueber die Aufloesung linearer Gleichungen mit reellen Coefficienten*, Math. Annalen 6, 1873: there
are such weights, or some firings at once can repeat.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Stage, run_stages
from dineros.analysis.covering.firings import firings
from dineros.analysis.model.subject import flattened_without_signals
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.linear_programs import LinearProgram, in_whole_numbers
from dineros.analysis.portfolio.budgets import GIVEN_UP
from dineros.analysis.questions.relaxed import Relaxed, bounds_in_time, relaxed
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.timed.nets import TimedNet, compile_timed_net
from dineros.analysis.timed.timed_subject import TimedSubject, signals_matter
from dineros.metamodel import sym
from dineros.metamodel.times.given import says_times


@dataclass(frozen=True)
class WithoutTimes:
    """What is proved."""

    dead: frozenset[str]
    """Names of transitions that never fire."""
    most: int | None = None
    """The most tokens that a place can hold with times; None if nothing proves a bound."""
    markings: int = 0
    """How many there are, if the net is bounded without its times."""
    has_no_deadlock: bool = False
    """Whether each marking enables something that is not a change of a signal."""


def without_times(subject: TimedSubject, budget: Budget, orders: OrderCache | None = None) -> WithoutTimes:
    """Return what is proved of a net without its times, within a budget.

    Signals are left out: without times they forbid nothing, as they may change at any time.
    """
    budget = budget.begun()
    budget.stage("the net without its times")
    timed, model = subject.timed, subject.model
    if isinstance(model, sym.SystemModel) and signals_matter(model):
        timed = compile_timed_net(flattened_without_signals(model, times=says_times(model))[0].net)
    proof = _Proof(subject.timed, timed, timed.untimed.once(relaxed), orders)
    run_stages(proof, PLAN, budget, lambda each: each.known is not None, given_up=GIVEN_UP)
    return proof.known or WithoutTimes(frozenset(), proof.most)


@dataclass
class _Proof:
    """What is asked, and what is proved so far; `timed` is the net without signals."""

    net: TimedNet
    timed: TimedNet
    loose: Relaxed
    orders: OrderCache | None
    space: SymbolicStateSpace | None = None
    most: int | None = None
    known: WithoutTimes | None = None

    def make_space(self, budget: Budget) -> None:
        """Explore all markings."""
        space = symbolic_state_space(self.loose.net, budget, orders=self.orders)
        self.space = space if space.complete else None

    def by_all_markings(self, budget: Budget) -> None:
        """Evaluate all markings."""
        assert self.space is not None
        self.known = _proved(self.net, self.timed, self.loose, self.space, budget)

    def by_sums(self, budget: Budget) -> None:
        """Bound the tokens of places by weighted sums of tokens."""
        sums = [bound.value for bound in place_bounds(self.loose.net) if bound is not None]
        if len(sums) < len(self.loose.net.places):
            return
        found = bounds_in_time(self.timed, self.loose, _of_signals(self.net, self.timed), budget)
        bounds = [bound for bound in found.values() if bound is not None]
        if len(bounds) == len(found):
            self.most = max([*sums, *bounds], default=0)

    def by_firings(self, budget: Budget) -> None:
        """Search for what fires, transition by transition."""
        net = self.timed.untimed
        found = firings(net, budget)
        dead = frozenset(net.transitions[t] for t in found.dead)
        self.known = WithoutTimes(dead, self.most, has_no_deadlock=found.has_no_deadlock)


PLAN = (
    Stage(_Proof.make_space, time=0.6),
    Stage(_Proof.by_all_markings, lambda proof: proof.space is not None),
    Stage(_Proof.by_sums, time=0.3),
    Stage(_Proof.by_firings),
)
"""Bounds, and firings one by one, are only asked if there are too many markings."""


def _of_signals(net: TimedNet, timed: TimedNet) -> frozenset[int]:
    """Return the transitions that signals may keep from firing, by their numbers without signals."""
    needs = {name: len(net.untimed.pre.row(t)) for t, name in enumerate(net.untimed.transitions)}
    names = timed.untimed.transitions
    return frozenset(t for t, name in enumerate(names) if needs.get(name) != len(timed.untimed.pre.row(t)))


def _proved(
    net: TimedNet, timed: TimedNet, loose: Relaxed, space: SymbolicStateSpace, budget: Budget
) -> WithoutTimes:
    """Return what all markings prove of a net; `timed` is the net without signals."""
    names = loose.net.transitions
    dead = frozenset(name for name in names if not space.enabled(name))
    most: int | None = max(space.largest_place(), default=0)
    if not loose.places:
        return WithoutTimes(dead, most, space.markings, space.deadlocks() == 0)
    for bound in bounds_in_time(timed, loose, _of_signals(net, timed), budget).values():
        most = None if bound is None or most is None else max(most, bound)
    unchanged = set(range(len(names))) - loose.transitions
    return WithoutTimes(dead, most, has_no_deadlock=loose.some_is_enabled(unchanged, budget))


def time_goes_on(net: TimedNet) -> bool:
    """Return whether weights of tokens prove that transitions which must fire at once have no loop.

    Each transition with the interval ``[0,0]`` must make the weighted sum of tokens smaller. If there are no
    such weights, nothing is known.
    """
    immediate = [t for t, interval in enumerate(net.intervals) if interval.latest == 0]
    if not immediate:
        return True
    deltas = [net.untimed.delta[t] for t in immediate]
    places = len(net.untimed.places)
    program = LinearProgram([{p: float(n) for p, n in delta.items()} for delta in deltas], places)
    proposed = program.solve(
        np.ones(places), np.full(len(deltas), -1.0), np.zeros(places), np.full(places, np.inf)
    )
    if proposed is None:
        return False
    weights, _ = in_whole_numbers(proposed)
    if any(weight < 0 for weight in weights):
        return False
    return all(sum(weights[p] * n for p, n in delta.items()) < 0 for delta in deltas)
