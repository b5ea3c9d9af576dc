"""Input signals and clauses: the text, its normal form, and whose signals they are (paper, Sect. 5.3.3)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache

from dineros.metamodel import sym
from dineros.metamodel.base import EObject
from dineros.metamodel.clauses import (
    LiteralVariables,
    NormalForm,
    SignalLiteral,
    cnf_text,
    literal_text,
    parse,
    signal_names,
    to_cnf,
    value_names,
)
from dineros.metamodel.clauses.expressions import atoms_of
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.elements import label
from dineros.metamodel.errors import ClauseError, near_matches

MOST_VALUES = 32
"""Most values of a signal: the flattened net has a transition from each value to each other one."""

VALUE_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,62}")
"""Valid names of values of signals; places of the flattened net, topics and parameters contain them."""

Disjunctions = set[frozenset[SignalLiteral]]


@lru_cache(maxsize=1024)
def _form(text: str) -> NormalForm | ClauseError:
    """Return the normal form of a text, or what is wrong with it."""
    try:
        return to_cnf(parse(text))
    except ClauseError as error:
        return error


def _is_readable(clause: sym.InputClause, index: Index) -> bool:
    return not isinstance(_form(clause.text), ClauseError)


def _literals(clause: sym.InputClause, index: Index) -> list[sym.Literal]:
    return [
        literal
        for disjunction in clause.disjunctions
        for literal in disjunction.literals
        if literal not in index.incomplete
    ]


def _signals(clause: sym.InputClause, index: Index) -> Mapping[str, tuple[str, ...]]:
    """Return the signals that a clause can use, with the names of their values."""
    node_net = index.node_net_of(clause)
    if node_net is None:
        return {}
    return index.once(
        ("signals", node_net),
        lambda: {label(signal): value_names(signal) for signal in node_net.signals if label(signal)},
    )


def _knows_signals(clause: sym.InputClause, index: Index) -> bool:
    return _is_readable(clause, index) and _signals(clause, index).keys() >= set(signal_names(clause.text))


def _compares_values(clause: sym.InputClause, index: Index) -> bool:
    return _knows_signals(clause, index) and clause_values_known.check(clause, index) is True


@constraint("{it} cannot be read: {found}", fix="write a boolean expression such as Sensor & !Danger")
def clause_readable(clause: sym.InputClause, index: Index) -> Outcome:
    """The text of a clause is a boolean expression with a normal form that is not too large."""
    form = _form(clause.text)
    return form if isinstance(form, ClauseError) else True


@constraint(
    "{it} uses the signal {found}, which its node net does not have",
    fix="add the signal to the node net or use one of its own",
    guard=_is_readable,
)
def clause_signals_known(clause: sym.InputClause, index: Index) -> Outcome:
    """The text of a clause names signals of the node net of its transition."""
    known = _signals(clause, index)
    unknown = next((name for name in signal_names(clause.text) if name not in known), None)
    return unknown is None or ClauseError(repr(unknown), hint=near_matches(unknown, known))


@constraint(
    "{it} {found}",
    fix="write the name of a boolean signal alone, and compare others: Mode = 'idle'",
    guard=_knows_signals,
)
def clause_values_known(clause: sym.InputClause, index: Index) -> Outcome:
    """A clause compares signals that have values, with their values, and no others."""
    known = _signals(clause, index)
    for name, value in atoms_of(parse(clause.text)):
        if value is None and known[name]:
            return f"uses the signal {name!r} without a value"
        if value is not None and value not in known[name]:
            hint = near_matches(value, known[name])
            return ClauseError(
                f"compares the signal {name!r} with {value!r}, which is not one of its values", hint=hint
            )
    return True


@constraint("{it} uses {found}, a signal of another node net", fix="use a signal of its own node net")
def clause_within_node_net(clause: sym.InputClause, index: Index) -> Outcome:
    """A clause uses signals of the node net of its transition."""
    own = index.node_net_of(clause)
    foreign = [
        literal.signal
        for literal in _literals(clause, index)
        if own is None or literal.signal.node is not own
    ]
    return not foreign or describe(foreign[0])


@constraint(
    "{it} has the text {element.text!r}, but its normal form is {found!r}",
    fix="set the clause from its text again",
    guard=lambda clause, index: (
        _compares_values(clause, index) and clause_within_node_net.check(clause, index) is True
    ),
)
def clause_form_is_text(clause: sym.InputClause, index: Index) -> Outcome:
    """The normal form of a clause is equivalent to its text."""
    form = _form(clause.text)
    assert not isinstance(form, ClauseError)
    literals = [literal for disjunction in clause.disjunctions for literal in disjunction.literals]
    if any(literal in index.incomplete or not label(literal.signal) for literal in literals):
        return True
    stored = {
        frozenset(
            SignalLiteral(label(literal.signal), literal.negated, literal.value)
            for literal in disjunction.literals
        )
        for disjunction in clause.disjunctions
    }
    derived = {frozenset(disjunction) for disjunction in form}
    if stored == derived:
        return True
    known = _signals(clause, index)
    is_same = _implies(stored, derived, known) and _implies(derived, stored, known)
    return is_same or cnf_text(clause)


def _implies(premise: Disjunctions, conclusion: Disjunctions, known: Mapping[str, tuple[str, ...]]) -> bool:
    """Return whether every assignment that satisfies one normal form satisfies another (by SAT solving)."""
    from pysat.solvers import Solver

    if frozenset() in premise:
        return True
    variables = LiteralVariables[str](lambda name: known[name])

    def number(literal: SignalLiteral) -> int:
        return variables.number(literal.signal, literal.value, literal.negated)

    given = [[number(each) for each in part] for part in premise]
    refuted = [[-number(each) for each in part] for part in conclusion]
    with Solver(name="minisat22", bootstrap_with=[*given, *variables.rules()]) as solver:
        return not any(solver.solve(part) for part in refuted)


@constraint("{it} has the literal {found} twice", fix="set the clause from its text again")
def disjunction_literals_distinct(disjunction: sym.Disjunction, index: Index) -> Outcome:
    """No literal occurs twice in a disjunction."""
    known = set()
    for literal in disjunction.literals:
        key = (literal.signal, literal.negated, literal.value)
        if key in known:
            return repr(literal_text(literal))
        known.add(key)
    return True


@constraint(
    "{it} is never true, so its transition never fires",
    fix="change the text of the clause, or remove the transition",
    severity="warning",
)
def clause_not_false(clause: sym.InputClause, index: Index) -> Outcome:
    """A clause has no disjunction without literals."""
    return all(len(disjunction.literals) > 0 for disjunction in clause.disjunctions)


def _called(signal: sym.InputSignal) -> tuple[EObject | None, str]:
    return (signal.node, label(signal))


@constraint("{it} is called {found}, as another signal of its node net", fix="give one of them another name")
def signal_name_unique(signal: sym.InputSignal, index: Index) -> Outcome:
    """The signals of a node net have different names (or ids, if they have no name)."""
    return index.earliest(signal, sym.InputSignal, _called) is signal or repr(label(signal))


@constraint("{it} {found}", fix="give it two values or more with different names, or none")
def signal_values(signal: sym.InputSignal, index: Index) -> Outcome:
    """A signal has no values, or two or more with different names; what it is at the start is one of them."""
    names = [str(value.name) for value in signal.values if value not in index.incomplete]
    if len(names) < len(signal.values):
        return True
    wrong = next(
        (name for name in names if not VALUE_NAME.fullmatch(name) or name in ("true", "false")), None
    )
    if wrong is not None:
        return f"has a value {wrong!r}, which is not a name of letters, digits and underscores"
    if len(names) == 1 or len(names) > MOST_VALUES:
        return "has one value" if len(names) == 1 else f"has {len(names)} values, more than {MOST_VALUES}"
    if len(set(names)) < len(names):
        return f"has the value {next(name for name in names if names.count(name) > 1)!r} twice"
    if signal.start is not None and signal.start not in names:
        return ClauseError(
            f"starts as {signal.start!r}, which is not one of its values",
            hint=near_matches(signal.start, names)
            if names
            else "a signal without values is true or false at the start, as `initial` says",
        )
    return not (names and signal.initial) or "has values, and is true at the start"


@constraint("no clause uses {it}", fix="use it in a clause or remove it", severity="warning")
def signal_used(signal: sym.InputSignal, index: Index) -> Outcome:
    """A signal is used by a clause."""
    return len(signal.literals) > 0


@constraint("{it} names {found}", fix="name two signals or more, each once")
def exclusive_signals(assumption: sym.ExclusiveSignals, index: Index) -> Outcome:
    """Signals that are never true together are two or more booleans, each named once."""
    signals = list(assumption.signals)
    valued = next((each for each in signals if each.values), None)
    if valued is not None:
        return f"{describe(valued)}, which is not true or false"
    if len(signals) < 2:
        return f"{len(signals)} signals" if len(signals) != 1 else "one signal"
    twice = next((each for number, each in enumerate(signals) if each in signals[:number]), None)
    return True if twice is None else f"{describe(twice)} twice"
