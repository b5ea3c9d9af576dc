"""Test cases of transitions: the tokens that a test puts, and the expected result of the firing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from dineros.generators.application.arcs import ArcEnd
from dineros.metamodel import sym
from dineros.metamodel.clauses import LiteralVariables, SignalSetting, value_names
from dineros.metamodel.token_data import Value


@dataclass(frozen=True)
class Case:
    """A marking and signals under which a transition can fire; ids are those of the running net."""

    transition: str
    """The transition, in the first instance if there are several."""
    marking: dict[str, int]
    """Tokens of the places it needs; all others are empty."""
    signals: dict[str, SignalSetting]
    """Values of the signals that differ from those at the start."""
    change: dict[str, int]
    """Change of the marking by the firing."""
    obstacle: str = ""
    """Why it cannot fire with only these; empty: it can."""
    data: dict[str, dict[str, Value]] = field(default_factory=dict)
    """For each place, the fields of its token that occur in a guard."""


def case_of(
    transition: str,
    inputs: Sequence[ArcEnd],
    outputs: Sequence[ArcEnd],
    clause: sym.InputClause | None,
    initial: dict[str, SignalSetting],
    running: Callable[[str], str],
    data: Mapping[str, dict[str, Value]],
) -> Case:
    """Return the case of a transition.

    Parameters
    ----------
    transition : str
        Its id in the running net.
    initial : dict of str to bool
        The signals of its node, with their initial values.
    running : callable
        Returns the id of a place in the running net.
    data : mapping of str to dict
        For each place of the model, values of fields that fulfil its guard.
    """
    taken, read, change = Counter[str](), Counter[str](), Counter[str]()
    limits: dict[str, int] = {}
    for end in inputs:
        place = running(end.place)
        if end.kind == "normal":
            taken[place] += end.weight
        elif end.kind == "read":
            read[place] = max(read[place], end.weight)
        else:
            limits[place] = min(end.weight, limits.get(place, end.weight))
    for end in outputs:
        change[running(end.place)] += end.weight
    change.subtract(taken)
    marking = {place: taken[place] + read[place] for place in (*taken, *read)}
    signals = satisfying(clause, initial)
    obstacle = "" if signals is not None else "its clause can never be true"
    for place, limit in limits.items():
        if marking.get(place, 0) >= limit:
            obstacle = f"an inhibitor arc forbids the tokens that it needs on {place}"
    return Case(
        transition,
        marking,
        {id: value for id, value in (signals or {}).items() if value != initial[id]},
        {place: count for place, count in change.items() if count},
        obstacle,
        {running(place): values for place, values in data.items()},
    )


def satisfying(
    clause: sym.InputClause | None, initial: dict[str, SignalSetting]
) -> dict[str, SignalSetting] | None:
    """Return values of the signals under which a clause holds, near the initial ones; None: none."""
    from pysat.solvers import Minisat22

    if clause is None:
        return initial
    used = [literal for disjunction in clause.disjunctions for literal in disjunction.literals]
    values = {literal.signal.id: value_names(literal.signal) for literal in used}
    variables = LiteralVariables[str](lambda id: values[id])
    for id, value in initial.items():
        if isinstance(value, bool):  # as in the model: which values are found depends on the order
            variables.number(id, None, negated=False)
    literals = [
        [variables.number(each.signal.id, each.value, each.negated) for each in disjunction.literals]
        for disjunction in clause.disjunctions
    ]
    with Minisat22(bootstrap_with=[*literals, *variables.rules()]) as solver:
        solver.set_phases(variables.near(initial))
        if not solver.solve():
            return None
        return initial | variables.chosen(solver.get_model() or [])
