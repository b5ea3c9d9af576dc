"""The question whether the initial marking satisfies a CTL formula."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.count import Count
from dineros.analysis.portfolio.reach import Reach

if TYPE_CHECKING:
    from dineros.analysis.symbolic.order_cache import OrderCache

NO_BOUNDS = "the places have no known bounds"
"""Reason why decision diagrams cannot answer; then no other method that needs bounds is tried."""


@dataclass(frozen=True)
class Satisfies:
    """Whether the initial marking satisfies a CTL formula."""

    net: CompiledNet
    formula: Formula
    names: Names
    orders: OrderCache | None = None
    seed: int = 1

    @cached_property
    def bound(self) -> BoundAtoms:
        """The atoms of the formula."""
        return BoundAtoms(self.net, self.formula, self.names)

    def is_answer(self, outcome: Outcome) -> bool:
        """Return whether an outcome answers the question."""
        return outcome.status != "unknown"

    def ends_others(self, outcome: Outcome) -> bool:
        """Return whether an outcome ends methods that run side by side."""
        return outcome.status != "unknown" or outcome.reason == NO_BOUNDS


Question: TypeAlias = Reach | Satisfies | Count
"""The questions for methods."""
