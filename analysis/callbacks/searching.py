"""Callbacks that can wait forever, where not all markings can be seen.

For each callback, a part of the net decides whether it always ends; if not, a run continues from there
until the circle is closed. Callbacks of which that is not decided are looked for by runs of the whole net.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from random import Random

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.blocking import Blocked
from dineros.analysis.callbacks.circles import Circle
from dineros.analysis.callbacks.refining import Endings, why_unknown
from dineros.analysis.callbacks.waiting import Callback, Waiting
from dineros.analysis.callbacks.walking import Walks
from dineros.analysis.nets.compiled import CompiledNet

ENDINGS_SHARE = 0.7
"""Part of the time in which callbacks are decided on parts of the net; runs of the net have the rest."""

CLOSED = 4
"""Runs from where a callback never ends: another may close another circle."""

OWN_SECONDS = 5.0
"""Seconds of runs that look for a circle of their own, of callbacks that wait for others."""


@dataclass(frozen=True)
class Search:
    """What is found.

    Attributes
    ----------
    blocked : tuple of Blocked
        Callbacks that can wait forever: each circle once, and each other callback once, unless it waits for a
        circle.
    is_complete : bool
        Whether all others that were asked for are proved to end always.
    reason : str
        Why not; empty if they are.
    is_settled : bool
        Whether all others end always, but for those that wait for a circle that was found.
    """

    blocked: tuple[Blocked, ...]
    is_complete: bool
    reason: str = ""
    is_settled: bool = True


def searched(
    net: CompiledNet, waiting: Waiting, budget: Budget, pages: Collection[str] | None = None
) -> Search:
    """Search for callbacks that can wait forever, without the state space.

    Parameters
    ----------
    net : CompiledNet
        The net.
    waiting : Waiting
        What waits for what in it.
    budget : Budget
        Its time and memory.
    pages : collection of str, optional
        Ids of the pages whose callbacks are asked for; all by default.
    """
    walks = Walks(net, waiting)
    found: list[Blocked] = []
    left: list[Callback] = []
    waits: list[Callback] = []
    asked = [each for each in waiting.callbacks.values() if pages is None or each.waiter.element in pages]
    endings = Endings(net).of_all((each.places for each in asked), budget.share(ENDINGS_SHARE))
    for callback in asked:
        ending = endings[callback.places]
        if ending.status == "unknown":
            left.append(callback)
        elif ending.status == "waits":
            waits.append(callback)
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


def _unnamed(waits: list[Callback], found: list[Blocked]) -> list[Callback]:
    """Return the callbacks that can wait forever, though in no circle that was found."""
    named = {each.callback for each in found if each.circle is None}
    named.update(waiter for each in found if each.circle is not None for waiter in each.circle.waiters)
    return [callback for callback in waits if callback.waiter not in named]


def _once(found: list[Blocked]) -> list[Blocked]:
    """Return each circle once, and what has none once where it is in no circle either."""
    circles: dict[Circle, Blocked] = {}
    for each in found:
        if each.circle is not None:
            known = circles.get(each.circle)
            if known is None or len(each.trace) < len(known.trace):
                circles[each.circle] = each
    inside = {waiter for circle in circles for waiter in circle.waiters}
    others = {each.callback: each for each in found if each.circle is None and each.callback not in inside}
    return [*circles.values(), *others.values()]
