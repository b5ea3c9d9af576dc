"""Guards and assignments of transitions, by the numbers of places and transitions.

The meaning of a guard is defined only in `dineros.metamodel.guards`; this module maps it to the running net.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from dineros.metamodel import pn, sym
from dineros.metamodel.guards.conditions import Condition
from dineros.metamodel.guards.deciding import as_value, read_step
from dineros.metamodel.token_data import FieldType, TokenType, Value
from dineros.runtime.nets.capacities import Arcs

Copied = tuple[int, str]
"""A field of the token that is taken or read from a place."""


class Decision(NamedTuple):
    """The guard and the assignments of one transition.

    Attributes
    ----------
    takes, reads : tuple of (int, Condition)
        For each place that it takes from, or reads, the condition for the token.
    assigns : tuple
        For places that it puts tokens on, the assigned fields: a value, or the field that is copied.
    """

    takes: tuple[tuple[int, Condition], ...] = ()
    reads: tuple[tuple[int, Condition], ...] = ()
    assigns: tuple[tuple[int, tuple[tuple[str, Value | Copied], ...]], ...] = ()


OPEN = Decision()
"""The decision of a transition without guard and assignments."""


def decision_of(
    transition: pn.Node,
    arcs: Sequence[Arcs],
    node_of: Sequence[pn.Place],
    type_of: Callable[[int], TokenType],
) -> Decision:
    """Return the guard and the assignments of a transition.

    Parameters
    ----------
    transition : pn.Node
        The transition in the model.
    arcs : sequence of Arcs
        The tokens it takes and puts, and the number its read arcs need, including those it takes.
    node_of : sequence of pn.Place
        For each place of the running net, its place in the model.
    type_of : callable
        Returns the token type of a place.

    Raises
    ------
    GuardError
        A guard or an assignment is invalid.
    """
    if not isinstance(transition, sym.Transition) or (transition.guard, transition.assigns) == (None, None):
        return OPEN
    inputs, outputs, reads = (dict(each) for each in arcs)
    number_of: dict[pn.Place, int] = {node_of[number]: number for number in (*outputs, *inputs, *reads)}

    def fields(place: pn.Place) -> dict[str, FieldType]:
        return {field.name: field for field in type_of(number_of[place]).fields}

    seen = {node_of[number]: count for number, count in (inputs | reads).items()}
    step = read_step(transition, seen, [node_of[number] for number in outputs], fields)
    asked = {number_of[place]: condition for place, condition in step.guard.items()}
    assigns = []
    for place, given in step.assigned.items():
        known = fields(place)
        values: list[tuple[str, Value | Copied]] = [
            (
                name,
                (number_of[value[0]], value[1]) if isinstance(value, tuple) else as_value(value, known[name]),
            )
            for name, value in given.items()
        ]
        assigns.append((number_of[place], tuple(values)))
    return Decision(
        takes=tuple((place, condition) for place, condition in asked.items() if place in inputs),
        reads=tuple((place, condition) for place, condition in asked.items() if place not in inputs),
        assigns=tuple(assigns),
    )


def kinds_of(decisions: Iterable[Decision]) -> tuple[tuple[int, Condition], ...]:
    """Return the places and conditions that occur in guards, each once."""
    return tuple(dict.fromkeys(each for decision in decisions for each in (*decision.takes, *decision.reads)))
