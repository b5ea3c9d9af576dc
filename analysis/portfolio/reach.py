"""A question: can a marking be reached that fulfils a condition? ``EF``, ``AG`` and ``G`` ask it, too."""

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
"""Reason of an answer that was interrupted: no other method is asked then."""


@dataclass(frozen=True)
class Reach:
    """Whether a marking can be reached that fulfils a condition, and how.

    Attributes
    ----------
    net : CompiledNet
        The net.
    condition : Formula
        On markings.
    names : Names
        What names in the condition stand for.
    order : {"breadth-first", "depth-first"}
        How explicit search goes.
    is_shortest : bool
        Whether a shortest way is asked for; then a longer one is the answer only where the search for it ends
        without one.
    own_goals : tuple of Goal, optional
        What explicit search looks for, if it is not to be read from the condition.
    is_shown : bool
        Whether the way is shown to anybody; otherwise an answer may come without one.
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
        """Goals of explicit search, one of which is met where the condition holds; None: too many."""
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
        """What the atoms ask."""
        return self.bound.conditions

    def holds(self, marking: Sequence[int]) -> bool:
        """Whether a marking fulfils the condition, by definition."""
        return holds_on_lasso(self.condition, [], [Step(tuple(marking), None)], self.bound.is_true)

    def reached(self, trace: Sequence[int], by: str) -> Outcome:
        """Return that a trace leads there, replayed; if it is shown, without what is not needed."""
        if not self.is_shown:
            if not self.holds(replay(self.net, trace)[-1]):
                raise AssertionError(f"{by}: its way does not lead to {self.condition}")
            return Outcome("reachable", tuple(trace), by=by)
        return Outcome("reachable", shortened(self.net, trace, self.holds), by=by)

    def is_answer(self, outcome: Outcome) -> bool:
        """Whether an outcome answers the question, so that no other method need be asked."""
        if outcome.status == "unknown":
            return outcome.reason == INTERRUPTED
        # Explicit search finds a shortest way where one is asked for; ways of others may be longer.
        return outcome.status == "unreachable" or not self.is_shortest or outcome.by == EXPLICIT

    def ends_others(self, outcome: Outcome) -> bool:
        """Whether methods that work side by side are ended by an outcome."""
        return self.is_answer(outcome)


EXPLICIT = "explicit search"
