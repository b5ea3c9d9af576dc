"""Which causes must be fixed together before a consequence of several of them disappears."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

Cause = TypeVar("Cause")
Consequence = TypeVar("Consequence")


def fewest_causes(
    causes: Sequence[Cause],
    consequences: Sequence[Consequence],
    gone: Callable[[Sequence[Cause], Sequence[Consequence]], Sequence[Consequence]],
) -> list[tuple[list[Cause], list[Consequence]]]:
    """Group consequences by the causes that must be fixed for them, without causes that are not needed.

    Causes are left out one after the other, the last one first, as long as the consequence stays absent. So
    no cause of a group can be left out, but another group may be as small. Groups of one cause are not tried.

    Parameters
    ----------
    causes : sequence
        Causes that, fixed together, remove all the consequences.
    consequences : sequence
        What is gone then.
    gone : callable
        Returns which of some consequences are gone if some causes are fixed. It may return fewer than there
        are, for example if time runs out: then a group may be larger than necessary.
    """
    return _groups(list(causes), list(consequences), gone, len(causes) - 1)


def _groups(
    causes: list[Cause],
    consequences: list[Consequence],
    gone: Callable[[Sequence[Cause], Sequence[Consequence]], Sequence[Consequence]],
    last: int,
) -> list[tuple[list[Cause], list[Consequence]]]:
    """Group consequences; the causes after the last one that is tried are needed."""
    groups = []
    for number in range(last, -1, -1):
        if len(causes) < 3 or not consequences:
            break
        fewer = [*causes[:number], *causes[number + 1 :]]
        ids = {id(each) for each in gone(fewer, consequences)}
        if part := [each for each in consequences if id(each) in ids]:
            groups += _groups(fewer, part, gone, number - 1)
            consequences = [each for each in consequences if id(each) not in ids]
    return [*groups, (causes, consequences)] if consequences else groups
