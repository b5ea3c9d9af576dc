"""Clauses in a model: from text to stored normal form and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from dineros.metamodel import sym
from dineros.metamodel.clauses.expressions import SignalSetting, atoms_of, quoted
from dineros.metamodel.clauses.normal_form import to_cnf
from dineros.metamodel.clauses.parser import column_of, parse, signal_names
from dineros.metamodel.elements import label, node_net_of
from dineros.metamodel.errors import ClauseError, UnknownElementError, near_matches
from dineros.metamodel.positions import location_of


class UsedSignal(NamedTuple):
    """A literal of a clause, with the signal of the model."""

    signal: sym.InputSignal
    negated: bool
    value: str | None


def set_clause(transition: sym.Transition, text: str, name: str | None = None) -> sym.InputClause:
    """Guard a transition by a boolean expression over signals of its node net.

    Stores the text as written and its conjunctive normal form, in place of the transition's clause so far.
    A signal is called by its name, or by its id where it has none. After an error nothing has changed.

    Raises
    ------
    ClauseError
        The text is not an expression, uses a signal that the node net does not have, or is too large.
    """
    disjunctions = _normal_form(transition, text)
    remove_clause(transition)
    clause = sym.InputClause(name=name, text=text, disjunctions=disjunctions)
    transition.clause = clause
    return clause


def complete_clause(clause: sym.InputClause) -> None:
    """Store the conjunctive normal form of a clause that has its text alone, as people write it by hand.

    Raises
    ------
    ClauseError
        As for `set_clause`.
    """
    assert clause.transition is not None, "a clause belongs to its transition"
    clause.disjunctions.extend(_normal_form(clause.transition, clause.text or ""))


def signals_of_clause(transition: sym.Transition, text: str) -> list[list[UsedSignal]]:
    """Return the conjunctive normal form of a text: for each disjunction what it asks of signals.

    Raises
    ------
    ClauseError
        As for `set_clause`.
    """
    try:
        signals = _signals(transition)
        for used in signal_names(text):
            if used not in signals:
                error = _unknown_signal(transition, used, signals)
                error.column = column_of(text, used)
                raise error
        expression = parse(text)
        for name, value in atoms_of(expression):
            _require_value(signals[name], value, column_of(text, name))
        form = to_cnf(expression)
    except ClauseError as error:
        error.element = transition.id
        error.location = error.location or location_of(transition)
        raise
    return [
        [UsedSignal(signals[literal.signal], literal.negated, literal.value) for literal in literals]
        for literals in form
    ]


def value_names(signal: sym.InputSignal) -> tuple[str, ...]:
    """Return the names of the values of a signal; none: it is true or false."""
    return tuple(str(value.name) for value in signal.values)


def start_value(signal: sym.InputSignal) -> SignalSetting:
    """Return what a signal is at the start."""
    names = value_names(signal)
    if not names:
        return bool(signal.initial)
    return signal.start if signal.start is not None else names[0]


def formula_names(signal: sym.InputSignal) -> list[str]:
    """Return how formulas call what a signal can be: ``signal(Danger)``, ``signal(Mode.idle)``."""
    return [f"{signal.id}.{value}" for value in value_names(signal)] or [str(signal.id)]


def setting_text(value: SignalSetting) -> str:
    """Return what a signal is, as people read it."""
    return value if isinstance(value, str) else str(value).lower()


def _require_value(signal: sym.InputSignal, value: str | None, column: int | None) -> None:
    """Refuse a comparison that does not fit the signal."""
    names = value_names(signal)
    if value is None and names:
        shown = f"{quoted(label(signal))} = '{names[0]}'"
        raise ClauseError(
            f"the signal {label(signal)!r} is not true or false", column=column, hint=f"compare it: {shown}"
        )
    if value is not None and value not in names:
        hint = near_matches(value, names) or (f"its values are {', '.join(names)}" if names else None)
        raise ClauseError(
            f"the signal {label(signal)!r} has no value {value!r}"
            if names
            else f"the signal {label(signal)!r} is true or false, and has no value {value!r}",
            column=column,
            hint=hint or "give the signal values, or write its name alone",
        )


def _normal_form(transition: sym.Transition, text: str) -> list[sym.Disjunction]:
    return [
        sym.Disjunction(
            literals=[
                sym.Literal(signal=each.signal, negated=each.negated, value=each.value) for each in literals
            ]
        )
        for literals in signals_of_clause(transition, text)
    ]


def remove_clause(transition: sym.Transition) -> None:
    """Take the clause off a transition, and its literals off the signals they name."""
    clause = transition.clause
    if clause is None:
        return
    for disjunction in clause.disjunctions:
        for literal in disjunction.literals:
            literal.signal = None
    transition.clause = None


def cnf_text(clause: sym.InputClause) -> str:
    """Return the stored normal form as text that `parse` reads, such as ``(a | b) & !c``."""
    disjunctions = [
        " | ".join(literal_text(literal) for literal in disjunction.literals)
        for disjunction in clause.disjunctions
    ]
    if not disjunctions:
        return "true"
    if len(disjunctions) == 1:
        return disjunctions[0] or "false"
    return " & ".join(f"({text})" if " | " in text else text or "false" for text in disjunctions)


def literal_text(literal: sym.Literal) -> str:
    """Return a literal as `parse` reads it, such as ``!Danger`` or ``Mode <> 'idle'``."""
    name = quoted(label(literal.signal))
    if literal.value is None:
        return f"!{name}" if literal.negated else name
    return f"{name} {'<>' if literal.negated else '='} '{literal.value}'"


def evaluate(clause: sym.InputClause, values: Mapping[str, SignalSetting]) -> bool:
    """Return whether the stored normal form holds under values of its signals, by name.

    Raises
    ------
    UnknownElementError
        A signal of the clause has no value.
    """
    return all(
        any(_value(literal, values) for literal in disjunction.literals)
        for disjunction in clause.disjunctions
    )


def _value(literal: sym.Literal, values: Mapping[str, SignalSetting]) -> bool:
    name = label(literal.signal)
    if name not in values:
        raise UnknownElementError(f"the signal {name!r} has no value", hint=near_matches(name, values))
    return (values[name] == (True if literal.value is None else literal.value)) is not literal.negated


def _signals(transition: sym.Transition) -> dict[str, sym.InputSignal]:
    node_net = node_net_of(transition)
    return {label(signal): signal for signal in node_net.signals if label(signal)} if node_net else {}


def _unknown_signal(
    transition: sym.Transition, used: str, known: Mapping[str, sym.InputSignal]
) -> ClauseError:
    node_net = node_net_of(transition)
    if node_net is None:
        return ClauseError(
            f"the transition {label(transition)!r} is not in a node net, so it has no signal {used!r}",
            hint="put its page into a node net",
        )
    hint = near_matches(used, known) or (
        f"its signals are {', '.join(known)}" if known else "it has no signals"
    )
    return ClauseError(f"the node net {label(node_net)!r} has no signal {used!r}", hint=hint)
