"""What is found of the robot of `examples/foreign` as it is imported: its nested call waits forever."""

from __future__ import annotations

import pytest

from dineros.observation.importing.building import to_model
from tests.support.systems.foreign import NESTED, given, robot, search


@pytest.mark.long
def test_the_nested_call_waits_for_ever_and_nothing_else_does() -> None:
    found = search(to_model(robot(), given()).model)
    assert [str(each.circle) for each in found.blocked] == [NESTED]
    assert found.is_complete


@pytest.mark.long
def test_it_is_found_where_all_behaviour_is_open() -> None:
    """Callbacks that may call anything wait forever, too; of two, it is left open: they may also send."""
    found = search(to_model(robot()).model)
    callers = {each.callback.element for each in found.blocked}
    assumed = NESTED.replace("the only thread", "the only thread (that it has one is assumed)")
    assert assumed in {str(each.circle) for each in found.blocked}
    assert callers >= {
        *("commander.on_timer", "commander.on_answer_of_plan"),
        *("monitor.on_odometry", "monitor.on_timer", "monitor.on_answer_of_charge"),
        *("planner.on_map", "planner.on_timer", "planner.serves_plan", "planner.on_answer_of_where"),
    }


@pytest.mark.long
def test_fixed_every_callback_ends() -> None:
    found = search(to_model(robot(fixed=True), given(fixed=True)).model)
    assert (found.blocked, found.is_complete) == ((), True)
