"""Models that break the constraints of `token_types`."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import flow, read
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small

CASES = Cases()


def _other(small: Small, ros: str | None = None) -> sym.TokenType:
    other = sym.TokenType(id="Other", ros=ros)
    small.net.otherTokenTypes.append(other)
    return other


@CASES.breaks(
    "topic-has-one-type",
    "topic channel 'chatter' joins places of different token types: place 'Said' has 'Token', "
    "place 'Heard' has 'Other'",
    "give the places one token type",
)
def subscriber_of_another_type(small: Small) -> None:
    small["Heard"].tokenType = _other(small)


@CASES.breaks(
    "requests-have-one-type",
    "service channel 'ask' has requests of different token types: place 'Entry' has 'Other', "
    "place 'Ask' has 'Token'",
    "give the request places of clients and the server's entry one token type",
)
def entry_of_another_type(small: Small) -> None:
    small["Entry"].tokenType = _other(small)


@CASES.breaks(
    "responses-have-one-type",
    "service channel 'ask' has responses of different token types: place 'Exit' has 'Other', "
    "place 'Answer' has 'Token'",
    "give the response places of clients and the server's exit one token type",
)
def exit_of_another_type(small: Small) -> None:
    small["Exit"].tokenType = small["Count"].tokenType = _other(small)


@CASES.breaks(
    "ros-message-known",
    "token type 'Other' is not a ROS message that tokens can be: '../msg/String' names no ROS message",
    "write it like std_msgs/msg/String",
)
def path_for_a_message(small: Small) -> None:
    _other(small, "../msg/String")


@CASES.breaks(
    "ros-message-has-fields",
    "token type 'Other' has fields and is the ROS message 'std_msgs/msg/String'",
    "remove the fields: a ROS message brings its own",
)
def message_with_fields(small: Small) -> None:
    _other(small, "std_msgs/msg/String").fields.append(sym.TokenField(name="data"))


@CASES.breaks(
    "type-change-has-handler",
    "transition 'Talk' puts tokens of a type that it does not take: 'Other' in place 'Log'",
    "write a handler that makes them; without one they carry the defaults",
)
def log_of_another_type(small: Small) -> None:
    flow(small["Talk"], sym.Place(id="Log", tokenType=_other(small), page=small["talker"]))


def _says(small: Small, ros: str) -> None:
    """Let the topic's tokens be a ROS message."""
    other = _other(small, ros)
    small["Said"].tokenType = small["Heard"].tokenType = other
    read(sym.Place(id="Seen", tokenType=other, page=small["talker"]), small["Talk"])


@CASES.breaks(
    "channel-type-of-tokens",
    "topic channel 'chatter' has the type 'std_msgs/msg/String', but its tokens are the ROS message "
    "std_msgs/msg/Int64",
    "omit the type of the channel, or give its places a token type with fields of its own",
)
def channel_of_another_message(small: Small) -> None:
    _says(small, "std_msgs/msg/Int64")
    small["chatter"].mappings.clear()


@CASES.breaks(
    "mapped-type-is-own",
    "field mapping 'data' of topic channel 'chatter' is for tokens that are the ROS message "
    "std_msgs/msg/String themselves",
    "remove the mapping, or give the places a token type with fields of its own",
)
def mapping_of_a_message(small: Small) -> None:
    _says(small, "std_msgs/msg/String")
    small["chatter"].mappings[0].tokenField = "data"


@CASES.breaks(
    "field-bound",
    "token field 'tag' of token type 'Token' has the bound 3",
    "use a bound of 1 or more, for lists without a length only",
)
def text_with_a_bound(small: Small) -> None:
    small["Token"].fields[2].bound = 3


@CASES.breaks(
    "field-ros-fits",
    "token field 'pose' of token type 'Token' of the kind number has the ROS type 'uint8'",
    "use a ROS type of the kind, such as uint8, float32 or string<=20, or none",
)
def integers_for_numbers(small: Small) -> None:
    small["Token"].fields[1].ros = "uint8"


@CASES.breaks(
    "field-default-fits",
    "token field 'count' of token type 'Token' has a default that does not fit: count takes uint8, 0 to 255, "
    "not 256",
    "write the default as JSON of the field's kind",
)
def default_out_of_range(small: Small) -> None:
    small["Token"].fields[0].ros, small["Token"].fields[0].default = "uint8", "256"
