"""Paths of data through a system model: callbacks, topics and stored values between them, and their times."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from dineros.analysis.latencies.stores import Stored, stored_values
from dineros.analysis.nets.graph_parts import strongly_connected_parts
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of, readers_of, runs_callbacks
from dineros.metamodel.elements import arcs, channels, label, node_net_of, pages, resolve, system_model_of
from dineros.metamodel.matching import are_matched
from dineros.metamodel.times.given import duration_of, latency_between, reaction_of
from dineros.metamodel.times.overlaps import runs_overlapping
from dineros.metamodel.times.rates import on_the_way

MOST_PATHS = 16
"""Paths between two ends that are followed one by one."""


@dataclass(frozen=True)
class Hop:
    """A message from a publisher to a reader."""

    writer: sym.PublisherPort
    reader: sym.SubscriberPort


Way = Hop | Stored
"""How data comes from a callback to the next one."""
Fillers: TypeAlias = dict[pn.Node | None, list[sym.CallbackPage]]
"""By place the callbacks that put tokens there."""


@dataclass(frozen=True)
class Path:
    """Where an instance begins, through which callbacks its data goes, and where it ends."""

    callbacks: tuple[sym.CallbackPage, ...]
    hops: tuple[Way, ...] = ()
    """Between them; one more in front where the instance begins with a publication, and one less for each
    that is left out.
    """
    reader: sym.SubscriberPort | None = None
    """In whose history the instance begins, if its first callback is a subscription's."""
    last: sym.PublisherPort | None = None
    """The publication that ends it; otherwise it ends with its last callback."""

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
        """Return how data is passed on from a callback of the path; None for the last one."""
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


def pages_that_fill(model: sym.SystemModel) -> Fillers:
    """Return the callbacks that put tokens on each place; several may share the place of a publisher."""
    found: Fillers = defaultdict(list)
    for arc in arcs(model):
        filler, place = callback_page_of(arc.source), resolve(arc.target)
        if filler is not None and isinstance(place, pn.Place) and filler not in found[place]:
            found[place].append(filler)
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
    hops, fillers = hops_of(model), pages_that_fill(model)
    ways: list[Way] = [*hops, *stored_values(model)]
    if isinstance(first, sym.CallbackPage):
        starts = responses_of(first)
    else:
        starts = [
            Path((page,), (hop,))
            for hop in hops
            if hop.writer.channel is first
            and (page := callback_page_of(resolve(hop.reader.place))) is not None
        ]
    found = []
    for start in starts:
        for path in _longer(start, ways, fillers):
            for whole in _ended(path, last, fillers):
                found.append(whole)
                if len(found) == MOST_PATHS:
                    return found
    return found


def _longer(path: Path, ways: list[Way], fillers: Fillers) -> Iterator[Path]:
    yield path
    for way in ways:
        page = way.reader if isinstance(way, Stored) else callback_page_of(resolve(way.reader.place))
        if page is not None and page not in path.callbacks and _begins(way, path.callbacks[-1], fillers):
            longer = Path((*path.callbacks, page), (*path.hops, way), path.reader)
            yield from _longer(longer, ways, fillers)


def _begins(way: Way, page: sym.CallbackPage, fillers: Fillers) -> bool:
    """Return whether data flows out of a callback."""
    return way.writer is page if isinstance(way, Stored) else page in fillers[resolve(way.writer.place)]


def _ended(path: Path, last: sym.CallbackPage | sym.TopicChannel, fillers: Fillers) -> Iterator[Path]:
    if isinstance(last, sym.CallbackPage):
        if path.callbacks[-1] is last:
            yield path
        return
    for writer in last.publishers:
        if path.callbacks[-1] in fillers[resolve(writer.place)]:
            yield Path(path.callbacks, path.hops, path.reader, writer)


def has_only_newer(path: Path, number: int) -> bool:
    """Return whether all that comes to a callback of a path, on the path's way, is data of it in order.

    Then what displaces the data of a release comes from a later release. Another publisher, another callback
    that begins the same run, and runs that overlap and overtake each other break that.

    `number`: the callback, counted from 0.
    """
    way = path.before(number)
    if way is None:
        return True  # its release is one of the chain
    if not isinstance(way, Hop):
        return _runs_in_order(path, number - 1)
    channel = way.writer.channel
    if channel is None or len(channel.publishers) > 1:
        return False
    if number == 0:
        return True  # each publication is a release
    return _has_one_filler(way, path) and _runs_in_order(path, number - 1)


