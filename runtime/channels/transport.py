"""What a node asks of a transport, and what a transport tells a node.

A *transport* carries messages between nodes: in this process (`dineros.runtime.channels.local`) or through
ROS 2. A node opens it with its ports and with itself as the receiver. A transport may call the receiver from
any thread; a node calls its transport from one thread only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, runtime_checkable

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError
from dineros.runtime.channels.goals import ActionEvent, KnownGoal
from dineros.runtime.nets.ports import (
    ActionClientPort,
    ActionPort,
    ActionServerPort,
    Check,
    ClientPort,
    Data,
    Message,
    OutcomeKind,
    Port,
    Ports,
    PublisherPort,
    Queue,
    ServerPort,
    SubscriberPort,
    TimerPort,
)
from dineros.runtime.nets.sources import Source
from dineros.runtime.nets.staleness import Expectation

Answer = Callable[[Message], None]
"""Sends the response to a request; called once by the node, on its own thread. It does not raise."""


class Receiver(Protocol):
    """What a transport calls, from any thread; calls return at once, the node acts on its own thread."""

    def message_arrived(self, port: SubscriberPort, message: Message, lost: int) -> None:
        """Take a message of a topic; `lost` messages are missing just before it."""

    def is_open(self, port: SubscriberPort | ServerPort) -> bool:
        """Return whether the node takes a message of a topic, or a request, now.

        Where it does not, it stays in the middleware, whose history loses the oldest.
        """

    def request_arrived(self, port: ServerPort, message: Message, answer: Answer) -> None:
        """Take a request. One that comes again is served once; every `answer` given for it is called."""

    def requests_wait(self, port: ServerPort) -> None:
        """Learn that a transport which is `Keeping` has requests, or has lost some."""

    def messages_skipped(self, port: SubscriberPort, message: Message) -> int:
        """Return how many messages of a publisher before this one are missing; none of a new publisher."""

    def knows_request(self, port: ServerPort, message_id: str) -> bool:
        """Return whether a request was taken before: one that comes again waits for no instance."""

    def response_arrived(self, port: ClientPort, message: Message) -> None:
        """Take the response to the request of this id; one that nobody waits for (any more) is ignored."""

    def request_failed(self, port: ClientPort, message_id: str, reason: str) -> None:
        """Learn that a request timed out or was not sent: it is recorded and sent again with the same id."""

    def ticked(self, timer: TimerPort) -> None:
        """Learn that a timer ticks; a tick that comes before its callback has begun is gone."""

    def action_event(self, port: ActionPort, event: ActionEvent) -> None:
        """Learn of a goal of an action."""

    def refused(self, port: SubscriberPort | ServerPort | ActionServerPort, error: Exception) -> None:
        """Learn that something came that is not a message; it is counted, and the first is recorded."""

    def dropped(self, port: Port, queue: Queue, count: int) -> None:
        """Learn that a full queue lost messages outside of `publish` and `message_arrived`."""

    def signals_changed(self, values: Mapping[str, SignalSetting], source: str) -> None:
        """Set input signals at once, by id or name; `source` says where they came from and is recorded.

        Raises
        ------
        DinerosError
            The node has no such signal; none is set.
        """

    def signal_expected(self, signal: str, expectation: Expectation) -> None:
        """Notice from now on when nobody sets a signal."""

    def source(self, name: str) -> Source:
        """Return the counters of what sets signals under this name, shown by the node from now on."""

    def remove_source(self, source: Source) -> None:
        """Show it no more."""


@runtime_checkable
class Choosy(Protocol):
    """A transport that does not send all that tokens can carry."""

    def check(self, port: Port, part: str = "") -> Check | None:
        """Return what raises for data that cannot be sent at a port; None: it sends all.

        `part` is ``result`` or ``feedback`` of an action's server.
        """


def check_of(transport: Transport, port: Port, part: str = "") -> Check | None:
    """Return what raises for data that a transport cannot send at a port; None: it sends all."""
    if not isinstance(transport, Choosy):
        return None
    return transport.check(port, part) if part else transport.check(port)


@runtime_checkable
class Repeating(Protocol):
    """A transport that tells what was sent before a restart from what is sent for the first time."""

    def publish_again(self, port: PublisherPort, message: Message) -> object:
        """Send a message that was sent before to those who tell by its id whether they had it."""


@runtime_checkable
class Pausing(Protocol):
    """A transport that does not ask again by itself whether the node takes a message."""

    def opened(self, port: SubscriberPort) -> object:
        """Learn that the node takes messages of a topic again; on the thread of the node's loop."""


