"""Kinds of tokens that guards distinguish, and the kinds that a transition takes and puts.

Tokens of a place have the same colour if no guard that they can reach distinguishes them. A field that no
guard uses is ignored. The partition is refined backwards along copies of fields until nothing
changes (as in partition refinement: Paige and Tarjan, SIAM J. Comput. 16(6), 1987).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement, product
from math import prod
from typing import NamedTuple

from dineros.metamodel import pn, sym
from dineros.metamodel.errors import GuardError
from dineros.metamodel.guards.conditions import Comparison, Condition, FieldName, comparisons
from dineros.metamodel.guards.reading import MOST_KINDS, Fields, Source
from dineros.metamodel.guards.values import (
    Values,
    classes_of,
    contains,
    is_subset,
    sample,
    values_of,
    values_text,
)
from dineros.metamodel.token_data import FieldType

Colour = tuple[Values, ...]
"""The values that each field of a token may have, in the order of the fields of its place's palette."""


@dataclass(frozen=True)
class Step:
    """The guard and the assignments of a transition.

    Attributes
    ----------
    guard : mapping of place to Condition
        Condition on the token of each place.
    assigned : mapping of place to mapping
        By place and field, the value that it assigns to tokens it puts, or the field that it copies.
    """

    guard: Mapping[pn.Place, Condition]
    assigned: Mapping[pn.Place, Mapping[str, int | Source]]


class Moves(NamedTuple):
    """Numbers of tokens that a transition takes, reads and puts, by place."""

    takes: Mapping[pn.Place, int]
    reads: Mapping[pn.Place, int]
    puts: Mapping[pn.Place, int]


class Variant(NamedTuple):
    """One way to fire a transition: the colours of the tokens that it takes, reads and puts, by place."""

    takes: Mapping[pn.Place, tuple[Colour, ...]]
    reads: Mapping[pn.Place, tuple[Colour, ...]]
    puts: Mapping[pn.Place, tuple[Colour, ...]]


class Palette:
    """The colours of the tokens of one place.

    Attributes
    ----------
    fields : dict of str to list
        By name of each field that guards use: its classes of values.
    """

    def __init__(self, declared: Mapping[str, FieldType], asked: Mapping[str, list[Comparison]]) -> None:
        self._declared = declared
        self.fields = {name: classes_of(declared[name], asked[name]) for name in sorted(asked)}
        total = prod(len(classes) for classes in self.fields.values())
        if total > MOST_KINDS:
            raise GuardError(f"guards tell {total} kinds of tokens apart, more than {MOST_KINDS}")

    @cached_property
    def colours(self) -> list[Colour]:
        """All colours."""
        return list(product(*self.fields.values()))

    def colour_of(self, data: Mapping[str, object]) -> Colour:
        """Return the colour of a token with values for all fields."""
        found = []
        for name, classes in self.fields.items():
            value = data[name]
            assert isinstance(value, int)
            found.append(next(each for each in classes if contains(each, int(value))))
        return tuple(found)

    def fulfils(self, colour: Colour, condition: Condition) -> bool:
        """Return whether the tokens of a colour fulfil a condition: either all of them do, or none."""
        values = {FieldName(None, name): sample(each) for name, each in zip(self.fields, colour, strict=True)}
        return condition.evaluate(values)

    def values(self, colour: Colour, field: str) -> Values:
        """Return the values that a field of a token of a colour may have."""
        return colour[list(self.fields).index(field)]

    def text(self, colour: Colour) -> str:
        """Return a colour in words: ``success=false``, ``level=0..3, mode=IDLE|BUSY``."""
        parts = zip(self.fields, colour, strict=True)
        return ", ".join(f"{name}={values_text(self._declared[name], values)}" for name, values in parts)


def palettes(
    steps: Mapping[sym.Transition, Step], fields: Fields, copied: Iterable[tuple[pn.Place, pn.Place]] = ()
) -> dict[pn.Place, Palette]:
    """Return the colours of the tokens of each place whose colours matter.

    Parameters
    ----------
    steps : mapping of transition to Step
        Guards and assignments of transitions.
    fields : callable
        The fields of a place's tokens.
    copied : iterable of tuple
        Pairs of places: a channel copies data from tokens of the first place to tokens of the second.

    Raises
    ------
    GuardError
        Guards distinguish too many kinds of tokens.
    """
    asked: dict[Source, list[Comparison]] = {}
    copies: dict[tuple[Source, Source], None] = {}
    for step in steps.values():
        for place, condition in step.guard.items():
            for each in comparisons(condition):
                _add(asked, (place, each.field.field), each)
        for place, given in step.assigned.items():
            for name, value in given.items():
                if isinstance(value, tuple):
                    copies[value, (place, name)] = None
    handed = list(copied)
    changed = True
    while changed:
        changed = False
        for before, after in handed:
            for place, name in list(asked):
                if place is after and can_be_handed(name, fields(before), fields(after)):
                    copies[(before, name), (after, name)] = None
        for source, target in copies:
            for each in asked.get(target, ()):
                same = Comparison(FieldName(None, source[1]), each.sign, each.value)
                changed |= _add(asked, source, same)
    by_place: dict[pn.Place, dict[str, list[Comparison]]] = {}
    for (place, name), known in asked.items():
        by_place.setdefault(place, {})[name] = known
    return {place: Palette(fields(place), known) for place, known in by_place.items()}


