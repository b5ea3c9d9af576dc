"""Tokens and messages of existing interfaces, counting of losses, names, environment; no ROS process runs."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.ros_names import resource_names
from dineros.metamodel.token_data import FieldType, TokenType, Value
from dineros.runtime.nets.ports import FieldMapping, Message
from dineros.runtime.ros.channels.quality import LossCounter, most_known
from dineros.runtime.ros.conversion.interfaces import InterfaceError, load_interface
from dineros.runtime.ros.conversion.mappings import ConversionError, MappedCodec, _converted, _type
from dineros.runtime.ros.process.environment import fast_dds_profile, ros_environment
from dineros.runtime.ros.wheels import correct_paths

FIELDS = TokenType(
    "Token",
    (
        FieldType("text", "text", "text", None, ""),
        FieldType("count", "integer", "text", None, 0),
        FieldType("weight", "number", "text", None, 1.0),
        FieldType("is_hot", "boolean", "text", None, False),
        FieldType("values", "list", "number", None, []),
    ),
)


def codec(interface: str, **mapped: str) -> MappedCodec:
    mappings = [FieldMapping("message", path.replace("__", "."), field) for path, field in mapped.items()]
    return MappedCodec(load_interface(interface), interface, mappings, FIELDS)


def token(**fields: Value) -> Message:
    return Message("a/b/1", {field.name: field.default for field in FIELDS.fields} | fields)


@pytest.mark.parametrize(
    ("interface", "path", "field", "value"),
    [
        ("std_msgs/msg/String", "data", "text", "grüße"),
        ("std_msgs/msg/Bool", "data", "is_hot", True),
        ("std_msgs/msg/Int8", "data", "count", -128),
        ("std_msgs/msg/UInt64", "data", "count", 2**63 - 1),
        ("std_msgs/msg/Float32", "data", "weight", 0.5),
        ("std_msgs/msg/Float64", "data", "count", 3),
        ("std_msgs/msg/Byte", "data", "count", 255),
        ("std_msgs/msg/Header", "stamp.sec", "count", 7),
        ("std_msgs/msg/Float64MultiArray", "data", "values", [1.0, -2.5]),
        ("std_msgs/msg/Float64MultiArray", "data[2]", "weight", 4.5),
        ("std_msgs/msg/Float64MultiArray", "layout.dim[1].label", "text", "rows"),
    ],
)
def test_there_and_back(interface: str, path: str, field: str, value: Value) -> None:
    made = codec(interface, **{path: field})
    back = made.decode(made.encode(token(**{field: value})))
    assert back == Message("", dict(token(**{field: value}).data))
    assert type(back.data[field]) is type(value)


def test_fields_that_are_not_mapped_keep_their_defaults() -> None:
    made = codec("std_msgs/msg/String", data="text")
    assert made.decode(made.encode(token(text="a", weight=9.0))).data["weight"] == 1.0


@pytest.mark.parametrize(
    ("interface", "field", "value", "text"),
    [
        ("std_msgs/msg/Int8", "count", 128, "takes int8, not 128"),
        ("std_msgs/msg/UInt16", "count", -1, "takes uint16, not -1"),
        ("std_msgs/msg/Byte", "count", 256, "takes octet, not 256"),
        ("std_msgs/msg/Char", "count", -1, "takes uint8, not -1"),
        ("std_msgs/msg/UInt64", "count", -1, "takes uint64, not -1"),
        ("std_msgs/msg/Int32", "weight", 1e12, "takes int32, not 1000000000000"),
        ("std_msgs/msg/Float32", "weight", 1e300, "takes a single-precision number, not 1e.300"),
        ("std_msgs/msg/Float32MultiArray", "values", [0.0, -1e39], "takes a single-precision number"),
    ],
)
def test_values_outside_the_range(interface: str, field: str, value: Value, text: str) -> None:
    with pytest.raises(ConversionError, match=text):
        codec(interface, data=field).encode(token(**{field: value}))
    with pytest.raises(ConversionError, match=f"{field} cannot be sent: {interface} data {text}"):
        codec(interface, data=field).check(token(**{field: value}).data)


@pytest.mark.parametrize(
    ("ros_type", "value", "text"),
    [
        ("string<4>", "grüß", "at most 4 bytes, not 6"),
        ("wstring<2>", "😀a", "at most 2 characters, not 3"),
        ("sequence<double, 2>", [1.0, 2.0, 3.0], "at most 2 elements, not 3"),
        ("sequence<string<1>, 2>", ["a", "bc"], "at most 1 bytes, not 2"),
    ],
)
def test_values_outside_of_their_bounds(ros_type: str, value: Value, text: str) -> None:
    """No package that is installed has such a field, so that its type is taken apart here."""
    with pytest.raises(ConversionError, match=text):
        _converted(value, _type(ros_type), "field")


@pytest.mark.parametrize(("given", "expected"), [(math.inf, 1.7976931348623157e308), (math.nan, 0.0)])
def test_numbers_that_json_cannot_say(given: float, expected: float) -> None:
    interface = load_interface("std_msgs/msg/Float64")
    assert (
        codec("std_msgs/msg/Float64", data="weight").decode(interface(data=given)).data["weight"] == expected
    )


@pytest.mark.parametrize(
    ("interface", "path", "field", "text"),
    [
        ("std_msgs/msg/String", "datum", "text", "has no field datum"),
        ("std_msgs/msg/String", "data", "weight", r"data of std_msgs/msg/String \(string\) cannot carry"),
        ("std_msgs/msg/Header", "stamp", "count", "cannot carry"),
        ("std_msgs/msg/Header", "frame_id.length", "count", "has no fields"),
        ("std_msgs/msg/String", "data[0]", "text", "has no element"),
        ("std_msgs/msg/Float64MultiArray", "layout.dim.label", "text", "name an element"),
        ("std_msgs/msg/String", "data", "nothing", "no field 'nothing'"),
    ],
)
def test_wrong_mappings(interface: str, path: str, field: str, text: str) -> None:
    with pytest.raises(InterfaceError, match=text):
        codec(interface, **{path: field})


@pytest.mark.parametrize("name", ["std_msgs/msg/Strin", "nowhere/msg/String", "String", "std_msgs/action/A"])
def test_interfaces_that_are_not_there(name: str) -> None:
    with pytest.raises(InterfaceError):
        load_interface(name)


def test_room_for_what_a_subscriber_knows() -> None:
    """Of each sender no more than it has sent, and no more than a publisher is taken to keep."""
    assert most_known(4, {}) == 0
    assert most_known(4, {"a/p": 3, "b/p": 25}) == 3 + 10
    assert most_known(16, {"a/p": 25}) == 16


class TestLosses:
    @staticmethod
    def lost(counter: LossCounter, *messages: tuple[str, int], publishers: int = 1) -> list[int]:
        return [counter.lost_before(id, sequence, lambda: publishers) for id, sequence in messages]

    def test_gaps(self) -> None:
        counter = LossCounter()
        assert self.lost(counter, ("a/p/1", 1), ("a/p/2", 2), ("a/p/5", 5)) == [0, 0, 2]

    def test_before_the_first_one_that_came(self) -> None:
        assert self.lost(LossCounter(), ("a/p/4", 4)) == [3]

    def test_senders_are_told_apart(self) -> None:
        assert self.lost(LossCounter(), ("a/p/1", 1), ("b/p/1", 1), ("a/p/2", 2), ("b/p/3", 3)) == [
            0,
            0,
            0,
            1,
        ]

    def test_sender_that_began_anew(self) -> None:
        counter = LossCounter()
        assert self.lost(counter, ("a/p/7", 7), ("a/p/8", 1), ("a/p/9", 2), ("a/p/9", 3)) == [6, 0, 0, 0]

    def test_publisher_that_was_started_again(self) -> None:
        """It publishes again what its queue held; a gap before that is a loss, and nobody counts it twice."""
        counter = LossCounter()
        self.lost(counter, ("a/p/7", 7), ("a/p/8", 8))
        assert counter.lost_at_restart("a/p/6", 1) == 0  # an old one comes again
        counter = LossCounter({"a/p": 8})
        assert [counter.lost_at_restart("a/p/21", 1), *self.lost(counter, ("a/p/21", 1))] == [12, 0]
        assert [counter.lost_at_restart("a/p/22", 2), *self.lost(counter, ("a/p/22", 2))] == [0, 0]
        assert counter.lost_at_restart(f"a/p/{10**12}", 1) == 0  # forged

    def test_both_were_started_again_before_the_first_message(self) -> None:
        """The receiver took no message of the sender before, so its saved state does not name the sender."""
        counter = LossCounter({}, is_resumed=True)
        assert counter.lost_at_restart("a/p/11", 1, lambda: 1) == 10
        assert self.lost(counter, ("a/p/11", 1), ("a/p/12", 2)) == [0, 0]
        assert counter.lost_at_restart("a/p/13", 3, lambda: 1) == 0
        assert counter.lost_at_restart("b/p/99", 1, lambda: 1) == 0  # forged: more senders than publishers
        assert LossCounter({}, is_resumed=True).lost_at_restart(f"a/p/{10**12}", 1, lambda: 1) == 0
        assert LossCounter().lost_at_restart("a/p/11", 1, lambda: 1) == 0

    def test_what_comes_again_hides_no_loss_and_feigns_none(self) -> None:
        """Of what a publisher sends again, its own queue or the receiver's may lose a part."""
        counter = LossCounter({"a/p": 6})
        assert self.lost(counter, ("a/p/5", 1), ("a/p/7", 3)) == [0, 0]  # 6 came in an earlier life
        assert self.lost(counter, ("a/p/10", 6)) == [2]
        counter = LossCounter()
        assert self.lost(counter, *((f"a/p/{number}", number) for number in range(1, 7))) == [0] * 6
        assert self.lost(counter, ("a/p/4", 1), ("a/p/5", 2), ("a/p/7", 4)) == [0, 0, 0]
        assert self.lost(counter, ("a/p/5", 1)) == [0]
        assert counter.lost_at_restart("a/p/8", 1) == 0
        assert counter.lost_at_restart("a/p/9", 1) == 1

    def test_receiver_that_was_started_again_with_a_publisher_that_was_not(self) -> None:
        counter = LossCounter({"a/p": 5})
        assert [counter.lost_at_restart("a/p/9", 9), *self.lost(counter, ("a/p/9", 9))] == [0, 3]

    def test_receiver_that_began_anew(self) -> None:
        assert self.lost(LossCounter({"a/p": 7}), ("a/p/8", 8)) == [0]
        assert self.lost(LossCounter({"a/p": 7}), ("a/p/10", 10)) == [2]

    def test_forged_ids(self) -> None:
        """Another publisher that uses a sender's ids makes nobody believe in losses, or fall over."""
        counter = LossCounter()
        ids = [("a/p/1", 1), (f"a/p/{'9' * 5000}", 1), ("a/p/500", 10_000), ("a/p/2", 2), ("a/p/3", 3)]
        assert self.lost(counter, *ids) == [0] * 5

    def test_no_more_senders_than_publishers_are_believed(self) -> None:
        """A stranger makes up a sender for each of its messages."""
        counter = LossCounter()
        made_up = [(f"controller@{n:08x}/p/999999", n) for n in range(1, 1001)]
        assert self.lost(counter, *made_up) == [0] * 1000
        counter = LossCounter()
        assert self.lost(counter, ("a/p/1", 1), *made_up, ("a/p/2", 2), ("a/p/5", 5)) == [0] * 1002 + [2]

    def test_as_many_senders_as_publishers_are_believed(self) -> None:
        messages = [("a/p/1", 1), ("b/p/4", 4), ("c/p/6", 6)]
        assert self.lost(LossCounter(), *messages, publishers=3) == [0, 3, 5]
        assert self.lost(LossCounter(), *messages, publishers=2) == [0, 3, 0]

    def test_ids_out_of_step_with_their_publisher_are_not_believed(self) -> None:
        """A stranger uses the ids of a sender that continues, with high numbers."""
        counter = LossCounter()
        honest = [(f"a/p/{n}", n) for n in range(1, 101)]
        forged = [(f"a/p/{10**9 + n}", 10**6 + n) for n in range(1, 101)]
        mixed = [message for pair in zip(honest, forged, strict=True) for message in pair]
        assert self.lost(counter, *mixed) == [0] * 200

    def test_a_publisher_that_goes_on_has_not_begun_anew(self) -> None:
        """A stranger claims again and again to be a sender that began again, and skipped many messages."""
        counter = LossCounter()
        told = []
        for n in range(1, 101):
            for message in ((f"a/p/{n + 50}", n + 50), (f"a/p/{n * 10**6}", n)):
                told.append(counter.lost_at_restart(*message))
                counter.lost_before(*message, lambda: 2)
        assert sum(map(bool, told)) <= 1

    def test_without_ids(self) -> None:
        assert self.lost(LossCounter(), ("", 5), ("", 6), ("", 9)) == [0, 0, 2]
        assert self.lost(LossCounter(), ("", 5), ("", 9), publishers=2) == [0, 0]


