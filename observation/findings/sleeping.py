"""Adds up the sleeps of a callback."""

from __future__ import annotations

from collections.abc import Iterable

from dineros.sources.branches import Attempt, Branch, Called, Do, Leave, Loop, Turns
from dineros.sources.facts import Effect, Item

LONG = 1.0
"""Least seconds of a sleep that is reported."""


def sleeps_of(body: Iterable[Item]) -> tuple[list[Effect], float]:
    """Return the sleeps that a run of a callback certainly has unless it ends early, and their seconds.

    A loop with an unknown number of iterations has one. Of two branches, the one that sleeps less counts, or
    the one that continues.

    Examples
    --------
    >>> from dineros.sources.places import Place
    >>> nap = Effect("sleep", "0.2", Place("robot.py", 1), "in a loop", timeout=0.2)
    >>> sleeps_of([Turns([[Do(nap)], [Do(nap)]])])[1]
    0.4
    """
    found: list[Effect] = []
    seconds = 0.0
    for item in body:
        ways: list[list[Item]] = []
        if isinstance(item, Do) and item.effect.do == "sleep" and item.effect.timeout is not None:
            found.append(item.effect)
            seconds += item.effect.timeout
        elif isinstance(item, (Called, Loop)):
            ways = [item.body]
        elif isinstance(item, Turns):
            ways = [[each for turn in item.turns for each in turn]]
        elif isinstance(item, Attempt):
            ways = [[*item.body, *item.otherwise, *item.last]]
        elif isinstance(item, Branch):
            ways = [each for each in (item.then, item.otherwise) if not _leaves(each)]
        if ways:
            inner, least = min((sleeps_of(each) for each in ways), key=lambda pair: pair[1])
            found += inner
            seconds += least * (item.count if isinstance(item, Loop) else 1)
        if isinstance(item, Leave):
            break
    return found, seconds


def _leaves(block: list[Item]) -> bool:
    return any(isinstance(each, Leave) for each in block)
