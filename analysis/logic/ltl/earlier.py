"""Searches for counterexamples to one formula, each with more fairness assumptions than the one before.

A run that is fair to more transitions is also fair to fewer of them. So if no accepting run starts in a
state, none does with more assumptions. A later search visits the other states in the same order as a search
without this knowledge, and finds the same run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.nets.compiled import CompiledNet


@dataclass(frozen=True, eq=False)
class _Ended:
    """A search that ended with a run, or without one."""

    formula: Formula
    product: Product
    rejected: NDArray[np.intp]

    def is_of(self, net: CompiledNet, formula: Formula, weak: Sequence[int], strong: Sequence[int]) -> bool:
        """Whether a question is the same one, or assumes more."""
        return (
            self.product.net is net
            and self.formula == formula
            and {*self.product.strong} <= {*strong}
            and {*self.product.weak} <= {*weak, *strong}
        )


class EarlierSearches:
    """The last search, with the states that it stored, and those in which no accepting run starts."""

    def __init__(self) -> None:
        self._last: _Ended | None = None

    def stored(
        self, net: CompiledNet, formula: Formula, weak: Sequence[int], strong: Sequence[int]
    ) -> tuple[Product, NDArray[np.intp]] | None:
        """Return a product with its stored states, and those in which no accepting run starts; or None."""
        last, self._last = self._last, None
        if last is None or not last.is_of(net, formula, weak, strong):
            return None
        return last.product, last.rejected

    def record(self, formula: Formula, product: Product, rejected: NDArray[Any]) -> None:
        """Keep the states of a search that has ended."""
        self._last = _Ended(formula, product, rejected)
