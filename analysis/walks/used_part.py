"""The part of a net that some transitions use; its markings are as small as these use few places."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from dineros.analysis.nets.compiled import ArcTable, CompiledNet


class UsedPart:
    """Some transitions of a net with the places that they take from, put to or test.

    A sequence of these transitions can be fired in the part exactly if it can be fired in the net, since no
    other place matters to it. In a large net, markings of the part are much smaller.

    Attributes
    ----------
    net : CompiledNet
        The part; its transitions and places are in the order of the whole net.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "b": 0, "c": 1}, [("t", {"a": 1}), ("u", {"c": 1}, {"b": 1})])
    >>> part = UsedPart(net, [1])
    >>> part.net.places, part.inside([1, 1]), part.outside([0])
    (('b', 'c'), [0, 0], [1])
    """

    def __init__(self, net: CompiledNet, transitions: Iterable[int]) -> None:
        self._transitions = sorted(set(transitions))
        self._number = {t: number for number, t in enumerate(self._transitions)}
        tables = net.pre, net.post, net.inhibitor
        places = sorted({p for table in tables for t in self._transitions for p, _ in table.row(t)})
        place_of = {place: number for number, place in enumerate(places)}
        initial = np.ascontiguousarray(net.initial[places])
        initial.setflags(write=False)
        self.net = CompiledNet(
            tuple(net.places[place] for place in places),
            tuple(net.transitions[t] for t in self._transitions),
            initial,
            *(
                ArcTable.from_rows([{place_of[p]: n for p, n in table.row(t)} for t in self._transitions])
                for table in tables
            ),
        )

    def inside(self, sequence: Iterable[int]) -> list[int]:
        """Return the numbers in the part of transitions of the net."""
        return [self._number[t] for t in sequence]

    def outside(self, sequence: Sequence[int]) -> list[int]:
        """Return the numbers in the net of transitions of the part."""
        return [self._transitions[t] for t in sequence]
