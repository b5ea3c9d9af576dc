"""Servers of a node.

A server serves as many requests at a time as it has instances, the oldest first; a request that comes twice
is served once and answered twice. Under the rules of ROS 2 it keeps as many requests as its depth, and
forgets the oldest for one more (rule R5); one that comes again takes no room there.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Iterable

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.message_ids import Senders, parse_id
from dineros.runtime.channels.traffic import SendError, Traffic
from dineros.runtime.channels.transport import Answer, Keeping
from dineros.runtime.nets.ports import Message, ServerPort

LOG = logging.getLogger("dineros.runtime")
KEPT_SENDERS = 256
LONGEST_QUEUE = 1000
"""Requests that wait for an instance, at most, where the rules know no depth: what comes then is dropped."""
KEPT_RESPONSES = 64
"""Responses that are kept of each sender which has several requests under way, besides those."""

KEPT_ANSWERS = 64
"""Attempts of a request that are answered: the first one, and the last ones but for it."""


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
    about : dict
        What records say of it.
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
        Requests that wait for an instance, the oldest first, each with where its response goes.
    responses : dict of str to dict of str to Message
        The last responses to each sender by id, for a request that comes again: `kept` of them.
    kept : int
        How many responses to each sender are kept. Of a sender that has one request under way, the next one
        acknowledges the response to the one before.
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
        """Serve a request, or let it wait; one that came before gets the same response."""
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
                return  # answered long ago
        if self._depth is None and len(self.waiting) >= LONGEST_QUEUE:
            error = DinerosError(f"{LONGEST_QUEUE:,} requests wait already")
            self._traffic.refuse(self.port.channel, self.port.service, error)
            return
        self.waiting.append((message, [answer]))

    def knows(self, message_id: str) -> bool:
        """Return whether a request was taken before, and is being served or has its response kept."""
        if any(instance.message == message_id for instance in self.instances):
            return True
        return message_id in self.responses.get(_sender(message_id), {})

    def is_open(self, arriving: int) -> bool:
        """Return whether a request is taken from the middleware besides those that arrive; from any thread.

        Even while all instances serve others: the history is kept here, since what comes again and is known
        must be answered then, too. Nobody else might end what the instances wait for.
        """
        return self._depth is None or arriving <= self._depth

    @property
    def busy(self) -> int:
        """How many requests it serves now."""
        return sum(instance.message is not None for instance in self.instances)

    def _is_free(self, instance: Instance) -> bool:
        return instance.message is None and self._traffic.engine.has_room(instance.entry)

    def _keeping(self) -> Keeping | None:
        """Return what keeps requests for this server; None: it gets them as they come."""
        transport: object = self._traffic.transport
        return transport if self._depth is not None and isinstance(transport, Keeping) else None

    def _fetch(self, transport: Keeping) -> None:
        """Take requests from a transport that keeps them, until one is new."""
        while not self.waiting:
            lost, taken = transport.take_request(self.port)
            self._lose(lost)
            if taken is None:
                break
            self._arrived(*taken)

    def _lose(self, messages: Iterable[str]) -> None:
        """Count and record requests that the full history has forgotten; their clients may ask again."""
        traffic, port = self._traffic, self.port
        for message in messages:
            traffic.drops[port.channel, "request"] += 1
            traffic.observer.emit(
                "drop", channel=port.channel, queue="request", message=message, count=1, change={}
            )

    def serve(self) -> None:
        """Give waiting requests to inactive instances that have room, the oldest first."""
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
        """Send the response of an instance, which is inactive then.

        Raises
        ------
        SendError
            The transport cannot send what the token carries; it stays where it is. Firings are checked, so
            that this is a token of the initial marking, or of a journal that another version has written.
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
        """Keep a response for a request that comes again; the last ones of each of the senders heard last."""
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
    except Exception:  # the client asks again
        LOG.exception("the response to %s was not sent", response.id)
