"""What properties say, and what their answers do, as formulas of branching time."""

from __future__ import annotations

from dineros.analysis.logic.language.syntax import (
    And,
    Comparison,
    Constant,
    Deadlock,
    Enabled,
    Exists,
    Finally,
    Fired,
    ForAll,
    Formula,
    Globally,
    Name,
    Not,
    Or,
)
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.properties.normal_form import is_linear, of_linear
from dineros.analysis.properties.property import Property


def claim(one: Property, value: bool | int, net: CompiledNet) -> Formula | None:
    """Return a formula that holds just where a property's answer is right; None where there is none.

    Its names are those of the property; of a question of any net, those of the net.
    """
    if one.kind == "bound":
        sum = tuple((1, Name(name)) for name in one.places)
        always = ForAll(Globally(Comparison(sum, "<=", value)))
        return And((always, Exists(Finally(Comparison(sum, ">=", value)))))
    said = one.formula or said_of_all(one.examination, net)
    if one.kind == "ltl":
        found = in_branching_time(said)
        if found is None:
            return None
        said = found
    return said if value else Not(said)


def in_branching_time(formula: Formula) -> Formula | None:
    """Return "all runs satisfy a formula of linear time" in branching time, where that can be said."""
    found = of_linear(formula)
    parts = found.operands if isinstance(found, And) else (found,)
    steps = (isinstance(atom, Fired) for part in parts for atom in part.subformulas())
    return None if any(is_linear(part) for part in parts) or any(steps) else found


def said_of_all(examination: str, net: CompiledNet) -> Formula:
    """Return what a question of any net says, as a formula; readers know it by its id."""
    fired = [Enabled(Name(transition)) for transition in net.transitions]
    places = [Name(place) for place in net.places]
    match examination:
        case "ReachabilityDeadlock":
            return Exists(Finally(Deadlock()))
        case "OneSafe":
            return ForAll(Globally(_joined(And, [Comparison(((1, p),), "<=", 1) for p in places])))
        case "QuasiLiveness":
            return _joined(And, [Exists(Finally(each)) for each in fired])
        case "Liveness":
            return _joined(And, [ForAll(Globally(Exists(Finally(each)))) for each in fired])
        case _:  # a stable marking
            tokens = zip(places, net.initial.tolist(), strict=True)
            return _joined(Or, [ForAll(Globally(Comparison(((1, p),), "==", held))) for p, held in tokens])


def _joined(operator: type[And | Or], parts: list[Formula]) -> Formula:
    """Return a formula of any number of parts."""
    if len(parts) > 1:
        return operator(tuple(parts))
    return parts[0] if parts else Constant(operator is And)
