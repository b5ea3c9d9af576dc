"""Temporal logic on nets: conditions on markings, state/event LTL with fairness, and CTL.

`verify_ltl` and `check_ctl` answer with an `Outcome`; its trace has been replayed by the plain firing rule.
Importing this package does not import Numba; the first question does.
"""

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.outcome import Outcome as Verdict
from dineros.analysis.logic.ctl.checking import check_ctl
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.metamodel.moved import find_moved

__all__ = [
    "Budget",
    "FormulaError",
    "Names",
    "NetNames",
    "Outcome",
    "Progress",
    "Verdict",
    "check_ctl",
    "parse",
    "verify_ltl",
]

find_moved(
    __name__, {"answer": "dineros.analysis.answers.outcome", "budget": "dineros.analysis.answers.budget"}
)