@runtime_checkable
class Measuring(Protocol):
    """A transport that can tell how full the histories were from which messages come."""

    def most_waiting(self, port: SubscriberPort) -> int:
        """Return how many messages of a topic waited at a time, at most, since this was asked last."""

    def waited(self, port: SubscriberPort) -> float:
        """Return for how many seconds the message that was taken last had waited in its history."""


@runtime_checkable
class Ticking(Protocol):
    """A transport that has timers; where it has none, those of a node go by the clock of its loop."""

    def start_timers(self) -> object:
        """Tell the receiver of each tick from now on, the first one after a period; once, when it is open."""


@runtime_checkable
class Keeping(Protocol):
    """A transport that keeps requests until the node takes them: on the thread of the node's loop."""

    def take_request(self, port: ServerPort) -> tuple[list[str], tuple[Message, Answer] | None]:
        """Return what was lost before, as `lost_requests` does, and the oldest request that waits then.

        Both at one moment: a request may arrive at any time, and what it pushes out of the history is
        recorded before the request itself is served. With the request comes what sends its response; None:
        none waits.
        """

    def lost_requests(self, port: ServerPort) -> list[str]:
        """Return the ids of the requests that the full history has lost since this was asked last."""


@runtime_checkable
class Forgetting(Protocol):
    """A transport that keeps something of each request until its response is there."""

    def forget(self, port: ClientPort, message_id: str) -> object:
        """Learn that the node waits no longer for the response to a request."""


class Transport(Protocol):
    """What a node calls, from the thread of its loop."""

    def open(self, ports: Ports, receiver: Receiver) -> None:
        """Join the channels; what arrives goes to the receiver from now on."""

    def publish(self, port: PublisherPort, message: Message) -> bool:
        """Send a message; False: the publisher's queue was full and the message is dropped.

        A transport that overwrites the oldest instead says True here, and `dropped` for the one overwritten
        where it knows of it.
        """

    def request(self, port: ClientPort, message: Message) -> None:
        """Send a request, once more if it was sent before: the node does so after a time-out.

        The node has as many under way per client as `ClientPort.outstanding` says.
        """

    def close(self) -> None:
        """Leave the channels; when it returns, the receiver is called no more."""


@runtime_checkable
class ActionTransport(Protocol):
    """A transport that carries goals; a node calls it from the thread of its loop."""

    def restore_goals(self, port: ActionServerPort, goals: Sequence[KnownGoal]) -> None:
        """Know the goals of an earlier life again, before any other arrives."""

    def send_goal(self, port: ActionClientPort, message: Message) -> None:
        """Send a goal; one that was sent before goes again with the same id."""

    def follow_goal(self, port: ActionClientPort, message: Message) -> None:
        """Ask for the result of a goal of an earlier life, which was accepted."""

    def cancel_goal(self, port: ActionClientPort, goal: str) -> None:
        """Ask to cancel a goal; asked again where nobody answers."""

    def give_feedback(self, port: ActionServerPort, goal: str, number: int, data: Data) -> None:
        """Send feedback to the client of a goal: the goal's `number`-th."""

    def finish_goal(self, port: ActionServerPort, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """Send the result of a goal to its client, now or when that asks for it."""


def action_transport(transport: Transport) -> ActionTransport:
    """Return a transport as one that carries goals.

    Raises
    ------
    DinerosError
        It carries none.
    """
    if not isinstance(transport, ActionTransport):
        raise DinerosError(f"{type(transport).__name__} carries no goals of actions")
    return transport