def _runs_in_order(path: Path, number: int) -> bool:
    """Return whether each run of a callback has data of the path, and runs end in their order."""
    page = path.callbacks[number]
    if runs_overlapping(page) > 1 or not has_only_newer(path, number):
        return False
    return not isinstance(path.before(number), Hop | None) or _has_one_beginning(page)


def _has_one_filler(hop: Hop, path: Path) -> bool:
    """Return whether one callback publishes by the publisher of a hop."""
    model = system_model_of(path.callbacks[0])
    return model is not None and len(pages_that_fill(model)[resolve(hop.writer.place)]) == 1


def _has_one_beginning(page: sym.CallbackPage) -> bool:
    readers = readers_of(page)
    return not readers if page.kind == sym.CallbackKind.timer else len(readers) == 1


def missing_on(path: Path) -> Iterator[str]:
    """Yield the missing times on a path, one feature of one element each."""
    for page in path.callbacks:
        node = node_net_of(page)
        if node is not None and not runs_callbacks(node):
            reaction = reaction_of(node)
            if reaction is None or reaction.latest is None:
                yield f"the reaction of node {label(node)} is not given"
            continue
        own = [page, *_beside(page)]
        for each in own:
            has_intervals = any(t.interval is not None for t in Body(each).transitions)
            if has_intervals and shares_clocks(each):
                yield f"the duration of callback {label(each)} is not given, and its runs overlap"
                continue
            duration = duration_of(each)
            if not has_intervals and (duration is None or duration.latest is None):
                where = "" if each is page else f", which can run before {label(page)}"
                yield f"the duration of callback {label(each)} is not given{where}"
    for hop in path.topics:
        topic = "" if hop.writer.channel is None else hop.writer.channel.topic
        latency = latency_between(hop.writer, hop.reader)
        ends = [node_net_of(port.place) for port in (hop.writer, hop.reader)]
        if managed := next((each for each in ends if each is not None and each.lifecycle is not None), None):
            yield f"node {label(managed)} of topic {topic} is managed, and nothing says when it is active"
        elif latency is None or latency.latest is None:
            yield f"the model gives no latency for topic {topic}"
        elif not on_the_way(hop.writer, hop.reader):
            yield f"nothing bounds how often topic {topic} is published"


def callbacks_in_no_time(model: sym.SystemModel) -> list[sym.CallbackPage]:
    """Return callbacks that start each other in a circle through topics and may take no time for it.

    Such a circle can run without end at one moment, so the markings that follow depend on how time passes.
    """
    fillers = pages_that_fill(model)
    follows: dict[sym.CallbackPage, list[sym.CallbackPage]] = {page: [] for page in callback_pages(model)}
    for hop in hops_of(model):
        reader = callback_page_of(resolve(hop.reader.place))
        assert reader is not None
        if _may_be_zero(latency_between(hop.writer, hop.reader)):
            for page in fillers[resolve(hop.writer.place)]:
                if not _takes_time(page):
                    follows[page].append(reader)
    return [
        page
        for part in strongly_connected_parts(follows)
        for page in part
        if len(part) > 1 or page in follows[page]
    ]


def _takes_time(page: sym.CallbackPage) -> bool:
    """Return whether each run takes some time; if transitions have intervals, each must take some."""
    if page.kind == sym.CallbackKind.timer:
        return True  # no message starts it
    steps = [each.interval for each in Body(page).transitions if each.interval is not None]
    if steps and len(steps) == len(Body(page).transitions):
        return not any(map(_may_be_zero, steps))
    return not steps and not _may_be_zero(duration_of(page))


def _may_be_zero(interval: pn.TimeInterval | None) -> bool:
    return interval is None or interval.earliest == 0


def shares_clocks(page: sym.CallbackPage) -> bool:
    """Return whether runs of a callback would share the clocks of its transitions, which are left open."""
    return runs_overlapping(page) > 1 and any(each.interval is not None for each in Body(page).transitions)


def _beside(page: sym.CallbackPage) -> Iterator[sym.CallbackPage]:
    """Yield the other callbacks of a node."""
    node = node_net_of(page)
    for each in node.eAllContents() if node is not None else ():
        if isinstance(each, sym.CallbackPage) and each is not page:
            yield each
