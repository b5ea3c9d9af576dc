"""The receiver of a node: all that a transport delivers, from any thread."""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel.clauses import SignalSetting
from dineros.runtime.channels.arrivals import Arrivals
from dineros.runtime.channels.exchange import Exchange
from dineros.runtime.channels.goals import ActionEvent
from dineros.runtime.channels.transport import Answer
from dineros.runtime.nets.ports import (
    ActionPort,
    ActionServerPort,
    ClientPort,
    Message,
    Port,
    Queue,
    ServerPort,
    SubscriberPort,
    TimerPort,
)
from dineros.runtime.nets.sources import Source
from dineros.runtime.nets.staleness import Expectation
from dineros.runtime.nodes.core import Core


class NodeReceiver:
    """Hands over to the loop of a node what its transport delivers.

    Parameters
    ----------
    core : Core
        The core of the node.
    exchange : Exchange
        Its ports.
    arrivals : Arrivals
        Its messages and requests that wait for room.
    """

    def __init__(self, core: Core, exchange: Exchange, arrivals: Arrivals) -> None:
        self._core = core
        self._loop, self._post = core.loop, core.loop.post
        self._execution = core.execution
        self._exchange, self._arrivals = exchange, arrivals

    def is_open(self, port: SubscriberPort | ServerPort) -> bool:
        """Return whether the node takes another message or request now."""
        return self._arrivals.is_open(port)

    def message_arrived(self, port: SubscriberPort, message: Message, lost: int) -> None:
        """Queue a message for the loop; `lost` messages are missing just before it."""
        self._arrivals.message_arrived(port, message, lost)

    def request_arrived(self, port: ServerPort, message: Message, answer: Answer) -> None:
        """Queue a request for the loop."""
        self._arrivals.request_arrived(port, message, answer)

    def dropped(self, port: Port, queue: Queue, count: int) -> None:
        """Count and record messages that a full queue lost."""
        self._arrivals.dropped(port, queue, count)

    def requests_wait(self, port: ServerPort) -> None:
        """Schedule taking the requests that the transport keeps."""
        self._post(self._exchange.servers[port].serve)

    def messages_skipped(self, port: SubscriberPort, message: Message) -> int:
        """Return how many of its publisher's messages before this one are missing; from any thread."""
        return self._exchange.subscribers[port].skipped(message)

    def knows_request(self, port: ServerPort, message_id: str) -> bool:
        """Return whether an instance serves a request, or its response is kept."""
        return self._exchange.servers[port].knows(message_id)

    def response_arrived(self, port: ClientPort, message: Message) -> None:
        """Schedule putting a response onto its place."""
        self._post(lambda: self._exchange.clients[port].responded(message))

    def request_failed(self, port: ClientPort, message_id: str, reason: str) -> None:
        """Schedule sending a request again."""
        self._post(lambda: self._exchange.clients[port].failed(message_id, reason))

    def ticked(self, timer: TimerPort) -> None:
        """Schedule the callback of a timer."""
        moment = self._loop.clock()
        self._post(lambda: self._execution.timing.ticked(timer, moment))

    def action_event(self, port: ActionPort, event: ActionEvent) -> None:
        """Schedule handling an event about a goal."""
        self._post(lambda: self._exchange.actions.take(port, event))

    def refused(self, port: SubscriberPort | ServerPort | ActionServerPort, error: Exception) -> None:
        """Schedule counting received data that is not a valid message."""
        self._post(lambda: self._exchange.refuse(port, error))

    def signals_changed(self, values: Mapping[str, SignalSetting], source: str) -> None:
        """Have signals set."""
        self._core.submit_signals(values, source)

    def signal_expected(self, signal: str, expectation: Expectation) -> None:
        """Schedule watching whether a signal is set as expected."""
        self._core.signal(signal).stale_after(expectation.seconds, expectation.then)

    def source(self, name: str) -> Source:
        """Return the counters of a signal source."""
        return self._core.new_source(name)

    def remove_source(self, source: Source) -> None:
        """Stop showing these counters."""
        self._core.remove_source(source)
