"""Constants of ROS messages are names of values of their fields, and do not limit them."""

from __future__ import annotations

import pytest

from dineros.analysis.checks.check import check
from dineros.metamodel import sym
from dineros.metamodel.build import node_net, place, step
from dineros.metamodel.guards.values import values_of
from dineros.metamodel.token_data import FieldType
from dineros.metamodel.token_types.constants import Constant, with_named_values
from dineros.metamodel.token_types.installed import installed_fields


def field(name: str, ros: str) -> FieldType:
    return FieldType(name, "integer", "text", None, 0, ros, None, ())


def named(fields: list[FieldType], *constants: tuple[str, str, object]) -> dict[str, list[str]]:
    found = with_named_values(fields, [Constant(*each) for each in constants])  # type: ignore[arg-type]
    assert [each.name for each in found] == [each.name for each in fields]
    return {each.name: [name for name, _ in each.range.names] for each in found if each.range.names}


def test_a_constant_belongs_to_the_field_whose_name_it_begins_with() -> None:
    fields = [field("state", "uint8"), field("state_next", "uint8"), field("mode", "uint8")]
    constants = [("uint8", "STATE_IDLE", 0), ("uint8", "STATE_NEXT_BUSY", 1), ("uint8", "OTHER", 2)]
    assert named(fields, *constants) == {"state": ["STATE_IDLE"], "state_next": ["STATE_NEXT_BUSY"]}


def test_or_to_the_only_field_of_its_type() -> None:
    fields = [field("level", "uint8"), field("line", "uint32")]
    assert named(fields, ("uint8", "WARN", 30), ("int8", "ODD", 1), ("uint32", "LEVEL_TOP", 2)) == {
        "level": ["WARN"],
        "line": ["LEVEL_TOP"],
    }
    assert named([field("a", "uint8"), field("b", "uint8")], ("uint8", "WARN", 30)) == {}


def test_other_constants_name_nothing() -> None:
    fields = [field("state", "uint8")]
    assert (
        named(fields, ("string", "STATE_TEXT", "x"), ("bool", "STATE_ON", True), ("float64", "PI", 3.1)) == {}
    )


def test_a_field_with_named_values_keeps_all_its_values() -> None:
    (status,) = (each for each in installed_fields("action_msgs/msg/GoalStatus") if each.name == "status")
    assert status.range.value_of("STATUS_ABORTED") == 6
    assert values_of(status) == ((-128, 127),)
    assert status.range.fault(77) is None


@pytest.mark.parametrize("rest", [False, True])
def test_values_without_a_name_are_not_forgotten(rest: bool) -> None:
    """Steps for every constant: without one for the rest, a message can wait forever."""
    model = sym.SystemModel(
        id="watch", tokenType=sym.TokenType(id="Status", ros="action_msgs/msg/GoalStatus")
    )
    node = node_net(model, "watcher")
    start, got, done = place(node, "Start", tokens=1), place(node, "Got"), place(node, "Done")
    done.kind = sym.PlaceKind.end
    step(node, "Hear", [start], [got])
    step(node, "Known", [got], [done]).guard = "status between 'STATUS_UNKNOWN' and 'STATUS_ABORTED'"
    if rest:
        step(node, "Rest", [got], [done]).guard = "status < 'STATUS_UNKNOWN' or status > 'STATUS_ABORTED'"
    faults = {finding.rule for finding in check(model).findings if finding.severity != "note"}
    assert ("deadlock" in faults) is not rest
