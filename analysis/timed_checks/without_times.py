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

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.covering.firings import firings
from dineros.analysis.model.subject import flattened_without_signals
from dineros.analysis.nets.linear_programs import LinearProgram, in_whole_numbers
from dineros.analysis.nets.models import compile_net
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.timed_subject import TimedSubject, signals_matter
from dineros.metamodel import sym
from dineros.metamodel.times.given import says_times

SPACE_SHARE = 0.6
"""Part of the time for all markings; the rest is for single transitions."""


@dataclass(frozen=True)
class WithoutTimes:
    """What is proved.

    Attributes
    ----------
    dead : frozenset of str
        Names of transitions that never fire.
    most : int or None
        The most tokens that a place can hold; None if the net may be unbounded.
    markings : int
        How many there are, if the net is bounded.
    has_no_deadlock : bool
        Whether each marking enables something that is not a change of a signal.
    """

    dead: frozenset[str]
    most: int | None = None
    markings: int = 0
    has_no_deadlock: bool = False


def without_times(subject: TimedSubject, budget: Budget, orders: OrderCache | None = None) -> WithoutTimes:
    """Return what is proved of a net without its times, within a budget.

    Signals are left out: without times they forbid nothing, as they may change at any time.
    """
    budget = budget.begun()
    budget.stage("the net without its times")
    net, model = subject.net, subject.model
    if isinstance(model, sym.SystemModel) and signals_matter(model):
        net = compile_net(flattened_without_signals(model, times=says_times(model))[0].net)
    try:
        space = symbolic_state_space(net, budget.share(SPACE_SHARE), orders=orders)
        if space.complete:
            dead = frozenset(name for name in net.transitions if not space.enabled(name))
            most = max(space.largest_place(), default=0)
            return WithoutTimes(dead, most, space.markings, space.deadlocks() == 0)
    except (BudgetExceededError, DiagramMemoryError, LevelSizeError, UnknownBoundError):
        pass
    found = firings(net, budget)
    dead = frozenset(net.transitions[t] for t in found.dead)
    return WithoutTimes(dead, has_no_deadlock=found.has_no_deadlock)


def time_goes_on(net: TimedNet) -> bool:
    """Tell whether weights of tokens prove that no infinitely many firings happen in no time.

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
