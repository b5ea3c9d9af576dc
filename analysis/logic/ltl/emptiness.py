"""Decides whether a product has an accepting run: drives the search, grows its tables, finds a short run."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.kernels.search import (
    CANDIDATE,
    DEAD,
    EMPTY,
    FOUND,
    IS_REJECTED,
    LIVE,
    OVERFLOW,
    PAUSED,
    POOL,
    ROOTS,
    SEARCH_FULL,
    STORE_FULL,
    Search,
    explore,
)
from dineros.analysis.logic.ltl.fairness import InnerGraph
from dineros.analysis.logic.ltl.lassos import ProductRun, find_run

States = NDArray[np.intp]

VISITS = 100_000
"""Number of states visited between checks of the clock."""


@dataclass
class Emptiness:
    """The search for an accepting run of a product.

    Attributes
    ----------
    known : array of int
        Stored states in which no accepting run starts.
    """

    product: Product
    budget: Budget
    known: States = field(default_factory=lambda: np.empty(0, dtype=np.intp))

    def __post_init__(self) -> None:
        self.search = _new_search(self.product)
        self.search.number[self.known] = DEAD

    @property
    def rejected(self) -> States:
        """Visited states in which no accepting run starts."""
        return np.flatnonzero(self.search.number == DEAD)

    def run(self) -> ProductRun | None:
        """Return an accepting run, or None if there is none.

        Raises
        ------
        BudgetExceededError
            A limit was exceeded before.
        """
        product = self.product
        while True:
            status = explore(
                *product.parts,
                self.search,
                VISITS,
            )
            if status == EMPTY:
                return None
            if status == FOUND:
                return find_run(product, self._component())
            if status == CANDIDATE:
                graph = InnerGraph.of(product, self._component())
                part = graph.accepting_part(product.conditions.required)
                if part is not None:
                    return find_run(product, part)
                self.search.control[IS_REJECTED] = 1
            elif status == STORE_FULL:
                self._check()
                product.grow(self._search_bytes())
                self._lengthen_numbers()
            elif status == SEARCH_FULL:
                self._grow_search()
            elif status == OVERFLOW:
                product.widen(self._search_bytes())
            else:
                assert status == PAUSED
                self._check()

    def _check(self) -> None:
        self.budget.report(self.product.progress(self.product.memory_bytes + self._search_bytes()))

    def _component(self) -> np.ndarray[tuple[int], np.dtype[np.int32]]:
        """Return the states of the component on top of the stack."""
        search = self.search
        first = search.root_number[search.control[ROOTS] - 1]
        live = search.live[: search.control[LIVE]]
        # Numbers increase along the stack.
        start = int(np.searchsorted(search.number[live], first))
        return live[start:].copy()

    def _search_bytes(self) -> int:
        return sum(array.nbytes for array in self.search)

    def _lengthen_numbers(self) -> None:
        size = len(self.product.store.words)
        number = np.zeros(size, dtype=np.int32)
        number[: self.search.number.size] = self.search.number
        self.search = self.search._replace(number=number, is_kept=np.empty(size, dtype=np.bool_))

    def _grow_search(self) -> None:
        """Double the stacks that are nearly full."""
        search, control = self.search, self.search.control
        changed: dict[str, np.ndarray[tuple[int, ...], np.dtype[np.int64]]] = {}
        stacks = [("pool_target", POOL, self.product.room), ("pool_label", POOL, self.product.room)]
        stacks += [("live", LIVE, 2), ("frame_state", 0, 2), ("frame_pool", 0, 2)]
        stacks += [(name, ROOTS, 2) for name in ("root_number", "root_marks", "root_strong", "root_arc")]
        for name, size, room in stacks:
            array = getattr(search, name)
            if control[size] + room > len(array):
                self.budget.check_memory(self.product.memory_bytes + self._search_bytes() + 2 * array.nbytes)
                larger = np.empty((2 * len(array), *array.shape[1:]), dtype=array.dtype)
                larger[: len(array)] = array
                changed[name] = larger
        self.search = search._replace(**changed)  # type: ignore[arg-type]


def _new_search(product: Product) -> Search:
    size = 1 << 12
    marks = product.conditions.required.size
    search = Search(
        np.zeros(len(product.store.words), dtype=np.int32),
        np.empty(len(product.store.words), dtype=np.bool_),
        np.zeros(size, dtype=np.int32),
        np.zeros(size, dtype=np.int64),
        np.zeros(2 * size + 2 * product.room, dtype=np.int32),
        np.zeros(2 * size + 2 * product.room, dtype=np.int32),
        np.zeros(size, dtype=np.int32),
        np.zeros(size, dtype=np.int32),
        np.zeros((size, marks), dtype=np.int64),
        np.zeros((size, marks), dtype=np.int64),
        np.zeros((size, marks), dtype=np.int64),
        np.zeros(6, dtype=np.int64),
    )
    # No edge leads to the first state.
    search.pool_target[0], search.pool_label[0] = 0, -1
    search.control[POOL] = 1
    return search
