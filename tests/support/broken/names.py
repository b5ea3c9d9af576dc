"""Models that break the constraints of `names`."""

from __future__ import annotations

from dineros.metamodel import sym
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, callbacks, plain, runtime

CASES = Cases()


@CASES.breaks(
    "id-present",
    "a place in page 'right' has no id",
    "give it an id of its own",
    of=plain,
)
def place_without_id(small: Small) -> None:
    small["r"].id = None


@CASES.breaks(
    "id-present",
    "a place named 'Rest' in page 'right' has no id",
    "give it an id of its own",
    of=plain,
)
def named_place_with_an_empty_id(small: Small) -> None:
    small["r"].name = "Rest"
    small["r"].id = ""


@CASES.breaks(
    "id-without-blanks",
    "place 'r 1' has white space in its id",
    "write the id without blanks, and put the readable text into the name",
    of=plain,
)
def id_with_a_blank(small: Small) -> None:
    small["r"].id = "r 1"


@CASES.breaks(
    "id-characters",
    'place "it\'s" has "\'" in its id',
    "write the id with letters, digits and characters such as _ - . @, and put the readable text into the "
    "name",
)
def quote_in_an_id(small: Small) -> None:
    small["Idle"].id = "it's"


@CASES.breaks(
    "id-characters",
    "place 'right\\u202eleft' has '\\u202e' in its id",
    "write the id with letters, digits and characters such as _ - . @, and put the readable text into the "
    "name",
)
def unprintable_id(small: Small) -> None:
    small["Idle"].id = "right\u202eleft"


@CASES.breaks(
    "id-unique",
    "place 'p' has the id of another element, a place in page 'left'",
    "give one of them another id: all elements of a file, channels too, share one space of ids",
    of=plain,
)
def two_places(small: Small) -> None:
    small["r"].id = "p"


@CASES.breaks(
    "id-unique",
    "callback group 'Idle' has the id of another element, a place in node net 'talker'",
    "give one of them another id: all elements of a file, channels too, share one space of ids",
)
def place_and_callback_group(small: Small) -> None:
    small["group"].id = "Idle"


@CASES.breaks(
    "id-unique",
    "token type 'Idle-Talk' has the id of another element, an arc in node net 'talker'",
    "give one of them another id: all elements of a file, channels too, share one space of ids",
)
def token_type_and_arc(small: Small) -> None:
    small["Token"].name = "Token"
    small["Token"].id = "Idle-Talk"


@CASES.breaks(
    "node-net-name-unique",
    "node net 'listener' has the ROS name of node net 'talker'",
    "give one of them another name or namespace",
)
def same_name(small: Small) -> None:
    small["listener"].name = "talker"
    small["listener"].namespace = "/left"


@CASES.breaks(
    "node-name-valid",
    "node net 'listener' is called 'listener-1', which is not a name for a ROS node",
    "use letters, digits and _, not starting with a digit",
)
def name_with_a_dash(small: Small) -> None:
    small["listener"].name = "listener-1"


@CASES.breaks(
    "package-name-valid",
    "node net 'talker' has the package 'Talking', which is not a name for a ROS package",
    "use two or more small letters, digits and _, starting with a letter, as REP 144 requires",
)
def package_with_a_capital(small: Small) -> None:
    small["talker"].package = "Talking"


@CASES.breaks(
    "package-name-valid",
    "node net 'talker' has the package '', which is not a name for a ROS package",
    "use two or more small letters, digits and _, starting with a letter, as REP 144 requires",
)
def empty_package(small: Small) -> None:
    small["talker"].package = ""


@CASES.breaks(
    "namespace-valid",
    "node net 'talker' has the namespace 'left', which is not a ROS namespace",
    "write it like /left/arm",
)
def relative_namespace(small: Small) -> None:
    small["talker"].namespace = "left"


@CASES.breaks(
    "topic-name-valid",
    "topic channel 'chatter' has the topic '/cell/2nd', which is not a ROS topic name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
)
def part_starts_with_a_digit(small: Small) -> None:
    small["chatter"].topic = "/cell/2nd"


@CASES.breaks(
    "topic-name-valid",
    "topic channel 'chatter' has the topic '/cell//chatter', which is not a ROS topic name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
)
def doubled_slash(small: Small) -> None:
    small["chatter"].topic = "/cell//chatter"


@CASES.breaks(
    "topic-name-valid",
    "topic channel 'chatter' has the topic '/chatter/', which is not a ROS topic name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
)
def slash_at_the_end(small: Small) -> None:
    small["chatter"].topic = "/chatter/"


@CASES.breaks(
    "topic-name-valid",
    "topic channel 'chatter' has the topic 'the chatter', which is not a ROS topic name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
)
def blank(small: Small) -> None:
    small["chatter"].topic = "the chatter"


@CASES.breaks(
    "topic-name-valid",
    "topic channel 'chatter' has the topic '{node/chatter', which is not a ROS topic name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
)
def open_brace(small: Small) -> None:
    small["chatter"].topic = "{node/chatter"


@CASES.breaks(
    "topic-name-valid",
    "topic channel 'chatter' has the topic '~chatter', which is not a ROS topic name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
)
def tilde_without_slash(small: Small) -> None:
    small["chatter"].topic = "~chatter"


