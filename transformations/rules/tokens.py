"""What rules ask of the arcs around a place: which transitions change it, by how much, and what they need.

References to places have to be resolved before, so that arcs end at the places themselves.
"""

from __future__ import annotations

from collections import Counter

from dineros.metamodel import pn
from dineros.transformations.language.datatypes import WHOLE
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.language.expressions import Expression, Match

LANGUAGE.add(__name__)


class Raising(Expression):
    """The transitions whose firing leaves more tokens in a place than there were."""

    eclass = pn.Transition
    many = True

    def __init__(self, place: Expression) -> None:
        super().__init__(place)
        self.place = place

    def evaluate(self, match: Match) -> list[pn.Node]:
        """Return them, in the order of the arcs."""
        return [
            transition for transition, tokens in _changes(self.place.evaluate(match)).items() if tokens > 0
        ]

    def __str__(self) -> str:
        return f"what raises {self.place}"


class Lowering(Raising):
    """The transitions whose firing leaves fewer tokens in a place than there were."""

    def evaluate(self, match: Match) -> list[pn.Node]:
        """Return them, in the order of the arcs."""
        return [
            transition for transition, tokens in _changes(self.place.evaluate(match)).items() if tokens < 0
        ]

    def __str__(self) -> str:
        return f"what lowers {self.place}"


class Change(Expression):
    """By how many tokens the firing of a transition raises a place."""

    datatype = WHOLE

    def __init__(self, place: Expression, transition: Expression) -> None:
        super().__init__(place, transition)
        self.place = place
        self.transition = transition

    def evaluate(self, match: Match) -> int:
        """Return the change; below 0 where it lowers the place."""
        return _changes(self.place.evaluate(match))[self.transition.evaluate(match)]

    def __str__(self) -> str:
        return f"change of {self.place} by {self.transition}"


class Heaviest(Expression):
    """The largest number of tokens that one firing puts on a place, or needs there; 0 where none does."""

    datatype = WHOLE

    def __init__(self, place: Expression, *, puts: bool) -> None:
        super().__init__(place)
        self.place = place
        self.puts = puts

    def evaluate(self, match: Match) -> int:
        """Return the number."""
        place: pn.Place = self.place.evaluate(match)
        return max((_puts(place) if self.puts else _needs(place)).values(), default=0)

    def __str__(self) -> str:
        return f"heaviest arc {'into' if self.puts else 'out of'} {self.place}"


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
