"""The final condition of an application: if it holds, nothing has to continue."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from dineros.analysis.model.subject import Subject
from dineros.metamodel import sym

if TYPE_CHECKING:
    from dineros.analysis.symbolic.engine import SymbolicStateSpace


class FinalCondition:
    """A condition on markings that a model states.

    Raises
    ------
    FormulaError
        The text is not a condition on one marking, or names something that does not exist.
    """

    def __init__(self, subject: Subject, text: str) -> None:
        from dineros.analysis.logic.ctl.fixpoints import basic
        from dineros.analysis.logic.language.atoms import BoundAtoms
        from dineros.analysis.logic.language.parser import parse

        self._formula = basic(parse(text, "state"))
        self._atoms = BoundAtoms(subject.net, self._formula, subject.names)

    @classmethod
    def of(cls, subject: Subject) -> FinalCondition | None:
        """Return the condition of the model; None if it states none.

        Raises
        ------
        FormulaError
            It cannot be read.
        """
        model = subject.model
        text = model.finalCondition if isinstance(model, sym.SystemModel) else None
        return cls(subject, text) if text else None

    def holds_at(self, marking: Sequence[int]) -> bool:
        """Return whether a marking that enables nothing satisfies the condition."""
        from dineros.analysis.logic.language.atoms import Step
        from dineros.analysis.logic.language.semantics import holds_on_lasso

        return holds_on_lasso(self._formula, [], [Step(tuple(marking), None)], self._atoms.is_true)

    def among(self, space: SymbolicStateSpace) -> int:
        """Return the set of all markings that satisfy the condition, pinned in the diagram."""
        from dineros.analysis.logic.ctl.fixpoints import satisfying
        from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets

        return satisfying(self._formula, SymbolicSets(space, self._atoms))[self._formula]
