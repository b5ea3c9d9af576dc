"""Actions in pictures of nets: a sign like that of a service, and what goes in and out by its name."""

from __future__ import annotations

from dineros.transformations.flattening.split import split
from dineros.views.nets.contents.building import view_of
from tests.support.ros2_systems.deliveries import deliveries


def test_an_action_is_a_channel_with_its_slots() -> None:
    view = view_of(deliveries(2, 1, feedback=True))
    assert view.node("Delivery").kind == "service"
    assert [caption.text for caption in view.node("Delivery").captions] == ["action, 1 slot"]
    drawn = {
        (edge.kind, edge.source, edge.target, edge.label) for edge in view.edges if edge.kind != "normal"
    }
    assert ("request", "Send0", "Delivery", "office0") in drawn
    assert ("request", "Recall1", "Delivery", "office1: cancel") in drawn
    assert ("response", "Delivery", "Refused0", "office0: rejected") in drawn
    assert ("call", "Delivery", "Stop", "cancel") in drawn
    assert ("return", "Back", "Delivery", "canceled") in drawn
    assert ("return", "Progress", "Delivery", "feedback") in drawn


def test_answers_to_one_place_are_one_line() -> None:
    model = deliveries()
    (client,) = model.channels[0].clients  # type: ignore[attr-defined]
    client.aborted = client.canceled = client.succeeded
    texts = [edge.label for edge in view_of(model).edges if edge.target == "Delivered0"]
    assert texts == ["office0: succeeded, aborted, canceled"]


def test_a_node_of_its_own_shows_its_ports() -> None:
    robot, office = (view_of(part) for part in split(deliveries(1, 2)))
    assert [caption.text for caption in robot.node("Delivery").captions] == ["action, 2 slots"]
    assert ("call", "Delivery", "Parcel") in {(edge.kind, edge.source, edge.target) for edge in robot.edges}
    assert ("request", "Send0", "Delivery") in {
        (edge.kind, edge.source, edge.target) for edge in office.edges
    }
