"""Generalised Buchi automata with acceptance on transitions, the common form of every LTL formula here.

A word is accepted when some run on it takes, for every mark, infinitely many edges that carry the mark; with
no marks, when some run exists. Letters are sets of atoms; an edge reads all letters that hold its positive
and none of its negative atoms. Sets of atoms and of marks are integers, one bit each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from dineros.analysis.logic.language.syntax import Atom
from dineros.analysis.nets.graph_parts import strongly_connected_parts


class Edge(NamedTuple):
    """An edge of an automaton.

    Attributes
    ----------
    positive, negative : int
        Bits of atoms that must be true, and false.
    marks : int
        Bits of acceptance marks.
    """

    positive: int
    negative: int
    marks: int
    target: int

    def reads(self, letter: int) -> bool:
        """Whether the edge can be taken at a letter, given as bits of the true atoms."""
        return letter & self.positive == self.positive and not letter & self.negative


@dataclass(frozen=True)
class Automaton:
    """A transition-based generalised Buchi automaton.

    Attributes
    ----------
    atoms : tuple of Atom
        What the bits of letters mean.
    edges : tuple of tuples of Edge
        Outgoing edges by state.
    """

    atoms: tuple[Atom, ...]
    marks: int
    initial: int
    edges: tuple[tuple[Edge, ...], ...]

    @property
    def all_marks(self) -> int:
        """Bits of all marks."""
        return (1 << self.marks) - 1

    def components(self) -> list[list[int]]:
        """Strongly connected components, targets before sources."""
        graph = {s: [edge.target for edge in edges] for s, edges in enumerate(self.edges)}
        return [sorted(component) for component in strongly_connected_parts(graph)]
