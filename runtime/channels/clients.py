"""The service clients of a node: requests under way and their responses.

A client has one request under way, or as many as the model allows. It sends a request again until the
response arrives or its time-out ends. A response after the time-out is dropped (rule R7).
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

from dineros.runtime.channels.traffic import SendError, Traffic
from dineros.runtime.nets.ports import ClientPort, Message
from dineros.runtime.scheduling.timers import IDLE, Timer

LOG = logging.getLogger("dineros.runtime")
RESEND_DELAY = 0.1
LONGEST_RESEND_DELAY = 5.0


def resend_delay(attempt: int) -> float:
    """Return the delay in seconds before the next attempt; `attempt` is the last one, counted from 1."""
    return min(LONGEST_RESEND_DELAY, RESEND_DELAY * 2.0 ** min(attempt - 1, 30))


@dataclass(eq=False)
class Call:
    """A request under way.

    Attributes
    ----------
    message : Message
        The request.
    asked : float
            When it was first sent, by the node's clock.
    attempts : int
            How many times it was sent.
    response : Message or None
            Its response, while that waits for room on its place.
    is_late : bool
            Whether it has timed out while the place for the time-out token has no room.
    resending, ending : Timer
            Timers that send it again and that end it.
    """

    message: Message
    asked: float
    attempts: int = 1
    response: Message | None = None
    is_late: bool = False
    resending: Timer = IDLE
    ending: Timer = IDLE


class Client:
    """Sends the tokens of one place as requests and puts the responses on another one.

    Parameters
    ----------
    traffic : Traffic
            Shared by all ports of the node.
    port : ClientPort
        The port.
    request_timeout : float or None
            Seconds after which a request without a response is sent again.

    Attributes
    ----------
    calls : dict of str to Call
        The requests under way by id, the oldest first.
    departure : int
        Number of the departure; on hold while no more requests may be under way.
    request, response, timed_out : int
            The places for requests, responses and time-outs; None: the port has no such place.
    """

    def __init__(self, traffic: Traffic, port: ClientPort, request_timeout: float | None) -> None:
        self._traffic = traffic
        self.port = port
        self.request, self.response = traffic.places[port.request], traffic.places[port.response]
        self.timed_out = None if port.timed_out is None else traffic.places[port.timed_out]
        self.departure = traffic.add_departure(self.request, self.send, port)
        self._about = {"channel": port.channel, "client": port.client}
        self._request_timeout = request_timeout
        self.calls: dict[str, Call] = {}
        self._is_held = True

    def begin(self) -> None:
        """Release departures; requests under way before a restart are sent again."""
        self._hold_or_not()
        for call in list(self.calls.values()):
            self._patience(call)
            self._ask_again(call)

    def restore(self, message: Message, attempts: int, age: float) -> None:
        """Restore a request that was under way before a restart; it was first sent `age` seconds ago."""
        self.calls[message.id] = Call(message, self._traffic.loop.clock() - age, attempts)

    def send(self) -> None:
        """Send the oldest token as a request."""
        traffic, port, place = self._traffic, self.port, self.request
        token = traffic.engine.oldest(place)
        call = Call(Message(traffic.next_id(port.request), token.data), traffic.loop.clock())
        self._ask(call)
        traffic.engine.take(place)
        traffic.count_sent(port.request)
        self.calls[call.message.id] = call
        self._hold_or_not()
        self._patience(call)
        if traffic.observer.is_observing:
            traffic.left("request", self._about, port.request, token, call.message.id)

    def _hold_or_not(self) -> None:
        """Release the departure while more requests may be under way, else hold it."""
        must_wait = len(self.calls) >= self.port.outstanding
        if must_wait is not self._is_held:
            engine = self._traffic.engine
            (engine.hold if must_wait else engine.unhold)(self.departure)
            self._is_held = must_wait

    def _patience(self, call: Call) -> None:
        """Start the timer that ends a request at its time-out."""
        if self.port.timeout is not None:
            loop = self._traffic.loop
            left = max(0.0, call.asked + self.port.timeout - loop.clock())
            call.ending = loop.timers.call_later(left, lambda: self._give_up(call))

    def _ask(self, call: Call) -> None:
        traffic = self._traffic
        try:
            traffic.joined.request(self.port, call.message)
        except Exception as error:
            raise SendError(f"cannot call {self.port.service}: {error}") from error
        if self._request_timeout is not None:
            reason = f"no response in {self._request_timeout:g} s"
            call.resending = traffic.loop.timers.call_later(
                self._request_timeout, lambda: self.failed(call.message.id, reason)
            )

    def failed(self, message_id: str, reason: str) -> None:
        """Record that a request got no response, and schedule sending it again."""
        call = self.calls.get(message_id)
        if call is None or call.response is not None or call.is_late:
            return
        call.resending.cancel()
        LOG.warning("request %s of %s: %s", message_id, self.port.service, reason)
        attempt = call.attempts
        self._traffic.observer.emit("timeout", **self._about, message=message_id, attempt=attempt)
        call.attempts += 1
        # In real time even if the simulated time stands still: a resend after a loss does not depend on it.
        steady_timers = self._traffic.loop.steady_timers
        call.resending = steady_timers.call_later(resend_delay(attempt), lambda: self._ask_again(call))

    def _ask_again(self, call: Call) -> None:
        try:
            self._ask(call)
        except SendError as error:
            self.failed(call.message.id, str(error))

    def responded(self, message: Message) -> None:
        """Put the token of a response if a request waits for it; without an id, it answers the oldest one."""
        id = message.id or next(iter(self.calls), "")
        call, traffic, port = self.calls.get(id), self._traffic, self.port
        if call is None:
            return
        if not traffic.engine.has_room(self.response):
            call.resending.cancel()
            call.response = message
            return
        token = traffic.arriving(port.service, self.response, message.data)
        if token is None:
            call.response = None
            return
        self._end(call)
        traffic.engine.put(self.response, token)
        if traffic.observer.is_observing:
            traffic.came("response", self._about, port.response, token, id)

    def _end(self, call: Call) -> None:
        """Remove a request that has ended, so that another one may be sent."""
        call.resending.cancel()
        call.ending.cancel()
        del self.calls[call.message.id]
        self._hold_or_not()

    def _give_up(self, call: Call) -> None:
        """Stop waiting for a response and put a time-out token, if the model has a place for it.

        The token carries the data of the request, if its place has tokens of that type.
        """
        traffic, port, place = self._traffic, self.port, self.timed_out
        call.is_late = True
        call.resending.cancel()
        token = None
        if place is not None:
            if not traffic.engine.has_room(place):
                return
            types = traffic.engine.structure.types
            data = call.message.data if types[place] is types[self.request] else {}
            token = traffic.arriving(port.service, place, data)
            if token is None:
                return
        self._end(call)
        traffic.joined.forget(port, call.message.id)
        if place is not None and port.timed_out is not None and token is not None:
            traffic.engine.put(place, token)
            traffic.came("giveUp", self._about, port.timed_out, token, call.message.id)
        else:
            nothing: dict[str, object] = {"place": None, "token": None}
            traffic.observer.emit(
                "giveUp", **self._about, **nothing, message=call.message.id, data={}, change={}
            )

    def let_in(self) -> None:
        """Handle responses and time-outs that wait for room, as far as there is room now."""
        for call in list(self.calls.values()):
            if call.response is not None:
                self.responded(call.response._replace(id=call.message.id))
            if call.is_late and call.message.id in self.calls:
                self._give_up(call)
