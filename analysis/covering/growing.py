"""Limits places without changing the answers of a question: counters and logs are removed or limited.

A place from which no transition takes tokens only grows. If it is compared only with numbers up to K, no
comparison distinguishes K from more tokens, so it may be limited to K: every run of the net is a run of the
new net and vice versa, with the same answers. Such a place that is compared with nothing is removed. If a
place from which transitions take tokens is limited to K, further tokens are lost: the new net has fewer runs,
but each of them is a run of the net, with more tokens on that place.
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
    """A net in which some places hold at most a given number of tokens.

    Attributes
    ----------
    net : CompiledNet
        The net. Remaining places keep their names and their order; complements of limited places follow them.
    origin : tuple of int
        For each transition, the transition of the original net that it fires.
    place : dict of int to int
        For each place of the original net, the place that represents it; removed places have none.
    added : frozenset of int
        Transitions with which a full place stays full although tokens are taken from it.
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
        """Return the transitions of the original net in a firing sequence."""
        return tuple(self.origin[t] for t in trace)

    def images(self) -> dict[int, list[int]]:
        """For each transition of the original net, those that fire it; without any, it can never fire."""
        images: dict[int, list[int]] = {}
        for number, t in enumerate(self.origin):
            images.setdefault(t, []).append(number)
        return images


def growing_places(net: CompiledNet) -> tuple[int, ...]:
    """Places onto which some transition puts tokens and from which none takes; they may be read."""
    changes: dict[int, list[int]] = {}
    for change in net.delta:
        for place, tokens in change.items():
            changes.setdefault(place, []).append(tokens)
    return tuple(place for place, tokens in sorted(changes.items()) if min(tokens) > 0)


def largest_weights(net: CompiledNet) -> list[int]:
    """For each place, the largest weight of an input or inhibitor arc."""
    largest = [0] * len(net.places)
    for table in (net.pre, net.inhibitor):
        for place, weight in zip(table.place.tolist(), table.weight.tolist(), strict=True):
            largest[place] = max(largest[place], weight)
    return largest


def without_growth(net: CompiledNet, compared: Mapping[int, int] | None = None) -> Limited | None:
    """Limit the places that only grow, as far as no comparison can distinguish; None: there are none.

    Parameters
    ----------
    compared : mapping of int to int, optional
        For each place, the number of tokens from which the question distinguishes no more.

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
    """Limit places to a number of tokens each; further tokens are lost.

    A transition that can reach a limit is replaced by several: one that puts all tokens, and one for each
    smaller number for which there is room. Exactly one of them is enabled when the original one was.

    Parameters
    ----------
    limits : mapping of int to int
        For each place, its maximum number of tokens.
    is_open : bool
        Whether a full place represents any number of tokens from its limit on: then it may stay full when
        tokens are taken from it. Such a net can do everything that the net can, and more, if no limit is less
        than the weight of an input or inhibitor arc at its place.
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
    """Return the replacements of a transition, one for each way in which its places reach their limits."""
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
            # A read arc together with taking and putting: all tokens must be there, those not taken stay.
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
    """Return arcs to a place and to its complement, for each number of tokens for which there may be room."""
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
