"""The receiver of a node: all that a transport delivers, from any thread."""

from __future__ import annotations

from dineros.runtime.channels.arrivals import Arrivals
from dineros.runtime.channels.exchange import Exchange
from dineros.runtime.channels.goals import ActionEvent
from dineros.runtime.nets.ports import (
    ActionPort,
    ActionServerPort,
    ClientPort,
    Message,
    ServerPort,
    SubscriberPort,
    TimerPort,
)
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
        self._exchange = exchange
        self.is_open = arrivals.is_open
        self.message_arrived, self.request_arrived = arrivals.message_arrived, arrivals.request_arrived
        self.dropped = arrivals.dropped
        self.signals_changed = core.submit_signals
        self.source, self.remove_source = core.new_source, core.remove_source

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

    def signal_expected(self, signal: str, expectation: Expectation) -> None:
        """Schedule watching whether a signal is set as expected."""
        self._core.signal(signal).stale_after(expectation.seconds, expectation.then)
