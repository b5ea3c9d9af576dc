"""Nodes that launch files start from packages that are not in the folder: known by a table, else named."""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import channels
from dineros.observation.importing.building import to_model
from dineros.observation.importing.coded import coded
from dineros.sources.facts import is_open
from dineros.sources.launch.vendors import known_vendors
from dineros.sources.reading import Launch, read_source

ROBOT = """
<launch>
  <node pkg="rplidar_ros" exec="rplidar_node" namespace="front"><remap from="scan" to="/scan"/></node>
  <node pkg="nav2_amcl" exec="amcl" name="where"/>
  <node pkg="mine" exec="unknown"/>
  <node_container pkg="rclcpp_components" exec="component_container" name="box" namespace="">
    <composable_node pkg="usb_cam" plugin="usb_cam::UsbCamNode" name="camera"/>
  </node_container>
</launch>
"""
OWN = """
[[idiom]]
path = "mine/unknown"
node = "known"
makes = [{ kind = "subscriptions", name = "scan", type = "sensor_msgs/msg/LaserScan", depth = 3 }]
"""


def test_ports_come_from_the_table(tmp_path: Path) -> None:
    (tmp_path / "robot.launch.xml").write_text(ROBOT)
    facts = read_source(tmp_path, launch=Launch("robot.launch.xml"))
    named = {node.name: node for node in facts.nodes}
    assert named.keys() == {"rplidar_node", "where", "camera"}
    assert named["rplidar_node"].remappings == {"scan": "/scan"}
    assert named["where"].managed and named["camera"].program == "container /box"
    assert [each.name for each in named["camera"].of("publishers")] == ["image_raw", "camera_info"]
    assert facts.unread == ["robot.launch.xml:5: mine/unknown is not in this folder"]
    code = coded([(".", facts)], "robot")
    model = to_model(code.system, code.given).model
    assert [each for each in validate(model) if each.severity == "error"] == []
    (scan,) = [each for each in channels(model, sym.TopicChannel) if each.topic == "/scan"]
    assert len(scan.publishers) == len(scan.subscribers) == 1


def test_users_add_to_the_table(tmp_path: Path) -> None:
    (tmp_path / "robot.launch.xml").write_text(ROBOT)
    table = tmp_path / "own.toml"
    table.write_text(OWN)
    facts = read_source(tmp_path, [table], Launch("robot.launch.xml"))
    assert "known" in {node.name for node in facts.nodes}
    assert facts.unread == []


def test_the_table_is_well_formed() -> None:
    kinds = {"publishers", "subscriptions", "services", "clients", "action_servers", "action_clients"}
    parts = {"msg": ("publishers", "subscriptions"), "srv": ("services", "clients")}
    for path, idiom in known_vendors().items():
        assert idiom.node and idiom.makes, path
        for make in idiom.makes:
            package, part, name = make["type"].split("/")
            assert make["kind"] in kinds and not is_open(make["name"]), path
            assert make["kind"] in parts.get(part, ("action_servers", "action_clients")), (path, make)
            assert package.islower() and name[0].isupper(), path