def test_names_are_distinct() -> None:
    assert resource_names(["a-b", "a_b", "a b", "TooHot"]) == {
        "a-b": "a_b_2",
        "a_b": "a_b",
        "a b": "a_b_3",
        "TooHot": "TooHot",
    }


def test_environment(tmp_path: Path) -> None:
    made = ros_environment(tmp_path, 7, "memory", {"ROS_STATIC_PEERS": "far.example", "HOME": "/home"})
    assert (made["ROS_DOMAIN_ID"], made["HOME"]) == ("7", "/home")
    assert "ROS_STATIC_PEERS" not in made
    assert Path(made["FASTRTPS_DEFAULT_PROFILES_FILE"]).read_text() == fast_dds_profile("memory")
    assert Path(made["ROS_LOG_DIR"]).is_dir()
    assert "UDPv4" not in fast_dds_profile("memory")


def test_wrong_domain(tmp_path: Path) -> None:
    with pytest.raises(DinerosError, match="no ROS domain 102"):
        ros_environment(tmp_path, 102)


def test_paths_of_wheels_are_fixed_once(tmp_path: Path) -> None:
    file = tmp_path / "share/std_msgs/cmake/export.cmake"
    file.parent.mkdir(parents=True)
    numpy = "/opt/python/cp311-cp311/lib/python3.11/site-packages/numpy/_core/include"
    file.write_text(f'INCLUDE "/opt/python/cp311-cp311/include/python3.11;{numpy}"\n')
    assert correct_paths(tmp_path) == [file]
    folders = file.read_text().split('"')[1].split(";")
    assert all(Path(folder).is_dir() for folder in folders)
    assert correct_paths(tmp_path) == []
