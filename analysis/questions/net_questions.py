"""Questions about a net: what an engine decides."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.names import Names
from dineros.analysis.nets.compiled import CompiledNet

if TYPE_CHECKING:
    from dineros.analysis.explicit import Order
    from dineros.analysis.logic.ltl.earlier import EarlierSearches
    from dineros.analysis.symbolic.order_cache import OrderCache


@dataclass(frozen=True)
class Question(ABC):
    """A question about a net."""

    net: CompiledNet
    names: Names

    @abstractmethod
    def decided(self, budget: Budget) -> Outcome:
        """Return the answer of DiNeROS's engines, in an order that suits the question.

        Raises
        ------
        FormulaError
            The question is invalid, or has an unknown name.
        """


@dataclass(frozen=True)
class Enabled(Question):
    """A firing sequence to a marking that enables a transition, followed by the transition.

    Attributes
    ----------
    name : str
        Name of the transition; if several have it, any of them.
    """

    name: str
    order: Order = "breadth-first"

    def decided(self, budget: Budget) -> Outcome:
        """Search for it; see `dineros.analysis.portfolio.asking`."""
        from dineros.analysis.portfolio.asking import find_enabled

        return find_enabled(self.net, self.name, self.names, budget, self.order)


@dataclass(frozen=True)
class Marking(Question):
    """A firing sequence to a marking that fulfils a condition.

    Attributes
    ----------
    condition : str
        The condition, without temporal operators.
    """

    condition: str
    order: Order = "breadth-first"

    def decided(self, budget: Budget) -> Outcome:
        """Search for it; see `dineros.analysis.portfolio.asking`."""
        from dineros.analysis.portfolio.asking import find_marking

        return find_marking(self.net, self.condition, self.names, budget, self.order)


@dataclass(frozen=True)
class Linear(Question):
    """Whether all fair runs satisfy a formula of LTL.

    Attributes
    ----------
    weak, strong : tuple of str
        Names of weakly and of strongly fair transitions.
    earlier : EarlierSearches, optional
        What is known from the same question with fewer fair transitions.
    """

    formula: str
    weak: tuple[str, ...] = ()
    strong: tuple[str, ...] = ()
    earlier: EarlierSearches | None = field(default=None, compare=False, repr=False)

    def decided(self, budget: Budget) -> Outcome:
        """Decide goals by reachability; for the rest, search the product with an automaton on the fly."""
        from dineros.analysis.logic.language.bounded import bounds_times
        from dineros.analysis.logic.language.errors import FormulaError
        from dineros.analysis.questions.formulas import verify_linear

        if bounds_times(self.formula):
            raise FormulaError("the formula bounds times", hint="--time takes firing intervals into account")
        return verify_linear(self.net, self.formula, self.names, self.weak, self.strong, budget, self.earlier)


@dataclass(frozen=True)
class Branching(Question):
    """Whether the initial marking satisfies a formula of CTL."""

    formula: str
    orders: OrderCache | None = None

    def decided(self, budget: Budget) -> Outcome:
        """Decide goals by reachability; for the rest, store markings and build decision diagrams."""
        from dineros.analysis.questions.formulas import verify_branching

        return verify_branching(self.net, self.formula, self.names, budget, self.orders)
