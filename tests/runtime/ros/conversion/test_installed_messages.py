"""Tokens that are installed messages: what is read of one is what its class has; tokens pass unchanged."""

from __future__ import annotations

import random
import sys
from array import array
from pathlib import Path
from typing import Any

import numpy
import pytest

from dineros.metamodel.errors import FeatureValueError
from dineros.metamodel.token_data import FieldType, TokenType, Value, ros_scalar
from dineros.metamodel.token_types.installed import (
    UnknownInterfaceError,
    installed_constants,
    installed_fields,
)
from dineros.runtime.nets.ports import Message
from dineros.runtime.nets.tokens import TokenChecker
from dineros.runtime.ros.conversion.interfaces import load_interface
from dineros.runtime.ros.conversion.messages import TokenCodec

MESSAGES = sorted(f"{path.parts[-3]}/msg/{path.stem}" for path in Path(sys.prefix).glob("share/*/msg/*.json"))


def plain(message: Any) -> Value:
    """Return a message as the classes of ROS show it, without looking at what was read of its definition."""
    if isinstance(message, bytes):
        return message[0]
    if isinstance(message, (array, numpy.ndarray)):
        elements: list[Value] = message.tolist()
        return elements
    if isinstance(message, (list, tuple)):
        return [plain(each) for each in message]
    if not hasattr(message, "get_fields_and_field_types"):
        return message  # type: ignore[no-any-return]
    names = [name for name in message.get_fields_and_field_types() if not name.startswith("structure_needs")]
    return {name: plain(getattr(message, name)) for name in names}


def any_value(field: FieldType, choose: random.Random) -> Value:
    """Return a value that a field takes, its limits often."""
    if field.kind == "list":
        count = choose.randint(0, min(field.bound or 3, 3)) if field.length is None else field.length
        return [single(field, choose) for _ in range(count)]
    return single(field, choose)


def single(field: FieldType, choose: random.Random) -> Value:
    if field.scalar == "record":
        return {part.name: any_value(part, choose) for part in field.fields}
    if field.scalar == "boolean":
        return choose.random() < 0.5
    if field.scalar == "number":
        return choose.choice([0.0, -1.5, 3.25, 2.0**100, -(2.0**-20)])
    scalar = ros_scalar(str(field.ros))
    assert scalar is not None
    if field.scalar == "text":
        return str(choose.choice(["", "a", "frame", "Ä"])[: scalar.bound])
    size = 8 if scalar.name in ("byte", "char") else int(scalar.name.lstrip("uint"))
    unsigned = scalar.name in ("byte", "char") or scalar.name.startswith("u")
    low, high = (0, 2**size - 1) if unsigned else (-(2 ** (size - 1)), 2 ** (size - 1) - 1)
    return int(choose.choice([low, high, choose.randint(low, high)]))


@pytest.mark.parametrize("name", MESSAGES)
def test_what_is_read_is_what_the_class_has(name: str) -> None:
    """Defaults are those of a new message, and any data comes back as it went through ROS."""
    from rclpy.serialization import deserialize_message, serialize_message

    fields, interface = installed_fields(name), load_interface(name)
    token_type = TokenType("Any", fields, name)
    codec, checker = TokenCodec(interface, "model", token_type), TokenChecker(token_type)
    assert dict(checker.default) == plain(interface())
    choose = random.Random(name)
    for _ in range(5):
        data = checker.complete({field.name: any_value(field, choose) for field in fields})
        message = codec.encode(Message("", data))
        assert plain(message) == dict(data)
        back = deserialize_message(serialize_message(message), interface)
        assert codec.decode(back) == Message("", dict(data))


def test_there_are_messages_of_every_kind() -> None:
    """The comparison above sees arrays, sequences, bounds, nested types and every scalar that is in use."""
    seen: set[tuple[str | None, str, bool, bool]] = set()

    def walk(fields: tuple[FieldType, ...]) -> None:
        for field in fields:
            ros = "record" if field.fields else field.ros
            seen.add((ros, field.kind, field.length is not None, field.bound is not None))
            walk(field.fields)

    for name in MESSAGES:
        walk(installed_fields(name))
    assert {("record", "list", False, True), ("record", "list", False, False)} <= seen
    assert {("float64", "list", True, False), ("byte", "list", False, False)} <= seen
    scalars = {f"{sign}int{size}" for sign in ("", "u") for size in (8, 16, 32, 64)}
    assert {*scalars, "float32", "float64", "bool", "byte", "string"} <= {ros for ros, *_ in seen}


def test_constants_are_those_of_the_class() -> None:
    found = 0
    for name in MESSAGES:
        constants, interface = installed_constants(name), load_interface(name)
        found += len(constants)
        for constant, value in constants.items():
            there = getattr(interface, constant)
            assert value == (there[0] if isinstance(there, bytes) else there), (name, constant)
    assert found > 50


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("std_msgs/msg/Strng", "the package std_msgs has no message Strng (did you mean 'String'?)"),
        ("moon_msgs/msg/String", "the ROS interface moon_msgs/msg/String is not installed (install the pack"),
        ("std_srvs/srv/SetBool", "'std_srvs/srv/SetBool' names no ROS message (write it like std_msgs/msg/S"),
        ("../../etc/msg/Passwd", "'../../etc/msg/Passwd' names no ROS message"),
    ],
)
def test_other_names_are_refused(name: str, said: str) -> None:
    with pytest.raises(UnknownInterfaceError) as caught:
        installed_fields(name)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ({"pose": {"position": {"w": 1.0}}}, "pose.position has no field 'w'"),
        ({"header": {"stamp": {"nanosec": -1}}}, "takes uint32, 0 to 4294967295, not -1"),
        ({"header": {"frame_id": 1}}, "takes a text, not 1"),
        ({"pose": 1}, "pose takes a dictionary, not 1"),
    ],
)
def test_data_that_does_not_fit_is_refused(data: dict[str, Value], said: str) -> None:
    name = "geometry_msgs/msg/PoseStamped"
    checker = TokenChecker(TokenType("Goal", installed_fields(name), name))
    with pytest.raises(FeatureValueError, match=said.replace(".", r"\.")):
        checker.complete(data)
