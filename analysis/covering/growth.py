"""How tokens grow without bound, and what would end it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dineros.analysis.answers.budget import Budget
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
"""Nodes of the coverability tree that are made before walks are tried: part of a second."""

NEAR = 100_000
"""Markings of the search for a way to grow that inhibitor arcs do not stop."""


def near_growth(net: CompiledNet, budget: Budget) -> list[Pumping]:
    """Return proofs that places grow without bound, of what is near or met by walks.

    Where the coverability tree shows one at once, that is all; else each place that may grow is looked at.
    """
    growing = [place for place, bound in enumerate(place_bounds(net)) if bound is None]
    if not growing:
        return []
    found = coverability(net, FEW_NODES, budget.share(0.05), only_boundedness=True)
    if found.pumping is not None:
        return [found.pumping]
    return [] if found.is_bounded else first_round(net, budget, growing=growing).pumpings


def growth_of(net: CompiledNet, budget: Budget) -> Pumping | None:
    """Return a proof that a net is unbounded, replayed; None where none was found."""
    budget = budget.begun()
    found = coverability(net, budget=budget.share(0.3), only_boundedness=True).pumping
    if found is None and net.inhibitor.place.size:
        found = tree_of(net, budget.share(0.3)).pumping
    if found is None:
        found = explore(net, budget.share(0.3, most_states=NEAR)).pumping
    return found


@dataclass(frozen=True)
class Remedy:
    """Credits with which a net is bounded: who puts more tokens on some places waits until others took some.

    Attributes
    ----------
    weights : dict of int to int
        The places, and how many credits each of their tokens takes.
    credits : int
        How many there are in all, those of the initial tokens included.
    waiting, acknowledging : tuple of int
        Transitions that take credits, and that give some back.
    counters : tuple of int
        Places that nothing takes from: they have to go, or to stop at a number.
    """

    weights: dict[int, int]
    credits: int
    waiting: tuple[int, ...]
    acknowledging: tuple[int, ...]
    counters: tuple[int, ...]


def remedy_of(net: CompiledNet) -> Remedy | None:
    """Look for credits with which a net is bounded, which is proved; None where none were found.

    A linear program proposes weights of all places without a bound that as few transitions as possible raise.
    A place of credits keeps their sum below a number: with one such place it is a capacity, with several of
    them an acknowledgement.
    """
    counters = growing_places(net)
    small = without_places(net, counters)
    weights = _proposed(small)
    if weights is None:
        return None
    gains = [sum(weights.get(p, 0) * n for p, n in change.items()) for change in small.delta]
    # Enough for each step that takes credits, and for some step that gives them back.
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
    """Return weights of at least one for each place without a bound."""
    places, transitions = len(net.places), len(net.transitions)
    low = np.zeros(places + transitions)
    for place, bound in enumerate(place_bounds(net)):
        low[place] = bound is None
    # Unknowns: the weights, and by how much each transition raises their sum at most.
    rows = [{**change, places + t: -1} for t, change in enumerate(net.delta)]
    costs = np.concatenate([np.full(places, 1e-3), np.ones(transitions)])
    found = LinearProgram(rows, places + transitions).solve(
        costs, np.zeros(transitions), low, np.full(places + transitions, np.inf)
    )
    return None if found is None else integer_weights(found[:places])


def with_credits(net: CompiledNet, weights: Mapping[int, int], most: int) -> CompiledNet:
    """Return the net with a place of credits: a weighted sum of tokens never grows above a number."""
    (tokens, rows), credits = net.by_names(), unused("credits", net.places)
    for t, row in enumerate(rows):
        gain = sum(weights.get(p, 0) * n for p, n in net.delta[t].items())
        if gain > 0:
            rows[t] = row._replace(inputs={**row.inputs, credits: gain})
        elif gain < 0:
            rows[t] = row._replace(outputs={**row.outputs, credits: -gain})
    return CompiledNet.build(tokens | {credits: most - weighted_sum(net, dict(weights))}, rows)
