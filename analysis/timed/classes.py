"""State class graphs of time Petri nets.

W and M are linear classes, by equality and by inclusion; S and E are strong classes, by equality and by
inclusion. By inclusion only the largest classes are kept, so the graph has the same markings and fewer
classes. A are atomic classes: those of E, cut until all states of a class have successors in the same
classes. The letters are those of TINA.

References
----------
B. Berthomieu, M. Diaz, *Modeling and verification of time dependent systems using time Petri nets*, IEEE TSE
17(3), 1991. B. Berthomieu, F. Vernadat, *State class constructions for branching analysis of time Petri
nets*, TACAS 2003, LNCS 2619.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["W", "M", "S", "E", "A"]


@dataclass(frozen=True)
class ClassGraph:
    """State classes and what leads from one to another.

    Attributes
    ----------
    kind : {"W", "M", "S", "E", "A"}
    classes, edges, markings : int
        How many there are. An edge is a class, a transition and the class after it.
    deadlocks : int
        Classes in which nothing can fire, however long one waits.
    reason : str or None
        Why it is not complete: "time", "memory", "states", "tokens" or "interrupted".
    """

    kind: Kind
    classes: int
    edges: int
    markings: int
    deadlocks: int
    is_complete: bool
    reason: str | None
    memory_bytes: int
