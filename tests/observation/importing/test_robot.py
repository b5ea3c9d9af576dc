"""What is found of the robot of `examples/foreign` as it is imported: its nested call waits for ever."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.searching import Search, searched
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.witness import replay
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.observation.importing.building import to_model
from tests.support.foreign import given, robot

NESTED = (
    "callback planner.serves_plan of server instance 1 waits for the response of service /where to instance "
    "1 of service /plan, which waits for the thread of node net planner, which callback planner.serves_plan "
    "of server instance 1 has"
)


def search(model: sym.SystemModel) -> Search:
    """Return what is found; where each run leads, replayed on the whole net, its circle is closed."""
    assert [each for each in validate(model) if each.severity == "error"] == []
    subject = base_subject(model)
    waiting = Waiting(subject)
    found = searched(subject.net, waiting, Budget(seconds=300).begun())
    for each in found.blocked:
        assert waiting.circle(replay(subject.net, each.trace)[-1]) == each.circle
    return found


def test_the_nested_call_waits_for_ever_and_nothing_else_does() -> None:
    found = search(to_model(robot(), given()).model)
    assert [str(each.circle) for each in found.blocked] == [NESTED]
    assert found.is_complete


def test_it_is_found_where_all_behaviour_is_open() -> None:
    """Callbacks that may call anything wait for ever, too; all others are proved to end."""
    found = search(to_model(robot()).model)
    callers = {each.callback.element for each in found.blocked}
    assert NESTED in {str(each.circle) for each in found.blocked}
    assert callers == {
        *("commander.on_timer", "monitor.on_mission", "monitor.on_odometry", "monitor.on_timer"),
        *("planner.on_map", "planner.on_timer", "planner.serves_plan"),
    }
    assert found.is_complete


def test_mended_every_callback_ends() -> None:
    found = search(to_model(robot(mended=True), given(mended=True)).model)
    assert (found.blocked, found.is_complete) == ((), True)
