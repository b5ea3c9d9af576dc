"""Finds the least time of one turn of a loop: what code sleeps in it, on each way through it."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, isfinite

from dineros.sources.branches import Attempt, Branch, Called, Do, Leave, Loop, Turns, walk
from dineros.sources.facts import Effect, Item

_CONTINUES, _RETURNS = "continues", "returns"


def pace_of(turn: list[Item]) -> float | None:
    """Return the least seconds of a turn that is followed by another one; None: no time, or unknown.

    Examples
    --------
    >>> pace_of([])
    """
    falls, _, goes_on = _least(turn)
    found = min(falls, goes_on)
    return round(found, 9) if found > 0 and isfinite(found) else None


def published_in(turn: list[Item], *, is_certain: bool = True) -> Iterator[tuple[Effect, bool]]:
    """Yield what a turn publishes at most once, and whether it certainly does."""
    for item in turn:
        if isinstance(item, Do):
            if item.effect.do == "publish":
                yield item.effect, is_certain
        elif isinstance(item, Called):
            yield from published_in(item.body, is_certain=is_certain and not _leaves(item.body))
        elif isinstance(item, Branch):
            for block in (item.then, item.otherwise):
                yield from published_in(block, is_certain=False)
        elif isinstance(item, Attempt):
            for block in (item.body, item.otherwise, *item.handlers, item.last):
                yield from published_in(block, is_certain=False)
        if _leaves([item]):
            is_certain = False


def _leaves(block: list[Item]) -> bool:
    """Return whether code may be left before its end."""
    return any(
        isinstance(item, (Leave, Attempt, Loop, Turns))
        or (isinstance(item, Branch) and (_leaves(item.then) or _leaves(item.otherwise)))
        for item in block
    )


def _least(block: list[Item]) -> tuple[float, float, float]:
    """Return the least seconds until a block falls through, its function returns, its loop continues."""
    falls, returns, goes_on = 0.0, inf, inf
    for item in block:
        if isinstance(item, Leave):
            returns = min(returns, falls) if item.way == _RETURNS else returns
            goes_on = min(goes_on, falls) if item.way == _CONTINUES else goes_on
            return inf, returns, goes_on
        if isinstance(item, Do):
            falls += _slept(item.effect)
            continue
        if isinstance(item, Called):
            inner = _least(item.body)
            falls += min(inner[0], inner[1])
            continue
        if isinstance(item, (Loop, Turns)) and _returns(item):
            returns = min(returns, falls)
        for other in _ways(item):
            returns, goes_on = min(returns, falls + other[1]), min(goes_on, falls + other[2])
        falls += min((other[0] for other in _ways(item)), default=0.0)
    return falls, returns, goes_on


def _returns(item: Item) -> bool:
    """Return whether a statement may end its function."""
    return any(isinstance(each, Leave) and each.way == _RETURNS for each in walk([item]))


def _ways(item: Item) -> list[tuple[float, float, float]]:
    """Return the times of the ways through a statement."""
    if isinstance(item, Branch):
        return [_least(item.then), _least(item.otherwise)]
    if isinstance(item, Attempt):
        last = _least(item.last)
        whole = _least([*item.body, *item.otherwise, *item.last])
        failed = [_least([*handler, *item.last]) for handler in item.handlers]
        early = min((_least(item.body)[1:]), default=inf)
        return [whole, *failed, (inf, *((last[0] + early,) * 2 if isfinite(early) else (inf, inf)))]
    return []


def _slept(effect: Effect) -> float:
    is_sleep = effect.do == "sleep" and effect.how in ("time.sleep", "rate")
    return effect.timeout or 0.0 if is_sleep else 0.0
