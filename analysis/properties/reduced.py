"""A net reduced for one question: only elements that the question refers to must stay."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, SomeEnabled
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.syntax import (
    FALSE,
    TRUE,
    And,
    Atom,
    Comparison,
    Constant,
    Formula,
    Name,
    Or,
)
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.properties.normal_form import folded, has_next
from dineros.analysis.reductions import Property, Reduction, reduce

#: Maximum number of transitions of a net for which the reduction takes little time.
MOST_TRANSITIONS = 3_000


@dataclass(frozen=True)
class Reduced:
    """A question about a reduced net.

    Attributes
    ----------
    net : CompiledNet
    formula : Formula
        Names in it are those of the net.
    reduction : Reduction
        The reduction, which translates traces back.
    """

    net: CompiledNet
    formula: Formula
    reduction: Reduction


def reduced(net: CompiledNet, formula: Formula, names: Names) -> Reduced | None:
    """Return an equivalent question about a reduced net, for LTL without "next" or for one marking.

    None if the formula counts steps or is about deadlocks, or if the net is large.
    """
    if has_next(formula) or len(net.transitions) > MOST_TRANSITIONS:
        return None
    bound = BoundAtoms(net, formula, names)
    made: dict[Formula, Formula] = {}
    for part in formula.subformulas():
        if isinstance(part, Atom) and not isinstance(part, Constant):
            compared = _compared(net, bound.conditions[part])
            if compared is None:
                return None
            made[part] = compared
        else:
            made[part] = part.with_operands(tuple(made[operand] for operand in part.operands))
    wanted = folded(made[formula], {})
    observed = {
        name.text for part in wanted.subformulas() if isinstance(part, Comparison) for _, name in part.terms
    }
    reduction = reduce(net, {Property.LTL_WITHOUT_NEXT}, observed_places=observed)
    return Reduced(reduction.net, wanted, reduction)


def _compared(net: CompiledNet, condition: object) -> Formula | None:
    """Return a condition as comparisons of tokens; None: it cannot be expressed."""
    match condition:
        case Linear(factors, symbol, bound):
            terms = tuple((factor, Name(net.places[p])) for p, factor in factors.items())
            if not terms:
                return None
            return Comparison(terms, symbol, bound)  # type: ignore[arg-type]
        case SomeEnabled(transitions):
            return _any([_enabling(net, t) for t in sorted(transitions)])
    return None


def _enabling(net: CompiledNet, transition: int) -> Formula:
    rows: list[Formula] = [
        Comparison(((1, Name(net.places[p])),), ">=", weight) for p, weight in net.pre.row(transition)
    ]
    rows += [
        Comparison(((1, Name(net.places[p])),), "<", weight) for p, weight in net.inhibitor.row(transition)
    ]
    return TRUE if not rows else rows[0] if len(rows) == 1 else And(tuple(rows))


def _any(parts: list[Formula]) -> Formula:
    return FALSE if not parts else parts[0] if len(parts) == 1 else Or(tuple(parts))
