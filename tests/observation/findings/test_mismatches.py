"""What ports alone show to be wrong, by both nodes' names."""

from __future__ import annotations

from dataclasses import replace

import pytest

from dineros.observation.findings.mismatches import mismatches
from dineros.observation.findings.types import unknown_types
from dineros.observation.systems import USUAL, ObservedNode, ObservedSystem
from tests.support.systems.foreign import LATCHED, SENSOR, port, robot, trigger


def found(*nodes: ObservedNode) -> dict[str, str]:
    return {each.rule: each.message for each in mismatches(ObservedSystem("nowhere", nodes))}


def test_the_robot_has_two_mismatches() -> None:
    findings = mismatches(robot())
    assert [finding.rule for finding in findings] == ["quality-not-matched"] * 2
    assert [finding.elements for finding in findings] == [
        ("/battery_level", "/battery", "/monitor"),
        ("/image", "/sensors/camera", "/detector"),
    ]
    assert "durability of /battery is volatile, and /monitor requests transientLocal" in findings[0].message


def test_what_is_offered_may_be_more_than_what_is_asked_for() -> None:
    strict, lax = USUAL._replace(durability="transientLocal", deadline=0.1), USUAL._replace(deadline=0.2)
    talker, listener = (ObservedNode(name) for name in ("/a", "/b"))
    assert not found(
        replace(talker, publishers=(port("/x", quality=strict),)),
        replace(listener, subscribers=(port("/x", quality=lax),)),
    )
    assert (
        "deadline"
        in found(
            replace(talker, publishers=(port("/x", quality=lax),)),
            replace(listener, subscribers=(port("/x", quality=strict._replace(durability="volatile")),)),
        )["quality-not-matched"]
    )


def test_unheard_unfilled_and_near() -> None:
    messages = found(
        ObservedNode("/a", publishers=(port("/cmd_vel"), port("/lonely"))),
        ObservedNode("/b", subscribers=(port("/cmd_vell"),)),
        ObservedNode("/c", subscribers=(port("/robot/lonely"),)),
    )
    assert set(messages) == {"topic-unheard", "topic-unfilled", "names-near"}
    near = [
        each.elements[:2]
        for each in mismatches(
            ObservedSystem(
                "nowhere",
                (
                    ObservedNode("/a", publishers=(port("/cmd_vel"), port("/lonely"))),
                    ObservedNode("/b", subscribers=(port("/cmd_vell"), port("/robot/lonely"))),
                ),
            )
        )
        if each.rule == "names-near"
    ]
    assert near == [("/cmd_vel", "/cmd_vell"), ("/lonely", "/robot/lonely")]


def test_ros_itself_is_at_the_other_end_of_some_topics() -> None:
    events = port("/parameter_events", "rcl_interfaces/msg/ParameterEvent")
    changes = port("/camera/transition_event", "lifecycle_msgs/msg/TransitionEvent")
    logs = port("/rosout", "rcl_interfaces/msg/Log")
    assert not found(ObservedNode("/a", publishers=(logs,), subscribers=(events, changes)))


@pytest.mark.parametrize(
    ("takers", "expected"),
    [
        ({"/c": ("/left/image_raw",), "/d": ("/depth/image_raw",)}, set()),  # a usual end of names
        ({"/c": ("/left/image_raw",), "/d": ("/outt/image_raw",)}, {"/outt/image_raw"}),
        ({"/c": ("/left/image_raw",)}, {"/left/image_raw"}),
        ({"/a": ("/in/image_raw",)}, set()),  # input and output of one node
    ],
)
def test_names_with_a_usual_end_are_not_near(takers: dict[str, tuple[str, ...]], expected: set[str]) -> None:
    nodes = {"/a": ("/out/image_raw",)} | {name: () for name in takers if name != "/a"}
    system = ObservedSystem(
        "nowhere",
        tuple(
            ObservedNode(
                name,
                publishers=tuple(map(port, given)),
                subscribers=tuple(map(port, takers.get(name, ()))),
            )
            for name, given in nodes.items()
        ),
    )
    assert {each.elements[1] for each in mismatches(system) if each.rule == "names-near"} == expected


def test_services() -> None:
    messages = found(
        ObservedNode("/a", servers=(trigger("/plan"),)),
        ObservedNode("/b", servers=(trigger("/plan"),), clients=(trigger("/plam"),)),
    )
    assert "/plan has several servers: /a, /b" in messages["servers-share-name"]
    assert "no node serves /plam, which /b calls" in messages["service-unserved"]
    assert "names-near" in messages


def test_services_that_the_library_makes_are_served() -> None:
    names = ("/a/change_state", "/a/get_parameters", "/b/change_state", "/c/get_parameters")
    clients = tuple(trigger(name) for name in names)
    nodes = (ObservedNode("/a", lifecycle="unconfigured"), ObservedNode("/b", clients=clients))
    unserved = [each for each in mismatches(ObservedSystem("test", nodes)) if each.rule == "service-unserved"]
    assert [each.elements[0] for each in unserved] == ["/b/change_state", "/c/get_parameters"]


def test_types_that_differ() -> None:
    messages = found(
        ObservedNode("/a", publishers=(port("/x"),)),
        ObservedNode("/b", subscribers=(port("/x", "std_msgs/msg/Int32", SENSOR),)),
    )
    assert set(messages) == {"types-differ"}
    assert "std_msgs/msg/String at /a; std_msgs/msg/Int32 at /b" in messages["types-differ"]


@pytest.mark.parametrize(
    ("first", "second", "node", "severity"),
    [(True, True, "/a", "warning"), (True, False, "/a", "error"), (True, True, "/b", "error")],
)
def test_types_of_ports_in_branches_of_one_node_may_be_alternatives(
    first: bool, second: bool, node: str, severity: str
) -> None:
    """A driver creates the port of the variant that it finds: this was an error."""
    one = replace(port("/x"), is_optional=first)
    other = replace(port("/x", "std_msgs/msg/Int32"), is_optional=second)
    nodes = (
        (ObservedNode("/a", publishers=(one, other)),)
        if node == "/a"
        else (ObservedNode("/a", publishers=(one,)), ObservedNode(node, publishers=(other,)))
    )
    differing = [each for each in mismatches(ObservedSystem("test", nodes)) if each.rule == "types-differ"]
    assert [each.severity for each in differing] == [severity]


def test_nodes_that_share_a_name_went_or_have_another_time() -> None:
    system = ObservedSystem(
        "nowhere",
        (ObservedNode("/a", use_sim_time=True), ObservedNode("/b", use_sim_time=False), ObservedNode("/c")),
        departed=("/a",),
        duplicates=("/b",),
    )
    assert [each.rule for each in mismatches(system)] == ["nodes-share-name", "node-departed", "time-mixed"]


def test_a_type_that_is_not_installed_is_one_line() -> None:
    nodes = (
        ObservedNode("/a", publishers=(port("/x", "moon_msgs/msg/Dust"), port("/y", "moon_msgs/msg/Dust"))),
    )
    (finding,) = unknown_types(ObservedSystem("nowhere", nodes))
    assert "/x, /y: the type is unknown here: the ROS interface moon_msgs/msg/Dust" in finding.message
    assert not list(unknown_types(ObservedSystem("nowhere", (ObservedNode("/a", publishers=(port("/x"),)),))))


def test_latched_matches_latched() -> None:
    assert not found(
        ObservedNode("/a", publishers=(port("/x", quality=LATCHED),)),
        ObservedNode("/b", subscribers=(port("/x", quality=LATCHED),)),
    )
