"""Reachability questions: whether a marking is reachable that fulfils a condition; also for CTL and LTL."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit import Order
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.logic.language.atoms import BoundAtoms, Condition, Step
from dineros.analysis.logic.language.disjunctions import goals_of
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import Atom, Formula
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.nets.witness import replay

INTERRUPTED = "interrupted"
"""Reason of an interrupted answer: then no other method is tried."""


@dataclass(frozen=True)
class Reach:
    """Whether a marking that fulfils a condition is reachable, with the required kind of trace.

    Attributes
    ----------
    condition : Formula
        On markings.
    is_shortest : bool
        Whether a shortest trace is required; then a longer one is returned only if the search for it ends
        without one.
    own_goals : tuple of Goal, optional
        Goals of explicit search, if they are not derived from the condition.
    is_shown : bool
        Whether the trace is shown to the user; if not, the answer may have none.
    """

    net: CompiledNet
    condition: Formula
    names: Names
    order: Order = "breadth-first"
    is_shortest: bool = False
    own_goals: tuple[Goal, ...] | None = None
    is_shown: bool = True

    @cached_property
    def goals(self) -> list[Goal] | None:
        """Goals of explicit search: the condition holds exactly if one is fulfilled; None: too many."""
        if self.own_goals is not None:
            return list(self.own_goals)
        return goals_of(self.net, self.condition, self.names)

    @property
    def transition(self) -> int | None:
        """The only transition that is to be enabled, if the question is about one."""
        goals = self.own_goals or ()
        transitions = [t for goal in goals for t in goal.transitions]
        return transitions[0] if len(goals) == len(transitions) == 1 else None

    @cached_property
    def bound(self) -> BoundAtoms:
        """The atoms of the condition."""
        return BoundAtoms(self.net, self.condition, self.names)

    @property
    def conditions(self) -> Mapping[Atom, Condition]:
        """The conditions in the atoms."""
        return self.bound.conditions

    def holds(self, marking: Sequence[int]) -> bool:
        """Return whether a marking fulfils the condition, by definition."""
        return holds_on_lasso(self.condition, [], [Step(tuple(marking), None)], self.bound.is_true)

    def reached(self, trace: Sequence[int], by: str) -> Outcome:
        """Return the outcome of a trace, replayed; if it is shown, without unnecessary firings."""
        if not self.is_shown:
            if not self.holds(replay(self.net, trace)[-1]):
                raise AssertionError(f"{by}: its way does not lead to {self.condition}")
            return Outcome("reachable", tuple(trace), by=by)
        return Outcome("reachable", shortened(self.net, trace, self.holds), by=by)

    def is_answer(self, outcome: Outcome) -> bool:
        """Return whether an outcome answers the question, so that no other method is needed."""
        if outcome.status == "unknown":
            return outcome.reason == INTERRUPTED
        # Explicit search finds a shortest trace if one is required; other methods may find longer ones.
        return outcome.status == "unreachable" or not self.is_shortest or outcome.by == EXPLICIT

    def ends_others(self, outcome: Outcome) -> bool:
        """Return whether an outcome ends methods that run side by side."""
        return self.is_answer(outcome)


EXPLICIT = "explicit search"
