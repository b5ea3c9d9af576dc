"""Structure of nets: place invariants as exact integers, computed with limited work.

A *place invariant* is an integer weighting y of the places with y . C = 0 (C the incidence matrix): y . m
is the same in every reachable marking m. A *semiflow* is a non-negative one. A weighting with y . C <= 0
only bounds: y . m never grows; it is called a *bounding weighting* here.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection
from dataclasses import dataclass
from math import gcd

from dineros.analysis.nets.compiled import CompiledNet

#: Maximum number of row entries written by elimination: a second or two.
ELIMINATION_WORK = 4_000_000


@dataclass(frozen=True)
class PlaceInvariant:
    """Weights of places whose weighted sum of tokens is constant.

    Attributes
    ----------
    weights : dict
        Place index -> weight, without zeros.
    constant : int
        Weighted sum in the initial marking.
    """

    weights: dict[int, int]
    constant: int

    @classmethod
    def of(cls, net: CompiledNet, weights: dict[int, int]) -> PlaceInvariant:
        """Return the invariant of a net with the given weights, which are not checked."""
        constant = sum(int(net.initial[p]) * weight for p, weight in weights.items())
        return cls(dict(sorted(weights.items())), constant)


def place_invariants(net: CompiledNet, work: int = ELIMINATION_WORK) -> list[PlaceInvariant]:
    """Return a generating set of all integer place invariants of a net.

    Every integer invariant is an integer combination of the returned ones: the rows that become zero when the
    incidence matrix is brought to echelon form by unimodular row operations. If that takes more than `work`
    entries of rows, the rows that are zero by then are returned: a part of such a set.

    References
    ----------
    H. Cohen, *A Course in Computational Algebraic Number Theory*, Springer 1993, section 2.4 (kernel over Z).
    """
    rows: list[dict[int, int]] = [{} for _ in net.places]
    holders: defaultdict[int, set[int]] = defaultdict(set)
    for t, change in enumerate(net.delta):
        for p, tokens in change.items():
            rows[p][t] = tokens
            holders[t].add(p)
    weights: list[dict[int, int]] = [{p: 1} for p in range(len(net.places))]
    alive = set(range(len(net.places)))
    for t in sorted(holders, key=lambda t: len(net.delta[t])):
        # Euclid's algorithm on the column keeps every step unimodular, so the kernel is generated over the
        # integers.
        while len(holders[t]) > 1 and work > 0:
            pivot = min(holders[t], key=lambda r: (abs(rows[r][t]), len(rows[r]), len(weights[r]), r))
            for r in sorted(holders[t] - {pivot}):
                factor = rows[r][t] // rows[pivot][t]
                work -= len(rows[pivot]) + len(weights[pivot])
                _subtract(weights[r], weights[pivot], factor)
                _subtract(rows[r], rows[pivot], factor)
                for column in rows[pivot]:
                    (holders[column].add if column in rows[r] else holders[column].discard)(r)
        if work <= 0:
            return [PlaceInvariant.of(net, weights[r]) for r in sorted(alive) if not rows[r]]
        for r in holders[t].copy():
            alive.discard(r)
            for column in rows[r]:
                holders[column].discard(r)
    return [PlaceInvariant.of(net, weights[r]) for r in sorted(alive)]


def proportional_places(net: CompiledNet) -> list[PlaceInvariant]:
    """Return the invariants of two places, and of constant places, found by hashing even in large nets.

    Two places have one if every transition changes one of them in proportion to the other: a place and its
    complement, or two places in sequence.
    """
    changes: list[dict[int, int]] = [{} for _ in net.places]
    for t, change in enumerate(net.delta):
        for p, tokens in change.items():
            changes[p][t] = tokens
    first: dict[tuple[tuple[int, int], ...], tuple[int, int]] = {}
    found = []
    for p, row in enumerate(changes):
        if not row:
            found.append(PlaceInvariant.of(net, {p: 1}))
            continue
        common = gcd(*row.values())
        scale = common if next(iter(row.values())) > 0 else -common
        other, factor = first.setdefault(tuple((t, n // scale) for t, n in row.items()), (p, scale))
        if other != p:
            shared = gcd(scale, factor) if scale > 0 else -gcd(scale, factor)
            found.append(PlaceInvariant.of(net, {other: scale // shared, p: -factor // shared}))
    return found


def _subtract(row: dict[int, int], other: dict[int, int], factor: int) -> None:
    for key, value in other.items():
        result = row.get(key, 0) - factor * value
        if result:
            row[key] = result
        else:
            row.pop(key, None)


def never_possible(net: CompiledNet, dead: Collection[int] = ()) -> set[int]:
    """Return transitions that never fire even if no firing took tokens away, besides dead ones.

    This is the relaxed reachability of J. Hoffmann, B. Nebel, *The FF planning system*, JAIR 14, 2001.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 0, "b": 0}, [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {})])
    >>> never_possible(net)
    {0, 1}
    """
    count = len(net.transitions)
    raised: set[int] = set()
    possible: set[int] = set()
    waiting = list(range(count))
    while waiting:
        transition = waiting.pop()
        if transition in possible or transition in dead:
            continue
        if all(p in raised or net.initial[p] >= weight for p, weight in net.pre.row(transition)):
            possible.add(transition)
            for place, tokens in net.delta[transition].items():
                if tokens > 0 and place not in raised:
                    raised.add(place)
                    waiting.extend(net.consumers[place])
    return set(range(count)) - possible - set(dead)