@CASES.breaks(
    "service-name-valid",
    "service channel 'ask' has the service '/ask-me', which is not a ROS service name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
)
def dash(small: Small) -> None:
    small["ask"].service = "/ask-me"


@CASES.breaks(
    "port-name-valid",
    "publisher port 'chat ter' of place 'Said' is for 'chat ter', which is not a ROS name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
    of=runtime,
)
def topic_of_a_runtime_port(small: Small) -> None:
    small["Said"].ports[0].topic = "chat ter"


@CASES.breaks(
    "port-name-valid",
    "client port 'c1' of place 'Ask' is for '2ask', which is not a ROS name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
    of=runtime,
)
def service_of_a_runtime_port(small: Small) -> None:
    small["Ask"].ports[0].service = "2ask"


@CASES.breaks(
    "topic-unique",
    "topic channel 'other' is for the topic 'chatter', as is topic channel 'chatter'",
    "join their ports in one channel or rename one",
)
def same_topic(small: Small) -> None:
    other = sym.TopicChannel(id="other", topic="chatter", model=small.net)
    other.publishers.append(sym.PublisherPort(place=sym.Place(id="Other", page=small["talker"])))
    other.subscribers.append(sym.SubscriberPort(place=small["Heard"]))


@CASES.breaks(
    "service-unique",
    "service channel 'ask2' is for the service '/ask', as is service channel 'ask'",
    "join their clients in one channel or rename one",
)
def same_service(small: Small) -> None:
    page = sym.CallbackPage(id="second", kind="server", page=small["listener"])
    entry, exit_ = sym.Place(id="Entry2", page=page), sym.Place(id="Exit2", page=page)
    request, response = (
        sym.Place(id="Ask2", page=small["talker"]),
        sym.Place(id="Answer2", page=small["talker"]),
    )
    sym.ServiceChannel(
        id="ask2",
        service="/ask",
        server=sym.ServerPort(entry=entry, exit=exit_, page=page),
        clients=[sym.ClientPort(client="c1", request=request, response=response)],
        model=small.net,
    )


@CASES.breaks(
    "channel-type-valid",
    "topic channel 'chatter' has the type 'std_srvs/srv/Trigger', not one such as std_msgs/msg/String",
    "name a ROS interface, or leave it out to generate one from the token type",
)
def service_type_for_a_topic(small: Small) -> None:
    small["chatter"].type = "std_srvs/srv/Trigger"


@CASES.breaks(
    "channel-type-valid",
    "service channel 'ask' has the type 'String', not one such as std_srvs/srv/Trigger",
    "name a ROS interface, or leave it out to generate one from the token type",
)
def message_type_for_a_service(small: Small) -> None:
    small["ask"].type = "String"


@CASES.breaks(
    "token-type-name-valid",
    "token type 'Token' is called 'token', which is not a name for a ROS interface",
    "start with a capital letter and use letters and digits",
)
def small_letter(small: Small) -> None:
    small["Token"].name = "token"


_RENAME = "rename it: each node also has topics and services of its own"


@CASES.breaks(
    "channel-name-reserved",
    "service channel 'ask' has the reserved name /listener/release, a service of node net 'listener' "
    "itself, which controls the node",
    _RENAME,
)
def own_service(small: Small) -> None:
    small["ask"].service = "/listener/release"


@CASES.breaks(
    "channel-name-reserved",
    "service channel 'ask' has the reserved name /left/talker/set_signal/Ready, a service of node net "
    "'talker' itself, which sets a signal",
    _RENAME,
)
def service_of_another_node(small: Small) -> None:
    small["ask"].service = "/left/talker/set_signal/Ready"


@CASES.breaks(
    "channel-name-reserved",
    "service channel 'ask' has the reserved name /left/talker/get_parameters, a service of node net "
    "'talker' itself, which is the parameter interface of ROS",
    _RENAME,
)
def private_name_of_parameters(small: Small) -> None:
    small["ask"].service = "~/get_parameters"


@CASES.breaks(
    "channel-name-reserved",
    "topic channel 'chatter' has the reserved name /rosout, a topic of the type rcl_interfaces/msg/Log "
    "that nodes have themselves",
    _RENAME,
)
def topic_of_all_nodes(small: Small) -> None:
    small["chatter"].topic = "/rosout"


@CASES.breaks(
    "channel-name-reserved",
    "topic channel 'chatter' has the reserved name /listener/state, on which only node net 'listener' "
    "itself publishes",
    _RENAME,
)
def state_of_a_node(small: Small) -> None:
    small["chatter"].topic = "/listener/state"


@CASES.breaks(
    "channel-name-reserved",
    "topic channel 'chatter' has the reserved name /chatter/_messages, because _messages is a "
    "placeholder for another name",
    _RENAME,
)
def companion_of_a_topic(small: Small) -> None:
    small["chatter"].topic = "/chatter/_messages"


@CASES.breaks(
    "channel-name-reserved-by-hand",
    "service channel 'Service' has the reserved name /other/describe, a service of node net 'other' itself, "
    "which controls the node",
    _RENAME,
    of=callbacks,
)
def service_of_a_node_by_hand(small: Small) -> None:
    small["Service"].service = "/other/describe"
