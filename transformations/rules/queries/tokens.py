"""What rules ask of the arcs around a place: which transitions change it, by how much, and what they need.

References to places have to be resolved before, so that arcs end at the places themselves.
"""

from __future__ import annotations

from collections import Counter

from dineros.metamodel import pn
from dineros.transformations.language.datatypes import WHOLE
from dineros.transformations.language.functions import Query


class Raising(Query):
    """The transitions whose firing leaves more tokens in a place than there were, by its arcs."""

    eclass = pn.Transition
    many = True
    _words = "what raises {}"

    @staticmethod
    def _answer(place: pn.Place) -> list[pn.Node]:
        return [transition for transition, tokens in _changes(place).items() if tokens > 0]


class Lowering(Query):
    """The transitions whose firing leaves fewer tokens in a place than there were, by its arcs."""

    eclass = pn.Transition
    many = True
    _words = "what lowers {}"

    @staticmethod
    def _answer(place: pn.Place) -> list[pn.Node]:
        return [transition for transition, tokens in _changes(place).items() if tokens < 0]


class Change(Query):
    """By how many tokens the firing of a transition raises a place; below 0 where it lowers it."""

    datatype = WHOLE
    _words = "change of {} by {}"

    @staticmethod
    def _answer(place: pn.Place, transition: pn.Transition) -> int:
        return _changes(place)[transition]


class MostPut(Query):
    """The largest number of tokens that one firing puts on a place; 0 where none does."""

    datatype = WHOLE
    _words = "heaviest arc into {}"

    @staticmethod
    def _answer(place: pn.Place) -> int:
        return max(_puts(place).values(), default=0)


class MostNeeded(Query):
    """The largest number of tokens that one firing needs in a place; 0 where none does."""

    datatype = WHOLE
    _words = "heaviest arc out of {}"

    @staticmethod
    def _answer(place: pn.Place) -> int:
        return max(_needs(place).values(), default=0)


def _puts(place: pn.Place) -> Counter[pn.Node]:
    puts: Counter[pn.Node] = Counter()
    for arc in place.incoming:
        puts[arc.source] += arc.weight
    return puts


def _needs(place: pn.Place) -> Counter[pn.Node]:
    needs: Counter[pn.Node] = Counter()
    for arc in place.outgoing:
        if arc.kind != pn.ArcKind.inhibitor:
            needs[arc.target] += arc.weight
    return needs


def _changes(place: pn.Place) -> Counter[pn.Node]:
    """Return what each transition puts on a place, less what it takes; a read arc does neither."""
    changes = _puts(place)
    for arc in place.outgoing:
        if arc.kind == pn.ArcKind.normal:
            changes[arc.target] -= arc.weight
    return changes
