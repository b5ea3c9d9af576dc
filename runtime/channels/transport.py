"""The interface between a node and a transport.

A *transport* carries messages between nodes: in this process (`dineros.runtime.channels.local`) or through
ROS 2. A node opens it with its ports and with itself as the receiver. A transport may call the receiver from
any thread; a node calls its transport from one thread only.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

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
"""Sends the response to a request. The node calls it once, on its own thread; it does not raise."""


class Receiver(Protocol):
    """Methods that a transport calls, from any thread; they return at once, the node acts on its thread."""

    def message_arrived(self, port: SubscriberPort, message: Message, lost: int) -> None:
        """Receive a message of a topic; `lost` messages are missing just before it."""

    def is_open(self, port: SubscriberPort | ServerPort) -> bool:
        """Return whether the node takes a message of a topic, or a request, now.

        If not, the message stays in the middleware, whose history loses its oldest message when it is full.
        """

    def request_arrived(self, port: ServerPort, message: Message, answer: Answer) -> None:
        """Receive a request. A repeated request is handled once; each `answer` given for it is called."""

    def requests_wait(self, port: ServerPort) -> None:
        """Notice that a transport that keeps requests has some, or has lost some."""

    def messages_skipped(self, port: SubscriberPort, message: Message) -> int:
        """Return how many messages of a publisher before this one are missing; 0 for a new publisher."""

    def knows_request(self, port: ServerPort, message_id: str) -> bool:
        """Return whether a request was taken before: a repeated request waits for no instance."""

    def response_arrived(self, port: ClientPort, message: Message) -> None:
        """Receive the response to the request of this id; ignored if no request waits for it."""

    def request_failed(self, port: ClientPort, message_id: str, reason: str) -> None:
        """Notice that a request timed out or was not sent; it is recorded and sent again with the same id."""

    def ticked(self, timer: TimerPort) -> None:
        """Handle a tick of a timer; a tick before the callback has begun is lost."""

    def action_event(self, port: ActionPort, event: ActionEvent) -> None:
        """Handle an event about a goal of an action."""

    def refused(self, port: SubscriberPort | ServerPort | ActionServerPort, error: Exception) -> None:
        """Count received data that is not a valid message; the first case is recorded."""

    def dropped(self, port: Port, queue: Queue, count: int) -> None:
        """Count messages that a full queue lost outside of `publish` and `message_arrived`."""

    def signals_changed(self, values: Mapping[str, SignalSetting], source: str) -> None:
        """Set input signals at once, by id or name; `source` is their origin and is recorded.

        Raises
        ------
        DinerosError
            The node has no such signal; none is set.
        """

    def signal_expected(self, signal: str, expectation: Expectation) -> None:
        """Watch from now on whether the signal is set as expected."""

    def source(self, name: str) -> Source:
        """Return the counters of the signal source of this name; the node shows them from now on."""

    def remove_source(self, source: Source) -> None:
        """Stop showing a source."""


class Transport(ABC):
    """Carries the messages of one node; the node calls it from the thread of its loop.

    A transport must join channels, publish, send requests and leave. All other abilities have a default:
    without timers, for example, the timers of a node use the clock of its loop.

    Attributes
    ----------
    has_timers : bool
        Whether it has timers of its own, which `start_timers` starts.
    keeps_requests : bool
        Whether it keeps requests until `take_request` takes them. Otherwise requests arrive at once.
    """

    has_timers = False
    keeps_requests = False

    @abstractmethod
    def open(self, ports: Ports, receiver: Receiver) -> None:
        """Join the channels; from now on, the receiver gets all that arrives."""

    @abstractmethod
    def publish(self, port: PublisherPort, message: Message) -> bool:
        """Send a message; False: the publisher's queue was full and the message is dropped.

        A transport that overwrites the oldest message instead returns True here, and calls `dropped` for the
        overwritten message if it notices the loss.
        """

    @abstractmethod
    def request(self, port: ClientPort, message: Message) -> None:
        """Send a request, or send it again after a time-out.

        Each client has at most `ClientPort.outstanding` requests under way.
        """

    @abstractmethod
    def close(self) -> None:
        """Leave the channels; after it returns, the receiver is not called any more."""

    def check(self, port: Port, part: str = "") -> Check | None:
        """Return a function that raises for data that cannot be sent at a port; None: all data can be sent.

        For an action server, `part` is ``result`` or ``feedback``.
        """
        return None

    def publish_again(self, port: PublisherPort, message: Message) -> object:
        """Send a message that was sent before a restart; receivers recognise copies by the id."""
        return self.publish(port, message)

    def opened(self, port: SubscriberPort) -> object:
        """Notice that the node takes messages of a topic again; on the thread of the node's loop."""
        return None

    def most_waiting(self, port: SubscriberPort) -> int:
        """Return the most messages of a topic that waited in its history at once since the last call."""
        return 0

    def waited(self, port: SubscriberPort) -> float:
        """Return how many seconds the message taken last had waited in its history; 0: unknown."""
        return 0.0

    def start_timers(self) -> object:
        """Report each tick to the receiver, the first one after a period; called once, when it is open."""
        return None

    def take_request(self, port: ServerPort) -> tuple[list[str], tuple[Message, Answer] | None]:
        """Return the requests lost before, as `lost_requests` does, and the oldest request that waits.

        Both are read at one moment: a request may arrive at any time, and a request that it displaces from
        the history is recorded before it is handled itself. The request comes with the function that sends
        its response; None: no request waits.
        """
        return [], None

    def lost_requests(self, port: ServerPort) -> list[str]:
        """Return the ids of the requests that the full history has lost since the last call."""
        return []

    def forget(self, port: ClientPort, message_id: str) -> object:
        """Notice that the node no longer waits for the response to a request."""
        return None

    # Goals of actions.

    def restore_goals(self, port: ActionServerPort, goals: Sequence[KnownGoal]) -> None:
        """Restore the goals from before a restart, before any other goal arrives."""
        raise self._carries_no_goals()

    def send_goal(self, port: ActionClientPort, message: Message) -> None:
        """Send a goal; a repeated goal has the same id."""
        raise self._carries_no_goals()

    def follow_goal(self, port: ActionClientPort, message: Message) -> None:
        """Ask for the result of an accepted goal from before a restart."""
        raise self._carries_no_goals()

    def cancel_goal(self, port: ActionClientPort, goal: str) -> None:
        """Ask to cancel a goal; the transport repeats the request until the server answers."""
        raise self._carries_no_goals()

    def give_feedback(self, port: ActionServerPort, goal: str, number: int, data: Data) -> None:
        """Send the `number`-th feedback of a goal to its client."""
        raise self._carries_no_goals()

    def finish_goal(self, port: ActionServerPort, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """Send the result of a goal to its client, now or when the client asks for it."""
        raise self._carries_no_goals()

    def _carries_no_goals(self) -> DinerosError:
        return DinerosError(f"{type(self).__name__} carries no goals of actions")
