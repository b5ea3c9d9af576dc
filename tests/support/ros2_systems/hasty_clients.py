"""A client of an action that does not wait for the end of its goals."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, step
from tests.support.ros2_systems.deliveries import deliveries


def hasty() -> tuple[sym.SystemModel, sym.ActionClientPort]:
    """Return an action with a client that sends a goal at each tick of its timer, and waits for none."""
    model = deliveries()
    node = node_net(model, "hasty", execution="callbacks")
    tick = callback(node, "OnTick", "timer", 1.0)
    goal, over = place(tick, "Hasty.goal"), callback(node, "OnOver", "client")
    done = place(over, "Hasty.done")
    step(tick, "Hasty.send", [], [goal])
    step(over, "Hasty.take", [done], [])
    port = sym.ActionClientPort(client="hasty", goal=goal, succeeded=done, aborted=done, canceled=done)
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel)
    channel.clients.append(port)
    return model, port
