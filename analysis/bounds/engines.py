"""How long engines of nodes of the execution `net` take for messages and ticks, and how many messages wait.

The engine of such a node takes a message within its reaction if there is room for it in the node, and fires a
transition that needs nothing but that message within another reaction. As long as messages wait, a message
leaves the history at least once in the sum of both: other transitions that take the messages only make it
faster. So the messages of a busy period are taken as by a server with a fixed greatest service time. The
tokens of a place in the node, that transitions take which need nothing else, are such messages, too.

The first message of a busy period waits for one reaction at most. The k-th one is taken at most ``k - 1``
service times later. What has come by then, without the ``k - 1`` that are gone, is what waits at most. This
assumes that nothing is displaced, and holds where the result is not above the depth.

A message that is not lost is taken within one service time for each place of its history, whatever comes: a
message before it leaves the history within each, or is displaced, which starts the reaction again.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from dineros.analysis.bounds.curves import Curve, added
from dineros.analysis.bounds.firing import EngineFirings, OpenError, place_of
from dineros.analysis.bounds.reading import Tasks
from dineros.analysis.bounds.tasks import EngineReader, Source
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.elements import label, node_net_of
from dineros.metamodel.times.given import period_of
from dineros.metamodel.times.rates import seconds_of
from dineros.metamodel.times.runs import ports_at

MOST_MESSAGES = 200
"""Limit of the examined messages of a busy period."""
NEVER = 10**15
"""Period, in units, of what comes once: longer than any window."""
Cause = sym.CallbackPage | sym.SubscriberPort | pn.Place
"""What a transition takes: the ticks of a timer, the messages of a history, or the tokens of a place."""


@dataclass(frozen=True)
class EngineHistory:
    """What waits in a history that an engine reads."""

    longest: int | None
    """Greatest number of messages that wait, if the history is deep enough; None if nothing bounds it."""
    reason: str = ""
    """Why it is open; empty if the history never overflows."""


@dataclass(frozen=True)
class Passed:
    """How long data takes through a node."""

    least: int
    greatest: int
    """`least`, `greatest`: from the release to the end, or to the publication, in units of time."""
    is_certain: bool = True
    """Whether all data comes so far."""

    def after(self, least: int, greatest: int) -> Passed:
        """Return it with what comes before it."""
        return Passed(self.least + least, self.greatest + greatest, self.is_certain)


class Engines:
    """Bounds what engines do.

    Parameters
    ----------
    tasks : Tasks
        The callbacks of executors, and what engines read.
    published : function from EngineReader and Source to Curve or None
        When messages of a callback arrive; None if nothing bounds that.
    why : function from Source to str
        Why nothing bounds it.
    """

    def __init__(
        self,
        tasks: Tasks,
        published: Callable[[EngineReader, Source], Curve | None],
        why: Callable[[Source], str],
    ) -> None:
        self._tasks, self._published_by, self._why = tasks, published, why
        self._works, self._firing = tasks.works, EngineFirings(tasks)
        self._known: dict[Cause, Curve | OpenError] = {}

    def forget(self) -> None:
        """Forget all answers: the bounds of callbacks have changed."""
        self._known.clear()

    def history(self, reader: sym.SubscriberPort) -> EngineHistory:
        """Return what waits in a history that an engine reads."""
        try:
            taken, fired = self._service(reader)
            arrivals, depth = self.arrivals(reader), int(reader.limit)
            longest = 0
            for gone in range(MOST_MESSAGES):
                longest = max(longest, arrivals.within(gone * (taken + fired) + taken) - gone)
                if longest > depth:
                    reason = f"bounds allow {longest} waiting messages, and its depth is {depth}"
                    return EngineHistory(longest, reason)
                if arrivals.within((gone + 1) * (taken + fired)) <= gone + 1:
                    return EngineHistory(longest)
        except OpenError as error:
            return EngineHistory(None, str(error))
        return EngineHistory(None, "the reaction of its node is too long for what arrives")

    def through(
        self, page: sym.CallbackPage, reader: sym.SubscriberPort | None, writer: sym.PublisherPort | None
    ) -> Passed:
        """Return how long a callback takes from its release to its end, or until it publishes.

        Parameters
        ----------
        page
            A callback of a subscription or a timer, in a node of the execution `net`.
        reader
            The history that releases it; None for a timer.
        writer
            What publishes; None for the end.

        Raises
        ------
        OpenError
            Nothing bounds it.
        """
        target = None if writer is None else place_of(writer.place)
        cause: Cause = page if reader is None else reader
        if reader is None and page.kind != sym.CallbackKind.timer:
            raise OpenError(f"callback {label(page)} is not called by a timer or messages")
        found = self._onward(cause, page, target, ())
        if found is None:
            raise OpenError(f"no transition of callback {label(page)} passes its messages on")
        return found

    def why_late(self, page: sym.CallbackPage) -> str:
        """Return why a timer may strike while its last tick still waits; empty if it never does."""
        node = node_net_of(page)
        if node is not None and node.lifecycle is not None:
            return f"node {label(node)} is managed: it can be stopped and started"
        try:
            jitter, waiting = self._tasks.units(seconds_of(page.jitter or 0.0)), self._waiting(page)
            if waiting < self._period(page) - jitter:
                return ""
        except OpenError as error:
            return str(error)
        late = float(waiting * self._tasks.unit)
        return f"bounds allow a tick to wait {late:g} s, and it ticks every {page.timer:g} s"

    def published(self, writer: sym.PublisherPort) -> Curve:
        """Return when an engine publishes messages.

        Raises
        ------
        OpenError
            Nothing bounds it.
        """
        place, node = place_of(writer.place), node_net_of(writer.place)
        topic = "" if writer.channel is None else writer.channel.topic
        why = f"nothing bounds how often topic {topic} is published"
        if node is None or node.lifecycle is not None or place.tokens:
            raise OpenError(why)
        if any(not isinstance(port, sym.PublisherPort) for port in ports_at(place)):
            raise OpenError(why)
        if any(self._works.moves[each].takes[place] for each in self._works.around[place]):
            raise OpenError(why)
        return self._put(place, why)

    def arrivals(self, cause: Cause) -> Curve:
        """Return when ticks, messages or tokens come.

        Raises
        ------
        OpenError
            Nothing bounds it.
        """
        if cause not in self._known:
            self._known[cause] = OpenError("messages flow in a circle")
            try:
                self._known[cause] = self._come(cause)
            except OpenError as error:
                self._known[cause] = error
        found = self._known[cause]
        if isinstance(found, OpenError):
            raise found
        return found

    def _come(self, cause: Cause) -> Curve:
        if isinstance(cause, sym.CallbackPage):
            return Curve(((1, self._period(cause), self._tasks.units(seconds_of(cause.jitter or 0.0))),))
        if isinstance(cause, pn.Place):
            return self._put(cause, f"nothing bounds how often tokens come to place {label(cause)}")
        heard = self._tasks.readers[cause]
        if heard.reason:
            raise OpenError(heard.reason)
        curves = []
        for source in heard.sources:
            curve = self._published_by(heard, source)
            if curve is None:
                raise OpenError(self._why(source))
            curves.append(curve)
        for writer, (least, most) in heard.engines:
            curves.append(self.published(writer).spread(most - least))
        return added(curves)

    def _put(self, place: pn.Place, why: str) -> Curve:
        """Return when transitions put tokens on a place: each tick, message and token is taken by one."""
        most: defaultdict[Cause, int] = defaultdict(int)
        node = node_net_of(place)
        assert node is not None
        for each in self._works.around[place]:
            if number := self._works.moves[each].puts[place]:
                cause = next(self.causes(each), None)
                if cause is None:
                    raise OpenError(f"{why}: by transition {label(each)} of node {label(node)}")
                most[cause] = max(most[cause], number)
        curves = []
        for cause, number in most.items():
            if isinstance(cause, pn.Place) and self._firing.is_pool(cause):
                curves.append(Curve(((number * cause.tokens, NEVER, 0),), has_moments=False))
                continue
            spread = self._spread(cause)
            curves.append(Curve(self.arrivals(cause).times(number).spread(spread).terms, has_moments=False))
        return added(curves)

    def causes(self, move: pn.Transition) -> Iterator[Cause]:
        """Yield what a transition takes: ticks, messages, or tokens that come from elsewhere in the node."""
        page = callback_page_of(move)
        if page is not None and page.kind == sym.CallbackKind.timer and move in Body(page).beginnings():
            yield page
        for place in self._works.moves[move].takes:
            ports = ports_at(place)
            if len(ports) == 1 and isinstance(ports[0], sym.SubscriberPort):
                yield ports[0]
        for place in self._works.moves[move].takes:
            if self._firing.is_inside(place) or self._firing.is_pool(place):
                yield place

    def behind(self, writer: sym.PublisherPort) -> set[sym.SubscriberPort]:
        """Return the histories of a node whose messages can cause what its engine publishes."""
        found: set[sym.SubscriberPort] = set()
        todo, seen = [place_of(writer.place)], set[pn.Place]()
        while todo:
            place = todo.pop()
            if place in seen:
                continue
            seen.add(place)
            for each in self._works.around[place]:
                for cause in self.causes(each) if self._works.moves[each].puts[place] else ():
                    if isinstance(cause, sym.SubscriberPort):
                        found.add(cause)
                    elif isinstance(cause, pn.Place):
                        todo.append(cause)
        return found

    # ------------------------------------------------------------------------------------------ what is taken

    def _period(self, page: sym.CallbackPage) -> int:
        period = period_of(page)
        if period is None:
            raise OpenError(f"the period of {label(page)} is not given")
        return self._tasks.units(seconds_of(period))

    def _waiting(self, cause: Cause) -> int:
        """Return how long a tick, a message or a token waits at most until a transition takes it."""
        if isinstance(cause, sym.SubscriberPort):
            taken, fired = self._service(cause)
            history = self.history(cause)
            depth = int(cause.limit)
            longest = depth if history.longest is None else min(depth, history.longest)
            return fired + longest * (taken + fired)
        if isinstance(cause, pn.Place):
            return self._drained(cause)
        node = node_net_of(cause)
        times = [
            time
            for each in Body(cause).beginnings()
            if node is not None and not self._works.moves[each].takes
            if (time := self._firing.latest(each, node)) is not None
        ]
        if not times:
            raise OpenError(f"no first transition of callback {label(cause)} fires within a time")
        return min(times)

    def _spread(self, cause: Cause) -> int:
        """Return by how much the times vary at which ticks, messages or tokens are taken."""
        if not isinstance(cause, sym.CallbackPage):
            return self._waiting(cause)
        try:
            return min(self._period(cause), self._waiting(cause))
        except OpenError:
            return self._period(cause)  # one tick waits at most, for any time

    def _drained(self, place: pn.Place) -> int:
        """Return how long a token of a place inside a node stays there at most: all of a busy period."""
        node = node_net_of(place)
        assert node is not None
        fired, arrivals = self._firing.fired(place, node), self.arrivals(place)
        for gone in range(1, MOST_MESSAGES):
            if arrivals.within(gone * fired) <= gone:
                return gone * fired
        where = f"place {label(place)}"
        raise OpenError(f"the reaction of node {label(node)} is too long for what comes to {where}")

    def _service(self, reader: sym.SubscriberPort) -> tuple[int, int]:
        """Return within which time a message is taken out of its history, and then by a transition."""
        place, node = place_of(reader.place), node_net_of(reader.place)
        if node is None or node.lifecycle is not None:
            raise OpenError("its node is managed: it can be stopped and started")
        if ports_at(place) != [reader] or reader.inHand is not None or place.capacity or place.tokens:
            raise OpenError(f"place {label(place)} has other ports, tokens, a capacity or a limit")
        if any(self._works.moves[each].puts[place] for each in self._works.around[place]):
            raise OpenError(f"transitions of node {label(node)} put messages back, or take several")
        return self._firing.reaction(node), self._firing.fired(place, node)

    # ------------------------------------------------------------------------------------ what is passed on

    def _onward(
        self, cause: Cause, page: sym.CallbackPage, target: pn.Place | None, before: tuple[Cause, ...]
    ) -> Passed | None:
        """Return how long data of a cause takes to a place, or to the end; None if it does not go there."""
        if cause in before:
            raise OpenError(f"data flows in a circle in callback {label(page)}")
        node, moves = node_net_of(page), self._works.moves
        assert node is not None
        if node.lifecycle is not None:
            raise OpenError(f"node {label(node)} is managed: it can be stopped and started")
        least, is_first = 0, True
        if isinstance(cause, sym.CallbackPage):
            starts = Body(cause).beginnings()
        else:
            place = cause if isinstance(cause, pn.Place) else place_of(cause.place)
            starts = [each for each in self._works.around[place] if moves[each].takes[place]]
            if isinstance(cause, sym.SubscriberPort):
                least = self._firing.reacts_from(node)
            else:
                is_first = self.arrivals(cause).within(self._drained(cause)) <= 1
        greatest = self._waiting(cause)
        found, is_certain = [], True
        for each in starts:
            further = self._after(each, page, target, (*before, cause))
            if further is None:
                is_certain = False
                continue
            found.append(further.after(self._firing.earliest(each, node) if is_first else 0, 0))
        if not found and (starts or target is not None):
            return None
        is_certain &= all(each.is_certain for each in found)
        first = min((each.least for each in found), default=0)
        return Passed(least + first, greatest + max((each.greatest for each in found), default=0), is_certain)

    def _after(
        self, move: pn.Transition, page: sym.CallbackPage, target: pn.Place | None, before: tuple[Cause, ...]
    ) -> Passed | None:
        """Return how long data takes from the firing of a transition on."""
        puts = [place for place, number in self._works.moves[move].puts.items() if number]
        if target in puts:
            return Passed(0, 0)
        if target is None:
            if callback_page_of(move) is not page or move in Body(page).ends():
                return Passed(0, 0)
            if any(each in Body(page).requests for each in puts):
                raise OpenError(f"callback {label(page)} waits for a response")
            puts = [place for place in puts if callback_page_of(place) is page]
        found = []
        for place in puts:
            if self._firing.is_inside(place):
                further = self._onward(place, page, target, before)
                if further is not None:
                    found.append(further)
            elif target is None:
                raise OpenError(f"place {label(place)} has ports, tokens or a capacity")
        if not found:
            return None
        return Passed(
            min(each.least for each in found),
            max(each.greatest for each in found),
            any(each.is_certain for each in found),
        )
