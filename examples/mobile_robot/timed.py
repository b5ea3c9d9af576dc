"""The mobile robot with times: how soon it asks for its dock, and how soon it is charged.

``python -m examples.mobile_robot.timed`` writes `mobile_robot_timed.sym.xmi` next to this file. The times are
those of nodes that this project generates, on one machine that is not busy: an engine fires within 20 ms, and
a message takes 5 ms at most. How long a leg takes, and when the next round begins, is left open. The mission
asks to cancel a goal again after half a second.

It has one waypoint, and gives no feedback, which decides nothing. What handlers decide is in the model: a
mission whose battery is low sends no goal, and a scan that shows nothing lets no other transition wait.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import here, inhibit, seconds
from dineros.metamodel.elements import find, node_nets
from dineros.metamodel.files import save
from examples.mobile_robot.build import HOME, PATIENCE, build

REACTION = 0.02
"""Seconds in which an engine fires what is enabled."""
LATENCY = 0.005
"""Seconds that a message, a request or a response is on its way, at most."""
LEAVES_SIGNALS = ("TAgain", "TArrive")
"""Transitions that wait for people, or for the wheels: they fire at any time."""
ASKED = 0.7
"""Seconds after a warning in which the mission's request to dock has begun."""
CHARGED = 0.17
"""Seconds after its arrival at the dock in which the robot is charged and leaves."""
TRIED_AGAIN = 0.12
"""Seconds after a way is blocked in which the mission has decided what comes next."""
DEADLINES = {
    "AsksForTheDockInTime": f"fired(TWarn) leads to fired(TSearch) within {ASKED}",
    "IsChargedInTime": f"fired(TApproach) leads to fired(TUndock) within {CHARGED}",
    "DecidesInTime": "fired(TBlocked) leads to fired(TRetry) or fired(TGiveUp) or fired(TLeave) within "
    f"{TRIED_AGAIN}",
    "SeesInTime": "OnScanner responds within 0.02",
}


def build_timed() -> sym.SystemModel:
    """Return the model with times instead of signals, and with properties that they decide."""
    model = build(waypoints=1, has_feedback=False)
    model.id = model.name = "mobile_robot_timed"
    model.times = sym.DefaultTimes(reaction=seconds(0, REACTION), latency=seconds(0, LATENCY))
    for id in LEAVES_SIGNALS:
        transition = find(model, id, sym.Transition)
        transition.clause = None
        transition.interval = pn.TimeInterval(earliest=0.0)
    find(model, "TInsist", sym.Transition).interval = seconds(PATIENCE, PATIENCE + REACTION)
    send = find(model, "TSend", sym.Transition)
    assert send.page is not None
    inhibit(here(find(model, "Low", sym.Place), send.page), send)
    for net in node_nets(model):
        net.signals.clear()
    for each in [each for each in model.properties if "stays possible" in str(each.text)]:
        model.properties.remove(each)
    model.properties.extend(sym.Property(id=id, text=text) for id, text in DEADLINES.items())
    return model


if __name__ == "__main__":
    save(build_timed(), HOME / "mobile_robot_timed.sym.xmi")
