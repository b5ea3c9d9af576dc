"""Callbacks that wait forever where not all markings can be seen."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.callbacks.blocking import blocked, never_without
from dineros.analysis.callbacks.searching import near_circles, searched
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.callbacks.walking import Walks
from dineros.analysis.checks.blocking import ALL_END, OTHERS_END
from dineros.analysis.checks.boundedness import Boundedness
from dineros.analysis.checks.check import check
from dineros.analysis.covering.firings import near_firings
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import UnknownBoundError
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, node_net, place, step
from dineros.metamodel.elements import transitions
from dineros.metamodel.errors import DinerosError
from examples.callbacks.models import PROGRAMS, program
from tests.analysis.callbacks.test_waiting import CIRCLES
from tests.support.ros2_systems.executor_models import executor_models

WAITS_FOR_OTHERS = "calling_each_other"
"""A program in which a callback waits for callbacks that wait for each other."""

FEW = 300
"""Markings in which what is found is looked into."""


@pytest.mark.long
@pytest.mark.parametrize("name", PROGRAMS)
def test_circles_of_programs_without_an_end_of_markings(name: str) -> None:
    model = program(name)
    noise = sym.NodeNet(id="noise", net=model)
    heap = sym.Place(id="Heap", page=noise)
    flow(sym.Transition(id="Tick", page=noise), heap, sym.Transition(id="Burn", page=noise))
    report = check(model, Budget(seconds=60))
    circles = [finding for finding in report.findings if finding.rule == "callback-deadlock"]
    assert [finding.message for finding in circles] == ([CIRCLES[name]] if name in CIRCLES else [])
    if name == WAITS_FOR_OTHERS:  # whether it waits for something else, too, is not decided
        assert any("can wait for these" in str(each) for each in report.unknown)
    else:
        assert (OTHERS_END if circles else ALL_END) in report.proved


NEAR = ("same_group", "one_thread", "awaiting", "answer_one_thread", WAITS_FOR_OTHERS)
"""Programs whose circle closes after any run in which the callback asks."""


@pytest.mark.parametrize("name", PROGRAMS)
def test_circles_are_closed_after_known_runs(name: str) -> None:
    """A run that begins a call shows that its callback never ends; its tokens are followed to the circle."""
    subject = base_subject(program(name))
    waiting = Waiting(subject)
    walks = Walks(subject.net, waiting)
    traces = near_firings(subject.net, Budget(seconds=60)).traces
    endless = walks.endless_after(sorted(traces.values(), key=len))
    for each in waiting.callbacks.values():
        if each.waiter not in endless:
            continue
        trace = endless[each.waiter]
        assert each.waiter in {one.callback for one in walks.blocked_after(trace)}
        assert each.waiter not in {one.callback for one in walks.blocked_after(trace[:-1])}
        closed = walks.closed_after(trace, Budget(seconds=60), each)
        assert closed is not None and str(closed.circle) == CIRCLES[name]
    assert bool(endless) == (name in NEAR)


@pytest.mark.parametrize("name", PROGRAMS)
def test_circles_are_seen_at_little_cost(name: str) -> None:
    subject = base_subject(program(name))
    found = near_circles(subject.net, Waiting(subject), Budget(seconds=60))
    assert [str(each.circle) for each in found] == ([CIRCLES[name]] if name in NEAR else [])


def test_a_large_model_is_first_looked_at_for_circles(monkeypatch: pytest.MonkeyPatch) -> None:
    """No time is left for anything else: what is near has been found before."""
    model = program("same_group")
    for number in range(700):
        noise = sym.NodeNet(id=f"noise{number}", net=model)
        heap = sym.Place(id=f"Heap{number}", page=noise)
        flow(sym.Transition(id=f"Tick{number}", page=noise), heap)
    monkeypatch.setattr(Boundedness, "ask", lambda self, checked: checked.close(self.asks, "no time is left"))
    report = check(model, Budget(seconds=60))
    circles = [finding for finding in report.findings if finding.rule == "callback-deadlock"]
    assert [finding.message for finding in circles] == [CIRCLES["same_group"]]


@pytest.mark.long
@settings(
    max_examples=3,
    phases=[Phase.generate],
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)
@given(executor_models())
def test_what_is_found_is_so(model: sym.SystemModel) -> None:
    """From where a run leads, no marking can be reached in which its callback has ended."""
    for transition in transitions(model):
        transition.overrides.clear()  # priorities are not analysed
    try:
        subject = base_subject(model)
    except DinerosError:
        assume(False)
    waiting = Waiting(subject)
    by_waiter = {callback.waiter: callback for callback in waiting.callbacks.values()}
    walks = Walks(subject.net, waiting)
    found = [walks.shortest(each) for each in walks.found(Budget(seconds=10).begun())]
    for each in found:
        last = replay(subject.net, each.trace)[-1]
        places = by_waiter[each.callback].places
        assert all(any(marking[p] for p in places) for marking in markings_from(subject.net, last))
        assert each.circle is None or waiting.circle(last, each.callback) == each.circle


def markings_from(net: CompiledNet, first: list[int]) -> list[list[int]]:
    """Return the first markings that can be reached."""
    seen, found = {tuple(first)}, [first]
    for marking in found:
        for transition in range(len(net.transitions)):
            if len(found) < FEW and net.is_enabled(transition, marking):
                after = net.fire(transition, marking)
                if tuple(after) not in seen:
                    seen.add(tuple(after))
                    found.append(after)
    return found


def waiting_in_two_ways() -> sym.SystemModel:
    """Return a user that calls a server which blocks itself, or another one in a way that blocks the user."""
    model = sym.SystemModel(id="two_ways", middleware="ros2")
    home, command = node_net(model, "home", execution="callbacks"), node_net(model, "command")
    user = node_net(model, "user", execution="callbacks", threads=2)
    user.executor = sym.Executor.multi
    user.callbackGroups.append(own := sym.CallbackGroup(id="own", kind="exclusive"))
    obey = callback(command, "OnCommand", "server")
    asked, obeyed = place(obey, "Asked"), place(obey, "Obeyed")
    step(obey, "Obey", [asked], [obeyed])
    update = callback(home, "OnUpdate", "server")
    begun, updated = place(update, "Begun"), place(update, "Updated")
    page = callback(user, "OnTimer", "timer", 1.0)
    clients: dict[str, list[sym.ClientPort]] = {"command": [], "update": []}
    for where, name, entry, exit, service, group in (
        (update, "Forward", [begun], [updated], "command", None),
        (page, "Update", [], [], "update", own),
        (page, "Command", [], [], "command", None),
    ):
        request, response = place(where, f"{name}.request"), place(where, f"{name}.response")
        step(where, name, entry, [request])
        step(where, f"{name}.ends", [response], exit)
        port = sym.ClientPort(client=name, request=request, response=response, group=group)
        clients[service].append(port)
    for name, served, entry_place, exit_place in (
        ("command", obey, asked, obeyed),
        ("update", update, begun, updated),
    ):
        server = sym.ServerPort(page=served, entry=entry_place, exit=exit_place)
        channel = sym.ServiceChannel(
            id=name.title(), service=f"/{name}", server=server, clients=clients[name]
        )
        model.channels.append(channel)
    return model


def test_each_way_in_which_a_callback_waits_is_found() -> None:
    """That it waits for a circle of others is no proof that it is in none itself."""
    subject = base_subject(waiting_in_two_ways())
    waiting = Waiting(subject)
    search = searched(subject.net, waiting, Budget(seconds=60).begun())
    named = {circle.elements[0] for each in search.blocked if (circle := each.circle) is not None}
    assert named == {"OnUpdate", "OnTimer"}
    every = blocked(symbolic_state_space(subject.net), waiting)
    assert {each.circle.elements[0] for each in every if each.circle is not None} == named


@pytest.mark.long
@settings(
    max_examples=6,
    phases=[Phase.generate],
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)
@given(executor_models())
def test_what_is_proved_to_end_does(model: sym.SystemModel) -> None:
    """Where a search is complete, all markings agree of each callback that it does not name."""
    for transition in transitions(model):
        transition.overrides.clear()  # priorities are not analysed
    try:
        subject = base_subject(model)
        space = symbolic_state_space(subject.net, Budget(seconds=30).begun())
    except (DinerosError, UnknownBoundError, BudgetExceededError):
        assume(False)
    assume(space.complete)
    waiting = Waiting(subject)
    search = searched(subject.net, waiting, Budget(seconds=10).begun())
    assume(search.is_complete)
    named = {found.callback for found in search.blocked if found.circle is None}
    named.update(waiter for found in search.blocked if found.circle for waiter in found.circle.waiters)
    sets = SymbolicSets(space)
    for each in waiting.callbacks.values():
        if each.waiter not in named:
            assert not never_without(sets, each.places), each.waiter.text
