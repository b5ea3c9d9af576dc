"""Properties with times that some nodes of a model decide."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.requirements.stored import asked
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, node_net, place, seconds, step


def robot(reliability: sym.Reliability = sym.Reliability.reliable) -> sym.SystemModel:
    """Return a lidar, a pilot that stops for a scan, a brake, and a clerk who has nothing to do with them."""
    model = sym.SystemModel(id="robot", middleware="ros2")
    model.times = sym.DefaultTimes(reaction=seconds(0, 2.0), latency=seconds(0, 1.0))
    lidar = callback(node_net(model, "lidar"), "OnScanner", "timer", 50.0)
    ahead = place(lidar, "Ahead")
    flow(step(lidar, "TScan"), ahead)
    page = callback(node_net(model, "pilot"), "OnScan")
    scan, stop = place(page, "Scan"), place(page, "Stop")
    step(page, "TStop", [scan], [stop])
    brake = node_net(model, "brake")
    braking = callback(brake, "OnStop")
    asked_for, braked = place(braking, "Asked"), place(brake, "Braked")
    step(braking, "TBrake", [asked_for], [braked])
    step(brake, "TRelease", [braked])
    clerk = node_net(model, "clerk")
    step(clerk, "TIdle", [place(clerk, "Work", 1)], [place(clerk, "Rest")])
    for id, sent, got in (("Scans", ahead, scan), ("Stops", stop, asked_for)):
        topic = sym.TopicChannel(id=id, topic=f"/{id.lower()}")
        topic.qos = sym.QualityOfService(reliability=reliability)
        topic.publishers.append(sym.PublisherPort(place=sent, limit=1))
        topic.subscribers.append(sym.SubscriberPort(place=got, limit=1))
        model.channels.append(topic)
    return model


@pytest.mark.parametrize(
    ("text", "is_proved"),
    [
        ("fired(TStop) leads to fired(TBrake) within 5", True),
        ("fired(TStop) leads to fired(TBrake) within 4", False),
        ("fired(TScan) leads to fired(TBrake) within 10", True),
        ("always Work + Rest == 1", True),
        ("never Work == 0", False),
        ("never enabled(TIdle) and Work == 0", True),
        ("Braked >= 1 stays possible", False),
    ],
)
def test_some_nodes_prove_it(text: str, is_proved: bool) -> None:
    model = robot()
    property = sym.Property(id="Asked", text=text)
    model.properties.append(property)
    found = asked(property, timed_base_subject(model)).by_parts(Budget(seconds=60))
    assert (found is not None) == is_proved
    if found is not None:
        assert asked(property, timed_base_subject(model)).answer(Budget(seconds=60)).status == "holds"
