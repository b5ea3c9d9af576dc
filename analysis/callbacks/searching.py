"""Callbacks that can wait forever, where not all markings can be seen.

For each callback, a part of the net decides whether it always ends; if not, a run continues from there
until the circle is closed. Callbacks of which that is not decided are looked for by runs of the whole net.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from random import Random

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.callbacks.blocking import Blocked
from dineros.analysis.callbacks.circles import Circle
from dineros.analysis.callbacks.plans import Plans
from dineros.analysis.callbacks.refining import Ending, Endings, Running, why_unknown
from dineros.analysis.callbacks.waiting import Callback, Waiting
from dineros.analysis.callbacks.walking import Walks
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import last_marking
from dineros.metamodel.elements import is_unseen, node_net_of

ENDINGS = Share(time=0.7)
"""Part of the time in which callbacks are decided on parts of the net; runs of the net have the rest."""

CLOSED = 4
"""Runs from where a callback never ends: another may close another circle."""

OWN_SECONDS = 5.0
"""Seconds of runs that look for a circle of their own, of callbacks that wait for others."""


@dataclass(frozen=True)
class Search:
    """What is found."""

    blocked: tuple[Blocked, ...]
    """Callbacks that can wait forever: each circle once, and each other callback once, unless it waits for a
    circle.
    """
    is_complete: bool
    """Whether all other callbacks in the question are proved to end always."""
    reason: str = ""
    """Why not; empty if they are."""
    is_settled: bool = True
    """Whether all others end always, but for those that wait for a circle that was found."""


def searched(
    net: CompiledNet, waiting: Waiting, budget: Budget, pages: Collection[str] | None = None
) -> Search:
    """Search for callbacks that can wait forever, without the state space.

    Callbacks of nodes that stand for other programs are not asked for: they are found in circles only, and
    each circle has a callback of another node.

    `pages`: ids of the pages whose callbacks are asked for; all by default.
    """
    walks = Walks(net, waiting)
    found: list[Blocked] = []
    left: list[Callback] = []
    waits: list[Callback] = []
    asked = [each for each in _seen(waiting) if pages is None or each.waiter.element in pages]
    endings = _endings(net, waiting, asked, ENDINGS.share(budget), walks)
    for callback in asked:
        ending = endings[callback.places]
        if ending.status == "unknown":
            left.append(callback)
        elif ending.status == "waits":
            waits.append(callback)
            closed = walks.closed_after(ending.trace, budget, callback)
            if closed is not None:
                found.append(closed)
                continue
            runs = [
                blocked
                for seed in range(CLOSED)
                for blocked in walks.after(ending.trace, Random(seed), budget, callback)
            ]
            circles = [blocked for blocked in runs if blocked.circle is not None]
            found += circles or [blocked for blocked in runs if blocked.callback == callback.waiter]
    if left:
        found += walks.found(budget)
    elif _unnamed(waits, found):  # it may also wait for itself, not only for a circle of others
        found += walks.found(budget.at_most(OWN_SECONDS))
    reason = why_unknown(endings.values())
    is_settled = not left
    if not left and (others := _unnamed(waits, found)):
        is_settled = any(blocked.circle is not None for blocked in found)  # they may wait for that one
        named = ", ".join(callback.waiter.text for callback in others)
        reason = f"{named} can wait for these; it is unknown whether they can also wait for something else"
    return Search(tuple(map(walks.shortest, _once(found))), not reason, reason, is_settled)


def near_circles(net: CompiledNet, waiting: Waiting, budget: Budget) -> list[Blocked]:
    """Return circles that planned runs show: a part of what `searched` finds, at little cost."""
    walks, asked = Walks(net, waiting), _seen(waiting)
    waits = _planned(net, waiting, asked, walks)
    closed = [
        walks.closed_after(waits[each.places].trace, budget, each) for each in asked if each.places in waits
    ]
    return [walks.shortest(each) for each in _once([each for each in closed if each is not None])]


def _seen(waiting: Waiting) -> list[Callback]:
    """Return the callbacks of nodes that do not stand for other programs."""
    return [each for each in waiting.callbacks.values() if not is_unseen(node_net_of(each.waiter.model))]


def _endings(
    net: CompiledNet, waiting: Waiting, asked: Sequence[Callback], budget: Budget, walks: Walks
) -> dict[Running, Ending]:
    """Return whether callbacks always end, by small parts of the net, planned runs and larger parts."""
    ends, found = Endings(net), dict[Running, Ending]()
    for callback in asked:
        ending = ends.at_once(callback.places, budget)
        if ending is not None and ending.status != "unknown":
            found[callback.places] = ending
    left = [each for each in asked if each.places not in found]
    found.update(_planned(net, waiting, left, walks))
    found.update(ends.of_all((each.places for each in left if each.places not in found), budget))
    return found


def _planned(
    net: CompiledNet, waiting: Waiting, asked: Sequence[Callback], walks: Walks
) -> dict[Running, Ending]:
    """Return which callbacks never end after a run that is planned for one of their steps.

    Runs after which another of their steps is enabled are not followed further.
    """
    if not asked:
        return {}
    plans, ways = Plans(net), list[tuple[int, ...]]()
    for callback in asked:
        steps = waiting.steps[callback.page, callback.index]
        for way in map(plans.way_to, steps):
            if way is None:
                continue
            marking = last_marking(net, way)
            if callback.has_begun(marking) and not any(net.is_enabled(each, marking) for each in steps):
                ways.append(way)
    endless = walks.endless_after(sorted(ways, key=len))
    return {each.places: Ending("waits", endless[each.waiter]) for each in asked if each.waiter in endless}


def _unnamed(waits: list[Callback], found: list[Blocked]) -> list[Callback]:
    """Return the callbacks that can wait forever, though in no circle that was found."""
    named = {each.callback for each in found if each.circle is None}
    named.update(waiter for each in found if each.circle is not None for waiter in each.circle.waiters)
    return [callback for callback in waits if callback.waiter not in named]


def _once(found: list[Blocked]) -> list[Blocked]:
    """Return each circle once, and each callback that is in no circle once."""
    circles: dict[Circle, Blocked] = {}
    for each in found:
        if each.circle is not None:
            known = circles.get(each.circle)
            if known is None or len(each.trace) < len(known.trace):
                circles[each.circle] = each
    inside = {waiter for circle in circles for waiter in circle.waiters}
    others = {each.callback: each for each in found if each.circle is None and each.callback not in inside}
    return [*circles.values(), *others.values()]
