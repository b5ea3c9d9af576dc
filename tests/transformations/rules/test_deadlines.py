"""Missed deadlines of subscriptions: the rule, with and without times, and runs of nodes."""

from __future__ import annotations

import pytest

from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from tests.transformations.rules.test_times import explored

DEADLINE = 0.15


def camera(period: float, jitter: float, latency: tuple[float, float] = (0.0, 0.0)) -> sym.SystemModel:
    """Return a timer that publishes, and a node that gets a token if an image is late."""
    model = sym.SystemModel(id="silence", middleware="ros2")
    camera = node_net(model, "camera", execution="callbacks")
    on_timer = callback(camera, "OnTimer", "timer")
    on_timer.timer, on_timer.offset, on_timer.duration = period, seconds(0, 0), seconds(0, 0)
    on_timer.jitter = jitter or None
    shot = place(on_timer, "Shot")
    step(on_timer, "Shoot", [], [shot])
    watcher = node_net(model, "watcher", execution="callbacks")
    on_image = callback(watcher, "OnImage", "subscriber")
    on_image.duration = seconds(0, 0)
    seen, missed = place(on_image, "Seen"), place(watcher, "Missed")
    missed.capacity = 1
    step(on_image, "Look", [seen], [])
    step(watcher, "Complain", [missed], [])
    quality = sym.QualityOfService(deadline=DEADLINE)
    topic = sym.TopicChannel(id="Images", topic="/images", model=model, qos=quality)
    topic.latency = seconds(*latency)
    topic.publishers.append(sym.PublisherPort(place=shot, limit=2))
    topic.subscribers.append(sym.SubscriberPort(place=seen, limit=2, missed=missed))
    assert [str(each) for each in validate(model) if each.severity == "error"] == []
    return model


def misses(model: sym.SystemModel) -> bool:
    found = explored(model)
    names = found.net.untimed.transitions
    return any(names[t] == "Images.deadline.Missed.miss" for t in found.ways)


@pytest.mark.parametrize(
    ("period", "jitter", "latency"),
    [
        (0.1, 0.0, (0.0, 0.0)),
        (0.16, 0.0, (0.0, 0.0)),
        (0.1, 0.04, (0.0, 0.0)),
        (0.1, 0.06, (0.0, 0.0)),
        (0.1, 0.0, (0.0, 0.04)),
        (0.1, 0.0, (0.0, 0.06)),
        (0.1, 0.03, (0.01, 0.03)),
        (0.1, 0.03, (0.01, 0.04)),
    ],
)
def test_a_deadline_is_missed_where_two_messages_can_be_too_far_apart(
    period: float, jitter: float, latency: tuple[float, float]
) -> None:
    """The longest gap of two arrivals: the period, with one jitter and one spread of the latency."""
    gap = period + jitter + latency[1] - latency[0]
    assert misses(camera(period, jitter, latency)) == (gap >= DEADLINE)
