"""A node's channels on ROS 2: topics, services and signals through rclpy.

Callbacks deliver their data and return at once. The response of a service is sent when the net has one, from
any thread: there can be as many requests under way as the net has server instances.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from dineros.runtime.channels.transport import Answer, Receiver, Transport
from dineros.runtime.nets.ports import (
    ActionPort,
    Check,
    ClientPort,
    Message,
    Port,
    Ports,
    PublisherPort,
    ServerPort,
    SubscriberPort,
)
from dineros.runtime.ros.channels.actions import GoalCarrier
from dineros.runtime.ros.channels.clients import Clients
from dineros.runtime.ros.channels.companions import MESSAGES, REQUESTS, Announcer, Listener
from dineros.runtime.ros.channels.parameters import (
    DISCOVERY_TIMEOUT,
    REQUEST_TIMEOUT,
    declare,
    subscriber_parameters,
)
from dineros.runtime.ros.channels.pausing import pausing_group
from dineros.runtime.ros.channels.quality import (
    SERVICE_DEPTH,
    FillMeter,
    LossCounter,
    most_known,
    overriding_options,
    reliable_quality,
    topic_quality,
)
from dineros.runtime.ros.channels.signals import RosSignals
from dineros.runtime.ros.channels.timers import RosTimers
from dineros.runtime.ros.conversion.codecs import Codecs
from dineros.runtime.ros.conversion.messages import Codec
from dineros.runtime.ros.process.session import LOG, Session, made_in_ros


@dataclass(frozen=True)
class _Outlet:
    """A publisher, with the announcer of its messages if their type has no id field."""

    encode: Callable[[Message], Any]
    publisher: Any
    announcer: Announcer | None
    has_ids: bool


class RclpyTransport(GoalCarrier, Transport):
    """Connects a node to ROS 2.

    Parameters
    ----------
    session : Session
        The ROS node to use; it stays open when the transport closes.
    seen : mapping, optional
        Messages that the node received before a restart, as in a checkpoint: ``CHANNEL/PLACE`` -> sender ->
        number. None: the node was not restarted.
    announces : bool
        Whether messages of existing types get ids, which doubles the number of messages sent. A node without
        a journal never sends a message again, so it needs no ids.
    """

    has_timers = True

    def __init__(
        self,
        session: Session,
        seen: Mapping[str, Mapping[str, int]] | None = None,
        *,
        announces: bool = True,
    ) -> None:
        self._seen, self._is_resumed = seen or {}, seen is not None
        self._announces = announces
        self._session, self._node = session, session.node
        super().__init__()
        self._is_open = False
        self._has_histories = False
        self._publishers: dict[tuple[str, str], _Outlet] = {}
        self._entities: list[tuple[Callable[[Any], Any], Any]] = []
        self._clients: Clients | None = None
        self._signals: RosSignals | None = None
        self._timers: RosTimers | None = None
        self._checks: dict[Port, Check | None] = {}
        self._meters: dict[SubscriberPort, FillMeter] = {}

    def open(self, ports: Ports, receiver: Receiver) -> None:
        """Create publishers, subscriptions, clients and services; wait for the expected subscribers.

        Raises
        ------
        RosError
            ROS is not available, or refuses a name, a quality of service or a parameter.
        InterfaceError
            A ROS interface is not installed, or does not fit the model.
        """
        self._is_open = True
        self._has_histories = ports.middleware == "ros2"
        self._receiver, self._codecs = receiver, Codecs(ports)
        try:
            self._make_entities(ports)
        except BaseException:
            self.close()
            raise
        self._await_subscribers(ports)

    def _make_entities(self, ports: Ports) -> None:
        node, codecs, receiver = self._node, self._codecs, self._receiver
        timeout = float(declare(node, REQUEST_TIMEOUT))
        self._clients = Clients(node, receiver, timeout)
        for publisher in ports.publishers:
            self._add_publisher(publisher)
        for server in ports.servers:
            self._add_server(server)
        for client in ports.clients:
            self._checks[client] = self._clients.add(client, codecs).check
        for subscriber in ports.subscribers:
            self._add_subscriber(subscriber)
        self.open_goals(node, ports, codecs, receiver, timeout)
        self._signals = RosSignals(node, ports.signals, receiver)
        self._timers = self._own(RosTimers.close, RosTimers(node, ports.timers, receiver.ticked))

    def _own(self, destroy: Callable[[Any], Any], entity: Any) -> Any:
        self._entities.append((destroy, entity))
        return entity

    def _add_publisher(self, port: PublisherPort) -> None:
        node, (interface, codec) = self._node, self._codecs.topic(port)
        announcer = None
        if port.type is not None and port.is_kept and self._announces:
            name = f"{node.resolve_topic_name(port.topic)}/{MESSAGES}"
            with made_in_ros(repr(name)):
                announcer = Announcer(node, name, port.limit)
            self._own(Announcer.close, announcer)
        with made_in_ros(repr(port.topic)):
            options = overriding_options(port)
            publisher = node.create_publisher(
                interface, port.topic, topic_quality(port), qos_overriding_options=options
            )
        self._own(node.destroy_publisher, publisher)
        has_ids = port.type is None or announcer is not None
        self._publishers[port.channel, port.place] = _Outlet(codec.encode, publisher, announcer, has_ids)
        self._checks[port] = codec.check

    def _add_subscriber(self, port: SubscriberPort) -> None:
        node, receiver = self._node, self._receiver
        interface, codec = self._codecs.topic(port)
        seen = self._seen.get(f"{port.channel}/{port.place}", {})
        counter = LossCounter(seen, is_resumed=self._is_resumed)
        known = most_known(port.limit, seen)
        decode, arrived = codec.decode, receiver.message_arrived

        def accept(message: Message, info: Mapping[str, Any]) -> None:
            if self._is_open:
                sequence = info["publication_sequence_number"]
                publishers = subscription.get_publisher_count
                if again := counter.lost_at_restart(message.id, sequence, publishers):
                    receiver.dropped(port, "restart", again)
                lost = counter.lost_before(message.id, sequence, publishers)
                arrived(port, message, lost)

        meter = self._meters[port] = FillMeter(port.limit)
        group = pausing_group(lambda: receiver.is_open(port))
        if port.type is not None and port.is_kept:
            depth = port.limit + known
            take = self._with_companion(port, interface, codec, accept, group, depth)
        else:

            def take(ros_message: Any, info: Mapping[str, Any]) -> None:
                accept(decode(ros_message), info)

        def taken(ros_message: Any, info: Mapping[str, Any]) -> None:
            meter.took(info["received_timestamp"])
            take(ros_message, info)

        with made_in_ros(repr(port.topic)):
            subscription = node.create_subscription(
                interface,
                port.topic,
                taken,
                topic_quality(port, known),
                callback_group=group,
                qos_overriding_options=overriding_options(port),
            )
        group.entity = self._own(node.destroy_subscription, subscription)

    def _with_companion(
        self,
        port: SubscriberPort,
        interface: Any,
        codec: Codec,
        accept: Callable[[Message, Mapping[str, Any]], None],
        group: Any,
        depth: int,
    ) -> Callable[[Any, Mapping[str, Any]], None]:
        """Listen to announcements of publishers; return the function that takes the messages of the topic.

        Under the paper's rules, the announced messages are taken, since they are kept longer. Under the rules
        of ROS 2, the messages of the topic itself are taken, whose history has the depth of the model;
        announcements only provide their ids.
        """
        node, receiver = self._node, self._receiver
        topic, counter = node.resolve_topic_name(port.topic), LossCounter()

        def publishers() -> int:
            return int(node.count_publishers(topic))

        def strange(message: Message, lost: int) -> None:
            if self._is_open:
                receiver.message_arrived(port, message, lost)

        def alone(message: Message, info: Mapping[str, Any], is_alone: bool) -> None:
            if is_alone:
                strange(message, 0)

        if self._has_histories:
            ways: dict[str, Any] = {"announced": alone, "known": accept, "strange": accept}
        else:
            ways = {
                "announced": lambda message, info, is_alone: accept(message, info),
                "known": lambda message, lost: None,
                "strange": strange,
            }
        name, callbacks = f"{topic}/{MESSAGES}", {"senders": publishers, "group": group, **ways}
        listener = self._listen(port, name, depth, interface, codec, **callbacks)

        def take(ros_message: Any, info: Mapping[str, Any]) -> None:
            if self._is_open:
                more: Any = info
                if not self._has_histories:
                    more = counter.lost_before("", info["publication_sequence_number"], publishers)
                sequence = int(info["publication_sequence_number"])
                listener.arrived(ros_message, int(info["source_timestamp"]), sequence, more)

        return take

    def _listen(
        self,
        port: SubscriberPort | ServerPort,
        name: str,
        limit: int,
        interface: Any,
        codec: Codec,
        **callbacks: Any,
    ) -> Listener:
        def refused(error: Exception) -> None:
            if self._is_open:
                self._receiver.refused(port, error)

        with made_in_ros(repr(name)):
            listener = Listener(self._node, name, limit, interface, codec, refused=refused, **callbacks)
        self._own(Listener.close, listener)
        return listener

    def _add_server(self, port: ServerPort) -> None:
        node, receiver = self._node, self._receiver
        interface, requests, responses = self._codecs.service(port)
        self._checks[port] = responses.check

        def hand_on(request: Any, response: Any) -> Any:
            return request

        def requested(message: Message, answer: Answer) -> None:
            if self._is_open:
                receiver.request_arrived(port, message, answer)

        group, listener = pausing_group(lambda: receiver.is_open(port)), None
        if port.type is not None:
            service_name = node.resolve_service_name(port.service)
            listener = self._listen(
                port,
                f"{service_name}/{REQUESTS}",
                SERVICE_DEPTH,
                interface.Request,
                requests,
                senders=lambda: int(node.count_clients(service_name)),
                announced=lambda message, info, is_alone: None,
                known=requested,
                strange=requested,
                group=group,
            )
        quality = reliable_quality(port.depth if self._has_histories else SERVICE_DEPTH)
        with made_in_ros(repr(port.service)):
            service = node.create_service(
                interface, port.service, hand_on, qos_profile=quality, callback_group=group
            )
        group.entity = self._own(node.destroy_service, service)
        send_response = service.send_response

        def keep(request: Any, header: Any) -> None:
            """Take a request with the header that its response needs."""

            def answer(message: Message) -> None:
                if self._is_open:
                    try:
                        send_response(responses.encode(message), header)
                    except Exception as error:
                        LOG.error("the response to %s of %s is not sent: %s", message.id, port.service, error)

            if listener is None:
                requested(requests.decode(request), answer)
            elif self._is_open:
                number = int(header.request_id.sequence_number)
                listener.arrived(request, int(header.source_timestamp), number, answer)

        # The executor calls this with what the callback returned, expecting the response at once. An async
        # callback would keep this executor busy until its response is there (rclpy before 7.1.9).
        service.send_response = keep

    def _await_subscribers(self, ports: Ports) -> None:
        """Wait for the expected subscribers; a later subscriber would miss messages published before.

        Then wait until these take messages: until then, their histories could overflow.
        """
        node = self._node
        limit = float(declare(node, DISCOVERY_TIMEOUT))
        parameters = subscriber_parameters(port.channel for port in ports.publishers)
        expected = {channel: int(declare(node, parameter)) for channel, parameter in parameters.items()}
        missing = [port for port in ports.publishers if expected[port.channel] > 0]
        end = time.monotonic() + limit
        while missing and not self._session.is_ending:
            missing = [port for port in missing if self._subscribers(port) < expected[port.channel]]
            if missing and time.monotonic() >= end:
                topics = ", ".join(port.topic for port in missing)
                LOG.warning("after %g s, subscribers are missing on %s", limit, topics)
                break
            if missing:
                time.sleep(0.01)
        self._session.await_others(limit)

    def _subscribers(self, port: PublisherPort) -> int:
        return int(self._publishers[port.channel, port.place].publisher.get_subscription_count())

    def start_timers(self) -> None:
        """Start the timers; before this, the node could not begin their callbacks."""
        assert self._timers is not None
        self._timers.start()

    def publish(self, port: PublisherPort, message: Message) -> bool:
        """Publish a message; a full queue of ROS overwrites its oldest, and subscribers detect the gap."""
        outlet = self._publishers[port.channel, port.place]
        ros_message = outlet.encode(message)
        if outlet.announcer is None:
            outlet.publisher.publish(ros_message)
        else:
            outlet.announcer.send(message.id, ros_message, outlet.publisher.publish)
        return True

    def publish_again(self, port: PublisherPort, message: Message) -> None:
        """Publish a message that was published before, for receivers that recognise copies by the id."""
        outlet = self._publishers[port.channel, port.place]
        if outlet.announcer is not None:
            outlet.announcer.send_again(message.id, outlet.encode(message))
        elif outlet.has_ids:
            outlet.publisher.publish(outlet.encode(message))

    def request(self, port: ClientPort, message: Message) -> None:
        """Send a request once its server is available; the receiver is notified of a time-out."""
        assert self._clients is not None
        self._clients.request(port, message)

    def forget(self, port: ClientPort, message_id: str) -> None:
        """Stop waiting for the response to a request."""
        assert self._clients is not None
        self._clients.forget(port, message_id)

    def most_waiting(self, port: SubscriberPort) -> int:
        """Return the most messages that waited at once in a subscription's history since the last call."""
        meter = self._meters.get(port)
        return 0 if meter is None else meter.most_since()

    def waited(self, port: SubscriberPort) -> float:
        """Return how many seconds the message taken last had waited in its history."""
        meter = self._meters.get(port)
        return 0.0 if meter is None else meter.waited

    def check(self, port: Port, part: str = "") -> Check | None:
        """Return a function that raises for data outside the ranges of the mapped ROS fields."""
        if isinstance(port, ActionPort):
            return self.check_goal(port, part)
        return self._checks[port]

    def close(self) -> None:
        """Destroy the channels; the receiver is not called any more."""
        self._is_open = False
        if self._clients is not None:
            self._clients.close()
        self.close_goals()
        if self._signals is not None:
            self._signals.close()
        for destroy, entity in reversed(self._entities):
            destroy(entity)
        self._entities.clear()
        self._publishers.clear()
