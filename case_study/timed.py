"""The case study with times, which bound how soon the arms stop for a human.

``python -m case_study.timed`` writes `timed.sym.xmi` next to this file. The model is that of `build.py` by
the rules of ROS 2, with a sensor that always has data. Its times are those of the workspace's handlers and
of messages on one machine. They are in a model of their own: the figures of `sorting.sym.xmi`
are those of the paper, which has no times and the queues of ROS 1.
"""

from __future__ import annotations

from case_study import build as plain
from case_study.build import HOME, RETRY_TIME, SENSE_TIME
from dineros.metamodel import sym
from dineros.metamodel.build import seconds
from dineros.metamodel.elements import find
from dineros.metamodel.files import save

REACTION = 0.02
"""Seconds in which an engine fires what is enabled."""
LATENCY = 0.005
"""Seconds that a message, a request or a response is on its way, at most."""
STOP = 0.11
"""Seconds after which the arms have stopped for a human, or it is known that there is none."""


def build_timed() -> sym.SystemModel:
    """Return the case study with times."""
    model = plain.build("timed")
    model.middleware = sym.Middleware.ros2
    sense = find(model, "TSense", sym.Transition)
    sense.clause = None
    find(model, "sensorics", sym.NodeNet).signals.clear()
    sense.interval = seconds(SENSE_TIME, 2 * SENSE_TIME)
    find(model, "TRetry", sym.Transition).interval = seconds(RETRY_TIME, round(RETRY_TIME + REACTION, 3))
    model.times = sym.DefaultTimes(reaction=seconds(0, REACTION), latency=seconds(0, LATENCY))
    stop = f"fired(TStop) leads to Safe >= 1 or Unsafe >= 1 within {STOP}"
    model.properties.append(sym.Property(id="StopsInTime", text=stop))
    return model


if __name__ == "__main__":
    save(build_timed(), HOME / "timed.sym.xmi")
