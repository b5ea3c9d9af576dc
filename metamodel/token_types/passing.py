"""Which data is passed on when a transition fires, if its places have several token types.

A place gets the data of the first token of its type that the transition takes, or reads. So nothing is passed
on to a place whose type the transition does not take: a handler makes that data.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Generic, NamedTuple, TypeVar

P = TypeVar("P", bound=Hashable)


class Passing(NamedTuple, Generic[P]):
    """What continues at a transition.

    Attributes
    ----------
    result : place or None
        A place with the type of the data that continues, which handlers see and change; None: none is there.
    made : tuple of places
        Those that get tokens of a type that the transition neither takes nor reads.
    demanded : tuple of places
        Those of them that handlers have to name when they give data: their type is not that of the result.
    """

    result: P | None
    made: tuple[P, ...]
    demanded: tuple[P, ...]


def passing(
    inputs: Sequence[tuple[P, int]],
    outputs: Sequence[tuple[P, int]],
    reads: Sequence[P],
    type_of: Callable[[P], object],
) -> Passing[P]:
    """Return what continues at a transition.

    The result is of the type of the first token taken, if some place gets tokens of it or none gets any;
    otherwise of the type of the first place that gets tokens. Tokens that a loop takes and puts back come
    last. A transition that takes nothing puts tokens with the defaults of their types.

    Parameters
    ----------
    inputs, outputs : sequence of (place, int)
        What it takes and puts, no place twice in one of them.
    reads : sequence of places
        What its read arcs see.
    type_of : callable
        Returns the type of a place's tokens; types are the same where they are the same object.

    Examples
    --------
    >>> types = {"Orders": "Order", "Goal": "Pose", "Log": "Text"}
    >>> passing([("Orders", 1)], [("Goal", 1), ("Log", 1)], [], types.get)
    Passing(result='Goal', made=('Goal', 'Log'), demanded=('Log',))
    """
    back, taken = {place for place, _ in outputs}, dict(inputs)
    own = [place for place in taken if place not in back]
    sources = [*own, *(place for place in taken if place in back), *reads]
    targets = [place for place, weight in outputs if weight > taken.get(place, 0)]
    if not sources:
        return Passing(targets[0] if targets else None, (), ())
    first = type_of(sources[0])
    goes_on = not targets or any(type_of(target) is first for target in targets)
    result = sources[0] if goes_on else targets[0]
    there = {id(type_of(place)) for place in sources}
    made = tuple(place for place in targets if id(type_of(place)) not in there)
    return Passing(result, made, tuple(place for place in made if type_of(place) is not type_of(result)))
