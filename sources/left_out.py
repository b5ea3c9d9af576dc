"""Reports calls that create entities and that no program is known to run, with a line for each file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import NamedTuple

from dineros.metamodel.errors import counted
from dineros.sources.folders import is_test

_MOST_LINES = 6
"""Limit of the line numbers that are shown for a file."""


class MakingCall(NamedTuple):
    """A call that creates an entity, at the line of its name."""

    path: str
    line: int
    name: str


def lines(calls: Iterable[MakingCall], reached: set[tuple[str, int]]) -> Iterator[str]:
    """Yield a line for each file with calls that no program reached.

    Parameters
    ----------
    calls : iterable of MakingCall
        All calls of the files that were read.
    reached : set of (str, int)
        Path and line of those that a program reached.
    """
    left = sorted(
        {each for each in calls if (each.path, each.line) not in reached and not is_test(each.path)}
    )
    for path, found in groupby(left, key=lambda each: each.path):
        inside = list(found)
        names = ", ".join(dict.fromkeys(each.name for each in inside))
        more = [str(each.line) for each in inside[1:_MOST_LINES]]
        if len(inside) > _MOST_LINES:
            more.append(f"{len(inside) - _MOST_LINES} more")
        also = f" (also line{'s' if len(inside) > 2 else ''} {', '.join(more)})" if more else ""
        what = f"{counted(len(inside), 'call')} of {names}{also}"
        yield f"{path}:{inside[0].line}: {what} in code that no node is known to run; the model lacks them"
