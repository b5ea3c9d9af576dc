"""The service servers of a node.

A server handles as many requests at a time as it has instances, the oldest first. A request that arrives
twice is handled once and answered twice. Under the rules of ROS 2, the server keeps as many requests as its
depth; a further request displaces the oldest one (rule R5). A repeated request uses no room there.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Iterable

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.message_ids import Senders, parse_id
from dineros.runtime.channels.traffic import SendError, Traffic
from dineros.runtime.channels.transport import Answer, Transport
from dineros.runtime.nets.ports import Message, ServerPort

LOG = logging.getLogger("dineros.runtime")
KEPT_SENDERS = 256
LONGEST_QUEUE = 1000
"""Maximum number of requests that wait for an instance if the rules have no depth; others are dropped."""
KEPT_RESPONSES = 64
"""Extra responses kept for each sender that has several requests under way."""

KEPT_ANSWERS = 64
"""Attempts of a request that are answered: the first one and the last ones."""


class Instance:
    """A server instance: handles one request at a time.

    Attributes
    ----------
    entry, exit : int
        Its places.
    departure : int
            Number of its departure; on hold while the instance is idle.
    message : str or None
            Id of the request that it handles.
    answers : list of callable
            Functions that send the response.
    about : dict
            Fields that its records have in common.
    """

    def __init__(self, traffic: Traffic, server: Server, number: int) -> None:
        self.server = server
        self.number = number
        self.entry = traffic.places[server.port.entries[number]]
        self.exit = traffic.places[server.port.exits[number]]
        self.departure = traffic.add_departure(self.exit, self.send, server.port)
        self.message: str | None = None
        self.answers: list[Answer] = []
        self.about = {"channel": server.port.channel, "instance": number + 1}

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
            Requests that wait for an instance, the oldest first, each with the function that sends its
            response.
    responses : dict of str to dict of str to Message
            The last responses to each sender by id, for repeated requests; at most `kept` of them.
    kept : int
            Number of responses kept for each sender. If a sender has one request under way, its next request
            acknowledges the response to the previous one.
    """

    def __init__(self, traffic: Traffic, port: ServerPort) -> None:
        self._traffic = traffic
        self.port = port
        self.instances = [Instance(traffic, self, number) for number in range(port.instances)]
        self.waiting: deque[tuple[Message, list[Answer]]] = deque()
        self.responses: dict[str, dict[str, Message]] = {}
        self.kept = 1 if port.outstanding == 1 else KEPT_RESPONSES + port.outstanding
        has_history = traffic.engine.structure.ports.middleware == "ros2"
        self._depth = port.depth if has_history else None
        self._served = Senders()

    def requested(self, message: Message, answer: Answer) -> None:
        """Handle a request, or let it wait; a repeated request gets the same response."""
        self._arrived(message, answer)
        self.serve()
        if self._depth is not None and len(self.waiting) > self._depth:
            self._lose([self.waiting.popleft()[0].id])

    def _arrived(self, message: Message, answer: Answer) -> None:
        if not self._traffic.plausible(self.port.channel, self.port.service, message.id):
            return
        if message.id:
            known = [instance.answers for instance in self.instances if instance.message == message.id]
            known += [answers for waiting, answers in self.waiting if waiting.id == message.id]
            if known:
                known[0].append(answer)
                del known[0][1:-KEPT_ANSWERS]
                return
            kept = self.responses.get(_sender(message.id), {}).get(message.id)
            if kept is not None:
                _answer(answer, kept)
                return
            number = parse_id(message.id)
            if number is not None and self._served.had(*number):
                return  # answered and no longer kept
        if self._depth is None and len(self.waiting) >= LONGEST_QUEUE:
            error = DinerosError(f"{LONGEST_QUEUE:,} requests wait already")
            self._traffic.refuse(self.port.channel, self.port.service, error)
            return
        self.waiting.append((message, [answer]))

    def knows(self, message_id: str) -> bool:
        """Return whether a request was taken before, and is being handled or has its response kept."""
        if any(instance.message == message_id for instance in self.instances):
            return True
        return message_id in self.responses.get(_sender(message_id), {})

    def is_open(self, arriving: int) -> bool:
        """Return whether a request may be taken from the middleware now; from any thread.

        `arriving` requests are on their way here. Requests are taken even while all instances are busy: this
        server keeps the history, because known repeated requests must be answered then, too. Otherwise the
        instances could wait forever for something that depends on such an answer.
        """
        return self._depth is None or arriving <= self._depth

    @property
    def busy(self) -> int:
        """Number of requests that are being handled."""
        return sum(instance.message is not None for instance in self.instances)

    def _is_free(self, instance: Instance) -> bool:
        return instance.message is None and self._traffic.engine.has_room(instance.entry)

    def _keeping(self) -> Transport | None:
        """Return the transport if it keeps requests for this server; None: requests arrive at once."""
        transport = self._traffic.transport
        if transport is None or self._depth is None or not transport.keeps_requests:
            return None
        return transport

    def _fetch(self, transport: Transport) -> None:
        """Take requests from a transport that keeps them, until a new one is found."""
        while not self.waiting:
            lost, taken = transport.take_request(self.port)
            self._lose(lost)
            if taken is None:
                break
            self._arrived(*taken)

    def _lose(self, messages: Iterable[str]) -> None:
        """Count and record requests that the full history lost; their clients may send them again."""
        traffic, port = self._traffic, self.port
        for message in messages:
            traffic.drops[port.channel, "request"] += 1
            traffic.observer.emit(
                "drop", channel=port.channel, queue="request", message=message, count=1, change={}
            )

    def serve(self) -> None:
        """Give waiting requests, the oldest first, to idle instances whose place has room."""
        traffic, port = self._traffic, self.port
        keeping = self._keeping()
        if keeping is not None:
            self._lose(keeping.lost_requests(port))
        for instance in self.instances:
            while self._is_free(instance):
                if not self.waiting and keeping is not None:
                    self._fetch(keeping)
                if not self.waiting:
                    break
                message, answers = self.waiting.popleft()
                token = traffic.arriving(port.service, instance.entry, message.data)
                if token is None:
                    continue
                instance.message, instance.answers = message.id, answers
                traffic.engine.unhold(instance.departure)
                traffic.engine.put(instance.entry, token)
                if traffic.observer.is_observing:
                    entry = port.entries[instance.number]
                    traffic.came("serve", instance.about, entry, token, message.id)

    def reply(self, instance: Instance) -> None:
        """Send the response of an instance; the instance is idle then.

        Raises
        ------
        SendError
            The transport cannot send the token's data; the token stays on its place. Firings check their
            data, so this token is of the initial marking, or of a journal written by another version.
        """
        traffic, port = self._traffic, self.port
        try:
            traffic.check(instance.exit, traffic.engine.oldest(instance.exit).data)
        except Exception as error:
            raise SendError(f"cannot answer a request of {port.service}: {error}") from error
        token = traffic.engine.take(instance.exit)
        response = Message(instance.message or "", token.data)
        for answer in instance.answers:
            _answer(answer, response)
        instance.message, instance.answers = None, []
        traffic.engine.hold(instance.departure)
        if response.id:
            self.keep(response)
        if traffic.observer.is_observing:
            exit_ = port.exits[instance.number]
            traffic.left("reply", instance.about, exit_, token, response.id)
        self.serve()

    def keep(self, response: Message) -> None:
        """Keep a response for repeated requests: the last ones of each recent sender."""
        sender = _sender(response.id)
        responses = self.responses[sender] = self.responses.pop(sender, {})
        responses[response.id] = response
        if len(responses) > self.kept:
            del responses[next(iter(responses))]
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
    except Exception:  # the client sends the request again
        LOG.exception("the response to %s was not sent", response.id)
