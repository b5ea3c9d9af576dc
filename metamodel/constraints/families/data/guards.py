"""Guards and assignments: what they name is there, and fits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

from dineros.metamodel import pn, sym
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.errors import GuardError
from dineros.metamodel.guards.colours import Step
from dineros.metamodel.guards.conditions import Condition
from dineros.metamodel.guards.reading import Source, read_assignments, read_guard
from dineros.metamodel.token_data import FieldType


class _Seen(NamedTuple):
    """How many tokens of which places a transition takes or reads, and how many it puts."""

    takes: Counter[pn.Place]
    puts: Counter[pn.Place]


def _arcs(index: Index) -> dict[pn.Node, _Seen]:
    found: dict[pn.Node, _Seen] = {}
    for arc in index.all(pn.Arc):
        source, target = index.final(arc.source), index.final(arc.target)
        if isinstance(source, pn.Place) and isinstance(target, pn.Transition):
            if arc.kind != pn.ArcKind.inhibitor:
                found.setdefault(target, _Seen(Counter(), Counter())).takes[source] += arc.weight
        elif isinstance(source, pn.Transition) and isinstance(target, pn.Place):
            found.setdefault(source, _Seen(Counter(), Counter())).puts[target] += arc.weight
    return found


def _seen(transition: sym.Transition, index: Index) -> _Seen:
    return index.once("tokens of transitions", lambda: _arcs(index)).get(
        transition, _Seen(Counter(), Counter())
    )


def _are_known(transition: sym.Transition, index: Index) -> bool:
    """Whether the fields of all its places are known: ROS messages may be not installed here."""
    seen = _seen(transition, index)
    return all(index.fields_of(index.token_type_of(place)) is not None for place in (*seen.takes, *seen.puts))


def _fields(place: pn.Place, index: Index) -> Mapping[str, FieldType]:
    return index.fields_of(index.token_type_of(place)) or {}


def _guard(transition: sym.Transition, index: Index) -> Mapping[pn.Place, Condition]:
    """Return what a guard asks of the token of each place; GuardError: it cannot be read."""
    if transition.guard is None:
        return {}
    return read_guard(transition.guard, _seen(transition, index).takes, lambda place: _fields(place, index))


def _assigned(transition: sym.Transition, index: Index) -> Mapping[pn.Place, Mapping[str, int | Source]]:
    """Return what assignments give to tokens of each place; GuardError: they cannot be read."""
    if transition.assigns is None:
        return {}
    takes, puts = _seen(transition, index)
    return read_assignments(transition.assigns, takes, puts, lambda place: _fields(place, index))


def _readable(transition: sym.Transition, index: Index) -> Step | None:
    try:
        if _are_known(transition, index):
            return Step(_guard(transition, index), _assigned(transition, index))
    except GuardError:
        pass
    return None


def _has_guard(transition: sym.Transition, index: Index) -> bool:
    return transition.guard is not None and _are_known(transition, index)


def _has_assignments(transition: sym.Transition, index: Index) -> bool:
    return transition.assigns is not None and _are_known(transition, index)


@constraint(
    "{it} has a guard that cannot be used: {found}",
    fix="write a condition over fields of tokens that it takes or reads, such as Response.success = false",
    guard=_has_guard,
)
def guard_usable(transition: sym.Transition, index: Index) -> Outcome:
    """A guard asks about fields with few values of single tokens, and some token fulfils it."""
    try:
        _guard(transition, index)
    except GuardError as error:
        return error
    return True


@constraint(
    "{it} has assignments that cannot be used: {found}",
    fix="assign a value or a field to a field of a token that it puts: Answer.success := true",
    guard=_has_assignments,
)
def assignments_usable(transition: sym.Transition, index: Index) -> Outcome:
    """Assignments give fields of tokens that a transition puts values that they can have."""
    try:
        _assigned(transition, index)
    except GuardError as error:
        return error
    return True


def _sent(places: Mapping[pn.Place, object], index: Index) -> Outcome:
    """Return the first place whose tokens a port sends, in words; True: there is none."""
    return next(
        (describe(place) for place in places if any(use.sends for use in index.port_uses.get(place, ()))),
        True,
    )


@constraint(
    "{it} has a guard about tokens that a port sends: {found}",
    fix="put the guard on the transition before it, about the token that this one takes",
    guard=_has_guard,
)
def guard_not_sent(transition: sym.Transition, index: Index) -> Outcome:
    """No guard asks about tokens that wait to be sent: their data would decide in two nodes."""
    step = _readable(transition, index)
    return step is None or _sent(step.guard, index)
