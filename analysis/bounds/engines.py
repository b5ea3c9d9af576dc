"""How many messages wait at most where a node of the execution `net` reads a topic.

The engine of such a node takes a message within its reaction if there is room for it in the node, and fires a
transition that needs nothing but that message within another reaction. As long as messages wait, a message
leaves the history at least once in the sum of both: other transitions that take the messages only make it
faster. So the messages of a busy period are taken as by a server with a fixed greatest service time.

The first message of a busy period waits for one reaction at most. The k-th one is taken at most ``k - 1``
service times later. What has come by then, without the ``k - 1`` that are gone, is what waits at most. This
assumes that nothing is displaced, and holds where the result is not above the depth.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from fractions import Fraction

from dineros.analysis.bounds.solving import Solved
from dineros.analysis.bounds.tasks import Task
from dineros.analysis.bounds.work import Works
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.elements import label, node_net_of, resolve
from dineros.metamodel.matching import are_matched
from dineros.metamodel.times.given import latency_between, period_of, reaction_of
from dineros.metamodel.times.handlers import handled_for, handled_until, is_kept_back
from dineros.metamodel.times.rates import seconds_of
from dineros.metamodel.times.runs import ports_at

MOST_MESSAGES = 200
"""Messages of a busy period that are looked at."""


class _OpenError(Exception):
    """Nothing bounds it; the message says why."""


@dataclass(frozen=True)
class EngineHistory:
    """What waits in a history that an engine reads.

    Attributes
    ----------
    longest : int or None
        Greatest number of messages that wait, if the history is deep enough; None if nothing bounds it.
    reason : str
        Why it is open; empty if the history never overflows.
    response : Fraction
        Seconds from the arrival of a message until a transition takes it, at most.
    """

    longest: int | None
    reason: str = ""
    response: Fraction = Fraction(0)


class Engines:
    """Bounds histories that engines read.

    Parameters
    ----------
    works : Works
        What the transitions of the model do.
    tasks : list of Task
        The callbacks of executors.
    solved : Solved
        Their bounds.
    unit : Fraction
        Seconds of a unit of these.
    """

    def __init__(self, works: Works, tasks: list[Task], solved: Solved, unit: Fraction) -> None:
        self._works, self._tasks, self._solved, self._unit = works, tasks, solved, unit
        self._known: dict[sym.SubscriberPort, EngineHistory] = {}

    def history(self, reader: sym.SubscriberPort) -> EngineHistory:
        """Return what waits in a history that an engine reads."""
        if reader not in self._known:
            self._known[reader] = EngineHistory(None, "messages flow in a circle")
            try:
                self._known[reader] = self._bounded(reader)
            except _OpenError as error:
                self._known[reader] = EngineHistory(None, str(error))
        return self._known[reader]

    def _bounded(self, reader: sym.SubscriberPort) -> EngineHistory:
        place, node = _place(reader.place), node_net_of(reader.place)
        if node is None or node.lifecycle is not None:
            raise _OpenError("its node is managed: it can be stopped and started")
        taken, fired = self._reaction(node), self._fired(reader, place, node)
        service = taken + fired
        longest, gone = 0, 0
        while True:
            longest = max(longest, self._arrived(reader, gone * service + taken) - gone)
            if longest > int(reader.limit):
                reason = f"bounds allow {longest} waiting messages, and its depth is {int(reader.limit)}"
                return EngineHistory(longest, reason)
            gone += 1
            if self._arrived(reader, gone * service) <= gone:
                return EngineHistory(longest, response=fired + longest * service)
            if gone == MOST_MESSAGES:
                raise _OpenError(f"the reaction of node {label(node)} is too long for what arrives")

    # ------------------------------------------------------------------------------------------ what is taken

    def _reaction(self, node: sym.NodeNet) -> Fraction:
        reaction = reaction_of(node)
        if reaction is None or reaction.latest is None:
            raise _OpenError(f"the reaction of node {label(node)} is not given")
        return seconds_of(reaction.latest)

    def _fired(self, reader: sym.SubscriberPort, place: pn.Place, node: sym.NodeNet) -> Fraction:
        """Return within which time a message that the node has is taken by some transition."""
        around = self._works.around[place]
        moves = self._works.moves
        if ports_at(place) != [reader] or reader.inHand is not None or place.capacity or place.tokens:
            raise _OpenError(f"place {label(place)} has other ports, tokens, a capacity or a limit")
        if any(moves[each].puts[place] or moves[each].needs(place) > 1 for each in around):
            raise _OpenError(f"transitions of node {label(node)} put messages back, or take several")
        found = [
            time
            for each in around
            if moves[each].takes[place] and set(moves[each].takes) == {place}
            if (time := self._latest(each, node)) is not None
        ]
        if not found:
            raise _OpenError(f"no transition of node {label(node)} takes each message within a time")
        return min(found)

    def _latest(self, move: pn.Transition, node: sym.NodeNet) -> Fraction | None:
        """Return within which time a transition fires that has what it takes; None if it may wait."""
        works = self._works
        needs = works.moves[move]
        if set(needs.reads) - set(needs.takes) or needs.inhibits or move in works.overridden:
            return None
        if is_kept_back(move) or not all(self._is_open(place, move) for place in needs.puts):
            return None
        if isinstance(move, sym.Transition) and (move.clause is not None or move.guard is not None):
            return None
        if handled_for(move) is not None:
            until = handled_until(node, move)
            return None if until is None else seconds_of(until)
        if move.interval is None:
            return self._reaction(node)
        return None if move.interval.latest is None else seconds_of(move.interval.latest)

    def _is_open(self, place: pn.Place, move: pn.Transition) -> bool:
        """Return whether a place has room for what a transition puts, and its room restarts no clock.

        A message that is published has room for a moment only after the one before has left; so no other
        transition may publish there.
        """
        if place.capacity:
            return False
        ports = ports_at(place)
        is_published = all(isinstance(port, sym.PublisherPort) for port in ports)
        return not ports or (is_published and self._works.around[place] == [move] and not place.tokens)

    # --------------------------------------------------------------------------------------- what comes there

    def _arrived(self, reader: sym.SubscriberPort, window: Fraction) -> int:
        """Return how many messages arrive in a closed window at most."""
        total = 0
        for writer in reader.channel.publishers if reader.channel is not None else ():
            if are_matched(writer, reader):
                latency = latency_between(writer, reader)
                if latency is None or latency.latest is None:
                    topic = "" if writer.channel is None else writer.channel.topic
                    raise _OpenError(f"the model gives no latency for topic {topic}")
                spread = seconds_of(latency.latest) - seconds_of(latency.earliest or 0.0)
                total += self._published(writer, window + spread)
        return total

    def _published(self, writer: sym.PublisherPort, window: Fraction) -> int:
        place, node = _place(writer.place), node_net_of(writer.place)
        topic = "" if writer.channel is None else writer.channel.topic
        why = f"nothing bounds how often topic {topic} is published"
        if node is None or node.lifecycle is not None or place.tokens:
            raise _OpenError(why)
        if any(not isinstance(port, sym.PublisherPort) for port in ports_at(place)):
            raise _OpenError(why)
        putting = [each for each in self._works.around[place] if self._works.moves[each].puts[place]]
        if any(self._works.moves[each].takes[place] for each in self._works.around[place]):
            raise _OpenError(why)
        if runs_callbacks(node):
            return self._published_by_callbacks(place, putting, window, why)
        # Each tick, and each message, is taken by one of the transitions.
        most: defaultdict[sym.CallbackPage | sym.SubscriberPort, int] = defaultdict(int)
        for each in putting:
            cause = self._cause(each)
            if cause is None:
                raise _OpenError(f"{why}: by transition {label(each)} of node {label(node)}")
            most[cause] = max(most[cause], self._works.moves[each].puts[place])
        return sum(number * self._caused(cause, window) for cause, number in most.items())

    def _published_by_callbacks(
        self, place: pn.Place, putting: list[pn.Transition], window: Fraction, why: str
    ) -> int:
        total = 0
        for page in {callback_page_of(each) for each in putting}:
            tasks = [task for task in self._tasks if task.page is page]
            if page is None or not tasks:
                raise _OpenError(why)
            for task in tasks:
                curve, waited = self._solved.curves.get(task), self._solved.waited.get(task)
                if curve is None or waited is None or task.work is None:
                    raise _OpenError(self._solved.reasons.get(task, why))
                publishing = task.work.publishes.get(place)
                if publishing is not None:
                    units = -(-window // self._unit)
                    total += publishing.most * curve.spread(waited.delay).within(int(units))
        return total

    def _cause(self, move: pn.Transition) -> sym.CallbackPage | sym.SubscriberPort | None:
        """Return the timer whose ticks a transition takes, or the history whose messages it takes."""
        page = callback_page_of(move)
        if page is not None and page.kind == sym.CallbackKind.timer and move in Body(page).beginnings():
            return page
        for place in self._works.moves[move].takes:
            ports = ports_at(place)
            if len(ports) == 1 and isinstance(ports[0], sym.SubscriberPort):
                return ports[0]
        return None

    def _caused(self, cause: sym.CallbackPage | sym.SubscriberPort, window: Fraction) -> int:
        """Return how many ticks or messages are taken in a closed window."""
        if isinstance(cause, sym.SubscriberPort):
            history = self.history(cause)
            if history.longest is None or history.reason:
                raise _OpenError(f"reader history of {label(cause.place)}: {history.reason}")
            return self._arrived(cause, window + history.response)
        period, node = period_of(cause), node_net_of(cause)
        if period is None or node is None:
            raise _OpenError(f"the period of {label(cause)} is not given")
        times = [
            time
            for each in Body(cause).beginnings()
            if not self._works.moves[each].takes and (time := self._latest(each, node)) is not None
        ]
        # Otherwise one tick waits at most, for any time.
        waiting = min([*times, seconds_of(period)])
        jitter = seconds_of(cause.jitter or 0.0)
        return int((window + waiting + jitter) // seconds_of(period)) + 1


def _place(place: pn.Node) -> pn.Place:
    found = resolve(place)
    assert isinstance(found, pn.Place)
    return found


def is_of_engine(port: sym.TopicPort) -> bool:
    """Return whether a port belongs to a node of the execution `net`."""
    node = node_net_of(port.place)
    return node is not None and not runs_callbacks(node)
