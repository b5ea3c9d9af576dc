"""Which messages are under way: the order between nodes that traces must keep.

A message is published before it is taken; a request is made before it is served, then answered, then its
response got. Numbers of messages go up, per sending place; so what is kept grows with the messages that were
lost, not with a run.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from dineros.analysis.conformance.net import ConformanceNet
from dineros.analysis.conformance.refusals import Fault, Refusal, Waiting
from dineros.metamodel.message_ids import MessageIdError, Numbers, parse_id
from dineros.metamodel.records import Drop, Publish, Reply, Request, Response, Serve, Take
from dineros.metamodel.records.schema import ChannelStep, ServiceStep

_STAGES: Mapping[type[ServiceStep], tuple[type[ServiceStep] | None, str, str]] = {
    # what must have happened last to the client's call, what that is called, and what this step is called
    Request: (None, "", "requested"),
    Serve: (Request, "requested", "served"),
    Reply: (Serve, "served", "answered"),
    Response: (Reply, "answered", "responded to"),
}
_ORDER = {stage: number for number, stage in enumerate(_STAGES)}


class Past(NamedTuple):
    """How many of a client's calls had got so far when the traces of client and server begin."""

    requested: int
    served: int
    replied: int
    responded: int


class Messages:
    """Messages of a run, by sender.

    Parameters
    ----------
    net : ConformanceNet
        The net, for its clients.
    """

    def __init__(self, net: ConformanceNet) -> None:
        self._net = net
        self._sent: defaultdict[tuple[str, str], Numbers] = defaultdict(_numbers)
        self._taken: defaultdict[tuple[str, str, str], Numbers] = defaultdict(_numbers)
        self._calls: dict[tuple[str, str], tuple[str | None, type[ServiceStep]]] = {}
        self._clients: dict[tuple[str, str], str] = {}
        self._pasts: dict[tuple[str, str], tuple[str, Past]] = {}
        self._gaps: list[Take] = []
        self._drops: Counter[tuple[str, str]] = Counter()
        self._publishers = {(channel, port) for (channel, _), port in net.ports.items()}

    # Of traces that begin within the run.

    def began(self, channel: str, sender: str, number: int) -> None:
        """Note that a sender's messages up to a number were sent before its trace begins."""
        if number:
            self._sent[channel, sender].add(number, number)

    def began_taking(self, channel: str, place: str, sender: str, number: int) -> None:
        """Note that a place had taken a sender's messages up to a number before its trace begins."""
        if number:
            self._taken[channel, place, sender].add(number, number)

    def began_calling(self, channel: str, client: str, sender: str, past: Past) -> None:
        """Note which steps of a client's calls came before the traces of client and server begin."""
        self._pasts[channel, client] = sender, past
        self._clients[channel, sender] = client
        self._calls[channel, client] = (None, Response)
        self._pass_over(channel, client, 0)

    def _pass_over(self, channel: str, client: str, number: int) -> None:
        """Go on to the first step of a client's calls that a trace still tells."""
        known = self._pasts.get((channel, client))
        if known is None:
            return
        sender, past = known
        stages = list(_STAGES)
        at = _ORDER[self._calls[channel, client][1]]
        while True:
            at = (at + 1) % len(stages)
            following = number + (at == 0)
            if following > past[at]:
                return
            number = following
            self._calls[channel, client] = (f"{sender}/{number}", stages[at])

    # What is lost.

    def dropped(self, record: Drop) -> None:
        """Note messages that a queue dropped."""
        at = record.node if record.queue == "dispatcher" else record.place
        at = self._net.ports.get((record.channel, at or ""), at)
        if record.queue != "publisher" or not any(record.change.values()):
            self._drops[record.channel, at or ""] += record.count

    def lost(self) -> list[tuple[Take, str]]:
        """Return which takes follow on messages that were sent, never came, and that no queue dropped."""
        found = []
        # A message that a node, or the publisher, lost is missed by each of the subscribers.
        used: Counter[tuple[str, str, str]] = Counter()
        for record in self._gaps:
            sender, number = _parts(record.message or "")
            taken = self._taken[record.channel, record.place, sender]
            sent = self._sent[record.channel, sender]
            last = (number or 0) - 1
            missing = [each for each in self._before(taken, last) if each in sent and each not in taken]
            node = self._net.topics[record.channel].node_of.get(record.place, "")
            for at in (record.place, node, sender.rpartition("/")[2]):
                each_once = record.channel, at, record.place
                told = min(len(missing), self._drops[record.channel, at] - used[each_once])
                used[each_once] += told
                missing = missing[told:]
            if missing:
                more = f" to {missing[-1]}" if len(missing) > 1 else ""
                is_one = "is" if len(missing) == 1 else "are"
                found.append(
                    (record, f"{sender}/{missing[0]}{more} {is_one} lost, and no full queue dropped it")
                )
        return found

    @staticmethod
    def _before(taken: Numbers, last: int) -> Iterable[int]:
        """Return the numbers of the gap that ends with a number."""
        first = max((end for _, end in taken.ranges() if end <= last), default=0) + 1
        return range(first, last + 1)

    def may_publish(self, record: Publish) -> Refusal | None:
        """Refuse a message that was sent before."""
        return self._fresh(record)

    def published(self, record: Publish) -> None:
        """Note a message."""
        self._note(record)

    def may_take(self, record: Take) -> Refusal | None:
        """Refuse a message that the place has taken before, or that is not published yet."""
        if not record.message:
            return None
        sender, number = _parts(record.message)
        if number is None:
            return Fault(f"{record.message!r} is no message of the model: another program sent it")
        place = sender.rpartition("/")[2]
        if _node(sender) not in self._net.nodes or (record.channel, place) not in self._publishers:
            return Fault(f"{record.message!r} comes from no publisher of topic channel {record.channel!r}")
        if number in self._taken[record.channel, record.place, sender]:
            return Fault(f"it has taken {record.message} before")
        if number not in self._sent[record.channel, sender]:
            return Waiting(f"{record.message} was not published before", (_node(sender),))
        return None

    def taken(self, record: Take) -> None:
        """Note that a place has taken a message."""
        if record.message:
            sender, number = _parts(record.message)
            taken = self._taken[record.channel, record.place, sender]
            if number is not None and number > 1 and number - 1 not in taken:
                self._gaps.append(record)
            taken.add(number or 0)

    def client_of(self, record: ServiceStep) -> str | None:
        """Return the client that a step of a call is of."""
        if record.client:
            return record.client
        sender, _ = _parts(record.message or "")
        place = sender.rpartition("/")[2] or record.place
        return self._clients.get((record.channel, sender)) or self._net.clients.get((record.channel, place))

    def is_asking(self, record: ServiceStep, client: str) -> bool:
        """Tell whether a step is of a client's call that is not known to be served."""
        message, stage = self._calls.get((record.channel, client), (None, Response))
        return stage is Request and record.message in (message, None, "")

    def may_serve(self, record: ServiceStep, client: str) -> Refusal | None:
        """Refuse a step of a call that is not the next one of the client's call."""
        after, done, _ = _STAGES[type(record)]
        if after is None:
            return self._fresh(record)
        message, stage = self._calls.get((record.channel, client), (None, Response))
        if stage is after and record.message in (message, None, ""):
            return None
        if isinstance(record, Reply):
            return Fault(f"{record.message} is not being served")
        sender, number = _parts(record.message or "")
        if record.message and record.message == message and _ORDER[stage] >= _ORDER[type(record)]:
            return Fault(f"{record.message} was {_STAGES[type(record)][2]} before")
        if number is not None and record.message != message:
            if number in self._sent[record.channel, sender]:
                return Fault(f"{record.message} is an earlier call of client {client}, which has ended")
            if isinstance(record, Response):
                return Fault(f"{record.message} was not requested")
        client_node, server_node = self._net.ends_of_call(record.channel, client)
        awaited = client_node if isinstance(record, Serve) else server_node
        ros_name = self._net.names_in_ros[record.channel]
        outside = ""
        if isinstance(record, Response) and record.channel in self._net.typed_channels:
            outside = f"a program outside of the model answers requests of {ros_name}, too"
        return Waiting(f"{record.message or 'a call'} was not {done} before", (awaited,), outside)

    def served(self, record: ServiceStep, client: str) -> None:
        """Note a step of a call."""
        if isinstance(record, Request):
            self._note(record)
            self._clients[record.channel, _parts(record.message or "")[0]] = client
        message = record.message or self._calls.get((record.channel, client), (None, Response))[0]
        self._calls[record.channel, client] = (message, type(record))
        if (number := _parts(message or "")[1]) is not None:
            self._pass_over(record.channel, client, number)

    def _fresh(self, record: ChannelStep) -> Refusal | None:
        if not record.message:
            return None
        sender, number = _parts(record.message)
        place = self._net.ports.get((record.channel, record.place), record.place)
        if number is None or _node(sender) != record.node or sender.rpartition("/")[2] != place:
            return Fault(f"{record.message!r} is no id of a message that {record.node}/{record.place} sends")
        known = number in self._sent[record.channel, sender]
        return Fault(f"{record.message} was sent before") if known else None

    def _note(self, record: ChannelStep) -> None:
        if record.message:
            sender, number = _parts(record.message)
            self._sent[record.channel, sender].add(number or 0)


def _node(sender: str) -> str:
    """Return the node net of a sender, ``NODE/PLACE`` or ``NODE@RUN/PLACE``."""
    return sender.rpartition("/")[0].partition("@")[0]


def _parts(message: str) -> tuple[str, int | None]:
    """Return sender and number of a message id; no number where it is none."""
    try:
        known = parse_id(message)
    except MessageIdError:
        known = None
    return known or (message.rpartition("/")[0], None)


def _numbers() -> Numbers:
    return Numbers(limit=None)
