"""Whether every clause can be true."""

from __future__ import annotations

from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.witnesses.findings import Fault
from dineros.metamodel import sym


class Clauses(Question):
    """Whether every clause can be true."""

    UNSATISFIABLE = Fault(
        "unsatisfiable-clause",
        "error",
        "An input clause can never be true, so its transition never fires.",
        "{clause}",
    )
    faults = (UNSATISFIABLE,)
    asks = "whether every clause can be true"

    def ask(self, checked: Checked) -> None:
        """Ask a SAT solver."""
        if not isinstance(checked.model, sym.SystemModel):
            return
        from dineros.analysis.model.satisfiability import unsatisfiable_clauses

        found = unsatisfiable_clauses(checked.model)
        checked.report.findings += [
            self.UNSATISFIABLE.found(str(clause.transition.id), clause=clause) for clause in found
        ]
        if not found:
            checked.report.proved.append("every clause can be true")