def can_be_handed(name: str, source: Mapping[str, FieldType], target: Mapping[str, FieldType]) -> bool:
    """Return whether each value of a field of one token is allowed in the field of that name of another."""
    if name not in source or name not in target:
        return False
    values, others = values_of(source[name]), values_of(target[name])
    return values is not None and others is not None and is_subset(values, others)


def variants(step: Step | None, moves: Moves, known: Mapping[pn.Place, Palette]) -> Iterator[Variant]:
    """Yield the ways to fire a transition, in a fixed order.

    Parameters
    ----------
    step : Step or None
        Its guard and assignments; None: it has none.
    moves : Moves
        Its tokens, in places with a palette.
    known : mapping of place to Palette
        The palettes.
    """
    guard = {} if step is None else step.guard
    assigned = {} if step is None else step.assigned
    copied = {value[0] for each in assigned.values() for value in each.values() if isinstance(value, tuple)}
    takes = {place: _allowed(place, count, guard, known) for place, count in moves.takes.items()}
    reads = {
        place: _allowed(place, count, guard, known)
        for place, count in moves.reads.items()
        if place in guard or place in copied
    }
    for chosen in product(*takes.values(), *reads.values()):
        taken = dict(zip(takes, chosen, strict=False))
        read = dict(zip(reads, chosen[len(takes) :], strict=True))
        seen = {place: colours[0] for place, colours in (taken | read).items()}
        puts = {
            place: _made(place, count, assigned.get(place, {}), seen, known)
            for place, count in moves.puts.items()
        }
        for made in product(*puts.values()):
            yield Variant(taken, read, dict(zip(puts, made, strict=True)))


def occurring(
    start: Iterable[tuple[pn.Place, Colour]], chosen: Iterable[Variant]
) -> set[tuple[pn.Place, Colour]]:
    """Return the colours that tokens of places can have if only these variants fire."""
    found, left = set(start), list(chosen)
    changed = True
    while changed:
        changed, waiting = False, []
        for variant in left:
            if found.issuperset(needed(variant)):
                found |= {(place, colour) for place, made in variant.puts.items() for colour in made}
                changed = True
            else:
                waiting.append(variant)
        left = waiting
    return found


def needed(variant: Variant) -> set[tuple[pn.Place, Colour]]:
    """Return the places and colours of the tokens that a variant takes and reads."""
    both = (variant.takes, variant.reads)
    return {(place, colour) for each in both for place, colours in each.items() for colour in colours}


def _allowed(
    place: pn.Place, count: int, guard: Mapping[pn.Place, Condition], known: Mapping[pn.Place, Palette]
) -> list[tuple[Colour, ...]]:
    """Return the choices of tokens that a guard lets a transition take from a place."""
    palette = known[place]
    colours = [c for c in palette.colours if place not in guard or palette.fulfils(c, guard[place])]
    return list(combinations_with_replacement(colours, count))


def _made(
    place: pn.Place,
    count: int,
    given: Mapping[str, int | Source],
    seen: Mapping[pn.Place, Colour],
    known: Mapping[pn.Place, Palette],
) -> list[tuple[Colour, ...]]:
    """Return the choices of tokens that a transition puts: any value if none is assigned."""
    palette = known[place]
    allowed = []
    for name, classes in palette.fields.items():
        value = given.get(name)
        if isinstance(value, tuple):
            source, field = value
            value = sample(known[source].values(seen[source], field))
        allowed.append([each for each in classes if value is None or contains(each, value)])
    return list(combinations_with_replacement(list(product(*allowed)), count))


def _add(asked: dict[Source, list[Comparison]], source: Source, comparison: Comparison) -> bool:
    known = asked.setdefault(source, [])
    if comparison in known:
        return False
    known.append(comparison)
    return True
