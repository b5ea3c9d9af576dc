"""Queries about the arcs around a place: which transitions change it, by how much, and what they need.

References to places must be resolved before, so that arcs end at the places themselves.
"""

from __future__ import annotations

from collections import Counter

from dineros.metamodel import pn
from dineros.transformations.language import WHOLE, Query


class Raising(Query):
    """The transitions that increase the number of tokens on a place, according to its arcs."""

    eclass = pn.Transition
    many = True
    _words = "what raises {}"

    @staticmethod
    def _answer(place: pn.Place) -> list[pn.Node]:
        return [transition for transition, tokens in _changes(place).items() if tokens > 0]


class Lowering(Query):
    """The transitions that decrease the number of tokens on a place, according to its arcs."""

    eclass = pn.Transition
    many = True
    _words = "what lowers {}"

    @staticmethod
    def _answer(place: pn.Place) -> list[pn.Node]:
        return [transition for transition, tokens in _changes(place).items() if tokens < 0]


class Change(Query):
    """Change of the number of tokens on a place by the firing of a transition; may be negative."""

    datatype = WHOLE
    _words = "change of {} by {}"

    @staticmethod
    def _answer(place: pn.Place, transition: pn.Transition) -> int:
        return _changes(place)[transition]


class MostPut(Query):
    """The largest number of tokens that one firing puts on a place; 0 if none does."""

    datatype = WHOLE
    _words = "heaviest arc into {}"

    @staticmethod
    def _answer(place: pn.Place) -> int:
        return max(_puts(place).values(), default=0)


class MostNeeded(Query):
    """The largest number of tokens that one firing needs on a place; 0 if none does."""

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
    """Return the tokens that each transition puts on a place minus those it takes; read arcs count as 0."""
    changes = _puts(place)
    for arc in place.outgoing:
        if arc.kind == pn.ArcKind.normal:
            changes[arc.target] -= arc.weight
    return changes
