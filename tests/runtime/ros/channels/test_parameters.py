"""Parameter files that the generator writes are those that a node on ROS reads."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]

from dineros.generators import Options
from dineros.generators.workspace.planning import plan
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import save
from dineros.transformations.flattening.split import split
from tests.runtime.ros.conftest import Ros

OF_THE_PROCESS = {"log_level", "journal", "resume", "seed"}
"""Declared by the process, not by the node inside."""


def beacon() -> sym.SystemModel:
    """Return a node with a timer, a signal, and a publisher with all that a quality of service says."""
    said, heard = sym.Place(id="Said"), sym.Place(id="Heard")
    tick = sym.Transition(id="Tick")
    page = sym.CallbackPage(id="on-timer", kind="timer", timer=0.25, objects=[tick, said])
    flow(tick, said)
    beacon = sym.NodeNet(id="beacon", objects=[page], signals=[sym.InputSignal(id="Lit", initial=True)])
    receiver = sym.NodeNet(id="receiver", objects=[heard])
    quality = sym.QualityOfService(
        reliability="bestEffort",
        durability="transientLocal",
        liveliness="manualByTopic",
        deadline=0.5,
        lifespan=1.5,
        leaseDuration=2.0,
    )
    topic = sym.TopicChannel(
        id="Light",
        topic="/light",
        type="std_msgs/msg/Empty",
        publishers=[sym.PublisherPort(place=said, limit=3, qos=quality)],
        subscribers=[sym.SubscriberPort(place=heard, qos=sym.QualityOfService(reliability="bestEffort"))],
    )
    type_ = sym.TokenType(id="Flash", fields=[sym.TokenField(name="text")])
    pages = [beacon, receiver]
    return sym.SystemModel(id="coast", middleware="ros2", tokenType=type_, pages=pages, channels=[topic])


def flat(values: dict[str, Any], before: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in values.items():
        found |= flat(value, f"{before}{name}.") if isinstance(value, dict) else {f"{before}{name}": value}
    return found


def test_all_that_is_generated_is_declared(ros: Ros) -> None:
    model = beacon()
    for part in split(model):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")
    files = plan(model, Path("nowhere"), Options(source="coast.sym.xmi"), None).generated
    values = yaml.safe_load(files["src/coast_bringup/config/beacon.yaml"])
    own = values["/**"]["ros__parameters"]
    given = {"periods": {"on_timer": 0.5}, "qos_overrides": {"/light": {"publisher_Said": {"depth": 4}}}}
    assert own["periods"] == {"on_timer": 0.25}
    (ros.folder / "beacon.yaml").write_bytes(files["src/coast_bringup/config/beacon.yaml"])
    (ros.folder / "local.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": given}}))
    said = ros.script(
        "import json\n"
        "from dineros.runtime import Net\n"
        "from dineros.runtime.ros.running import RosNode\n"
        "files = ['--params-file', 'beacon.yaml', '--params-file', 'local.yaml']\n"
        "arguments = ['--ros-args', *files, '-p', 'expected_subscribers.Light:=0']\n"
        "beacon = RosNode(Net.load('beacon.rtm.xmi'), arguments=arguments)\n"
        "beacon.open()\n"
        "node = beacon.session.node\n"
        "parameters = {name: each.value for name, each in node.get_parameters_by_prefix('').items()}\n"
        "(light,) = [each for each in node.publishers if each.topic_name == '/light']\n"
        "quality = light.qos_profile\n"
        "times = quality.deadline, quality.lifespan, quality.liveliness_lease_duration\n"
        "names = quality.reliability.name, quality.durability.name, quality.liveliness.name\n"
        "seconds = [each.nanoseconds / 1e9 for each in times]\n"
        "print(json.dumps([parameters, quality.depth, names, seconds]))\n"
        "beacon.close()\n"
        "beacon.session.close()\n"
    )
    parameters, depth, names, seconds = json.loads(said)
    expected = flat(own) | flat(given) | {"expected_subscribers.Light": 0}
    assert {name: parameters.get(name) for name in expected if name not in OF_THE_PROCESS} == {
        name: value for name, value in expected.items() if name not in OF_THE_PROCESS
    }
    assert depth == 4
    assert names == ["BEST_EFFORT", "TRANSIENT_LOCAL", "MANUAL_BY_TOPIC"]
    assert seconds == [0.5, 1.5, 2.0]
