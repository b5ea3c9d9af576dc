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
    SignalIs,
    SignalSetting,
)
from dineros.metamodel.clauses.normal_form import MAX_DISJUNCTIONS, NormalForm, SignalLiteral, to_cnf
from dineros.metamodel.clauses.parser import MAX_DEPTH, MAX_LENGTH, parse, signal_names
from dineros.metamodel.clauses.stored import (
    cnf_text,
    complete_clause,
    evaluate,
    formula_names,
    literal_text,
    remove_clause,
    set_clause,
    setting_text,
    signals_of_clause,
    start_value,
    value_names,
)
from dineros.metamodel.clauses.variables import LiteralVariables

__all__ = [
    "MAX_DEPTH",
    "MAX_DISJUNCTIONS",
    "MAX_LENGTH",
    "And",
    "Constant",
    "Equivalent",
    "Expression",
    "Implies",
    "LiteralVariables",
    "NormalForm",
    "Not",
    "Or",
    "Signal",
    "SignalIs",
    "SignalLiteral",
    "SignalSetting",
    "cnf_text",
    "complete_clause",
    "evaluate",
    "formula_names",
    "literal_text",
    "parse",
    "remove_clause",
    "set_clause",
    "setting_text",
    "signal_names",
    "signals_of_clause",
    "start_value",
    "to_cnf",
    "value_names",
]
