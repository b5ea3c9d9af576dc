"""Models that break the constraints of `clauses`."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.clauses import set_clause
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small

CASES = Cases()


@CASES.breaks(
    "clause-readable",
    "input clause of transition 'Talk' cannot be read: column 9: expected a signal, '!' or '(', "
    "found the end",
    "write a boolean expression such as Sensor & !Danger",
)
def syntax_error(small: Small) -> None:
    small["Talk"].clause.text = "Ready & "


@CASES.breaks(
    "clause-readable",
    "input clause of transition 'Talk' cannot be read: the conjunctive normal form of the clause is "
    "too large (limit 4096 disjunctions)",
    "write it as a conjunction of small disjunctions, or split it over several transitions",
)
def too_large(small: Small) -> None:
    small["Talk"].clause.text = " <-> ".join(f"x{i}" for i in range(20))


@CASES.breaks(
    "clause-signals-known",
    "input clause of transition 'Talk' uses the signal 'Dangr', which its node net does not have",
    "did you mean 'Danger'?",
)
def misspelt_signal(small: Small) -> None:
    small["Talk"].clause.text = "Ready -> !Dangr"


@CASES.breaks(
    "clause-within-node-net",
    "input clause of transition 'Serve' uses input signal 'Danger', a signal of another node net",
    "use a signal of its own node net",
)
def foreign_signal(small: Small) -> None:
    small["Serve"].clause.disjunctions[0].literals[0].signal = small["Danger"]
    set_clause(sym.Transition(id="Shut", page=small["hear"]), "Open")


@CASES.breaks(
    "clause-form-is-text",
    "input clause of transition 'Talk' has the text 'Ready & !Danger', but its normal form is '!Ready | "
    "!Danger'",
    "set the clause from its text again",
)
def other_text(small: Small) -> None:
    small["Talk"].clause.text = "Ready & !Danger"


@CASES.breaks(
    "clause-form-is-text",
    "input clause of transition 'Talk' has the text 'Ready -> !Danger', but its normal form is '!Ready | "
    "Danger'",
    "set the clause from its text again",
)
def negation_lost(small: Small) -> None:
    small["Talk"].clause.disjunctions[0].literals[1].negated = False


@CASES.breaks(
    "clause-form-is-text",
    "input clause of transition 'Done' has the text 'Ready & Danger', but its normal form is 'Ready'",
    "set the clause from its text again",
)
def disjunctions_lost(small: Small) -> None:
    set_clause(small["Done"], "Ready & Danger").disjunctions[1].delete()


@CASES.breaks(
    "disjunction-literals-distinct",
    "disjunction of input clause of transition 'Serve' has the literal 'Open' twice",
    "set the clause from its text again",
)
def literal_twice(small: Small) -> None:
    small["Serve"].clause.disjunctions[0].literals.append(sym.Literal(signal=small["Open"]))


@CASES.breaks(
    "clause-not-false",
    "input clause of transition 'Done' is never true, so its transition never fires",
    "change the text of the clause, or remove the transition",
)
def false(small: Small) -> None:
    set_clause(small["Done"], "false")


@CASES.breaks(
    "signal-name-unique",
    "input signal 'Other' is called 'Open', as another signal of its node net",
    "give one of them another name",
)
def same_name(small: Small) -> None:
    small["listener"].signals.append(sym.InputSignal(id="Other", name="Open"))
    set_clause(small["Serve"], "Open")
    clause = set_clause(sym.Transition(id="Shut", page=small["hear"]), "Open")
    clause.disjunctions[0].literals[0].signal = small["Open"]


@CASES.breaks(
    "signal-used",
    "no clause uses input signal 'Spare'",
    "use it in a clause or remove it",
)
def unused(small: Small) -> None:
    small["listener"].signals.append(sym.InputSignal(id="Spare"))


@CASES.breaks(
    "exclusive-signals",
    "exclusive signals 'apart' names one signal",
    "name two signals or more, each once",
)
def one_exclusive_signal(small: Small) -> None:
    small.net.assumptions.append(sym.ExclusiveSignals(id="apart", signals=[small["Danger"]]))


def _with_values(small: Small) -> sym.InputSignal:
    mode = sym.InputSignal(
        id="Mode", values=[sym.SignalValue(name="idle"), sym.SignalValue(name="busy")], node=small["listener"]
    )
    set_clause(small["Serve"], "Open & Mode <> 'idle'")
    return mode


@CASES.breaks(
    "signal-values",
    "input signal 'Mode' has one value",
    "give it two values or more with different names, or none",
)
def a_single_value(small: Small) -> None:
    mode = _with_values(small)
    mode.values.remove(mode.values[1])


@CASES.breaks(
    "signal-values",
    "input signal 'Mode' starts as 'idel', which is not one of its values",
    "did you mean 'idle'?",
)
def start_that_is_no_value(small: Small) -> None:
    _with_values(small).start = "idel"


@CASES.breaks(
    "signal-values",
    "input signal 'Mode' starts as 'true', which is not one of its values",
    "a signal without values is true or false at the start, as `initial` says",
)
def start_of_a_signal_without_values(small: Small) -> None:
    mode = _with_values(small)
    mode.values.clear()
    mode.start = "true"
    set_clause(small["Serve"], "Open & Mode")


@CASES.breaks(
    "signal-values",
    "input signal 'Mode' has a value 'not busy', which is not a name of letters, digits and underscores",
    "give it two values or more with different names, or none",
)
def value_that_is_no_name(small: Small) -> None:
    _with_values(small).values[1].name = "not busy"


@CASES.breaks(
    "clause-values-known",
    "input clause of transition 'Serve' compares the signal 'Mode' with 'idle', which is not one of its "
    "values",
    "write the name of a boolean signal alone, and compare others: Mode = 'idle'",
)
def value_that_is_gone(small: Small) -> None:
    _with_values(small).values[0].name = "resting"


@CASES.breaks(
    "clause-values-known",
    "input clause of transition 'Serve' uses the signal 'Mode' without a value",
    "write the name of a boolean signal alone, and compare others: Mode = 'idle'",
)
def signal_without_its_value(small: Small) -> None:
    mode = sym.InputSignal(id="Mode", node=small["listener"])
    set_clause(small["Serve"], "Open & Mode")
    mode.values.extend([sym.SignalValue(name="idle"), sym.SignalValue(name="busy")])
