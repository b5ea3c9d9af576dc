"""Clients and servers of a node.

A client has one request under way; it is sent again until its response comes. A server serves as many
requests at a time as it has instances, the oldest first; a request that comes twice is served once and
answered twice.
"""

from __future__ import annotations

import logging
from collections import deque

from dineros.metamodel.message_ids import Senders, parse_id
from dineros.runtime.channels.traffic import SendError, Traffic
from dineros.runtime.channels.transport import Answer
from dineros.runtime.nets.ports import Check, ClientPort, Message, ServerPort
from dineros.runtime.scheduling.timers import Timer

LOG = logging.getLogger("dineros.runtime")
RESEND_DELAY = 0.1
LONGEST_RESEND_DELAY = 5.0
KEPT_SENDERS = 256
KEPT_ANSWERS = 64
"""Attempts of a request that are answered: the first one, and the last ones but for it."""


class Client:
    """Sends the tokens of one place as requests and puts the responses on another one.

    Attributes
    ----------
    pending : Message or None
        The request under way.
    attempts : int
        How often it was sent.
    departure : int
        Number of the departure; on hold while a request is under way.
    request, response : int
        The places of its requests and of their responses.
    """

    def __init__(
        self,
        traffic: Traffic,
        port: ClientPort,
        places: tuple[int, int],
        departure: int,
        timeout: float | None,
    ) -> None:
        self._traffic = traffic
        self.port = port
        self.request, self.response = places
        self.departure = departure
        self._timeout = timeout
        self._timer: Timer | None = None
        self._held: Message | None = None  # a response that waits for room
        self.pending: Message | None = None
        self.attempts = 0

    def send(self) -> None:
        """Send the oldest token as a request.

        Raises
        ------
        SendError
            The transport failed; the token stays where it is.
        """
        traffic, port, place = self._traffic, self.port, self.request
        token = traffic.engine.oldest(place)
        message = Message(traffic.next_id(port.request), token.data)
        self._ask(message)
        traffic.engine.take(place)
        traffic.engine.hold_departure(self.departure)
        traffic.count_sent(port.request)
        self.pending, self.attempts = message, 1
        if traffic.observer.is_observing:
            traffic.observer.emit(
                "request",
                channel=port.channel,
                client=port.client,
                place=port.request,
                token=token.id,
                message=message.id,
                change={port.request: -1},
            )

    def _ask(self, message: Message) -> None:
        try:
            self._traffic.joined.request(self.port, message)
        except Exception as error:
            raise SendError(f"cannot ask {self.port.service}: {error}") from error
        if self._timeout is not None:
            reason = f"no response in {self._timeout:g} s"
            self._timer = self._traffic.loop.timers.call_later(
                self._timeout, lambda: self.failed(message.id, reason)
            )

    def failed(self, message_id: str, reason: str) -> None:
        """Record that a request got no response, and send it again a little later."""
        if self.pending is None or self.pending.id != message_id:
            return
        self._stop_timer()
        LOG.warning("request %s of %s: %s", message_id, self.port.service, reason)
        self._traffic.observer.emit(
            "timeout",
            channel=self.port.channel,
            client=self.port.client,
            message=message_id,
            attempt=self.attempts,
        )
        delay = min(LONGEST_RESEND_DELAY, RESEND_DELAY * 2.0 ** min(self.attempts - 1, 30))
        self.attempts += 1
        # In real time, also where a simulation stands still: what was lost is no matter of its time.
        self._timer = self._traffic.loop.steady_timers.call_later(delay, self.ask_again)

    def ask_again(self) -> None:
        """Send the request under way once more, if there is one."""
        if self.pending is not None:
            self._timer = None
            try:
                self._ask(self.pending)
            except SendError as error:
                self.failed(self.pending.id, str(error))

    def responded(self, message: Message) -> None:
        """Put the token of the response, if it is the one waited for."""
        pending, traffic, port = self.pending, self._traffic, self.port
        if pending is None or (message.id and message.id != pending.id):
            return
        if not traffic.engine.has_room(self.response):
            self._stop_timer()
            self._held = message
            return
        token = traffic.arriving(port.service, self.response, message.data)
        if token is None:
            return
        self._stop_timer()
        self.pending = None
        traffic.engine.unhold_departure(self.departure)
        traffic.engine.put(self.response, token)
        if traffic.observer.is_observing:
            traffic.observer.emit(
                "response",
                channel=port.channel,
                client=port.client,
                place=port.response,
                token=token.id,
                message=pending.id,
                data=token.data,
                change={port.response: 1},
            )

    def let_in(self) -> None:
        """Take the response that waits for room, if there is one, now that there is some."""
        held, self._held = self._held, None
        if held is not None:
            self.responded(held)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


