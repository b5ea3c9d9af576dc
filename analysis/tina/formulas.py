"""Formulas in the language of ``selt``, which ``sift`` reads too where there are no temporal operators.

Only what selt's manual defines is written, with parentheses around every operand, a blank between
all symbols (``[]<>`` is one identifier there), and names qualified: ``S.{odd name}`` is a place, ``E.t`` the
event that a transition fires, ``L.dead`` the deadlock. An operator that is missing there is written by its
definition:

* weak until, release and ``!=`` by until and negation;
* ``<`` and ``>`` by ``<=``, since tokens are whole numbers; a subtracted place is on the other side;
* ``enabled(t)`` by the marking that enables t: selt has events, which are about the step taken, but nothing
  that says which steps could be taken.

References
----------
S. Chaki, E. M. Clarke, J. Ouaknine, N. Sharygina, N. Sinha, *State/event-based software model checking*, IFM
2004, LNCS 2999, whose logic selt's manual names as its own.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, NoneEnabled, SomeEnabled, SomeFired
from dineros.analysis.logic.language.syntax import (
    OPERATORS,
    And,
    Atom,
    Constant,
    Equivalent,
    Finally,
    Formula,
    Globally,
    Implies,
    Next,
    Not,
    Or,
    Release,
    Until,
    WeakUntil,
)
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.tina.programs import LONGEST_ARGUMENT, TinaError

TRUE, FALSE = "T", "F"
_AND, _OR = "/\\", "\\/"
PARTIAL = "L.sub"
"""Holds in states of a marking graph that were not explored further."""

_FORMS: dict[type[Formula], str] = {
    Not: "(- {0})",
    Implies: "({0} => {1})",
    Equivalent: "({0} <=> {1})",
    Next: "(() {0})",
    Finally: "(<> {0})",
    Globally: "([] {0})",
    Until: "({0} U {1})",
    WeakUntil: "(({0} U {1}) \\/ ([] {0}))",
    Release: "(- ((- {0}) U (- {1})))",
}
"""How operators are written, by the texts of their operands."""

_PLAIN = re.compile(r"[A-Za-z0-9_']+")


def always(text: str) -> str:
    """Return that a formula holds at every moment."""
    return f"([] {text})"


def not_(text: str) -> str:
    """Return the negation of a formula."""
    return f"(- {text})"


def formula_text(net: CompiledNet, formula: Formula, atoms: BoundAtoms) -> str:
    """Return an LTL formula, or a condition on markings, in the language of selt.

    Parameters
    ----------
    atoms : BoundAtoms
        What its atoms ask of the net.

    Raises
    ------
    TinaError
        The formula holds what selt cannot say, or becomes too long.

    Examples
    --------
    >>> from dineros.analysis.logic.language.names import NetNames
    >>> from dineros.analysis.logic.language.parser import parse
    >>> net = CompiledNet.build({"a b": 1, "c": 0}, [("t", {"a b": 1}, {"c": 2})])
    >>> tree = parse('G (fired(t) -> X c - {a b} > 1)', "ltl")
    >>> formula_text(net, tree, BoundAtoms(net, tree, NetNames(net)))
    '([] (E.t => (() (S.c >= S.{a b} + 2))))'
    """
    texts: dict[Formula, str] = {}
    for part in formula.subformulas():
        texts[part] = _part(net, part, [texts[operand] for operand in part.operands], atoms)
        if len(texts[part]) > LONGEST_ARGUMENT:
            raise TinaError(
                f"written for selt, the formula has more than {LONGEST_ARGUMENT:,} characters",
                hint="use another engine",
            )
    return texts[formula]


def enabled_text(net: CompiledNet, transition: int) -> str:
    """Return that a transition is enabled, as a condition on the marking."""
    needs = [f"(S.{quoted(net.places[place])} >= {weight})" for place, weight in net.pre.row(transition)]
    # Fewer tokens than the weight, which is at least one.
    bans = [
        f"(S.{quoted(net.places[place])} <= {weight - 1})" for place, weight in net.inhibitor.row(transition)
    ]
    return _joined(_AND, [*needs, *bans], TRUE)


def fair_text(net: CompiledNet, text: str, weak: Sequence[int], strong: Sequence[int]) -> str:
    """Return that all fair runs satisfy a formula: fairness is part of the formula.

    A run is weakly fair to a transition that is again and again not enabled or fired, and strongly fair to
    one that is fired again and again if it is enabled again and again.
    """
    weakly = [f"([] (<> {_joined(_OR, [not_(enabled_text(net, t)), _fired(net, t)], FALSE)}))" for t in weak]
    strongly = [f"(([] (<> {enabled_text(net, t)})) => ([] (<> {_fired(net, t)})))" for t in strong]
    fair = [*weakly, *strongly]
    return f"({_joined(_AND, fair, TRUE)} => {text})" if fair else text


def quoted(name: str) -> str:
    """Return a name of the net as an identifier."""
    return name if _PLAIN.fullmatch(name) else "{" + re.sub(r"([{}\\])", r"\\\1", name) + "}"


def _part(net: CompiledNet, part: Formula, operands: list[str], atoms: BoundAtoms) -> str:
    match part:
        case Constant(value):
            return TRUE if value else FALSE
        case Atom():
            return _atom(net, atoms, part)
        case And():
            return _joined(_AND, operands, TRUE)
        case Or():
            return _joined(_OR, operands, FALSE)
    if type(part) not in _FORMS:
        raise TinaError(f"selt has no exact equivalent of {part}", hint="use another engine")
    return _FORMS[type(part)].format(*operands)


def _atom(net: CompiledNet, atoms: BoundAtoms, atom: Atom) -> str:
    match atoms.conditions[atom]:
        case Linear(factors, operator, bound):
            return _comparison(net, factors, operator, bound)
        case SomeEnabled(transitions):
            return _joined(_OR, [enabled_text(net, t) for t in sorted(transitions)], FALSE)
        case SomeFired(transitions):
            return _joined(_OR, [_fired(net, t) for t in sorted(transitions)], FALSE)
        case NoneEnabled():
            return "L.dead"


def _fired(net: CompiledNet, transition: int) -> str:
    return f"E.{quoted(net.transitions[transition])}"


def _comparison(net: CompiledNet, factors: dict[int, int], operator: str, bound: int) -> str:
    """Compare two sums of natural numbers."""
    if not factors:
        return TRUE if OPERATORS[operator](0, bound) else FALSE
    if operator == "!=":
        return not_(_comparison(net, factors, "==", bound))
    if operator in "<>":  # p < q is p <= q - 1, p > q is p >= q + 1
        operator, bound = ("<=", bound - 1) if operator == "<" else (">=", bound + 1)
    left = _sum(net, {p: k for p, k in factors.items() if k > 0}, max(-bound, 0))
    right = _sum(net, {p: -k for p, k in factors.items() if k < 0}, max(bound, 0))
    return f"({left} {'=' if operator == '==' else operator} {right})"


def _sum(net: CompiledNet, factors: dict[int, int], number: int) -> str:
    terms = [
        (f"{factor} * " if factor > 1 else "") + f"S.{quoted(net.places[place])}"
        for place, factor in factors.items()
    ]
    return " + ".join([*terms, *([str(number)] if number or not terms else [])])


def _joined(operator: str, texts: Iterable[str], empty: str) -> str:
    parts = list(texts)
    if len(parts) < 2:
        return parts[0] if parts else empty
    return f"({f' {operator} '.join(parts)})"  # infix operators group to the right, and both are associative
