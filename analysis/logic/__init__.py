"""Temporal logic on nets: conditions on markings, state/event LTL with fairness, and CTL.

`verify_ltl` returns an `Outcome`; its trace has been replayed by the firing rule. Importing this package
imports neither Numba nor the model checkers; their first use does.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dineros.analysis.answers.budget import Budget, Progress
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.logic.language.errors import FormulaError
    from dineros.analysis.logic.language.names import Names, NetNames
    from dineros.analysis.logic.language.parser import parse
    from dineros.analysis.logic.ltl.verification import verify_ltl

__all__ = [
    "Budget",
    "FormulaError",
    "Names",
    "NetNames",
    "Outcome",
    "Progress",
    "parse",
    "verify_ltl",
]

_MODULES = {
    **dict.fromkeys(("Budget", "Progress"), "dineros.analysis.answers.budget"),
    "Outcome": "dineros.analysis.answers.outcome",
    "FormulaError": "dineros.analysis.logic.language.errors",
    **dict.fromkeys(("Names", "NetNames"), "dineros.analysis.logic.language.names"),
    "parse": "dineros.analysis.logic.language.parser",
    "verify_ltl": "dineros.analysis.logic.ltl.verification",
}
"""Modules of the names in this package, which are imported at their first use."""


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_MODULES[name]), name)
