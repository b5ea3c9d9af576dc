"""Unbounded growth of tokens, and remedies for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Attempt, Share, first_result
from dineros.analysis.covering.bounded_part import without_places
from dineros.analysis.covering.growing import growing_places
from dineros.analysis.covering.tree import tree_of
from dineros.analysis.explicit import explore
from dineros.analysis.nets.bounds import integer_weights, place_bounds, weighted_sum
from dineros.analysis.nets.compiled import CompiledNet, unused
from dineros.analysis.nets.coverability import Pumping, coverability
from dineros.analysis.nets.linear_programs import LinearProgram
from dineros.analysis.walks.first_round import first_round

FEW_NODES = 1_000
"""Nodes of the coverability tree before walks are tried: a fraction of a second."""

NEAR = 100_000
"""Markings of the search for growth that inhibitor arcs do not stop."""


FIRST = Share(time=0.05)
"""Share of a small coverability tree."""


def near_growth(net: CompiledNet, budget: Budget) -> list[Pumping]:
    """Return proofs that places are unbounded, found near the initial marking or by walks.

    If the coverability tree shows one at once, only this one is returned; else each place that may grow is
    examined.
    """
    growing = [place for place, bound in enumerate(place_bounds(net)) if bound is None]
    if not growing:
        return []
    found = coverability(net, FEW_NODES, FIRST.share(budget), only_boundedness=True)
    if found.pumping is not None:
        return [found.pumping]
    return [] if found.is_bounded else first_round(net, budget, growing=growing).pumpings


def growth_of(net: CompiledNet, budget: Budget) -> Pumping | None:
    """Return a replayed proof that a net is unbounded; None: none was found."""

    def by_tree(budget: Budget) -> Pumping | None:
        return tree_of(net, budget).pumping if net.inhibitor.place.size else None

    attempts = (
        Attempt(lambda share: coverability(net, budget=share, only_boundedness=True).pumping, time=0.3),
        Attempt(by_tree, time=0.3),
        Attempt(lambda share: explore(net, share).pumping, time=0.3, most_states=NEAR),
    )
    return first_result(attempts, budget)


@dataclass(frozen=True)
class Remedy:
    """Credits that bound a net: a transition that adds tokens waits until others have removed some.

    Attributes
    ----------
    weights : dict of int to int
        The places, and the credits for each of their tokens.
    credits : int
        Total number of credits, including those of the initial tokens.
    waiting, acknowledging : tuple of int
        Transitions that take credits, and that return some.
    counters : tuple of int
        Places from which no transition takes tokens: they must be removed or limited.
    """

    weights: dict[int, int]
    credits: int
    waiting: tuple[int, ...]
    acknowledging: tuple[int, ...]
    counters: tuple[int, ...]


def remedy_of(net: CompiledNet) -> Remedy | None:
    """Search for credits with which the net is provably bounded; None: none were found.

    A linear program proposes weights of all unbounded places, such that few transitions increase their sum. A
    place of credits keeps the weighted sum below a number: for one place, this is a capacity; for several, an
    acknowledgement.
    """
    counters = growing_places(net)
    small = without_places(net, counters)
    weights = _proposed(small)
    if weights is None:
        return None
    gains = [sum(weights.get(p, 0) * n for p, n in change.items()) for change in small.delta]
    # Enough credits for each step that takes some, and for some step that returns them.
    asked = [
        sum(weights.get(p, 0) * n for p, n in small.pre.row(t)) for t, gain in enumerate(gains) if gain < 0
    ]
    most = max(weighted_sum(small, weights) + max(gains, default=0), min(asked, default=0))
    if any(bound is None for bound in place_bounds(with_credits(small, weights, most))):
        return None
    back = [place for place in range(len(net.places)) if place not in counters]
    return Remedy(
        {back[p]: weight for p, weight in weights.items()},
        most,
        tuple(t for t, gain in enumerate(gains) if gain > 0),
        tuple(t for t, gain in enumerate(gains) if gain < 0),
        counters,
    )


def _proposed(net: CompiledNet) -> dict[int, int] | None:
    """Return weights of at least one for each unbounded place."""
    places, transitions = len(net.places), len(net.transitions)
    low = np.zeros(places + transitions)
    for place, bound in enumerate(place_bounds(net)):
        low[place] = bound is None
    # Unknowns: the weights, and an upper bound of the increase of their sum for each transition.
    rows = [{**change, places + t: -1} for t, change in enumerate(net.delta)]
    costs = np.concatenate([np.full(places, 1e-3), np.ones(transitions)])
    found = LinearProgram(rows, places + transitions).solve(
        costs, np.zeros(transitions), low, np.full(places + transitions, np.inf)
    )
    return None if found is None else integer_weights(found[:places])


def with_credits(net: CompiledNet, weights: Mapping[int, int], most: int) -> CompiledNet:
    """Return the net with a place of credits: a weighted sum of tokens never exceeds a number."""
    (tokens, rows), credits = net.by_names(), unused("credits", net.places)
    for t, row in enumerate(rows):
        gain = sum(weights.get(p, 0) * n for p, n in net.delta[t].items())
        if gain > 0:
            rows[t] = row._replace(inputs={**row.inputs, credits: gain})
        elif gain < 0:
            rows[t] = row._replace(outputs={**row.outputs, credits: -gain})
    return CompiledNet.build(tokens | {credits: most - weighted_sum(net, dict(weights))}, rows)
