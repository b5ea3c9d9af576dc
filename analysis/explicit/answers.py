"""What the explicit engine counts, and how it searches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypedDict

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.nets.coverability import Pumping

Reduction = Literal["stubborn"]
Order = Literal["breadth-first", "depth-first"]


class Options(TypedDict, total=False):
    """How a search is done; all may be left out.

    Attributes
    ----------
    workers : int
        Threads; as many as there are processors unless given. Depth first goes one.
    order : {"breadth-first", "depth-first"}
        Breadth first, the default, finds shortest ways, led by the state equation; depth first is often
        sooner at a goal that is far away.
    reduction : str
        ``stubborn`` fires stubborn sets only: of a count it keeps the deadlocks only.
    is_shortest : bool
        Whether a search for one goal continues for a shorter way where what it found may not be a shortest
        one; it does unless told.
    most_if_unbounded : int
        Markings at which a search for goals ends if it has seen that there is no end of them.
    """

    workers: int | None
    order: Order
    reduction: Reduction | None
    is_shortest: bool
    most_if_unbounded: int


@dataclass(frozen=True)
class ExplicitStateSpace:
    """What an exploration saw; exact for the net when `complete` and nothing was reduced.

    Attributes
    ----------
    markings, arcs, deadlocks : int
        Reachable markings, firings (pairs of a marking and an enabled transition), markings that enable
        nothing.
    largest_place : tuple of int
        By place: the most tokens in any marking.
    largest_total : int
        The most tokens in all places together in any marking.
    enabled : bool array
        By transition: whether some marking enables it.
    complete : bool
        Whether everything was seen.
    reason : str, optional
        What ended an incomplete exploration: ``memory``, ``states``, ``time``, ``unbounded`` or
        ``interrupted``.
    memory : int
        Bytes of markings and tables at the end.
    pumping : Pumping, optional
        Where unbounded: the proof.
    """

    markings: int
    arcs: int
    deadlocks: int
    largest_place: tuple[int, ...]
    largest_total: int
    enabled: NDArray[np.bool_]
    complete: bool
    reason: str | None
    memory: int
    pumping: Pumping | None = None
