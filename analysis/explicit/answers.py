"""The counts of the explicit engine, and the options of its search."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypedDict

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.nets.coverability import Pumping

Reduction = Literal["stubborn"]
Order = Literal["breadth-first", "depth-first"]


class Options(TypedDict, total=False):
    """The options of a search; all are optional.

    Attributes
    ----------
    workers : int
        Number of threads; by default the number of processors. Depth-first search uses one.
    order : {"breadth-first", "depth-first"}
        Breadth first, the default, finds shortest traces, guided by the state equation; depth first often
        finds a distant goal sooner.
    reduction : str
        ``stubborn`` fires stubborn sets only; then only the number of deadlocks is preserved.
    is_shortest : bool
        Whether a search for one goal continues for a shorter trace if the found one may not be a shortest
        one; true by default.
    most_if_unbounded : int
        Number of markings at which a search for goals ends if the net is known to be unbounded.
    """

    workers: int | None
    order: Order
    reduction: Reduction | None
    is_shortest: bool
    most_if_unbounded: int


@dataclass(frozen=True)
class ExplicitStateSpace:
    """The results of an exploration; exact for the net if `complete` and without reduction.

    Attributes
    ----------
    markings, arcs, deadlocks : int
        Reachable markings, firings (pairs of a marking and an enabled transition), and deadlocks.
    largest_place : tuple of int
        For each place, the most tokens in a marking.
    largest_total : int
        The most tokens in all places together in any marking.
    enabled : bool array
        For each transition, whether some marking enables it.
    reason : str, optional
        Why an exploration is incomplete: ``memory``, ``states``, ``time``, ``unbounded`` or ``interrupted``.
    memory : int
        Memory of markings and tables at the end, in bytes.
    pumping : Pumping, optional
        If the net is unbounded: the proof.
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
