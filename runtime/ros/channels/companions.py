"""Ids for messages of existing ROS types: announced on a companion topic, since they have no field for one.

The companion of a topic ``/fleet/arrivals`` is ``/fleet/arrivals/_messages``, that of a service ``/power``
is ``/power/_requests``; ROS hides names with an underscore. Whoever sends a message announces it there first:
its id, and the message itself as it is serialised. Programs that know nothing of DiNeROS see the same
messages as ever, each once.

Subscribers of DiNeROS take the announced messages, which are kept for them and come again like messages of a
type of its own, and pass over the copies on the topic itself; what nobody has announced, a stranger sent.
Servers take the requests themselves, since the response goes back to them, with the ids that were announced.
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
"""Last part of the names of companions, of topics and of services."""

SHORT_PATIENCE, LONG_PATIENCE = 0.2, 5.0
"""Seconds that a message waits for its announcement: where strangers send, too, and where all announce."""

PERIOD = 0.05
"""Seconds between looks at messages that wait."""


class AnnouncementError(DinerosError):
    """What came on a companion topic announces nothing."""


class Announcement(NamedTuple):
    """What is said of a message.

    Attributes
    ----------
    id : str
        Its id.
    content : bytes
        The message, serialised.
    number : int
        Which message of its sender it is on the topic or service itself, from 1; 0: nothing follows there, it
        was sent before.
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
        It is none.
    """
    try:
        match decode_json(text):
            case {"id": str(id), "content": str(content), "number": int(number)} if number is not True:
                return Announcement(id, base64.b64decode(content, validate=True), number)
    except (DinerosError, ValueError):
        pass
    raise AnnouncementError("no id and content of a message are announced")


class Announcer:
    """Announces the messages of a publisher or client. It is made before that is: nobody hears it earlier.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    name : str
        The companion topic.
    limit : int
        The limit of the queue that it accompanies.
    """

    def __init__(self, node: Any, name: str, limit: int) -> None:
        from rclpy.serialization import serialize_message
        from std_msgs.msg import String

        self._node, self._interface, self._serialise = node, String, serialize_message
        quality = reliable_quality(companion_depth(limit), is_kept=True)
        self._publisher = node.create_publisher(String, name, quality)
        self._sent = 0

    def send(self, id: str, ros_message: Any, send: Callable[[Any], Result]) -> Result:
        """Announce a message, and send it."""
        self._announce(id, ros_message, self._sent + 1)
        result = send(ros_message)
        self._sent += 1  # as the middleware counts: what it refuses has no number
        return result

    def send_again(self, id: str, ros_message: Any) -> None:
        """Say what was sent before: to those who hear announcements."""
        self._announce(id, ros_message, 0)

    def _announce(self, id: str, ros_message: Any, number: int) -> None:
        announcement = Announcement(id, self._serialise(ros_message), number)
        self._publisher.publish(self._interface(data=announcement.text()))

    def close(self) -> None:
        """Take it down."""
        self._node.destroy_publisher(self._publisher)


class Arrival(NamedTuple):
    """A message of the topic or service itself, and what `Listener` hands on with it."""

    message: Message
    more: Any


class Listener:
    """Hears what is announced to a subscriber or server. It is made before that is: it misses nothing.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    name : str
        The companion topic.
    limit : int
        The limit of the queue that it accompanies.
    interface : class
        Of the messages.
    codec : Codec
        Decodes them.
    senders : callable
        Tells how many there are on the topic or service itself.
    announced : callable
        Called with each message that is announced, with what ROS says of its announcement, and whether
        nothing follows on the topic or service itself.
    known : callable
        Called with each message that comes itself, now with its id, and what came with it.
    strange : callable
        Called with each message that nobody has announced, and what came with it.
    refused : callable
        Called with what is wrong with an announcement.
    group : rclpy.callback_groups.CallbackGroup, optional
        Of all that calls it, one at a time.

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
        self._gone: type[Exception] = InvalidHandle  # what it says once it is closed
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
        except Exception as error:  # anybody can say anything, and ROS raises what it likes
            self._refused(error)
            return
        self._announced(Message(id, data), info, not number)
        if number:
            self._recognition.announced(content_of(data, number), int(info["source_timestamp"]), id)

    def arrived(self, ros_message: Any, sent: int, number: int, more: Any) -> None:
        """Take a message of the topic or service itself.

        Parameters
        ----------
        ros_message : object
            The message.
        sent : int
            When it was sent, in nanoseconds.
        number : int
            Which one of its sender it is, from 1.
        more : object
            What comes with it.
        """
        arrival = Arrival(self._decode(ros_message), more)
        if self._recognition.is_idle and not self._subscription.get_publisher_count():
            self._strange(arrival.message, more)  # nobody announces anything here
            return
        content = content_of(arrival.message.data, number)
        self._catch_up()  # that of a sender that was killed must not take the place of its own
        if not self._recognition.recognise(content, sent, arrival):
            self._recognition.hold(content, sent, arrival)
            self._look_later()

    def _catch_up(self) -> None:
        """Hear what has been announced, and the executor has not come to yet."""
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
        """Hear no more; what waits for its announcement comes no more."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None
        self._node.destroy_subscription(self._subscription)
