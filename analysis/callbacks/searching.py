"""Callbacks that can wait forever, where not all markings can be seen.

For each callback, a part of the net decides whether it always ends; if not, a run continues from there
until the circle is closed. Callbacks of which that is not decided are looked for by runs of the whole net.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from types import MappingProxyType

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.blocking import Blocked
from dineros.analysis.callbacks.circles import Circle
from dineros.analysis.callbacks.refining import Ending, Endings, Running, why_unknown
from dineros.analysis.callbacks.waiting import Callback, Waiting
from dineros.analysis.callbacks.walking import Walks
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel.elements import is_unseen, node_net_of

ENDINGS_SHARE = 0.7
"""Part of the time in which callbacks are decided on parts of the net; runs of the net have the rest."""

CLOSED = 4
"""Runs from where a callback never ends: another may close another circle."""

NOTHING_NEAR: Mapping[int, Sequence[int]] = MappingProxyType({})

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
    net: CompiledNet,
    waiting: Waiting,
    budget: Budget,
    pages: Collection[str] | None = None,
    near: Mapping[int, Sequence[int]] = NOTHING_NEAR,
) -> Search:
    """Search for callbacks that can wait forever, without the state space.

    Callbacks of nodes that stand for other programs are not asked for: they are found in circles only, and
    each circle has a callback of another node.

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
    near : mapping of int to sequence of int, optional
        Known firing sequences, by the transition with which they end. They are looked at before parts of the
        net that cost more than a moment.
    """
    walks = Walks(net, waiting)
    found: list[Blocked] = []
    left: list[Callback] = []
    waits: list[Callback] = []
    asked = [
        each
        for each in waiting.callbacks.values()
        if not is_unseen(node_net_of(each.waiter.model)) and (pages is None or each.waiter.element in pages)
    ]
    endings = _endings(Endings(net), waiting, asked, budget.share(ENDINGS_SHARE), walks, near)
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


def _endings(
    ends: Endings,
    waiting: Waiting,
    asked: Sequence[Callback],
    budget: Budget,
    walks: Walks,
    near: Mapping[int, Sequence[int]],
) -> dict[Running, Ending]:
    """Return whether callbacks always end, by small parts of the net, known runs and larger parts."""
    found: dict[Running, Ending] = {}
    for callback in asked:
        ending = ends.at_once(callback.places, budget)
        if ending is not None and ending.status != "unknown":
            found[callback.places] = ending
    left = [each for each in asked if each.places not in found]
    steps = dict.fromkeys(step for each in left for step in waiting.steps[each.page, each.index])
    endless = walks.endless_after(sorted((near[step] for step in steps if step in near), key=len))
    found.update((each.places, Ending("waits", endless[id(each)])) for each in left if id(each) in endless)
    found.update(ends.of_all((each.places for each in left if each.places not in found), budget))
    return found


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