class Instance:
    """A server instance: serves one request at a time.

    Attributes
    ----------
    entry, exit : int
        Its places.
    departure : int
        Number of its departure; on hold while it serves nothing.
    message : str or None
        Id of the request that it serves.
    answers : list of callable
        Where the response goes.
    """

    def __init__(self, server: Server, number: int, entry: int, exit: int, departure: int) -> None:
        self.server = server
        self.number = number
        self.entry = entry
        self.exit = exit
        self.departure = departure
        self.message: str | None = None
        self.answers: list[Answer] = []

    def send(self) -> None:
        """Send the oldest token at the exit as the response."""
        self.server.reply(self)


class Server:
    """A service of the node.

    Attributes
    ----------
    instances : list of Instance
        Its server instances.
    waiting : deque
        Requests that wait for an instance, the oldest first, each with where its response goes.
    responses : dict of str to Message
        The last response to each sender, for a request that comes again. A sender has one request under way,
        so that its next one acknowledges the response to the one before.
    check : callable or None
        Raises for data that cannot be sent.
    """

    def __init__(self, traffic: Traffic, port: ServerPort) -> None:
        self._traffic = traffic
        self.port = port
        self.instances: list[Instance] = []
        self.waiting: deque[tuple[Message, list[Answer]]] = deque()
        self.responses: dict[str, Message] = {}
        self._served = Senders()
        self.check: Check | None = None

    def requested(self, message: Message, answer: Answer) -> None:
        """Serve a request, or let it wait; one that came before gets the same response."""
        if not self._traffic.plausible(self.port.channel, self.port.service, message.id):
            return
        if message.id:
            known = [instance.answers for instance in self.instances if instance.message == message.id]
            known += [answers for waiting, answers in self.waiting if waiting.id == message.id]
            if known:
                known[0].append(answer)
                del known[0][1:-KEPT_ANSWERS]
                return
            kept = self.responses.get(_sender(message.id))
            if kept is not None and kept.id == message.id:
                _answer(answer, kept)
                return
            number = parse_id(message.id)
            if number is not None and self._served.had(*number):
                return  # answered long ago
        self.waiting.append((message, [answer]))
        self.serve()

    def serve(self) -> None:
        """Give waiting requests to inactive instances that have room, the oldest first."""
        traffic, port = self._traffic, self.port
        for instance in self.instances:
            while instance.message is None and self.waiting and traffic.engine.has_room(instance.entry):
                message, answers = self.waiting.popleft()
                token = traffic.arriving(port.service, instance.entry, message.data)
                if token is None:
                    continue
                instance.message, instance.answers = message.id, answers
                traffic.engine.unhold_departure(instance.departure)
                traffic.engine.put(instance.entry, token)
                if traffic.observer.is_observing:
                    place = port.entries[instance.number]
                    traffic.observer.emit(
                        "serve",
                        channel=port.channel,
                        instance=instance.number + 1,
                        place=place,
                        token=token.id,
                        message=message.id,
                        data=token.data,
                        change={place: 1},
                    )

    def reply(self, instance: Instance) -> None:
        """Send the response of an instance, which is inactive then.

        Raises
        ------
        SendError
            The transport cannot send what the token carries; it stays where it is. Firings are checked, so
            that this is a token of the initial marking, or of a journal that another version has written.
        """
        traffic, port = self._traffic, self.port
        if self.check is not None:
            try:
                self.check(traffic.engine.oldest(instance.exit).data)
            except Exception as error:
                raise SendError(f"cannot answer a request of {port.service}: {error}") from error
        token = traffic.engine.take(instance.exit)
        response = Message(instance.message or "", token.data)
        for answer in instance.answers:
            _answer(answer, response)
        instance.message, instance.answers = None, []
        traffic.engine.hold_departure(instance.departure)
        if response.id:
            self.keep(response)
        if traffic.observer.is_observing:
            place = port.exits[instance.number]
            traffic.observer.emit(
                "reply",
                channel=port.channel,
                instance=instance.number + 1,
                place=place,
                token=token.id,
                message=response.id,
                change={place: -1},
            )
        self.serve()

    def keep(self, response: Message) -> None:
        """Keep a response for a request that comes again; the last one of each of the senders heard last."""
        sender = _sender(response.id)
        self.responses.pop(sender, None)
        self.responses[sender] = response
        if len(self.responses) > KEPT_SENDERS:
            del self.responses[next(iter(self.responses))]
        number = parse_id(response.id)
        if number is not None:
            self._served.add(*number)


def _sender(message_id: str) -> str:
    return message_id.rpartition("/")[0]


def _answer(answer: Answer, response: Message) -> None:
    try:
        answer(response)
    except Exception:  # the client asks again
        LOG.exception("the response to %s was not sent", response.id)
