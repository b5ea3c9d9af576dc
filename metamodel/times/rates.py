"""How many messages can be on their way at once: a bound that holds for all response times.

A run of a callback that overlaps a window of time was running when the window began, or has begun in it. Runs
that begin in it were waiting when the window began, or were released in it. So a timer that strikes every 10
ms overlaps a window of 25 ms with at most 1 + 1 + 3 runs: strikes do not pile up. A message that is on its
way at some moment was sent not longer ago than its greatest latency, which is such a window.

A request that begins a run in a window was under way when the window began, or was sent in it. A client has a
number of requests under way. If it gives up, requests that it has forgotten wait in the history, too.

The engine of a node net fires what is enabled, in any order and as often as it can. There each firing of a
transition takes the tick, or the message, that it needs: it was there when the window began, or came in it.

Steps with intervals of their own bound what a callback puts, too, however often it runs, and however often a
run repeats them (`dineros.metamodel.times.paces`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from fractions import Fraction
from typing import TypeAlias

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of, readers_of, runs_callbacks
from dineros.metamodel.callbacks.under_way import outstanding
from dineros.metamodel.callbacks.waiting import Waiting
from dineros.metamodel.calls import UNLIMITED, gives_up, services
from dineros.metamodel.elements import channels, node_net_of, node_nets, resolve, system_model_of
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.matching import are_matched
from dineros.metamodel.times.given import (
    duration_of,
    is_exclusive,
    latency_between,
    latency_of_calls,
    lifespan_between,
    period_of,
    runs_at_once,
    waits,
)
from dineros.metamodel.times.once import once, unchanged
from dineros.metamodel.times.paces import paces, slots
from dineros.metamodel.times.results import goals_ended
from dineros.metamodel.times.runs import most_put, only_put_by, ports_at, stand_for

MOST_ON_THE_WAY = 64
"""Messages between two ports, each with a clock of its own."""


_Pair: TypeAlias = tuple[sym.PublisherPort, sym.SubscriberPort]
_SETTLED: ContextVar[dict[_Pair, int] | None] = ContextVar("messages on their way", default=None)


class TooManyOnTheWayError(DinerosError):
    """More messages can be on their way at once than can be timed one by one."""


def seconds_of(bound: float) -> Fraction:
    """Return a bound of an interval, exactly."""
    return Fraction(repr(bound))


@contextmanager
def settled(model: sym.SystemModel) -> Iterator[None]:
    """Keep the numbers of messages on their way in a model, while rules replace server pages by copies."""
    with unchanged():
        pairs = [
            (writer, reader)
            for topic in channels(model, sym.TopicChannel)
            for writer in topic.publishers
            for reader in topic.subscribers
            if are_matched(writer, reader)
        ]
        token = _SETTLED.set({pair: on_the_way(*pair) for pair in pairs})
    try:
        yield
    finally:
        _SETTLED.reset(token)


def on_the_way(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> int:
    """Return how many messages between two ports need clocks of their own; 0: the latency stays open.

    It stays open if nothing bounds how many messages can be on their way. With too few clocks, messages would
    wait for one another, and a burst that overflows a reader would look harmless.

    Raises
    ------
    TooManyOnTheWayError
        There are too many.
    """
    known = _SETTLED.get()
    if known is not None and (writer, reader) in known:
        return known[writer, reader]
    latency = latency_between(writer, reader)
    if latency is None or latency.latest is None:
        return 0
    return _clocks(writer, latency.latest, "can be on their way at once", "latency")


def ages_at_once(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> int:
    """Return how many messages between two ports need clocks for their lifespans; 0: they may go at any time.

    They may if nothing bounds how many there are, or how old they get; and if the reader has other writers,
    as their order in its history is not known.

    Raises
    ------
    TooManyOnTheWayError
        There are too many.
    """
    span = lifespan_between(writer, reader)
    others = reader.channel.publishers if reader.channel is not None else ()
    if span is None or span.latest is None or not on_the_way(writer, reader):
        return 0
    if any(other is not writer and are_matched(other, reader) for other in others):
        return 0
    return _clocks(writer, span.latest, "are younger than their lifespan at once", "lifespan")


def _clocks(writer: sym.PublisherPort, seconds: float, words: str, limit: str) -> int:
    """Return how many messages are published within some seconds; 0: any number; too many are refused."""
    with unchanged():
        found = _publications(writer, seconds_of(seconds), frozenset())
    if found is None:
        return 0
    if found > MOST_ON_THE_WAY:
        topic = "" if writer.channel is None else writer.channel.topic
        raise TooManyOnTheWayError(
            f"up to {found} messages of topic {topic} {words}",
            element=topic,
            hint=f"give durations to the callbacks that publish them, or a smaller {limit}",
        )
    return max(1, found)


def publishes_without_end(
    writer: sym.PublisherPort, reader: sym.SubscriberPort, asked: frozenset[object] = frozenset()
) -> bool:
    """Return whether a port may publish any number of messages in no time, and no clock limits them.

    A run may go round a circle, a timer may have no period, or it may pass on what comes without end.
    """
    if on_the_way(writer, reader):
        return False
    is_run = runs_callbacks(node_net_of(writer.place)) and not writer.place.tokens
    pages = only_put_by(writer.place) if is_run else None
    if pages is None:
        return True
    for page in pages:
        if paces(page, writer.place) is not None:
            continue
        if most_put(page, writer.place) is None:
            return True
        if page.kind == sym.CallbackKind.timer and period_of(page) is None:
            return True
        if page.kind == sym.CallbackKind.subscriber and page not in asked:
            for entry in readers_of(page):
                for other in entry.channel.publishers if entry.channel is not None else ():
                    if are_matched(other, entry) and publishes_without_end(other, entry, asked | {page}):
                        return True
    return False


@once
def _publications(writer: sym.PublisherPort, window: Fraction, asked: frozenset[object]) -> int | None:
    """Return how many messages a port can publish in a window; None if nothing bounds it.

    Only an executor runs callbacks one after another. Messages can gather in the engine of a node net and
    leave all at once, unless each of them takes a tick or a message.
    """
    is_fed = any(not isinstance(port, sym.PublisherPort) for port in ports_at(writer.place))
    if writer.place.tokens or is_fed:
        return None
    if not runs_callbacks(node_net_of(writer.place)):
        return _put_by_engine(writer.place, window, asked)
    pages = only_put_by(writer.place)
    if pages is None:
        return None
    total = 0
    for page in pages:
        each, runs = most_put(page, writer.place), _runs(page, window, asked)
        by_runs = None if each is None or runs is None else each * runs
        steps = paces(page, writer.place)
        by_steps = None if steps is None else sum(step.within(window) for step in steps)
        known = [bound for bound in (by_runs, by_steps) if bound is not None]
        if not known:
            return None
        total += min(known)
    return total


def _put_by_engine(place: pn.Place, window: Fraction, asked: frozenset[object]) -> int | None:
    """Return how many tokens the engine of a node net can put on a place in a window; None: any number."""
    total = 0
    for each in stand_for(place):
        for arc in _given(each.incoming):
            fired = _firings(arc.source, window, asked)
            if fired is None:
                return None
            total += arc.weight * fired
    return total


def _given(arcs: Iterable[pn.Arc]) -> list[pn.Arc]:
    """Return the arcs that the model has: rules add more while it is flattened."""
    return [arc for arc in arcs if not isinstance(arc.page, pnm.Sheet)]


def _firings(move: pn.Node, window: Fraction, asked: frozenset[object]) -> int | None:
    """Return how often the engine of a node net can fire a transition in a window; None: any number."""
    if move in asked or not isinstance(move, pn.Transition):
        return None
    page = callback_page_of(move)
    bounds: list[int | None] = []
    if page is not None and page.kind == sym.CallbackKind.timer and move in Body(page).beginnings():
        bounds.append(_begun(page, window, asked))
    for arc in _given(move.incoming):
        taken = resolve(arc.source)
        if arc.kind == pn.ArcKind.normal and isinstance(taken, pn.Place):
            bounds.append(_taken(taken, window, asked | {move}))
    return min((bound for bound in bounds if bound is not None), default=None)


def _taken(place: pn.Place, window: Fraction, asked: frozenset[object]) -> int | None:
    """Return how many messages can be taken from a place in a window; None: any number, or none arrive there.

    Nothing but subscriptions may put tokens there.
    """
    places = stand_for(place)
    if any(_given(each.incoming) for each in places):
        return None
    ports = ports_at(place)
    if len(ports) != 1 or not isinstance(ports[0], sym.SubscriberPort):
        return None
    weights = [arc.weight for each in places for arc in _given(each.outgoing)]
    held = _in_hand(ports[0], max([1, place.tokens, *weights]))
    return None if held is None else _arriving(ports[0], held, window, asked)


def _runs(page: sym.CallbackPage, window: Fraction, asked: frozenset[object]) -> int | None:
    """Return how many runs of a callback can overlap a closed window; None if nothing bounds it."""
    at_once = _at_once(page)
    if at_once is None:
        return None
    bounds = [_by_duration(page, window, at_once)]
    if page not in asked:
        begun = _begun(page, window, asked | {page})
        bounds.append(None if begun is None else at_once + begun)
    known = [bound for bound in bounds if bound is not None]
    return min(known) if known else None


def _at_once(page: sym.CallbackPage) -> int | None:
    """Return how many runs of a callback there may be at once; those that await need not hold a thread."""
    if page.awaits and page.kind == sym.CallbackKind.goal:
        numbers = slots(page)
        return None if numbers is None else sum(numbers) if numbers else 1
    if page.awaits and waits(page) and not is_exclusive(page):
        return None
    return runs_at_once(page)


def _by_duration(page: sym.CallbackPage, window: Fraction, at_once: int) -> int | None:
    duration = duration_of(page)
    if duration is None or waits(page) or not duration.earliest:
        return None
    return at_once * (int(window // seconds_of(duration.earliest)) + 2)


def _begun(page: sym.CallbackPage, window: Fraction, asked: frozenset[object]) -> int | None:
    """Return how many runs can begin in a window: for what waited, and for what comes."""
    if page.kind == sym.CallbackKind.timer:
        period = period_of(page)
        if period is None:
            return None
        jitter = Fraction(0) if page.jitter is None else seconds_of(page.jitter)
        return 2 + int((window + jitter) // seconds_of(period))
    if page.kind == sym.CallbackKind.client:
        return _ended(page, window, asked)
    if page.kind == sym.CallbackKind.server:
        return _requested(page, window, asked)
    if page.kind != sym.CallbackKind.subscriber:
        return None
    total = 0
    for reader in readers_of(page):
        weights = [arc.weight for arc in reader.place.outgoing]
        held = _in_hand(reader, max([1, reader.place.tokens, runs_at_once(page), *weights]))
        come = None if held is None else _arriving(reader, held, window, asked)
        if come is None:
            return None
        total += come
    return total


def _requested(page: sym.CallbackPage, window: Fraction, asked: frozenset[object]) -> int | None:
    """Return how many runs of a server begin in a window: for requests under way, and for those that come."""
    model = system_model_of(page)
    if model is None or any(node.lifecycle is not None for node in node_nets(model)):
        return None
    served = [service for service in services(model) if service.server.page is page]
    if not served:
        return None
    total = 0
    for service in served:
        counts = {client: outstanding(client) for client in service.clients}
        # Requests without a client that waits are in the history, or on their way.
        forgets = gives_up(service) or UNLIMITED in counts.values()
        total += int(service.depth) if forgets else sum(counts.values())
        for client, number in counts.items():
            latency = latency_of_calls(client)
            if number != UNLIMITED and not _waits_for_answers(model, client):
                return None  # requests gather until the last ones are answered
            since = window
            if forgets:
                if latency is None or latency.latest is None:
                    return None
                since += seconds_of(latency.latest)
            sent = _sent(client.request, since, asked)
            if sent is None:
                return None
            total += sent
    return total


@once
def _waits_for_answers(model: sym.SystemModel, client: sym.ClientPort) -> bool:
    return Waiting(model).waits(client)


def _sent(place: pn.Place, window: Fraction, asked: frozenset[object]) -> int | None:
    """Return how many requests or goals callbacks put on a place in a window; None if nothing bounds it."""
    pages = None if place.tokens else only_put_by(place)
    if pages is None:
        return None
    total = 0
    for page in pages:
        each, runs = most_put(page, place), _runs(page, window, asked)
        if each is None or runs is None:
            return None
        total += each * runs
    return total


def _ended(page: sym.CallbackPage, window: Fraction, asked: frozenset[object]) -> int | None:
    """Return how many runs of a client's callback begin in a window for the ends of goals."""
    ended = goals_ended(page)
    if ended is None:
        return None
    total = 0
    for goals in ended:
        sent = _sent(goals.goal, window, asked)
        if sent is None:
            return None
        total += goals.times * (goals.under_way + sent)
    return total


def _arriving(
    reader: sym.SubscriberPort, held: int, window: Fraction, asked: frozenset[object]
) -> int | None:
    """Return how many messages wait when a window begins, `held` of them in the node, or come in it."""
    total = int(reader.limit) + held
    for writer in reader.channel.publishers if reader.channel is not None else ():
        if are_matched(writer, reader):
            latency = latency_between(writer, reader)
            if latency is None or latency.latest is None:
                return None
            sent = _publications(writer, window + seconds_of(latency.latest), asked)
            if sent is None:
                return None
            total += sent
    return total


def _in_hand(reader: sym.SubscriberPort, otherwise: int) -> int | None:
    """Return how many messages a node holds at most outside of a reader history; None if any number."""
    if reader.place.capacity:
        return int(reader.place.capacity)
    if reader.inHand is not None:
        return None if reader.inHand == UNLIMITED else int(reader.inHand)
    return otherwise
