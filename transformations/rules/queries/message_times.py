"""Queries about the times of messages, calls and goals between nodes."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.matching import is_best_effort
from dineros.metamodel.times.given import (
    gives_up_in_time,
    goals_taken_until,
    latency_between,
    latency_of_calls,
    lifespan_between,
    results_taken_until,
)
from dineros.metamodel.times.intervals import copied_interval, exactly
from dineros.metamodel.times.rates import ages_at_once, on_the_way
from dineros.transformations.language import REAL, TRUTH, WHOLE, Query


class Latency(Query):
    """Latency of a message from a publisher to a subscriber."""

    eclass = pn.TimeInterval
    _words = "latency from {} to {}"

    @staticmethod
    def _answer(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> pn.TimeInterval | None:
        return copied_interval(latency_between(writer, reader))


class OnTheWay(Query):
    """Number of messages from a publisher to a subscriber that have their own clocks at the same time."""

    datatype = WHOLE
    _words = "messages on their way from {} to {}"
    _answer = staticmethod(on_the_way)


class ArrivesNext(Query):
    """Whether messages without clocks, which nothing else removes, have a maximum latency."""

    datatype = TRUTH
    _words = "messages from {} to {} have a maximum latency and no clocks"

    @staticmethod
    def _answer(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> bool:
        latency = latency_between(writer, reader)
        if latency is None or latency.latest is None or is_best_effort(writer, reader):
            return False
        return lifespan_between(writer, reader) is None and not on_the_way(writer, reader)


class ArrivesUntil(Query):
    """Maximum latency of a message from a publisher to a subscriber."""

    datatype = REAL
    _words = "maximum latency from {} to {}"

    @staticmethod
    def _answer(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> float:
        latency = latency_between(writer, reader)
        assert latency is not None and latency.latest is not None
        return latency.latest


class Lifespan(Query):
    """Age at which a message is removed before it is taken."""

    eclass = pn.TimeInterval
    _words = "lifespan from {} to {}"

    @staticmethod
    def _answer(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> pn.TimeInterval | None:
        return copied_interval(lifespan_between(writer, reader))


class HasLifespan(Query):
    """Whether messages between two ports are removed when they are too old."""

    datatype = TRUTH
    _words = "messages from {} to {} have a lifespan"

    @staticmethod
    def _answer(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> bool:
        return lifespan_between(writer, reader) is not None


class AgesAtOnce(Query):
    """Number of messages between two ports whose ages have their own clocks at the same time."""

    datatype = WHOLE
    _words = "ages of messages from {} to {}"
    _answer = staticmethod(ages_at_once)


class CallLatency(Query):
    """Latency of each request and each response of a client."""

    eclass = pn.TimeInterval
    _words = "latency of {}"

    @staticmethod
    def _answer(client: sym.ClientPort) -> pn.TimeInterval | None:
        return copied_interval(latency_of_calls(client))


class CallsOnTheWay(Query):
    """Number of a client's requests that have clocks; 0 if their latency or their number is unbounded.

    Requests of a client that gives up have clocks if each request arrives before its time-out.
    """

    datatype = WHOLE
    _words = "requests of {} on their way"

    @staticmethod
    def _answer(client: sym.ClientPort) -> int:
        latency = latency_of_calls(client)
        if latency is None or latency.latest is None:
            return 0
        patience = client.timeout or 0.0
        if patience > 0.0 and not (gives_up_in_time(client) and latency.latest <= patience):
            return 0
        # Flattening has set the number of requests under way; a negative number means any number.
        return max(client.outstanding or 1, 0)


class CallsArriveInTime(Query):
    """Whether requests of all clients of a service have clocks while they are on their way."""

    datatype = TRUTH
    _words = "all requests of {} are on their way for a given time"

    @staticmethod
    def _answer(service: sym.ServiceChannel) -> bool:
        return all(CallsOnTheWay._answer(client) > 0 for client in service.clients)


class GoalsInTime(Query):
    """Whether goals of an action, and requests to cancel them, are taken within a time."""

    datatype = TRUTH
    _words = "{1} takes goals of {0} within a time"

    @staticmethod
    def _answer(action: sym.ActionChannel, server: sym.NodeNet | None) -> bool:
        return goals_taken_until(action, server) is not None


class TakenUntil(Query):
    """Maximum time until the server of an action takes a message that is sent to it."""

    datatype = REAL
    _words = "latest latency of {0} and reaction of {1}"
    _answer = staticmethod(goals_taken_until)


class ResultsInTime(Query):
    """Whether a client of an action takes results within a time."""

    datatype = TRUTH
    _words = "results of {1} for {0} are taken within a time"

    @staticmethod
    def _answer(client: sym.ActionClientPort, server: sym.NodeNet | None) -> bool:
        return results_taken_until(client, server) is not None


class HeardUntil(Query):
    """Maximum time until a client of an action takes a message that is sent to it."""

    datatype = REAL
    _words = "latest latency of {0} from {1}, and reaction"
    _answer = staticmethod(results_taken_until)


class GivesUpInTime(Query):
    """Whether the rules model the earliest time at which a client gives up."""

    datatype = TRUTH
    _words = "{} gives up after its time-out"
    _answer = staticmethod(gives_up_in_time)


class TimeOut(Query):
    """The time-out of a client, as an interval."""

    eclass = pn.TimeInterval
    _words = "[time-out of {0}, time-out of {0}]"

    @staticmethod
    def _answer(client: sym.ClientPort) -> pn.TimeInterval:
        return exactly(client.timeout)
