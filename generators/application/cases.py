"""Test cases of transitions: the tokens that a test puts, and the expected result of the firing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from dineros.generators.application.arcs import ArcEnd
from dineros.metamodel import sym
from dineros.metamodel.token_data import Value


@dataclass(frozen=True)
class Case:
    """A marking and signals under which a transition can fire; ids are those of the running net.

    Attributes
    ----------
    transition : str
        The transition, in the first instance if there are several.
    marking : dict of str to int
        Tokens of the places it needs; all others are empty.
    signals : dict of str to bool
        Values of the signals that differ from their initial values.
    change : dict of str to int
        Change of the marking by the firing.
    obstacle : str
        Why it cannot fire with only these; empty: it can.
    data : dict of str to dict
        For each place, the fields of its token that occur in a guard.
    """

    transition: str
    marking: dict[str, int]
    signals: dict[str, bool]
    change: dict[str, int]
    obstacle: str = ""
    data: dict[str, dict[str, Value]] = field(default_factory=dict)


def case_of(
    transition: str,
    inputs: Sequence[ArcEnd],
    outputs: Sequence[ArcEnd],
    clause: sym.InputClause | None,
    initial: dict[str, bool],
    running: Callable[[str], str],
    data: Mapping[str, dict[str, Value]],
) -> Case:
    """Return the case of a transition.

    Parameters
    ----------
    transition : str
        Its id in the running net.
    inputs, outputs : sequence of ArcEnd
        Its arcs.
    clause : sym.InputClause or None
        Its input clause.
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
    obstacle = "" if signals is not None else "its clause cannot be true"
    for place, limit in limits.items():
        if marking.get(place, 0) >= limit:
            obstacle = f"an inhibitor arc forbids what it needs on {place}"
    return Case(
        transition,
        marking,
        {id: value for id, value in (signals or {}).items() if value != initial[id]},
        {place: count for place, count in change.items() if count},
        obstacle,
        {running(place): values for place, values in data.items()},
    )


def satisfying(clause: sym.InputClause | None, initial: dict[str, bool]) -> dict[str, bool] | None:
    """Return values of the signals that fulfil a clause, near the initial ones; None: it has none."""
    from pysat.solvers import Minisat22

    if clause is None:
        return initial
    numbers = {id: number for number, id in enumerate(initial, start=1)}
    with Minisat22() as solver:
        for disjunction in clause.disjunctions:
            literals = [
                -numbers[literal.signal.id] if literal.negated else numbers[literal.signal.id]
                for literal in disjunction.literals
            ]
            solver.add_clause(literals)
        solver.set_phases([number if initial[id] else -number for id, number in numbers.items()])
        if not solver.solve():
            return None
        model = set(solver.get_model() or [])
    return {
        id: number in model if number in model or -number in model else initial[id]
        for id, number in numbers.items()
    }
