"""One cell and one piece with times: how soon the gate opens for a person.

``python -m examples.sorting_actions.timed`` writes `cell_timed.sym.xmi` next to this file. The times of
engines and messages are those of nodes that this project generates, on one machine that is not busy: an
engine fires within 20 ms, and a message takes 5 ms at most. The arm and the gate need the times of `cell.py`,
and up to 100 ms until the signal has come. When a piece is chosen, and when a person comes and goes, is left
open.

With more pieces, there are too many state classes for a quick answer.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import seconds
from dineros.metamodel.elements import find, node_nets
from dineros.metamodel.files import save
from examples.sorting_actions.build import HOME, MOTIONS, build

REACTION = 0.02
"""Seconds in which an engine fires what is enabled."""
LATENCY = 0.005
"""Seconds that a message, a request or a response is on its way, at most."""
MOTION = seconds(0.4, 0.5)
BRAKE = seconds(0.1, 0.2)
SHUT = seconds(0.0, 0.1)
ANY_TIME = seconds(0.0, None)
OPENED = 0.72
"""Seconds after which the gate is open for a person: one motion, four messages that engines take, and six
reactions. It is not the time to brake: a request to cancel may overtake its goal, which then is not canceled.
"""


def build_timed() -> sym.SystemModel:
    """Return the model with times instead of signals, and with a property that they decide."""
    model = build(cells={"L": ("Red",)})
    model.id = model.name = "cell_timed"
    model.times = sym.DefaultTimes(reaction=seconds(0, REACTION), latency=seconds(0, LATENCY))
    intervals = {"ChooseRed": ANY_TIME, "Notice": ANY_TIME, "ShutGate": ANY_TIME, "Release": SHUT}
    for motion in MOTIONS:
        intervals |= {f"Finish{motion}": MOTION, f"Fail{motion}": MOTION, f"Rest{motion}": BRAKE}
    for id, interval in intervals.items():
        transition = find(model, id, sym.Transition)
        transition.clause = None
        transition.interval = pn.TimeInterval(earliest=interval.earliest, latest=interval.latest)
    for net in node_nets(model):
        net.signals.clear()
    opens = f"fired(Notice) leads to GateOpen >= 1 within {OPENED}"
    model.properties.append(sym.Property(id="OpensInTime", text=opens))
    return model


if __name__ == "__main__":
    save(build_timed(), HOME / "cell_timed.sym.xmi")
