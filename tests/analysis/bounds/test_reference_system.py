"""Bounds of a system like the reference system of the ROS 2 real-time working group: 23 nodes.

Each node has a thread; each callback takes 10 ms, and sensors and the planner have timers of 100 ms. Of a
fusion, the first input is only kept, and the second one publishes.
"""

from __future__ import annotations

import time
from fractions import Fraction
from typing import Any

import pytest

from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import end_of
from tests.support.timed_systems.models import System, model_of

WORK, PERIOD = 10, 100
SENSORS = ("front_lidar", "rear_lidar", "point_cloud_map", "lanelet_map", "visualizer", "cluster_settings")
TRANSFORMS = {
    "front_points": "front_lidar",
    "rear_points": "rear_lidar",
    "voxel_grid": "point_cloud",
    "map_loader": "point_cloud_map",
    "ground_filter": "point_cloud",
    "collisions": "clusters",
    "controller": "planner",
    "parking": "lanelets",
    "lanes": "lanelets",
    "intersection": "cluster_settings",
}
FUSIONS = {
    "point_cloud": ("front_points", "rear_points"),
    "localizer": ("map_loader", "voxel_grid"),
    "vehicle": ("planner", "controller"),
    "global_planner": ("visualizer", "localizer"),
    "lanelets": ("lanelet_map", "global_planner"),
    "clusters": ("intersection", "ground_filter"),
}
PLANNED = ("collisions", "localizer", "global_planner", "lanelets", "parking", "lanes")
CHAIN = (
    "rear_lidar", "rear_points", "point_cloud.second", "voxel_grid", "localizer.second",
    "global_planner.second", "lanelets.second", "lanes", "planner.lanes",
)  # fmt: skip


def _row(name: str, node: str, publishes: bool, **released: Any) -> dict[str, Any]:
    topics = [["publish", f"{node}_out"]] if publishes else []
    script = [["work", WORK, WORK], *topics]
    return {"name": f"{name}.run", "node": node, "group": "default", "script": script, **released}


def _heard(topic: str) -> dict[str, Any]:
    return {"topic": f"{topic}_out", "depth": 10}


def system() -> System:
    """Return the system; units are milliseconds."""
    timer = {"period": PERIOD, "offset": "any"}
    callbacks = [_row(name, name, True, **timer) for name in (*SENSORS, "planner")]
    callbacks += [_row(name, name, True, **_heard(topic)) for name, topic in TRANSFORMS.items()]
    for name, (first, second) in FUSIONS.items():
        callbacks.append(_row(f"{name}.first", name, False, **_heard(first)))
        callbacks.append(_row(f"{name}.second", name, True, **_heard(second)))
    callbacks += [_row(f"planner.{name}", "planner", False, **_heard(name)) for name in PLANNED]
    nodes = {each["node"]: {"threads": 1} for each in callbacks}
    latency = {f"{node}_out": (0, 1) for node in nodes}
    return {"nodes": nodes, "latency": latency, "chains": [], "callbacks": callbacks}


def test_all_of_it_is_bounded_in_no_time() -> None:
    made = system()
    assert len(made["nodes"]) == 23
    model = model_of(made, 0.001)
    began = time.monotonic()
    bounds = Bounds(model)
    found = bounds.everything()
    assert time.monotonic() - began < 10, "it takes half a second"
    assert not any(each.reason for each in found.callbacks.values())
    assert all(overflows is False for _, overflows in found.readers.values())
    assert [name for name, loses in found.timers.items() if loses is not False] == ["planner.run"]
    chain = bounds.between(end_of(model, f"{CHAIN[0]}.run"), end_of(model, f"{CHAIN[-1]}.run"))
    assert chain.least is not None and chain.least.value == Fraction(len(CHAIN) * WORK, 1000)
    assert chain.greatest is not None and chain.greatest.value <= Fraction(3 * len(CHAIN) * WORK, 1000)
    assert chain.is_lost is False and chain.reaction is not None
    assert chain.reaction.value == chain.greatest.value + Fraction(PERIOD, 1000)


@pytest.mark.parametrize("order", ["any", "rclcpp"])
def test_a_slower_planner_has_bounds_only_in_an_order(order: str) -> None:
    """With callbacks of 20 ms, the planner has 140 ms of work in 100 ms; wait results starve nobody."""
    made = system()
    for each in made["callbacks"]:
        if each["node"] == "planner":
            each["script"][0][1:] = [20, 20]
    made["nodes"]["planner"]["order"] = order
    found = Bounds(model_of(made, 0.001)).everything()
    planner = [each for name, each in found.callbacks.items() if name.startswith("planner.")]
    assert len(planner) == 7
    assert all((each.greatest is None) == (order == "any") for each in planner)
