"""Clauses in a model: from text to stored normal form and back."""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import sym
from dineros.metamodel.clauses.expressions import quoted
from dineros.metamodel.clauses.normal_form import to_cnf
from dineros.metamodel.clauses.parser import column_of, parse, signal_names
from dineros.metamodel.elements import label, node_net_of
from dineros.metamodel.errors import ClauseError, UnknownElementError, near_matches
from dineros.metamodel.positions import location_of


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
    assert clause.transition is not None, "a clause stands on its transition"
    clause.disjunctions.extend(_normal_form(clause.transition, clause.text or ""))


def signals_of_clause(transition: sym.Transition, text: str) -> list[list[tuple[sym.InputSignal, bool]]]:
    """Return the conjunctive normal form of a text: for each disjunction its signals, and which are negated.

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
        form = to_cnf(parse(text))
    except ClauseError as error:
        error.element = transition.id
        error.location = error.location or location_of(transition)
        raise
    return [[(signals[literal.signal], literal.negated) for literal in literals] for literals in form]


def _normal_form(transition: sym.Transition, text: str) -> list[sym.Disjunction]:
    return [
        sym.Disjunction(
            literals=[sym.Literal(signal=signal, negated=negated) for signal, negated in literals]
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
            literal.signal = None  # type: ignore[assignment]
    transition.clause = None


def cnf_text(clause: sym.InputClause) -> str:
    """Return the stored normal form as text that `parse` reads, such as ``(a | b) & !c``."""
    disjunctions = [
        " | ".join(
            ("!" if literal.negated else "") + quoted(label(literal.signal))
            for literal in disjunction.literals
        )
        for disjunction in clause.disjunctions
    ]
    if not disjunctions:
        return "true"
    if len(disjunctions) == 1:
        return disjunctions[0] or "false"
    return " & ".join(f"({text})" if " | " in text else text or "false" for text in disjunctions)


def evaluate(clause: sym.InputClause, values: Mapping[str, bool]) -> bool:
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


def _value(literal: sym.Literal, values: Mapping[str, bool]) -> bool:
    name = label(literal.signal)
    if name not in values:
        raise UnknownElementError(f"the signal {name!r} has no value", hint=near_matches(name, values))
    return values[name] is not literal.negated


def _signals(transition: sym.Transition) -> dict[str, sym.InputSignal]:
    node_net = node_net_of(transition)
    return {label(signal): signal for signal in node_net.signals if label(signal)} if node_net else {}


def _unknown_signal(
    transition: sym.Transition, used: str, known: Mapping[str, sym.InputSignal]
) -> ClauseError:
    node_net = node_net_of(transition)
    if node_net is None:
        return ClauseError(
            f"the transition {label(transition)!r} stands in no node net, so it has no signal {used!r}",
            hint="put its page into a node net",
        )
    hint = near_matches(used, known) or (
        f"its signals are {', '.join(known)}" if known else "it has no signals"
    )
    return ClauseError(f"the node net {label(node_net)!r} has no signal {used!r}", hint=hint)
