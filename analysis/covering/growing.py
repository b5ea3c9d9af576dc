"""Places that hold no more than is looked at: counters and logs leave a net, others forget what is too much.

A place that nothing takes from only grows. What compares it with numbers up to K cannot tell K from more, so
it may stop at K: every run of the net is a run of the new one and the other way round, with the same answers.
A place from which nothing is taken and at which nothing looks stops at 0, and leaves the net. Where a place
that is taken from stops at K, what comes on top is lost: the new net has fewer runs, but each is one of the
net, with more tokens there.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from dineros.analysis.nets.compiled import CompiledNet, Transition, unused

Arcs = dict[int, int]
"""Weights by place."""

_Choice = tuple[Arcs, Arcs, dict[str, int], dict[str, int]]
"""Input and output arcs at a place, then at its complement."""


@dataclass(frozen=True)
class Limited:
    """A net in which some places hold no more than a number of tokens.

    Attributes
    ----------
    net : CompiledNet
        It. Places that are left keep their names and their order; behind them stand the complements of places
        with a limit.
    origin : tuple of int
        By transition: the one of the original net that it fires.
    place : dict of int to int
        By place of the original net: the place that stands for it. Places that left the net have none.
    added : frozenset of int
        Transitions by which a full place stays full though tokens are taken from it.
    """

    net: CompiledNet
    origin: tuple[int, ...]
    place: Mapping[int, int]
    added: frozenset[int] = frozenset()

    @classmethod
    def same(cls, net: CompiledNet) -> Limited:
        """Return a net without limits."""
        places, transitions = range(len(net.places)), range(len(net.transitions))
        return cls(net, tuple(transitions), {place: place for place in places})

    def back(self, trace: Iterable[int]) -> tuple[int, ...]:
        """Return the transitions of the original net that a sequence fires."""
        return tuple(self.origin[t] for t in trace)

    def images(self) -> dict[int, list[int]]:
        """Return, by transition of the original net, those that fire it; one without can never fire."""
        images: dict[int, list[int]] = {}
        for number, t in enumerate(self.origin):
            images.setdefault(t, []).append(number)
        return images


def growing_places(net: CompiledNet) -> tuple[int, ...]:
    """Places that some transition puts tokens on and none takes from, those included that are only read."""
    changes: dict[int, list[int]] = {}
    for change in net.delta:
        for place, tokens in change.items():
            changes.setdefault(place, []).append(tokens)
    return tuple(place for place, tokens in sorted(changes.items()) if min(tokens) > 0)


def largest_weights(net: CompiledNet) -> list[int]:
    """By place: the largest weight with which a transition looks at it, by an input or an inhibitor arc."""
    largest = [0] * len(net.places)
    for table in (net.pre, net.inhibitor):
        for place, weight in zip(table.place.tolist(), table.weight.tolist(), strict=True):
            largest[place] = max(largest[place], weight)
    return largest


def without_growth(net: CompiledNet, compared: Mapping[int, int] | None = None) -> Limited | None:
    """Let places that nothing takes from stop where nobody can tell; None where there are none.

    Parameters
    ----------
    net : CompiledNet
        The net.
    compared : mapping of int to int, optional
        By place: the number of tokens from which on a question cannot tell more apart.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "seen": 0}, [("look", {"a": 1}, {"a": 1, "seen": 1})])
    >>> without_growth(net).net.places
    ('a',)
    >>> without_growth(net, {1: 2}).net.places
    ('a', 'seen', 'seen.free')
    """
    growing = growing_places(net)
    if not growing:
        return None
    weights, compared = largest_weights(net), compared or {}
    return limited(net, {place: max(weights[place], compared.get(place, 0)) for place in growing})


def limited(net: CompiledNet, limits: Mapping[int, int], *, is_open: bool = False) -> Limited:
    """Let places hold no more than a limit each; what comes on top is lost.

    A transition that can meet a limit becomes several: one that puts all, and one for each smaller number
    that there is room for. Exactly one of them is enabled where it was.

    Parameters
    ----------
    net : CompiledNet
        The net.
    limits : mapping of int to int
        By place: how many tokens it holds at most.
    is_open : bool
        Whether a full place stands for any number of tokens from its limit on: then it may stay full when
        tokens are taken from it. Such a net can do all that the net can, and more, if no limit is less than a
        weight with which a transition looks at the place.
    """
    names = list(net.places)
    left = [place for place in range(len(names)) if limits.get(place) != 0]
    free = {place: f"{names[place]}.free" for place, limit in sorted(limits.items()) if limit}
    tokens = {names[p]: min(int(net.initial[p]), limits.get(p, int(net.initial[p]))) for p in left}
    for place, name in free.items():
        free[place] = unused(name, tokens)
        tokens[free[place]] = limits[place] - tokens[names[place]]
    rows: list[Transition] = []
    origin: list[int] = []
    added: set[int] = set()
    taken_names: set[str] = set()
    for t, name in enumerate(net.transitions):
        kept = _rows(net, t, limits, names, free, is_open=False)
        every = _rows(net, t, limits, names, free, is_open=True) if is_open else []
        more = [row for row in every if row not in kept]
        added.update(range(len(rows) + len(kept), len(rows) + len(kept) + len(more)))
        for number, row in enumerate([*kept, *more]):
            made_name = unused(name if number == 0 else f"{name}.{number}", taken_names)
            taken_names.add(made_name)
            rows.append(row._replace(name=made_name))
            origin.append(t)
    made = CompiledNet.build(tokens, rows)
    index = {name: place for place, name in enumerate(made.places)}
    place_of = {place: index[names[place]] for place in left}
    return Limited(made, tuple(origin), place_of, frozenset(added))


def _rows(
    net: CompiledNet,
    t: int,
    limits: Mapping[int, int],
    names: Sequence[str],
    free: Mapping[int, str],
    is_open: bool,
) -> list[Transition]:
    """Return what a transition becomes: one for each way in which the limits of its places may be met."""
    inputs, outputs = dict(net.pre.row(t)), dict(net.post.row(t))
    inhibitors = dict(net.inhibitor.row(t))
    reads: dict[str, int] = {}
    choices: list[list[_Choice]] = []
    for place, limit in limits.items():
        taken, put = inputs.pop(place, 0), outputs.pop(place, 0)
        weight = inhibitors.pop(place, None)
        if limit == 0:
            continue
        if taken > limit:
            return []
        if weight is not None and weight <= limit:
            reads[free[place]] = limit - weight + 1
        choices.append(_choices(place, free[place], limit, taken, put, is_open))
    result = []
    for picked in product(*choices):
        row_inputs = {names[p]: w for p, w in inputs.items()}
        row_outputs = {names[p]: w for p, w in outputs.items()}
        for taken_here, put_here, free_taken, free_put in picked:
            row_inputs |= {names[p]: w for p, w in taken_here.items()} | free_taken
            row_outputs |= {names[p]: w for p, w in put_here.items()} | free_put
        for place_name, weight in reads.items():
            # A read beside what is taken and put: as much has to be there, and what is not taken stays.
            more = max(0, weight - row_inputs.get(place_name, 0))
            row_inputs[place_name] = row_inputs.get(place_name, 0) + more
            row_outputs[place_name] = row_outputs.get(place_name, 0) + more
        result.append(
            Transition(
                net.transitions[t],
                {name: w for name, w in row_inputs.items() if w},
                {name: w for name, w in row_outputs.items() if w},
                {names[p]: w for p, w in inhibitors.items()},
            )
        )
    return result


def _choices(place: int, free: str, limit: int, taken: int, put: int, is_open: bool) -> list[_Choice]:
    """Return arcs to a place and to its complement, for each number of tokens that there may be room for."""
    gain = put - taken
    if gain <= 0:
        left = range(-gain) if is_open else ()
        stays: list[_Choice] = [({place: limit}, {place: limit - loss}, {}, {free: loss}) for loss in left]
        return [({place: taken}, {place: put}, {}, {free: -gain}), *stays]
    result: list[_Choice] = []
    if put <= limit:
        result.append(({place: taken}, {place: put}, {free: gain}, {}))
    for room in range(min(gain - 1, limit - taken), -1, -1):
        held = limit - room
        result.append(({place: held}, {place: limit}, {free: room}, {}))
    return result
