"""Where messages are lost because a managed node is not there, or not active."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from dineros.analysis.model.wording import source_of, topic_port, words
from dineros.metamodel import pn, sym
from dineros.transformations.flattening.traces import Link

Kind = Literal["inactive", "missed", "left"]

_KINDS: dict[str, Kind] = {
    "discard": "inactive",
    "miss": "missed",
    "left": "left",
    "gone": "left",
    "clear": "left",
}


@dataclass(frozen=True)
class Loss:
    """A way in which messages can be lost.

    Attributes
    ----------
    kind : {"inactive", "missed", "left"}
        The publisher's node is not active; the subscriber's is not configured; one of them was cleaned up or
        shut down while the message was on its way.
    elements : tuple of str
        Ids of the channel, and of the places of the ports.
    text : str
        What happens, in the words of the model.
    transitions : tuple of str
        Ids of the transitions of the net that do it; several of a publisher on a server page.
    """

    kind: Kind
    elements: tuple[str, ...]
    text: str
    transitions: tuple[str, ...]


def losses_of(links: Iterable[Link]) -> list[Loss]:
    """Return the ways in which a flattened model can lose messages so, in the order they were made."""
    found: dict[tuple[str, tuple[str, ...]], list[Link]] = {}
    for link in links:
        meaning = link.meaning
        if meaning is None or not isinstance(link.target, pn.Transition) or topic_port(link) is None:
            continue
        if meaning.part in _KINDS:
            ports = [source for source in link.sources if isinstance(source, sym.TopicPort)]
            elements = source_of(link, sym.TopicChannel).id, *(port.place.id for port in ports)
            # What is gone and what is cleared when a node is cleaned up is one loss.
            found.setdefault((_KINDS[meaning.part], elements), []).append(link)
    return [
        Loss(kind, elements, words(links[0]), tuple(link.target.id for link in links))  # type: ignore[arg-type]
        for (kind, elements), links in found.items()
    ]
