"""Follows a request from its arrival to the beginning of the callback that serves it."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.latencies.editing import PLAIN, Case, EditedNet, Firing
from dineros.analysis.latencies.following.runs import FollowedRuns
from dineros.analysis.latencies.markers import IDLE, NOW, WATCHING, exactly, some
from dineros.analysis.latencies.parts import Run


def follow_requests(
    net: EditedNet,
    followed: FollowedRuns,
    runs: Sequence[tuple[Run, dict[str, int]]],
    place: str,
    most: int,
) -> None:
    """Follow a request that waits on a place, behind those of the same client that wait there.

    Parameters
    ----------
    runs
        The callback, or its copies of each instance, and the tokens that a followed one puts.
    most
        How many requests wait there at most.
    """
    waits, ahead = net.place(f"observer of {place}"), net.place(f"observer of {place}: requests before")
    comes, producers = {WATCHING: 1, waits: 1}, net.producers(place)
    if most > 1:
        # How many wait may change while one is on its way: they are counted once it has arrived.
        landed, arrives = net.place(f"observer of {place}: landed"), f"observer of {place}: arrives"
        for producer in producers:
            net.redirect(producer, place, landed)
        net.add(Firing(arrives, {landed: 1}, {place: 1}, {}, {}, NOW))
        counted = (Case(take={IDLE: 1}, put=some(comes, ahead, k), **exactly(place, k)) for k in range(most))
        net.split(arrives, [PLAIN, *counted])
    else:
        for producer in producers:
            net.split(producer, [PLAIN, Case(take={IDLE: 1}, put=comes)])
    for run, begun in runs:
        for begin in followed.beginnings(run):
            if place in net.original(begin).take:
                first = Case(read={waits: 1}, take={ahead: 1})
                follows = Case(take={waits: 1}, put=begun, inhibit={ahead: 1})
                net.split(begin, [Case(inhibit={waits: 1}), first, follows])
