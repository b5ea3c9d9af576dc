"""The smallest change of callback groups and threads after which no callback waits forever."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.suggestions.callback_groups import Suggestion, suggest_callback_groups
from dineros.analysis.suggestions.changes import Changes
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import elements, find
from dineros.metamodel.files import save
from dineros.metamodel.settings import apply
from dineros.transformations.language.copying import deep_copy
from examples.callbacks.models import node, program, timer, topic
from tests.runtime.ros.test_callbacks import BLOCK
from tests.support.ros2_systems.blocking_callbacks import some_waits_for_ever
from tests.support.ros2_systems.deliveries import deliveries
from tests.support.ros2_systems.executor_cases import Case, case_model
from tests.support.ros2_systems.waiting_models import (
    awaiting_result,
    locking_crosswise,
    served_in_a_busy_group,
    sharing_a_lock,
    waiting_for_an_echo,
)

OWN = "Level.client.monitor.group=Level_monitor_group"
FIXES = {
    "same_group": [OWN],
    "one_thread": ["monitor.executor=multi", "monitor.threads=2"],
    "reentrant": ["OnTimer.group=OnTimer_group"],
    "awaiting": [OWN],
    "answer_one_thread": ["monitor.executor=multi", "monitor.threads=2"],
    "calling_each_other": [
        "Position.client.planner.group=Position_planner_group",
        "planner.executor=multi",
        "planner.threads=2",
    ],
}


def settings(suggestion: Suggestion) -> list[str]:
    return [setting for _, settings in suggestion.changes for setting in settings]


def changed(model: sym.SystemModel, settings: list[str]) -> sym.SystemModel:
    copied, _ = deep_copy(model)
    assert isinstance(copied, sym.SystemModel)
    for setting in settings:
        apply(copied, setting)
    return copied


@pytest.mark.parametrize("name", BLOCK)
def test_each_program_that_blocks_is_fixed(name: str, tmp_path: Path) -> None:
    """The fixed programs of real rclpy are such: `own_group`, `awaiting_own_group` and so on."""
    model = program(name)
    save(model, tmp_path / "before.sym.xmi")
    found = suggest_callback_groups(model)
    assert settings(found) == FIXES[name]
    assert (found.is_found, found.is_proved) == (True, True)
    assert [fault.rule for fault in found.faults] == ["callback-deadlock"]
    save(model, tmp_path / "after.sym.xmi")
    before, after = ((tmp_path / f"{when}.sym.xmi").read_text() for when in ("before", "after"))
    assert before == after, "the model is not changed"
    assert not some_waits_for_ever(changed(model, settings(found)))


@pytest.mark.long
@pytest.mark.parametrize(
    "case",
    [Case(client="own", threads=2, answers=True), Case(kind="reentrant", threads=1), Case(awaits=True)],
    ids=str,
)
def test_nothing_smaller_is_enough(case: Case) -> None:
    """All smaller changes are tried on the interpreter of system models."""
    model = case_model(case)
    found = suggest_callback_groups(model)
    assert not some_waits_for_ever(changed(model, settings(found)))
    for fewer in changes_of(model, len(found.changes) - 1):
        made = [setting for _, each in fewer.steps(model) for setting in each]
        assert some_waits_for_ever(changed(model, made)), fewer


def changes_of(model: sym.SystemModel, size: int) -> Iterator[Changes]:
    """Yield all changes of at most a size: groups of their own, reentrant groups, more threads."""
    nodes = [each.id for each in elements(model) if isinstance(each, sym.NodeNet)]
    pages = [(str(each.id), "") for each in elements(model) if isinstance(each, sym.CallbackPage)]
    services = [each for each in model.channels if isinstance(each, sym.ServiceChannel)]
    clients = [(str(each.id), str(client.client)) for each in services for client in each.clients]
    groups = [(str(each.id), "") for each in elements(model) if isinstance(each, sym.CallbackGroup)]
    atoms = [("own", owner) for owner in (*pages, *clients)]
    atoms += [("reentrant", owner) for owner in (*pages, *groups)]
    atoms += [("thread", (str(id), number)) for id in nodes for number in "12"]
    for number in range(size + 1):
        for chosen in combinations(atoms, number):
            own = frozenset(owner for kind, owner in chosen if kind == "own")
            reentrant = frozenset(owner for kind, owner in chosen if kind == "reentrant")
            if not reentrant <= own | set(groups):
                continue
            changes = Changes(own, reentrant)
            for kind, (id, _) in chosen:
                changes = changes.with_thread(id) if kind == "thread" else changes
            yield changes


def test_what_would_overflow_then_is_no_fix() -> None:
    """The monitor, which blocks at its first call, would publish what it hears faster than others listen."""
    model = program("same_group")
    page = find(model, "OnTimer", sym.CallbackPage)
    heard = sym.Place(id="Heard", page=sym.CallbackPage(id="OnHeard", page=node(model, "display")))
    said = sym.Place(id="Said", page=page)
    flow(find(model, "NoteLevel", sym.Transition), said)
    flow(heard, sym.Transition(id="Show", page=heard.page))
    topic(model, "Levels", said, heard)
    found = suggest_callback_groups(model)
    assert (found.is_found, found.is_proved, found.changes) == (False, True, [])
    assert found.reason == "no change of callback groups and threads suffices"
    assert found.tried == 3
    assert any(each.rule == "queue-overflow" for each in check(changed(model, FIXES["same_group"])).findings)


def test_a_callback_that_waits_for_nobody_is_not_fixed() -> None:
    model = sym.SystemModel(id="alone", middleware="ros2")
    page = timer(node(model, "n"), 1.0)
    never, between = sym.Place(id="Never", page=page), sym.Place(id="Between", page=page)
    end = sym.Transition(id="End", page=page)
    flow(sym.Transition(id="Begin", page=page), between, end)
    flow(never, end)
    found = suggest_callback_groups(model)
    assert (found.is_found, found.is_proved, found.tried) == (False, True, 1)


def test_out_of_time() -> None:
    found = suggest_callback_groups(program("same_group"), Budget(seconds=1e-9))
    assert (found.is_found, found.is_proved) == (False, False)
    assert "time" in found.reason


def test_the_group_of_a_client_of_an_action_is_a_change() -> None:
    model = awaiting_result()
    found = suggest_callback_groups(model)
    assert settings(found) == [
        "Act.client.boss.group=Act_boss_group",
        "boss.executor=multi",
        "boss.threads=2",
    ]
    assert (found.is_found, found.is_proved) == (True, True)
    assert not [each for each in check(changed(model, settings(found))).findings if each.severity == "error"]


@pytest.mark.long
@pytest.mark.parametrize("awaits", [False, True])
def test_so_is_that_of_its_server(awaits: bool) -> None:
    model = awaiting_result(same=True, awaits=awaits)
    found = suggest_callback_groups(model)
    assert settings(found) == ["OnTimer.group=OnTimer_group", "boss.executor=multi", "boss.threads=2"]
    assert (found.is_found, found.is_proved) == (True, True)


def test_a_server_leaves_the_group_of_all_that_ask_it() -> None:
    """One change instead of one for each callback that asks."""
    found = suggest_callback_groups(served_in_a_busy_group(timers=2))
    assert settings(found) == ["OnWork.group=OnWork_group"]
    assert (found.is_found, found.is_proved) == (True, True)


def test_callbacks_that_take_locks_in_opposite_order_may_not_run_at_once() -> None:
    """More threads and groups of their own do not help, but one thread does."""
    model = locking_crosswise()
    found = suggest_callback_groups(model)
    assert settings(found) == ["n.executor=single", "n.threads=1"]
    assert (found.is_found, found.is_proved) == (True, True)
    assert some_waits_for_ever(model)
    assert not some_waits_for_ever(changed(model, settings(found)))


def test_they_share_a_group_where_a_second_thread_is_needed() -> None:
    model = locking_crosswise(calls=True)
    found = suggest_callback_groups(model)
    assert settings(found) == [
        "OnTimer0.group=OnTimer0_OnTimer1_group",
        "OnTimer1.group=OnTimer0_OnTimer1_group",
    ]
    assert [words for words, _ in found.changes] == ["callbacks OnTimer0 and OnTimer1 in one callback group"]
    assert (found.is_found, found.is_proved) == (True, True)
    assert not some_waits_for_ever(changed(model, settings(found)))


def test_a_lock_of_the_model_is_not_fixed() -> None:
    """Whatever threads there are: who holds the lock waits for one that needs it."""
    found = suggest_callback_groups(sharing_a_lock())
    assert (found.is_found, found.is_proved) == (False, True)


def test_a_callback_that_waits_for_a_message_of_its_own_group() -> None:
    """No circle shows that, and yet a group helps."""
    model = waiting_for_an_echo()
    found = suggest_callback_groups(model)
    assert [fault.rule for fault in found.faults] == ["callback-never-ends"]
    assert (found.is_found, found.is_proved) == (True, True)
    assert settings(found) == ["OnWait.group=OnWait_group"]


def test_requests_to_cancel_that_are_never_heard() -> None:
    """A second thread hears them, and so does work that awaits."""
    model = deliveries(cancels=1)
    find(model, "robot", sym.NodeNet).execution = sym.Execution.callbacks
    found = suggest_callback_groups(model)
    assert [fault.rule for fault in found.faults] == ["cancel-never-heard"]
    assert settings(found) == ["robot.executor=multi", "robot.threads=2"]
    assert [[each for _, made in other for each in made] for other in found.others] == [
        ["Deliver.awaits=true"]
    ]
    for made in (settings(found), ["Deliver.awaits=true"]):
        assert "cancel-never-heard" not in {each.rule for each in check(changed(model, made)).findings}


@pytest.mark.long
def test_properties_that_a_change_breaks_are_told() -> None:
    """With two threads, two goals are worked on at once."""
    model = deliveries(clients=2)
    find(model, "robot", sym.NodeNet).execution = sym.Execution.callbacks
    model.properties.append(sym.Property(id="One", text="always Driving <= 1"))
    assert [each for each in suggest_callback_groups(model).breaks if "One" in each]
