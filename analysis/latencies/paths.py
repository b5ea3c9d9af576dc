"""Paths of data through a system model: callbacks, and the topics and stored values between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from dineros.analysis.latencies.stores import Stored, stored_values
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import callback_page_of, readers_of
from dineros.metamodel.elements import channels, pages, resolve
from dineros.metamodel.matching import are_matched

MOST_PATHS = 16
"""Paths between two ends that are followed one by one."""


@dataclass(frozen=True)
class Hop:
    """A message from a publisher to a reader."""

    writer: sym.PublisherPort
    reader: sym.SubscriberPort


Way = Hop | Stored
"""How data comes from a callback to the next one."""


@dataclass(frozen=True)
class Path:
    """Where an instance begins, through which callbacks its data goes, and where it ends.

    Attributes
    ----------
    callbacks : tuple of sym.CallbackPage
    hops : tuple of Hop or Stored
        Between them; one more in front where the instance begins with a publication, and one less for each
        that is left out.
    reader : sym.SubscriberPort or None
        In whose history the instance begins, if its first callback is a subscription's.
    last : sym.PublisherPort or None
        The publication that ends it; otherwise it ends with its last callback.
    """

    callbacks: tuple[sym.CallbackPage, ...]
    hops: tuple[Way, ...] = ()
    reader: sym.SubscriberPort | None = None
    last: sym.PublisherPort | None = None

    @property
    def begins_with_message(self) -> bool:
        """Whether it begins with a publication."""
        return len(self.hops) == len(self.callbacks)

    @property
    def topics(self) -> list[Hop]:
        """The hops over topics."""
        return [each for each in self.hops if isinstance(each, Hop)]

    @property
    def stores(self) -> list[Stored]:
        """The hops over stored values."""
        return [each for each in self.hops if isinstance(each, Stored)]

    def before(self, number: int) -> Way | None:
        """Return how data comes to a callback of the path; None if the path begins there."""
        at = number - (not self.begins_with_message)
        return self.hops[at] if at >= 0 else None

    def after(self, number: int) -> Way | None:
        """Return how data goes on from a callback of the path; None for the last one."""
        at = number + self.begins_with_message
        return self.hops[at] if at < len(self.hops) else None


def callback_pages(model: sym.SystemModel) -> list[sym.CallbackPage]:
    """Return the callbacks of a model, in its order."""
    return [page for page in pages(model) if isinstance(page, sym.CallbackPage)]


def hops_of(model: sym.SystemModel) -> list[Hop]:
    """Return the ways of messages from callbacks to callbacks."""
    found = []
    for topic in channels(model, sym.TopicChannel):
        for writer in topic.publishers:
            for reader in topic.subscribers:
                if callback_page_of(resolve(reader.place)) is not None and are_matched(writer, reader):
                    found.append(Hop(writer, reader))
    return found


def responses_of(page: sym.CallbackPage) -> list[Path]:
    """Return the paths of a callback alone: one for each history that it reads."""
    if page.kind == sym.CallbackKind.subscriber:
        return [Path((page,), reader=port) for port in readers_of(page)]
    return [Path((page,))]


def paths_between(
    model: sym.SystemModel,
    first: sym.CallbackPage | sym.TopicChannel,
    last: sym.CallbackPage | sym.TopicChannel,
) -> list[Path]:
    """Return the paths between two callbacks or topics that pass no callback twice."""
    hops = hops_of(model)
    ways: list[Way] = [*hops, *stored_values(model)]
    if isinstance(first, sym.CallbackPage):
        starts = responses_of(first)
    else:
        starts = [
            Path((page,), (hop,))
            for hop in hops
            if hop.writer.channel is first and (page := callback_page_of(hop.reader.place)) is not None
        ]
    found = []
    for start in starts:
        for path in _longer(start, ways):
            for whole in _ended(model, path, last):
                found.append(whole)
                if len(found) == MOST_PATHS:
                    return found
    return found


def _longer(path: Path, ways: list[Way]) -> Iterator[Path]:
    yield path
    for way in ways:
        writer, page = _ends(way)
        if writer is path.callbacks[-1] and page is not None and page not in path.callbacks:
            yield from _longer(Path((*path.callbacks, page), (*path.hops, way), path.reader), ways)


def _ends(way: Way) -> tuple[sym.CallbackPage | None, sym.CallbackPage | None]:
    if isinstance(way, Stored):
        return way.writer, way.reader
    return callback_page_of(way.writer.place), callback_page_of(way.reader.place)


def _ended(model: sym.SystemModel, path: Path, last: sym.CallbackPage | sym.TopicChannel) -> Iterator[Path]:
    if isinstance(last, sym.CallbackPage):
        if path.callbacks[-1] is last:
            yield path
        return
    for writer in last.publishers:
        if callback_page_of(writer.place) is path.callbacks[-1]:
            yield Path(path.callbacks, path.hops, path.reader, writer)
