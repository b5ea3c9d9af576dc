"""What a node has on ROS beside the channels of its model is what the constraints reserve."""

from __future__ import annotations

import json

import pytest

from dineros.metamodel.ros_names import hidden_part, reserved_services, reserved_topics
from tests.runtime.ros.conftest import Ros
from tests.runtime.ros.test_steering import ACTIVATE, CHANGE, CONFIGURE

LOOK = """
import json, time
import rclpy
rclpy.init()
node = rclpy.create_node("looking", start_parameter_services=False)
end = time.monotonic() + 40
def seen(ask):
    try:
        return dict(ask("office", "/"))
    except Exception:  # it is not there yet
        return {}
def look():
    return [seen(node.get_service_names_and_types_by_node), seen(node.get_publisher_names_and_types_by_node),
            seen(node.get_subscriber_names_and_types_by_node)]
found = look()
awaited = {"/office/describe", "/office/set_signal/Open"}
while not awaited <= set(found[0]) or "/office/state" not in found[1]:
    assert time.monotonic() < end, found
    time.sleep(1)
    found = look()
print(json.dumps(found))
rclpy.shutdown()
"""


@pytest.mark.long
@pytest.mark.parametrize("is_managed", [False, True])
def test_the_list_of_reserved_names_is_complete(ros: Ros, is_managed: bool) -> None:
    ros.node("office", options=["--lifecycle"] if is_managed else [])
    for change in (CONFIGURE, ACTIVATE) if is_managed else ():
        ros.script(CHANGE.format(id=change))
    services, published, heard = json.loads(ros.script(LOOK))
    signals: dict[str, tuple[str, ...]] = {"Open": (), "too-late": ()}
    known = reserved_services("/office", signals, is_managed)
    own = {name for name in services if name.startswith("/office/")}
    assert own <= known.keys()
    assert {f"/office/{name}" for name in ("proceed", "release", "describe", "get_parameters")} <= own
    topics = reserved_topics("/office", signals, is_managed)
    for name, types in {**published, **heard}.items():
        if name.startswith("/office/") or name in ("/rosout", "/parameter_events", "/diagnostics"):
            assert hidden_part(name) or types == [topics[name][0]], name
    assert "/office/state" in published
