"""Where messages and requests are lost because a managed node is not there, or a message is too old."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from dineros.analysis.model.wording import source_of, topic_port, words
from dineros.metamodel import pn, sym

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link

Kind = Literal["inactive", "missed", "left", "unserved", "unanswered", "given up", "expired"]

_KINDS: dict[str, Kind] = {
    "discard": "inactive",
    "miss": "missed",
    "left": "left",
    "gone": "left",
    "clear": "left",
    "expire": "expired",
}
_OF_REQUESTS: dict[str, Kind] = {"miss": "unserved", "left": "unanswered", "unanswered": "unanswered"}


@dataclass(frozen=True)
class Loss:
    """A way in which messages or requests can be lost."""

    kind: Kind
    """The publisher's node is not active; the subscriber's is not configured; one of them was cleaned up or
    shut down while the message was on its way; the server's is not configured; it was cleaned up or shut down
    before it answered. ``given up``: one of the last two, and the client has a time-out. ``expired``: the
    message is older than its lifespan.
    """
    elements: tuple[str, ...]
    """Ids of the channel, and of the places of the ports; of a request that of the client's requests."""
    text: str
    """What happens, in the words of the model."""
    transitions: tuple[str, ...]
    """Ids of the transitions of the net that do it; several of a publisher on a server page."""


def losses_of(links: Iterable[Link]) -> list[Loss]:
    """Return the ways in which a flattened model can lose messages so, in the order they were made."""
    found: dict[tuple[str, tuple[str, ...]], list[Link]] = {}
    for link in links:
        meaning = link.meaning
        if meaning is None or not isinstance(link.target, pn.Transition):
            continue
        if topic_port(link) is not None and meaning.part in _KINDS:
            ports = [source for source in link.sources if isinstance(source, sym.TopicPort)]
            elements = source_of(link, sym.TopicChannel).id, *(port.place.id for port in ports)
            # Messages that are discarded and messages that are cleared when a node is cleaned up count as one
            # loss.
            found.setdefault((_KINDS[meaning.part], elements), []).append(link)
        elif meaning.queue == "request" and meaning.part in _OF_REQUESTS:
            client = source_of(link, sym.ClientPort)
            kind = _OF_REQUESTS[meaning.part] if client.timeout is None else "given up"
            elements = source_of(link, sym.ServiceChannel).id, client.request.id
            found.setdefault((kind, elements), []).append(link)
    return [
        Loss(kind, elements, words(links[0]), tuple(link.target.id for link in links))  # type: ignore[arg-type]
        for (kind, elements), links in found.items()
    ]
