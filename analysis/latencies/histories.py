"""The histories of readers, servers, clients and actions in a timed net: what waits there, and what is lost.

A history that can lose something is a queue of the net. Others are places: what clients that wait have under
way is never more than fits.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from dineros.analysis.model.queues import queues_of
from dineros.analysis.model.wording import queue_end, source_of
from dineros.analysis.timed.exploring import Explored
from dineros.metamodel import pn, sym
from dineros.transformations.flattening.traces import Link
from dineros.transformations.language.meaning import QueueKind
from dineros.transformations.rules.actions.goals import A1, A1Result, A2Reject
from dineros.transformations.rules.clients.acceptances import A9
from dineros.transformations.rules.services import S1

_SENT = {"publisher", "dispatcher"}
"""Kinds of queues that hold messages in transit, which no reader has received yet."""
_Holding = Mapping[tuple[type, str], QueueKind]
_WITHOUT_QUEUE: _Holding = {
    (S1, "requests"): "request",
    (S1, "responses"): "response",
    (A1, "requested"): "goal",
    (A1Result, "result"): "result",
    (A2Reject, "refused"): "answer",
    (A9, "told"): "answer",
}
"""By rule and role, the places of what waits where no queue of a kind is needed."""


@dataclass(frozen=True)
class History:
    """A history."""

    places: tuple[str, ...]
    """Places of the net whose tokens wait in it."""
    drops: frozenset[str] = frozenset()
    """Transitions by which it loses something, also a request whose client has given up."""

    def longest(self, explored: Explored) -> int:
        """Return the greatest number that waits in it, in the markings that were found."""
        index = {name: at for at, name in enumerate(explored.net.untimed.places)}
        columns = [index[name] for name in self.places]
        return int(explored.markings[:, columns].sum(axis=1).max())


def histories_of(links: Iterable[Link]) -> dict[str, History]:
    """Return the histories of a flattened model, by the place of the model that takes from them.

    That is the place of a subscriber, the entry of a server, the place of a client for responses or feedback.
    A client of an action has histories of results and of answers; their names are that of the place of its
    goals, with ``.results`` and ``.answers``.
    """
    links = [each for each in links if isinstance(each.target, pn.Node)]
    instead: dict[str, set[str]] = defaultdict(set)
    for link in links:
        if link.meaning is not None and link.meaning.queue and link.meaning.part == "instead":
            instead[history_name(link.meaning.queue, queue_end(link))].add(link.target.id)
    found = {}
    for queue in queues_of(links):
        if queue.kind not in _SENT:
            name = history_name(queue.kind, queue_end(queue.link))
            found[name] = History((queue.load,), frozenset({*queue.drops, *instead[name]}))
    others: dict[str, list[str]] = defaultdict(list)
    for link in links:
        kind = None if link.maker is None else _WITHOUT_QUEUE.get((link.maker, link.role))
        if kind is not None:
            others[history_name(kind, _end(kind, link))].append(link.target.id)
    return found | {name: History(tuple(each)) for name, each in others.items() if name not in found}


def history_name(kind: str, end: object) -> str:
    """Return the name of a history of a kind at a place."""
    name = str(getattr(end, "id", ""))
    return f"{name}.{kind}s" if kind in ("result", "answer") else name


def _end(kind: QueueKind, link: Link) -> pn.Place:
    if kind == "request":
        return source_of(link, sym.ServiceChannel).server.entry
    if kind == "response":
        return source_of(link, sym.ClientPort).response
    if kind == "goal":
        return source_of(link, sym.ActionChannel).server.entry
    return source_of(link, sym.ActionClientPort).goal
