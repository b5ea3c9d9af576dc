"""Questions about one net, and the engines that answer them; each is a class.

A question defines how the engines of DiNeROS decide it. Other engines have the same interface, and declare
which questions they support.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from dineros.analysis.answers.apart import is_end
from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.names import Names
from dineros.analysis.nets.compiled import CompiledNet

if TYPE_CHECKING:
    from dineros.analysis.explicit import Order
    from dineros.analysis.symbolic.order_cache import OrderCache
    from dineros.analysis.timed.nets import TimedNet


@dataclass(frozen=True)
class Question(ABC):
    """A question about a net.

    Attributes
    ----------
    net : CompiledNet
        The net.
    names : Names
        The elements that names in the question refer to.
    """

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
    order : {"breadth-first", "depth-first"}
        Order of the search.
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
    order : {"breadth-first", "depth-first"}
        Order of the search.
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
    formula : str
        The formula.
    weak, strong : tuple of str
        Names of weakly and of strongly fair transitions.
    """

    formula: str
    weak: tuple[str, ...] = ()
    strong: tuple[str, ...] = ()

    def decided(self, budget: Budget) -> Outcome:
        """Decide goals by reachability; for the rest, search the product with an automaton on the fly."""
        from dineros.analysis.logic.language.bounded import bounds_times
        from dineros.analysis.logic.language.errors import FormulaError
        from dineros.analysis.questions.formulas import verify_linear

        if bounds_times(self.formula):
            raise FormulaError("the formula bounds times", hint="--time asks with firing intervals")
        return verify_linear(self.net, self.formula, self.names, self.weak, self.strong, budget)


@dataclass(frozen=True)
class Branching(Question):
    """Whether the initial marking satisfies a formula of CTL.

    Attributes
    ----------
    formula : str
        The formula.
    orders : OrderCache or None
        Stored variable orders for the symbolic engine.
    """

    formula: str
    orders: OrderCache | None = None

    def decided(self, budget: Budget) -> Outcome:
        """Decide goals by reachability; for the rest, store markings and build decision diagrams."""
        from dineros.analysis.questions.formulas import verify_branching

        return verify_branching(self.net, self.formula, self.names, budget, self.orders)


class Engine(ABC):
    """An engine that answers questions. A new one is a subclass, and is entered in `ENGINES`.

    Attributes
    ----------
    name : str
        Value of `--engine`.
    """

    name: ClassVar[str]

    @abstractmethod
    def answer(self, question: Question, budget: Budget) -> Outcome:
        """Answer a question within a budget.

        Raises
        ------
        FormulaError
            The question is invalid, or has an unknown name.
        DinerosError
            The engine is not available, failed, or does not support the question.
        """


class Own(Engine):
    """The engines of DiNeROS, chosen according to the question."""

    name = "auto"

    def answer(self, question: Question, budget: Budget) -> Outcome:
        """Let the question choose. A witness that cannot be replayed is reported as an engine's error."""
        budget = budget.begun()
        try:
            return question.decided(budget)
        except AssertionError as error:
            if is_end(error):
                raise
            reason = f"an error inside an engine: {error} (please report it, with the model)"
            return Outcome("unknown", seconds=budget.spent, reason=reason)


class Tina(Engine):
    """TINA of LAAS, if it is on the PATH."""

    name = "tina"

    def answer(self, question: Question, budget: Budget) -> Outcome:
        """Run TINA's programs; their witnesses are replayed."""
        from dineros.analysis import tina

        match question:
            case Enabled(net, names, name, order):
                return tina.find_enabled(net, name, names, budget, order)
            case Marking(net, names, condition, order):
                return tina.find_marking(net, condition, names, budget, order)
            case Linear(net, names, formula, weak, strong):
                return tina.verify(net, formula, names, weak, strong, budget)
        raise tina.TinaError(f"TINA is not asked such questions: {type(question).__name__}")


CLASSES_SHARE = 0.7
"""Share of the time for state classes, if the question can also be decided without times."""

WITHOUT_TIMES = ", without times"
"""Suffix of the method's name if the question was decided without times."""


@dataclass(frozen=True)
class Timed(Engine):
    """State classes: questions about a net with its firing intervals and priorities.

    Attributes
    ----------
    net : TimedNet
        The net; questions are asked about the same net without its times.
    """

    net: TimedNet
    name = "time"

    def answer(self, question: Question, budget: Budget) -> Outcome:
        """Build state classes; a run that shows the answer has a schedule.

        If there are too many classes, the net without times is used: if it cannot fulfil a condition, neither
        can the net with times, which has fewer runs.
        """
        budget = budget.begun()
        if not self._holds_with_fewer_runs(question):
            return self._of_classes(question, budget)
        found = self._of_classes(question, budget.share(CLASSES_SHARE))
        if found.status != "unknown":
            return found
        plain = Own().answer(question, budget)
        if plain.status not in ("unreachable", "holds"):
            return found
        return replace(plain, by=f"{plain.by or 'all markings'}{WITHOUT_TIMES}", evidence=None)

    def _holds_with_fewer_runs(self, question: Question) -> bool:
        """Return whether a negative answer without times is also valid with times.

        With times, a run may stay in a marking in which nothing has to fire. So this is only used for
        formulas about all markings, or about all steps. Priorities affect which markings are deadlocks with
        times.
        """
        from dineros.analysis.logic.language.bounded import bounds_times
        from dineros.analysis.logic.language.parser import parse
        from dineros.analysis.logic.language.syntax import QUANTIFIERS, TEMPORAL, Deadlock, ForAll, Globally

        match question:
            case Enabled():
                return True
            case Marking(_, _, condition):
                said = parse(condition, "state")
            case Linear(_, _, formula, (), ()) if not bounds_times(formula):
                said = parse(formula)
                if not isinstance(said, Globally):
                    return False
                said = said.operands[0]
            case Branching(_, _, formula):
                said = parse(formula, "ctl")
                if not (isinstance(said, ForAll) and isinstance(said.operands[0], Globally)):
                    return False
                said = said.operands[0].operands[0]
            case _:
                return False
        parts = list(said.subformulas())
        if self.net.has_priorities and any(isinstance(part, Deadlock) for part in parts):
            return False
        return not any(isinstance(part, (*TEMPORAL, *QUANTIFIERS)) for part in parts)

    def _of_classes(self, question: Question, budget: Budget) -> Outcome:
        """Build state classes."""
        from dineros.analysis.logic.language.bounded import read_bounded
        from dineros.analysis.timed.branching_time import check_timed_ctl
        from dineros.analysis.timed.durations.bounded_response import decide_bounded
        from dineros.analysis.timed.goals import find_timed, find_timed_firing
        from dineros.analysis.timed.linear_time import verify_timed_ltl
        from dineros.metamodel.errors import DinerosError

        match question:
            case Enabled(_, names, name):
                return find_timed_firing(self.net, name, names, budget)
            case Marking(_, names, condition):
                return find_timed(self.net, condition, names, budget)
            case Linear(_, names, formula, (), ()):
                bounded = read_bounded(formula)
                if bounded is not None:
                    return decide_bounded(self.net, bounded, names, budget)
                return verify_timed_ltl(self.net, formula, names, budget)
            case Linear():
                raise DinerosError(
                    "fairness is not known with --time", hint="latest bounds say what must happen"
                )
            case Branching(_, names, formula):
                return check_timed_ctl(self.net, formula, names, budget)
        raise DinerosError(f"questions of this type are not asked with --time: {type(question).__name__}")


ENGINES: dict[str, Engine] = {engine.name: engine for engine in (Own(), Tina())}
"""By name."""
