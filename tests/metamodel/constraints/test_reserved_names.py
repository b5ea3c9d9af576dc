"""Names that nodes need for themselves: who may use them, and whether the list is complete."""

from __future__ import annotations

import pytest

from dineros.metamodel.constraints import validate
from tests.support.broken.small import system


def reserved(**names: str) -> list[str]:
    """Return violations, given `chatter` and `type` of the topic and `ask` of the service."""
    small = system()
    small["chatter"].topic = names.get("chatter", "/chatter")
    small["chatter"].type = names.get("type", "std_msgs/msg/String")
    small["ask"].service = names.get("ask", "/ask")
    found = validate(small.net)
    return [each.constraint for each in found if each.constraint.startswith("channel-name-reserved")]


@pytest.mark.parametrize(
    ("topic", "type"),
    [
        ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
        ("/listener/signals", "std_msgs/msg/String"),
        ("/left/talker/signals/Ready", "std_msgs/msg/Bool"),
        ("/talker/state", "std_msgs/msg/String"),  # the talker is in the namespace /left
        ("state", "std_msgs/msg/String"),
        ("/listener/stated", "std_msgs/msg/String"),
    ],
)
def test_a_node_may_use_the_topics_of_others_by_their_types(topic: str, type: str) -> None:
    assert reserved(chatter=topic, type=type) == []


@pytest.mark.parametrize("topic", ["/diagnostics", "/listener/signals", "/left/talker/signals/Ready"])
def test_with_another_type_they_are_reserved(topic: str) -> None:
    assert reserved(chatter=topic, type="std_msgs/msg/Float64") == ["channel-name-reserved"]


def test_lifecycle_services_are_reserved_for_managed_nodes_only() -> None:
    assert reserved(ask="/listener/change_state") == []
    small = system()
    from dineros.metamodel import sym

    small["listener"].lifecycle = sym.Lifecycle()
    small["ask"].service = "/listener/change_state"
    assert "channel-name-reserved" in [each.constraint for each in validate(small.net)]


@pytest.mark.parametrize("name", ["/proceed", "/other/release", "~/releases", "{node}/release"])
def test_other_services_are_free(name: str) -> None:
    assert reserved(ask=name) == []
