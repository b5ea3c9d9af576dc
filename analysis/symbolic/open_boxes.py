"""Automaton of the boxes that may still contain a vector, level by level from the top, built on demand.

A *box* is a product of sets of local states. On the way down a diagram, each local state closes the boxes
that do not allow it. The result below a node then depends only on the node and on what the boxes that are
still open ask for below: their *conditions*. Boxes that ask for the same have the same condition, such as
those of many clients that wait for one server to be free. Few sets of conditions occur at a level if each box
touches few levels, as guards do. Therefore all boxes are removed from a set in one walk
(`diagram_kernels.exclude`); removing them one after the other would walk the upper levels once for each box.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.symbolic.saturation import Diagram

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]
Masks = Mapping[int, Sequence[bool]]

#: Entries of `OpenBoxes.following` that are not sets: no box is open; a box contains the vector.
NONE_LEFT, HELD = 0, -1
NO_ROW = -1
FIRST_ROOM = 64


class OpenBoxes:
    """Sets of open boxes, numbered from 1 in the order in which they occur; number 1 is the set at the top.

    Parameters
    ----------
    diagram : Diagram
        Its order determines the top level.
    boxes : sequence of mapping
        Encoding level -> flag for each local state; levels not named are free. None stands for an empty box.

    Attributes
    ----------
    state_class : int32 array
        By ``diagram.base[level] + local state``: local states of a level that are allowed by the same boxes
        have the same number.
    row : int64 array
        By set: index of its first entry in `following`; ``NO_ROW`` until it is known.
    following : int32 array
        By ``row[set] + class``: the set one level down, ``NONE_LEFT`` or ``HELD``.
    """

    def __init__(self, diagram: Diagram, boxes: Sequence[Masks]) -> None:
        top = diagram.top
        self.state_class: Int32Array = np.zeros(int(diagram.base[-1]) + 1, dtype=np.int32)
        self.row: Int64Array = np.full(FIRST_ROOM, NO_ROW, dtype=np.int64)
        self.following: Int32Array = np.zeros(FIRST_ROOM, dtype=np.int32)
        self._used = 0
        positions = [sorted(int(diagram.position[level]) for level in box) for box in boxes]
        #: By level: the conditions that begin there, those that end there, those that touch it, and by class
        #: the touching ones that allow it, each with what is left of it below.
        self._begin: list[list[int]] = [[] for _ in range(top + 1)]
        self._end: list[set[int]] = [set() for _ in range(top + 1)]
        self._allow: list[list[dict[int, int]]] = [[{}] for _ in range(top + 1)]
        touching: list[dict[int, tuple[bool, ...]]] = [{} for _ in range(top + 1)]
        below: dict[int, int] = {}
        known: dict[tuple[int, int, tuple[bool, ...]], int] = {}
        for box, touched in zip(boxes, positions, strict=True):
            condition = 0
            for level in touched:
                mask = tuple(box[diagram.order[level - 1]])
                above = known.setdefault((condition, level, mask), len(known) + 1)
                touching[level][above], below[above] = mask, condition
                if not condition:
                    self._end[level].add(above)
                condition = above
            self._begin[touched[-1]].append(condition)
        for level, masks in enumerate(touching):
            if masks:
                self._allow[level] = self._classes(diagram, level, masks, below)
        self._touch = [frozenset(masks) for masks in touching]
        self._lowest_top = min((touched[-1] for touched in positions), default=top + 1)
        self._number: dict[tuple[int, frozenset[int]], int] = {}
        self._sets: list[tuple[int, frozenset[int]]] = []
        self._numbered(top, frozenset())

    def __len__(self) -> int:
        """Return the number of sets found so far."""
        return len(self._sets)

    def learn(self, number: int) -> None:
        """Compute the row of a set."""
        level, still_open = self._sets[number - 1]
        begun = still_open.union(self._begin[level])
        untouched = begun - self._touch[level]
        entries = []
        for allowed in self._allow[level]:
            met = begun & allowed.keys()
            left = untouched.union(allowed[condition] for condition in met)
            if not met.isdisjoint(self._end[level]):
                entries.append(HELD)
            elif not left and level <= self._lowest_top:
                entries.append(NONE_LEFT)
            else:
                entries.append(self._numbered(level - 1, left))
        while self._used + len(entries) > self.following.size:
            self.following = np.concatenate([self.following, np.zeros_like(self.following)])
        self.following[self._used : self._used + len(entries)] = entries
        self.row[number] = self._used
        self._used += len(entries)

    def _numbered(self, level: int, still_open: frozenset[int]) -> int:
        key = (level, still_open)
        number = self._number.get(key)
        if number is None:
            self._sets.append(key)
            number = self._number[key] = len(self._sets)
            if number >= self.row.size:
                self.row = np.concatenate([self.row, np.full_like(self.row, NO_ROW)])
        return number

    def _classes(
        self, diagram: Diagram, level: int, masks: Mapping[int, tuple[bool, ...]], below: Mapping[int, int]
    ) -> list[dict[int, int]]:
        """Number the local states of a level by the conditions that allow them; return these by class."""
        numbers: dict[tuple[bool, ...], int] = {}
        classes = [numbers.setdefault(column, len(numbers)) for column in zip(*masks.values(), strict=True)]
        start = int(diagram.base[level])
        self.state_class[start : start + len(classes)] = classes
        return [{condition: below[condition] for condition in compress(masks, column)} for column in numbers]
