"""The smallest change of callback groups and threads after which no callback waits for ever."""

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
from tests.support.ros2_systems.executor_cases import Case, case_model

OWN = "Level.client.monitor.group=Level_monitor_group"
MENDS = {
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
def test_each_program_that_blocks_is_mended(name: str, tmp_path: Path) -> None:
    """The mended programs of real rclpy are such: `own_group`, `awaiting_own_group` and so on."""
    model = program(name)
    save(model, tmp_path / "before.sym.xmi")
    found = suggest_callback_groups(model)
    assert settings(found) == MENDS[name]
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


def test_what_would_overflow_then_is_no_mend() -> None:
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
    assert found.reason == "no change of callback groups and threads is enough"
    assert found.tried == 3
    assert any(each.rule == "queue-overflow" for each in check(changed(model, MENDS["same_group"])).findings)


def test_a_callback_that_waits_for_nobody_is_not_mended() -> None:
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
