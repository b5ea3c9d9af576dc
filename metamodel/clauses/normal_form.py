"""Conjunctive normal form over the same signals: none is added, because rules make a place per disjunction.

The form is exact (equivalent to the expression) and simplified: no literal twice in a disjunction, no
disjunction that is always true, none that another one implies literal by literal (subsumption). It is neither
minimal nor checked for satisfiability: ``Sensor & !Sensor`` stays two disjunctions, ``false`` is one without
literals, ``true`` has no disjunction. For a signal with values, a disjunction has plain literals or a single
negated one.
An equivalent form can have exponentially many disjunctions; the conversion stops before that costs time or
memory.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from dineros.metamodel.clauses.expressions import (
    And,
    Atom,
    Constant,
    Equivalent,
    Expression,
    Implies,
    Not,
    Or,
    Signal,
    SignalIs,
    atoms_of,
)
from dineros.metamodel.clauses.parser import MAX_DEPTH
from dineros.metamodel.errors import ClauseError

MAX_DISJUNCTIONS = 4096
"""Most disjunctions of a normal form."""

# Comparisons and products of disjunctions a conversion may take: about a second.
_MAX_STEPS = 4_000_000


class SignalLiteral(NamedTuple):
    """A signal, by name, or its negation; or that it has a value, or not."""

    signal: str
    negated: bool = False
    value: str | None = None


NormalForm = tuple[tuple[SignalLiteral, ...], ...]


def to_cnf(expression: Expression) -> NormalForm:
    """Bring an expression into conjunctive normal form.

    Disjunctions and literals follow the order of the expression, so equal texts give equal forms.

    Raises
    ------
    ClauseError
        The form would have more than `MAX_DISJUNCTIONS` disjunctions, or the expression is too deep.
    """
    if expression.depth > MAX_DEPTH:
        raise ClauseError(f"the clause nests {expression.depth} operators, more than {MAX_DEPTH}")
    atoms = list(dict.fromkeys(atoms_of(expression)))
    masks = _Conversion(atoms).form(expression, False)
    forms = (_of_values(list(_literals(mask, atoms))) for mask in masks)
    return tuple(dict.fromkeys(form for form in forms if form is not None))


def _literals(mask: int, atoms: list[Atom]) -> Iterator[SignalLiteral]:
    while mask:
        bit = (mask & -mask).bit_length() - 1
        name, value = atoms[bit // 2]
        yield SignalLiteral(name, bool(bit & 1), value)
        mask &= mask - 1


def _of_values(literals: list[SignalLiteral]) -> tuple[SignalLiteral, ...] | None:
    """Return a disjunction without literals that others of its signal imply; None: it is always true.

    Not to have a value is to have another one: that includes all other values, and two of it are all values.
    """
    excluded: dict[str, str] = {}
    for each in literals:
        if each.negated and each.value is not None:
            if each.signal in excluded:
                return None
            excluded[each.signal] = each.value
    return tuple(each for each in literals if each.negated or each.signal not in excluded)


class _Conversion:
    """One conversion. A disjunction is a bit mask: bit 2i is atom i, bit 2i+1 its negation."""

    def __init__(self, atoms: list[Atom]) -> None:
        self._index = {atom: index for index, atom in enumerate(atoms)}
        self._plain = sum(1 << 2 * index for index in range(len(atoms)))
        self._known: dict[tuple[int, bool], list[int]] = {}
        self._steps = 0

    def form(self, expression: Expression, negated: bool) -> list[int]:
        """Return the normal form of an expression or of its negation, computed once for each."""
        key = (id(expression), negated)
        if key not in self._known:
            self._known[key] = self._form(expression, negated)
        return self._known[key]

    def _form(self, expression: Expression, negated: bool) -> list[int]:
        match expression:
            case Signal(name=name):
                return [1 << 2 * self._index[name, None] + negated]
            case SignalIs(name=name, value=wanted):
                return [1 << 2 * self._index[name, wanted] + negated]
            case Constant(value=value):
                return [] if value is not negated else [0]
            case Not(operand=operand):
                return self.form(operand, not negated)
            case And(parts=parts) | Or(parts=parts):
                forms = [self.form(part, negated) for part in parts]
                conjunction = isinstance(expression, And) is not negated
                return self._all(forms) if conjunction else self._any(forms)
            case Implies(premise=premise, conclusion=conclusion):
                forms = [self.form(premise, not negated), self.form(conclusion, negated)]
                return self._all(forms) if negated else self._any(forms)
            case Equivalent(left=left, right=right):
                forward = self._any([self.form(left, True), self.form(right, negated)])
                backward = self._any([self.form(left, False), self.form(right, not negated)])
                return self._all([forward, backward])
        raise TypeError(f"no expression: {expression!r}")

    def _all(self, forms: list[list[int]]) -> list[int]:
        return self._simplified([mask for form in forms for mask in form])

    def _any(self, forms: list[list[int]]) -> list[int]:
        """Distribute: one disjunction for each choice of a disjunction of every form."""
        product = [0]
        for form in forms:
            self._spend(len(product) * len(form))
            product = self._simplified([left | right for left in product for right in form])
        return product

    def _simplified(self, masks: list[int]) -> list[int]:
        distinct = [mask for mask in dict.fromkeys(masks) if not mask & mask >> 1 & self._plain]
        kept: set[int] = set()
        smaller: list[int] = []
        same: list[int] = []
        size = -1
        for mask in sorted(distinct, key=int.bit_count):
            if mask.bit_count() > size:  # only a disjunction with fewer literals can subsume another one
                smaller += same
                same, size = [], mask.bit_count()
            self._spend(1 + len(smaller))
            if not any(other & mask == other for other in smaller):
                same.append(mask)
                kept.add(mask)
                if len(kept) > MAX_DISJUNCTIONS:
                    raise _too_large()
        return [mask for mask in distinct if mask in kept]

    def _spend(self, steps: int) -> None:
        self._steps += steps
        if self._steps > _MAX_STEPS:
            raise _too_large()


def _too_large() -> ClauseError:
    return ClauseError(
        f"the conjunctive normal form of the clause is too large (limit {MAX_DISJUNCTIONS} disjunctions)",
        hint="write it as a conjunction of small disjunctions, or split it over several transitions",
    )
