"""Messages under way: the order between nodes that a replay must keep.

A message is published before it is taken. A request is sent before it is served, then answered, then its
response is received. Numbers of messages increase for each sending place; so the stored data grows with the
number of lost messages, not with the length of the run.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable

from dineros.analysis.conformance.net import ConformanceNet
from dineros.analysis.conformance.refusals import Fault, Refusal, Waiting
from dineros.analysis.conformance.services.stages import AFTER, Before, Stages
from dineros.analysis.conformance.topics.fates import sender_and_number
from dineros.metamodel.message_ids import Numbers
from dineros.metamodel.records import Drop, Reply, Request, Response, Serve, Take
from dineros.metamodel.records.schema import ChannelStep, ServiceStep


class Messages:
    """Messages of a run, by sender."""

    def __init__(self, net: ConformanceNet) -> None:
        self._net = net
        self._sent: defaultdict[tuple[str, str], Numbers] = defaultdict(_numbers)
        self._taken: defaultdict[tuple[str, str, str], Numbers] = defaultdict(_numbers)
        self.stages = Stages()
        self._clients: dict[tuple[str, str], str] = {}
        self._gaps: list[Take] = []
        self._drops: Counter[tuple[str, str]] = Counter()
        self._publishers = {(channel, port) for (channel, _), port in net.ports.items()}

    # Traces that begin in the middle of the run.

    def began(self, channel: str, sender: str, number: int) -> None:
        """Record that a sender's messages up to a number were sent before its trace begins."""
        if number:
            self._sent[channel, sender].add(number, number)

    def began_taking(self, channel: str, place: str, sender: str, number: int) -> None:
        """Record that a place had taken a sender's messages up to a number before its trace begins."""
        if number:
            self._taken[channel, place, sender].add(number, number)

    def began_calling(self, channel: str, client: str, before: Before) -> None:
        """Record the steps of a client's calls before the traces of client and server begin."""
        self._clients[channel, before.sender] = client
        self.stages.begin(channel, client, before)

    # Losses.

    def dropped(self, record: Drop) -> None:
        """Record messages that a queue dropped."""
        at = record.node if record.queue == "dispatcher" else record.place
        at = self._net.ports.get((record.channel, at or ""), at)
        if record.queue != "publisher" or not any(record.change.values()):
            self._drops[record.channel, at or ""] += record.count

    def lost(self) -> list[tuple[Take, str]]:
        """Return the takes before which messages are missing that were sent and that no queue dropped."""
        found = []
        # A message lost by a node, or by the publisher, is missing for each subscriber.
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
        """Return the missing numbers before a number."""
        return range(taken.highest_up_to(last) + 1, last + 1)

    def may_take(self, record: Take) -> Refusal | None:
        """Refuse a message that the place has taken before, or that is not published yet."""
        if not record.message:
            return None
        sender, number = _parts(record.message)
        if number is None:
            return Fault(f"{record.message!r} is not a message of the model: another program sent it")
        place = sender.rpartition("/")[2]
        if _node(sender) not in self._net.nodes or (record.channel, place) not in self._publishers:
            return Fault(f"{record.message!r} comes from no publisher of topic channel {record.channel!r}")
        if number in self._taken[record.channel, record.place, sender]:
            return Fault(f"it has already taken {record.message}")
        if number not in self._sent[record.channel, sender]:
            return Waiting(f"{record.message} was not published before", (_node(sender),))
        return None

    def taken(self, record: Take) -> None:
        """Record that a place has taken a message."""
        if record.message:
            sender, number = _parts(record.message)
            taken = self._taken[record.channel, record.place, sender]
            if number is not None and number > 1 and number - 1 not in taken:
                self._gaps.append(record)
            taken.add(number or 0)

    def client_of(self, record: ServiceStep) -> str | None:
        """Return the client of a step of a call."""
        if record.client:
            return record.client
        sender, _ = _parts(record.message or "")
        place = sender.rpartition("/")[2] or record.place
        return self._clients.get((record.channel, sender)) or self._net.clients.get((record.channel, place))

    def is_asking(self, record: ServiceStep, client: str) -> bool:
        """Return whether a step belongs to a client's call that is not known to be served."""
        return self.stages.of(record.channel, client, record.message or "") is Request

    def may_serve(self, record: ServiceStep, client: str) -> Refusal | None:
        """Refuse a step that is not the next step of the client's call."""
        kind, channel = type(record), record.channel
        after, done, _ = AFTER[kind]
        if after is None:
            return self.may_send(record)
        message = self.stages.message(record, client)
        sender, number = _parts(message)
        if kind is Serve and self.stages.was_over(channel, client, number or 0):
            self._serve_after_all(channel, client, message, number or 0)
        stage, late = self.stages.of(channel, client, message), self.stages.late(channel, message)
        if after in (stage, late) and not (late and kind is Response):
            return None
        if kind is Reply and stage is None and self.stages.ahead(channel, client, message):
            return Waiting(f"{message} was not requested before", self._net.ends_of_call(channel, client)[:1])
        if kind is Reply:
            return Fault(f"{record.message} is not being served")
        known = late if kind is Serve else None
        if (last := stage or known) is not None and record.message and not Stages.comes_before(last, kind):
            return Fault(f"{record.message} was {AFTER[kind][2]} before")
        if number is not None and stage is None:
            if number in self._sent[channel, sender]:
                how = "was given up" if late else "has ended"
                return Fault(f"{record.message} is an earlier call of client {client}, which {how}")
            if kind is Response:
                return Fault(f"{record.message} was not requested")
        client_node, server_node = self._net.ends_of_call(channel, client)
        awaited = client_node if kind is Serve else server_node
        outside = ""
        if kind is Response and channel in self._net.typed_channels:
            outside = (
                f"a program outside of the model answers requests of {self._net.names_in_ros[channel]}, too"
            )
        return Waiting(f"{record.message or 'a call'} was not {done} before", (awaited,), outside)

    def _serve_after_all(self, channel: str, client: str, message: str, number: int) -> None:
        """Resume a call that was over for its client when the traces begin, and not served yet."""
        if self.stages.of(channel, client, message) or self.stages.late(channel, message):
            return
        if self.stages.is_unknown_late(channel, client, number):
            self.stages.begin_late(channel, message)
        else:
            self.stages.resume(channel, client, message)

    def served(self, record: ServiceStep, client: str, instance: int | None) -> None:
        """Record a step of a call."""
        if isinstance(record, Request):
            self.sent(record)
            self._clients[record.channel, _parts(record.message or "")[0]] = client
        self.stages.step(record, client, instance)

    def may_give_up(self, channel: str, client: str, message: str) -> Fault | None:
        """Refuse that a client gives up a call for which it does not wait."""
        if self.stages.of(channel, client, message) is not None:
            return None
        if self.stages.late(channel, message) is not None:
            return Fault(f"{message} was given up before")
        sender, number = _parts(message)
        if number is not None and number in self._sent[channel, sender]:
            return Fault(f"{message} is an earlier call of client {client}, which has ended")
        return Fault(f"{message} was not requested")

    def may_lose(self, record: Drop, depth: int) -> Refusal | None:
        """Refuse that a history loses a request that was not sent, or was served, or if there was room."""
        sender, number = _parts(record.message or "")
        if number is None:
            return None
        asking = self._net.asking_nodes(record.channel)
        if not self.stages.is_unserved(record.channel, record.message or ""):
            if number in self._sent[record.channel, sender]:
                within = self.stages.has_begun_within(record.channel)
                return None if within else Fault(f"{record.message} was served before")
            return Waiting(f"{record.message} was not requested before", asking)
        others = self.stages.waiting(record.channel, record.message or "")
        if others >= depth or self.stages.has_begun_within(record.channel):
            return None
        return Waiting(
            f"it is lost from a request history with room: {others} others wait in its {depth} at most",
            asking,
        )

    def may_send(self, record: ChannelStep) -> Refusal | None:
        """Refuse a message or request that was sent before, or whose id does not belong to its sender."""
        if not record.message:
            return None
        sender, number = _parts(record.message)
        place = self._net.ports.get((record.channel, record.place), record.place)
        if number is None or _node(sender) != record.node or sender.rpartition("/")[2] != place:
            return Fault(
                f"{record.message!r} is not an id of a message that {record.node}/{record.place} sends"
            )
        known = number in self._sent[record.channel, sender]
        return Fault(f"{record.message} was sent before") if known else None

    def sent(self, record: ChannelStep) -> None:
        """Record a message or a request that is sent."""
        if record.message:
            sender, number = _parts(record.message)
            self._sent[record.channel, sender].add(number or 0)


def _node(sender: str) -> str:
    """Return the node net of a sender, ``NODE/PLACE`` or ``NODE@RUN/PLACE``."""
    return sender.rpartition("/")[0].partition("@")[0]


def _parts(message: str) -> tuple[str, int | None]:
    """Return sender and number of a message id; the number is None if there is none."""
    return sender_and_number(message) or (message.rpartition("/")[0], None)


def _numbers() -> Numbers:
    return Numbers(limit=None)
