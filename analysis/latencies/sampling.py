"""How an observer follows a value that a callback stores on a place, until another callback reads it.

The place holds one value at most. A marker is there while that value is the one that is followed. A
transition that takes the value displaces it; one that only reads it does not.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from dineros.analysis.latencies.editing import PLAIN, Case, EditedNet
from dineros.analysis.latencies.parts import Parts, Run
from dineros.analysis.latencies.stores import Stored
from dineros.analysis.timed.exploring import Explored
from dineros.metamodel.elements import label


class NotFollowedError(Exception):
    """A part of a path is of a kind that the observer does not follow."""


def place_of_value(parts: Parts, explored: Explored, stored: Stored) -> str:
    """Return the place of the net that holds a value.

    Raises
    ------
    NotFollowedError
        There are several, or it holds several values at once.
    """
    found = parts.places.get(stored.place, [])
    if len(found) != 1:
        raise NotFollowedError
    at = explored.net.untimed.places.index(found[0])
    if int(explored.markings[:, at].max()) > 1:
        raise NotFollowedError(
            f"place {label(stored.place)} holds several values, which cannot be distinguished"
        )
    return found[0]


def displaced(
    net: EditedNet, parts: Parts, stored: Stored, place: str, marker: str, lost: Case, newer_counts: bool
) -> bool:
    """Let transitions displace a value that is followed; return whether it is known which of them do.

    Parameters
    ----------
    net, parts
        The net with the observer, and its parts.
    stored
        The value.
    place, marker
        Where it is, and what is marked while it is the one that is followed.
    lost
        What happens if it is displaced.
    newer_counts
        Whether a newer value of the same callback is followed instead.
    """
    writes, reads = (
        {name for run in parts.runs_of(page) for name in run.moves | run.starts}
        for page in (stored.writer, stored.reader)
    )
    is_known = True
    for name in list(net.cases):
        if name in reads or place not in net.original(name).take:
            continue
        if name not in writes:  # it stores a value of its own, or tests whether there is one
            net.split(name, [PLAIN, lost])
            is_known = False
        elif not newer_counts:
            net.split(name, [Case(inhibit={marker: 1}), lost])
    return is_known


def require_steady(
    net: EditedNet, explored: Explored, run: Run, place: str, told_apart: Iterable[str]
) -> None:
    """Refuse a run that reads a value while a clock runs for what it publishes or ends with.

    The observer follows a run from the moment at which it reads the value. A clock that runs across that
    moment would start again.

    Parameters
    ----------
    net, explored
        The net with the observer, and all markings of the net without it.
    run, place
        What reads, and the place of the value.
    told_apart
        Transitions of which the observer makes cases.

    Raises
    ------
    NotFollowedError
        There is such a run, or several runs overlap.
    """
    if run.is_colored:
        raise NotFollowedError(f"runs of callback {label(run.page)} overlap, and it reads what others store")
    index = {name: at for at, name in enumerate(explored.net.untimed.places)}
    timed = [name for name in told_apart if not _is_prompt(net, name)]
    reading = [name for name in sorted(run.moves | run.starts) if _reads(net, name, place)]
    for reads in reading:
        for other in timed:
            needs: dict[str, int] = {}
            for firing in (net.original(reads), net.original(other)):
                for of in (firing.take, firing.read):
                    for each, weight in of.items():
                        needs[each] = needs.get(each, 0) + weight
            held = [explored.markings[:, index[each]] >= weight for each, weight in needs.items()]
            if np.logical_and.reduce(held).any():
                raise NotFollowedError(
                    f"callback {label(run.page)} reads a value while another step of it is timed"
                )


def _reads(net: EditedNet, name: str, place: str) -> bool:
    firing = net.original(name)
    return place in firing.take or place in firing.read


def _is_prompt(net: EditedNet, name: str) -> bool:
    interval = net.original(name).interval
    return interval.is_free or interval.latest == 0
