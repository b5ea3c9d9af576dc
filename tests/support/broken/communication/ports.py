"""Models that break the constraints of `ports`."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small

CASES = Cases()


@CASES.breaks(
    "port-place-in-node-net",
    "publisher port 'Free' of topic channel 'chatter' has its place outside of all node nets",
    "move the place into the node net that the port is of",
)
def place_outside(small: Small) -> None:
    page = pn.Page(id="outside", net=small.net)
    small["chatter"].publishers[0].place = sym.Place(id="Free", page=page)


@CASES.breaks(
    "place-receives-or-sends",
    "place 'Heard' both receives and sends by channels (subscriber port 'Heard' of topic channel "
    "'chatter' and publisher port 'Heard' of topic channel 'chatter')",
    "use two places with a transition between them",
)
def subscriber_and_publisher(small: Small) -> None:
    small["chatter"].publishers[0].place = small["Heard"]


@CASES.breaks(
    "place-receives-or-sends",
    "place 'Said' both receives and sends by channels (client port 'c1' of service channel 'ask' "
    "and publisher port 'Said' of topic channel 'chatter')",
    "use two places with a transition between them",
)
def response_and_publisher(small: Small) -> None:
    small["ask"].clients[0].response = small["Said"]


@CASES.breaks(
    "place-sent-once",
    "place 'Said' is sent by publisher port 'Said' of topic channel 'chatter' and client port 'c1' "
    "of service channel 'ask': each token goes to only one of them",
    "give each of them a place of its own",
)
def publisher_and_client(small: Small) -> None:
    small["ask"].clients[0].request = small["Said"]


@CASES.breaks(
    "place-sent-once",
    "place 'Said' is sent by publisher port 'Said' of topic channel 'chatter' and publisher port "
    "'Said' of topic channel 'chatter': each token goes to only one of them",
    "give each of them a place of its own",
)
def published_twice(small: Small) -> None:
    small["chatter"].publishers.append(sym.PublisherPort(place=small["Said"]))


@CASES.breaks(
    "place-subscribed-once",
    "place 'Heard' receives each message of the topic '/chatter' twice",
    "remove one of the subscriber ports",
)
def subscribed_twice(small: Small) -> None:
    small["chatter"].subscribers.append(sym.SubscriberPort(place=small["Heard"]))


@CASES.breaks(
    "subscriber-outside-server-page",
    "place 'News' receives messages but is on the server page 'serve': the instance that a message is for is "
    "undefined",
    "put it on a callback page next to the server page and use a reference place there",
)
def subscriber_on_a_server_page(small: Small) -> None:
    sym.Place(id="News", page=small["serve"])
    small["chatter"].subscribers.append(sym.SubscriberPort(place=small["News"]))


@CASES.breaks(
    "mapped-field-known",
    "field mapping 'data' of topic channel 'chatter' maps to the token field 'tga', which the token "
    "type does not have",
    "did you mean 'tag'?",
)
def misspelt_field(small: Small) -> None:
    small["chatter"].mappings[0].tokenField = "tga"


@CASES.breaks(
    "mapped-field-known",
    "field mapping 'data' of topic channel 'chatter' maps to the token field 'size', which the token "
    "type does not have",
    "use a field of the token type or add this one",
)
def no_such_field(small: Small) -> None:
    small["chatter"].mappings[0].tokenField = "size"


@CASES.breaks(
    "mapped-part-of-channel",
    "field mapping 'data' of topic channel 'chatter' is for a request, which a topic does not have",
    "use message for a topic, request or response for a service, goal, result or feedback for an action",
)
def request_of_a_topic(small: Small) -> None:
    small["chatter"].mappings[0].part = "request"


@CASES.breaks(
    "mapped-path-valid",
    "field mapping 'pose..x' of topic channel 'chatter' is not a path in a ROS interface",
    "write it like pose.position.x or ranges[0]",
)
def no_path(small: Small) -> None:
    small["chatter"].mappings[0].messageField = "pose..x"


@CASES.breaks(
    "mapped-once",
    "field mapping 'data' of topic channel 'chatter' is mapped twice",
    "remove one of the mappings",
)
def twice(small: Small) -> None:
    small["chatter"].mappings.append(sym.FieldMapping(messageField="data", tokenField="count"))


@CASES.breaks(
    "mappings-have-type",
    "topic channel 'chatter' has mappings but no type of ROS interface",
    "set its type, or remove the mappings",
)
def no_type(small: Small) -> None:
    small["chatter"].type = None
