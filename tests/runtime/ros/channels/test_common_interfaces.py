"""Messages of common interfaces, which the extra `interfaces` installs, on real ROS 2."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from dineros.generators import Options, generate
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, node_net, place, step
from dineros.metamodel.constraints import validate
from dineros.metamodel.files import save
from dineros.metamodel.token_types.installed import COMMON, UnknownInterfaceError, installed_messages
from dineros.transformations.flattening.split import split
from tests.runtime.ros.conftest import Ros

ROOT = Path(__file__).resolve().parents[4]


def scanner() -> sym.SystemModel:
    """Return a lidar that publishes two scans, and a node that maps them."""
    token = sym.TokenType(
        id="Scan",
        fields=[
            sym.TokenField(name="frame", kind="text", default='"laser"'),
            sym.TokenField(name="ranges", kind="list", elementKind="number"),
        ],
    )
    model = sym.SystemModel(id="scanner", middleware="ros2", tokenType=token)
    lidar, mapper = node_net(model, "lidar"), node_net(model, "mapper")
    turns, beam = place(lidar, "Turns", tokens=2), place(lidar, "Beam")
    step(lidar, "Turn", [turns], [beam])
    page = callback(mapper, "OnScan")
    seen = place(page, "Seen")
    flow(seen, sym.Transition(id="Map", page=page), place(page, "Mapped"))
    scan = sym.TopicChannel(
        id="Scans",
        topic="/scan",
        type="sensor_msgs/msg/LaserScan",
        model=model,
        publishers=[sym.PublisherPort(place=beam)],
        subscribers=[sym.SubscriberPort(place=seen)],
        qos=sym.QualityOfService(durability="transientLocal"),
    )
    for message, name in (("header.frame_id", "frame"), ("ranges", "ranges")):
        scan.mappings.append(sym.FieldMapping(messageField=message, tokenField=name))
    return model


HANDLERS = """
def configure(net):
    @net.handler("Turn")
    def turn(firing):
        return {"ranges": [0.5, 2.0]}
"""


@pytest.mark.long
def test_laser_scans_are_generated_and_sent(ros: Ros) -> None:
    model = scanner()
    assert [each.message for each in validate(model) if each.severity == "error"] == []
    generate(model, ros.folder / "ws", Options(source="scanner.sym.xmi"))
    package = (ros.folder / "ws/src/lidar/package.xml").read_text()
    assert "<exec_depend>sensor_msgs</exec_depend>" in package or "<depend>sensor_msgs</depend>" in package
    for part in split(model):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")
    ros.node("mapper")
    ros.node("lidar", handlers=HANDLERS)
    ros.wait(lambda: len(ros.fired("mapper", "Map")) == 2, "mapping")
    for record in ros.records("mapper", "take"):
        assert record["data"]["frame"] == "laser"
        assert record["data"]["ranges"] == [0.5, 2.0]


def test_the_extra_has_what_hints_promise() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    wheels = [each.partition("==")[0] for each in settings["interfaces"] if each.startswith("ros-jazzy-")]
    assert [each.removeprefix("ros-jazzy-").replace("-", "_") for each in wheels] == list(COMMON)
    for package in COMMON:
        assert installed_messages(package)


def test_what_no_wheel_has_is_named_without_the_extra() -> None:
    with pytest.raises(UnknownInterfaceError) as caught:
        installed_messages("nav2_msgs")
    assert "dineros[interfaces]" not in str(caught.value)
    assert "source the workspace" in str(caught.value)
