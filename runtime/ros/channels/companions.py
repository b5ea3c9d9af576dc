"""Ids for messages of existing ROS types: announced on a companion topic, since the types have no id field.

The companion of a topic ``/fleet/arrivals`` is ``/fleet/arrivals/_messages``, that of a service ``/power`` is
``/power/_requests``; ROS hides names with an underscore. A sender first announces a message on the companion
topic, with its id and the serialised message, and then sends it. Programs without DiNeROS receive the same
messages as without companions, each once.

Subscribers of DiNeROS take the announced messages, which are kept and repeated for them like messages of a
generated type, and skip the copies on the topic itself; a message without announcement comes from another
program. Servers take the requests themselves, since the response goes back to the sender, and assign the
announced ids.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, NamedTuple, TypeVar

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.json_text import decode_json
from dineros.metamodel.message_ids import parse_id
from dineros.metamodel.ros_names import COMPANIONS
from dineros.runtime.nets.ports import Message
from dineros.runtime.ros.channels.quality import companion_depth, reliable_quality
from dineros.runtime.ros.channels.recognition import Recognition, content_of
from dineros.runtime.ros.conversion.messages import Codec
from dineros.runtime.ros.process.clocks import steady_timer

Result = TypeVar("Result")

MESSAGES, REQUESTS = COMPANIONS
"""Last part of the names of companions: of topics and of services."""

SHORT_PATIENCE, LONG_PATIENCE = 0.2, 5.0
"""Seconds that a message waits for its announcement: if other programs send too, and if all announce."""

PERIOD = 0.05
"""Seconds between checks of waiting messages."""


class AnnouncementError(DinerosError):
    """A message on a companion topic is not a valid announcement."""


class Announcement(NamedTuple):
    """The announcement of a message.

    Attributes
    ----------
    id : str
        Its id.
    content : bytes
        The message, serialised.
    number : int
        Number of the message among those of its sender on the topic or service itself, from 1; 0: it is not
        sent there now, because it was sent before.
    """

    id: str
    content: bytes
    number: int

    def text(self) -> str:
        """Return it as JSON."""
        content = base64.b64encode(self.content).decode()
        return json.dumps({"id": self.id, "content": content, "number": self.number})


def read_announcement(text: str) -> Announcement:
    """Read an announcement.

    Raises
    ------
    AnnouncementError
        The text is not a valid announcement.
    """
    try:
        match decode_json(text):
            case {"id": str(id), "content": str(content), "number": int(number)} if number is not True:
                return Announcement(id, base64.b64decode(content, validate=True), number)
    except (DinerosError, ValueError):
        pass
    raise AnnouncementError("no id and content of a message are announced")


class Announcer:
    """Announces the messages of a publisher or client, and must be created before it.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    name : str
        The companion topic.
    limit : int
        The limit of the queue to which it belongs.
    """

    def __init__(self, node: Any, name: str, limit: int) -> None:
        from rclpy.serialization import serialize_message
        from std_msgs.msg import String

        self._node, self._interface, self._serialise = node, String, serialize_message
        quality = reliable_quality(companion_depth(limit), is_kept=True)
        self._publisher = node.create_publisher(String, name, quality)
        self._sent = 0

    def send(self, id: str, ros_message: Any, send: Callable[[Any], Result]) -> Result:
        """Announce a message, then send it with `send`."""
        self._announce(id, ros_message, self._sent + 1)
        result = send(ros_message)
        self._sent += 1  # counts like the middleware: a refused message has no number
        return result

    def send_again(self, id: str, ros_message: Any) -> None:
        """Announce a message that was sent before; only receivers of announcements get it."""
        self._announce(id, ros_message, 0)

    def _announce(self, id: str, ros_message: Any, number: int) -> None:
        announcement = Announcement(id, self._serialise(ros_message), number)
        self._publisher.publish(self._interface(data=announcement.text()))

    def close(self) -> None:
        """Destroy the publisher."""
        self._node.destroy_publisher(self._publisher)


class Arrival(NamedTuple):
    """A message of the topic or service itself, with the data that `Listener` passes on."""

    message: Message
    more: Any


class Listener:
    """Receives the announcements for a subscriber or server. Create it first, so that it misses none.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    name : str
        The companion topic.
    limit : int
        The limit of the queue to which it belongs.
    interface : class
        Class of the messages.
    codec : Codec
        Decodes them.
    senders : callable
        Returns the number of senders on the topic or service itself.
    announced : callable
        Called with each announced message, with ROS's information about the announcement, and whether no
        message follows on the topic or service itself.
    known : callable
        Called with each message of the topic or service that was announced, now with its id, and its data.
    strange : callable
        Called with each message that was not announced, and its data.
    refused : callable
        Called with the error of an invalid announcement.
    group : rclpy.callback_groups.CallbackGroup, optional
        Callback group of all these calls, which are made one at a time.

    Attributes
    ----------
    group : rclpy.callback_groups.CallbackGroup
        That group.
    """

    def __init__(
        self,
        node: Any,
        name: str,
        limit: int,
        interface: Any,
        codec: Codec,
        *,
        senders: Callable[[], int],
        announced: Callable[[Message, Mapping[str, Any], bool], None],
        known: Callable[[Message, Any], None],
        strange: Callable[[Message, Any], None],
        refused: Callable[[Exception], None],
        group: Any = None,
    ) -> None:
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
        from rclpy.exceptions import InvalidHandle
        from rclpy.serialization import deserialize_message
        from std_msgs.msg import String

        self._node, self._name, self._interface, self._decode = node, name, interface, codec.decode
        self._deserialise, self._senders = deserialize_message, senders
        self._gone: type[Exception] = InvalidHandle  # raised after it was closed
        self._announced, self._strange, self._refused = announced, strange, refused
        depth = companion_depth(limit)
        self._recognition: Recognition[Arrival] = Recognition(
            lambda arrival, id: known(Message(id, arrival.message.data), arrival.more),
            lambda arrival: strange(arrival.message, arrival.more),
            self._patience,
            limit=4 * depth,
        )
        self.group = group or MutuallyExclusiveCallbackGroup()
        self._timer: Any = None
        quality = reliable_quality(depth, is_kept=True)
        self._subscription = node.create_subscription(
            String, name, self._hear, quality, callback_group=self.group
        )

    def _hear(self, announcement: Any, info: Mapping[str, Any]) -> None:
        try:
            id, content, number = read_announcement(announcement.data)
            parse_id(id)
            data = self._decode(self._deserialise(content, self._interface)).data
        except Exception as error:  # announcements are untrusted, and ROS may raise any exception
            self._refused(error)
            return
        self._announced(Message(id, data), info, not number)
        if number:
            self._recognition.announced(content_of(data, number), int(info["source_timestamp"]), id)

    def arrived(self, ros_message: Any, sent: int, number: int, more: Any) -> None:
        """Receive a message of the topic or service itself.

        Parameters
        ----------
        ros_message : object
            The message.
        sent : int
            Time of sending, in nanoseconds.
        number : int
            Its number among the messages of its sender, from 1.
        more : object
            Data passed on with the message.
        """
        arrival = Arrival(self._decode(ros_message), more)
        if self._recognition.is_idle and not self._subscription.get_publisher_count():
            self._strange(arrival.message, more)  # no sender announces messages here
            return
        content = content_of(arrival.message.data, number)
        self._catch_up()  # the announcement of a killed sender must not be used for this message
        if not self._recognition.recognise(content, sent, arrival):
            self._recognition.hold(content, sent, arrival)
            self._look_later()

    def _catch_up(self) -> None:
        """Process announcements that have arrived but that the executor has not delivered yet."""
        subscription = self._subscription
        with suppress(self._gone), subscription.handle:
            while (taken := subscription.handle.take_message(subscription.msg_type, False)) is not None:
                self._hear(*taken)

    def _patience(self) -> float:
        announcing = self._node.count_publishers(self._name)
        if not announcing:
            return 0.0
        return SHORT_PATIENCE if self._senders() > announcing else LONG_PATIENCE

    def _look_later(self) -> None:
        if not self._recognition.is_waiting:
            return
        if self._timer is None:
            self._timer = steady_timer(self._node, PERIOD, self._look, self.group)
        elif self._timer.is_canceled():
            self._timer.reset()

    def _look(self) -> None:
        timer = self._timer
        if timer is None:  # it is being closed
            return
        self._catch_up()
        self._recognition.look()
        if not self._recognition.is_waiting:
            timer.cancel()

    def close(self) -> None:
        """Stop receiving; messages that wait for an announcement are discarded."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None
        self._node.destroy_subscription(self._subscription)
