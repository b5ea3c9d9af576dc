"""A net reduced for one question: only elements that the question refers to must stay."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.analysis.logic.language.atoms import BoundAtoms, as_comparisons
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.syntax import Comparison, Formula
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
    formula : Formula
        Names in it are those of the net.
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
    compared: dict[Formula, Formula | None] = {
        atom: as_comparisons(net, condition) for atom, condition in bound.conditions.items()
    }
    if None in compared.values():
        return None
    wanted = folded(formula.replaced(compared.get), {})
    observed = {
        name.text for part in wanted.subformulas() if isinstance(part, Comparison) for _, name in part.terms
    }
    reduction = reduce(net, {Property.LTL_WITHOUT_NEXT}, observed_places=observed)
    return Reduced(reduction.net, wanted, reduction)
