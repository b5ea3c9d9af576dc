"""A guard on what begins the callback of a timer is refused, if the callback has a duration."""

from __future__ import annotations

import pytest

from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import callback, here, node_net, place, seconds, step
from dineros.metamodel.errors import GuardError


def test_the_message_names_transition_and_timer() -> None:
    answer = sym.TokenType(id="Answer", fields=[sym.TokenField(name="success", kind="boolean")])
    model = sym.SystemModel(id="robot", middleware="ros2", tokenType=answer)
    node = node_net(model, "node", execution="callbacks")
    mode = place(node, "Mode", 1)
    tick = callback(node, "tick", "timer")
    tick.timer, tick.duration = 0.1, seconds(0, 0.01)
    runs = place(tick, "Runs")
    step(tick, "Begin", [here(mode, tick)], [runs]).guard = "success = true"
    step(tick, "End", [runs], [here(mode, tick)])
    with pytest.raises(GuardError, match="transition Begin begins the callback of timer tick"):
        timed_base_subject(model)
    tick.duration = None
    assert timed_base_subject(model).timed.untimed.transitions
