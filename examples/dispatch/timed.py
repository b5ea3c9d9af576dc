"""One robot of the dispatcher with times: how soon it is in a free aisle, and how soon that is free again.

``python -m examples.dispatch.timed`` writes `dispatch_timed.sym.xmi` next to this file. The times are those
of nodes that this project generates, on one machine that is not busy: an engine fires within 20 ms, and a
message takes 5 ms at most. How long a robot needs to cross the aisle is left open, as it may be blocked.

With more robots, there are too many state classes for these questions.
"""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import seconds
from dineros.metamodel.files import save
from examples.dispatch.build import HOME, build

REACTION = 0.02
"""Seconds in which an engine fires what is enabled."""
LATENCY = 0.005
"""Seconds that a message, a request or a response is on its way, at most."""
ENTERED = 0.09
"""Seconds after which a robot that asks for a free aisle is in it: two ways, and four reactions."""
FREED = 0.045
"""Seconds after which an aisle is free that a robot has left: one way, and two reactions."""


def build_timed() -> sym.SystemModel:
    """Return the model with times, and with properties that they decide."""
    model = build(robots=1, orders=1)
    model.id = model.name = "dispatch_timed"
    model.times = sym.DefaultTimes(reaction=seconds(0, REACTION), latency=seconds(0, LATENCY))
    entered = f"fired(Depart1) leads to fired(Enter1) or fired(GiveUp1) within {ENTERED}"
    freed = f"fired(Cross1) leads to AisleFree >= 1 within {FREED}"
    model.properties.extend(
        [sym.Property(id="EntersAFreeAisle", text=entered), sym.Property(id="AisleIsFreed", text=freed)]
    )
    return model


if __name__ == "__main__":
    save(build_timed(), HOME / "dispatch_timed.sym.xmi")
