"""What follows from a callback that never ends folds under it; what has another cause does not."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import UNLIMITED
from dineros.analysis.checks.check import check
from dineros.analysis.consequences.folding import fold_consequences
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, step
from dineros.metamodel.elements import find


def folded(model: sym.SystemModel) -> dict[str, list[tuple[str, str]]]:
    """Return the consequences of each finding, notes aside, by its rule."""
    budget = UNLIMITED.begun()
    report = check(model, budget)
    fold_consequences(model, report, budget)

    def named(found: tuple[Finding, ...]) -> list[tuple[str, str]]:
        return [(each.rule, each.elements[0]) for each in found]

    return {each.rule: named(each.consequences) for each in report.findings if each.severity != "note"}


def alone() -> sym.SystemModel:
    """Return a node whose timer callback waits for a token that nothing gives."""
    model = sym.SystemModel(id="alone", middleware="ros2")
    page = callback(node_net(model, "n", execution="callbacks"), "OnTimer", "timer", 1.0)
    never, between = place(page, "Never"), place(page, "Between")
    step(page, "Begin", [], [between])
    step(page, "End", [between, never], [])
    return model


def test_what_waits_for_a_token_that_nothing_gives() -> None:
    found = folded(alone())
    assert list(found) == ["callback-never-ends"]
    assert sorted(found["callback-never-ends"]) == [("dead-transition", "End"), ("deadlock", "End")]


def test_what_has_another_cause_stays() -> None:
    """A transition beside it that lacks another token, and one that never fires in a callback that ends."""
    model = alone()
    other = callback(find(model, "n", sym.NodeNet), "OnOther", "timer", 1.0)
    lacking, begun = place(other, "Lacking"), place(other, "Begun")
    step(other, "BeginOther", [], [begun])
    step(other, "EndOther", [begun], [])
    step(other, "Idle", [lacking, begun], [])
    found = folded(model)
    assert found["dead-transition"] == []
    assert ("dead-transition", "Idle") not in found["callback-never-ends"]
    assert ("dead-transition", "End") in found["callback-never-ends"]


def test_the_model_is_left_as_it_was() -> None:
    model = alone()
    before = [str(each.id) for each in model.pages]
    transitions = sum(1 for each in model.eAllContents() if isinstance(each, sym.Transition))
    folded(model)
    assert [str(each.id) for each in model.pages] == before
    assert sum(1 for each in model.eAllContents() if isinstance(each, sym.Transition)) == transitions


@pytest.mark.parametrize("shuts_down", [False, True], ids=["cleaned up", "shut down"])
def test_a_response_that_is_lost_with_its_server(shuts_down: bool) -> None:
    """The loss is the cause: with a time-out, the callback ends, and nothing is stuck."""
    model = sym.SystemModel(id="routes", middleware="ros2")
    lifecycle = sym.Lifecycle(cleansUp=not shuts_down, shutsDown=shuts_down)
    planner = node_net(model, "planner", execution="callbacks", lifecycle=lifecycle)
    plan = callback(planner, "OnRoute", "server")
    asked, planned = place(plan, "Asked"), place(plan, "Planned")
    step(plan, "Plan", [asked], [planned])
    user = node_net(model, "user", execution="callbacks", threads=2)
    user.executor = sym.Executor.multi
    user.callbackGroups.append(calls := sym.CallbackGroup(id="calls", kind="exclusive"))
    page = callback(user, "OnTimer", "timer", 1.0)
    request, response, waits = place(page, "Request"), place(page, "Response"), place(page, "Waits")
    step(page, "Ask", [], [request, waits])
    step(page, "Go", [response, waits], [])
    client = sym.ClientPort(client="user", request=request, response=response, group=calls)
    port = sym.ServerPort(page=plan, entry=asked, exit=planned)
    model.channels.append(sym.ServiceChannel(id="Route", service="/route", server=port, clients=[client]))
    found = folded(model)
    assert "callback-never-ends" not in found and "deadlock" not in found
    assert set(found["server-not-there"]) == {("deadlock", "Ask"), ("callback-never-ends", "OnTimer")}
    assert found["request-lost-with-server"] == []
    assert client.timeout is None


def test_callbacks_that_lack_the_same_token_are_one_fault() -> None:
    """A service's callback keeps a token of its node that it and another one need."""
    model = sym.SystemModel(id="taken", middleware="ros2")
    robot = node_net(model, "robot", execution="callbacks", threads=2)
    robot.executor = sym.Executor.multi
    free, user = place(robot, "Free", tokens=1), node_net(model, "user", execution="net")
    for name, given in (("Keep", []), ("Use", [free])):
        page = callback(robot, f"On{name}", "server")
        robot.callbackGroups.append(group := sym.CallbackGroup(id=f"group{name}", kind="exclusive"))
        page.group = group
        asked, answered = place(page, f"{name}Asked"), place(page, f"{name}Answered")
        step(page, name, [asked, free], [answered, *given])
        idle, request = place(user, f"{name}Idle", tokens=1), place(user, f"{name}Request")
        response = place(user, f"{name}Response")
        step(user, f"{name}Calls", [idle], [request])
        step(user, f"{name}Goes", [response], [idle])
        client = sym.ClientPort(client=f"user_{name}", request=request, response=response)
        port = sym.ServerPort(page=page, entry=asked, exit=answered)
        service = sym.ServiceChannel(id=f"Of{name}", service=f"/{name}", server=port, clients=[client])
        model.channels.append(service)
    before = [each.rule for each in check(model).findings if each.severity != "note"]
    assert sorted(before) == ["callback-never-ends", "callback-never-ends", "deadlock"]
    found = folded(model)
    assert sorted(rule for rule, _ in found["callback-never-ends"]) == ["callback-never-ends", "deadlock"]
