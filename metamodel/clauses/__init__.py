"""Input clauses: boolean expressions over the signals of a node net (paper, Sect. 5.3.3).

People write any expression; a model keeps their text and its conjunctive normal form.

>>> from dineros.metamodel import sym
>>> page, sense = sym.NodeNet(id="sensorics"), sym.Transition(id="sense")
>>> page.signals.extend([sym.InputSignal(id="Sensor"), sym.InputSignal(id="Danger")])
>>> page.objects.append(sense)
>>> clause = set_clause(sense, "not (Danger or Sensor) -> Sensor & Danger")
>>> cnf_text(clause)
'Danger | Sensor'
>>> evaluate(clause, {"Danger": False, "Sensor": True})
True
"""

from dineros.metamodel.clauses.expressions import (
    And,
    Constant,
    Equivalent,
    Expression,
    Implies,
    Not,
    Or,
    Signal,
)
from dineros.metamodel.clauses.normal_form import MAX_DISJUNCTIONS, NormalForm, SignalLiteral, to_cnf
from dineros.metamodel.clauses.parser import MAX_DEPTH, MAX_LENGTH, parse, signal_names
from dineros.metamodel.clauses.stored import (
    cnf_text,
    complete_clause,
    evaluate,
    remove_clause,
    set_clause,
    signals_of_clause,
)

__all__ = [
    "MAX_DEPTH",
    "MAX_DISJUNCTIONS",
    "MAX_LENGTH",
    "And",
    "Constant",
    "Equivalent",
    "Expression",
    "Implies",
    "NormalForm",
    "Not",
    "Or",
    "Signal",
    "SignalLiteral",
    "cnf_text",
    "complete_clause",
    "evaluate",
    "parse",
    "remove_clause",
    "set_clause",
    "signal_names",
    "signals_of_clause",
    "to_cnf",
]
