"""Consequences of several causes together name all of them, and no others."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks import searching
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.callbacks.walking import Walks
from dineros.analysis.consequences import circle_fixes
from dineros.analysis.consequences.together import fewest_causes
from dineros.analysis.model.subject import base_subject
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, node_net, place, step
from dineros.metamodel.clauses import set_clause
from tests.analysis.consequences.test_folding import consequences, faults, folded

pytestmark = pytest.mark.usefixtures("own_time")  # folding a cause has a share of the time


def lamps(*sizes: int) -> sym.SystemModel:
    """Return nodes in which so many transitions in a row have clauses that can never be true."""
    model = sym.SystemModel(id="lamps", middleware="ros2")
    for number, size in enumerate(sizes, 1):
        lamp = sym.NodeNet(id=f"lamp{number}", net=model)
        sym.InputSignal(id=f"dark{number}", node=lamp)
        before = sym.Place(id=f"Off{number}", tokens=1, page=lamp)
        for step_number in range(1, size + 1):
            dark = sym.Transition(id=f"Dark{number}_{step_number}", page=lamp)
            set_clause(dark, f"dark{number} & !dark{number}")
            after = sym.Place(id=f"Step{number}_{step_number}", page=lamp)
            flow(before, dark, after)
            before = after
        flow(before, sym.Transition(id=f"Shine{number}", page=lamp), sym.Place(id=f"On{number}", page=lamp))
    return model


def together(finding: Finding, transition: str) -> list[str]:
    """Return the causes that must be fixed, too, before a transition can fire."""
    (names,) = [
        [other.elements[0] for other in each.together]
        for each in finding.consequences
        if (each.rule, each.elements[0]) == ("dead-transition", transition)
    ]
    return names


def test_what_two_causes_have_in_common() -> None:
    """It is gone only where both are fixed, and is listed under the first, with the other one."""
    report = folded(lamps(2))
    assert faults(report.findings) == ["unsatisfiable-clause"] * 2
    assert ("dead-transition", "Shine1") in consequences(report.findings[0])
    assert together(report.findings[0], "Shine1") == [report.findings[1].elements[0]]
    assert together(report.findings[0], report.findings[0].elements[0]) == []
    assert consequences(report.findings[1]) == []


def test_a_consequence_of_two_causes_names_no_third_one() -> None:
    report = folded(lamps(2, 1, 3))
    causes = {each.elements[0]: each for each in report.findings if each.severity != "note"}
    assert {each.rule for each in causes.values()} == {"unsatisfiable-clause"}
    listed = {
        each.elements[0]: {cause.elements[0], *(other.elements[0] for other in each.together)}
        for cause in causes.values()
        for each in cause.consequences
        if each.rule == "dead-transition"
    }
    assert listed["Shine1"] == {"Dark1_1", "Dark1_2"}
    assert listed["Shine2"] == {"Dark2_1"}
    assert listed["Shine3"] == {"Dark3_1", "Dark3_2", "Dark3_3"}


def test_the_fewest_causes_of_each_consequence() -> None:
    """Compared with all subsets; a consequence is gone if one of its sets of causes is fixed."""
    for seed in range(200):
        chance = Random(seed)
        causes = list(range(chance.randint(2, 5)))
        needs = {
            name: [set(chance.sample(causes, chance.randint(2, len(causes)))) for _ in range(2)]
            for name in "abc"
        }

        def gone(
            some: Sequence[int], names: Sequence[str], needs: dict[str, list[set[int]]] = needs
        ) -> list[str]:
            return [name for name in names if any(each <= set(some) for each in needs[name])]

        groups = fewest_causes(causes, list(needs), gone)
        assert sorted(name for _, names in groups for name in names) == ["a", "b", "c"]
        for chosen, names in groups:
            for name in names:
                assert gone(chosen, [name])
                assert len(chosen) == 2 or not any(
                    gone([e for e in chosen if e != left], [name]) for left in chosen
                )


def calling_either() -> sym.SystemModel:
    """Return a timer that calls one of two services and waits; the second server waits for itself."""
    model = sym.SystemModel(id="hidden", middleware="ros2")
    robot = node_net(model, "robot", execution="callbacks")
    page = callback(robot, "OnTimer", "timer", timer=1.0)
    begun, had = place(page, "Begun"), place(page, "Had")
    step(page, "Tick", [], [begun]).kind = sym.TransitionKind.start
    step(page, "End", [had], []).kind = sym.TransitionKind.end
    servers = [
        callback(node_net(model, f"node{n}", execution="callbacks"), f"Serve{n}", "server") for n in (1, 2, 3)
    ]
    first = call(model, page, servers[0], begun, had)
    second = call(model, page, servers[1], begun, had)
    third = call(model, servers[1], servers[2], second.entry, second.exit)
    for port in (first, third):
        step(port.page, f"Answer{port.page.id[-1]}", [port.entry], [port.exit])
    return model


def call(
    model: sym.SystemModel,
    page: sym.CallbackPage,
    server: sym.CallbackPage,
    before: pn.Place,
    after: pn.Place,
) -> sym.ServerPort:
    """Let a callback call a service and wait for its response; return the port of its server."""
    number = server.id.removeprefix("Serve")
    request, response = place(page, f"Request{number}"), place(page, f"Response{number}")
    waits = place(page, f"Waits{number}")
    step(page, f"Ask{number}", [before], [request, waits])
    step(page, f"Has{number}", [response, waits], [after])
    asked, answered = place(server, f"Asked{number}"), place(server, f"Answered{number}")
    client = sym.ClientPort(client=f"{page.id}{number}", request=request, response=response)
    port = sym.ServerPort(page=server, entry=asked, exit=answered)
    service = sym.ServiceChannel(id=f"S{number}", service=f"/s{number}", server=port, clients=[client])
    model.channels.append(service)
    return port


@pytest.mark.long
def test_a_circle_that_others_hide_is_a_cause_together_with_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second call waits for the own thread, too, which shows only if its server ever answers."""
    monkeypatch.setattr(circle_fixes, "MOST_MODELS", 0)  # time-outs only, which fix one call each
    report = folded(calling_either(), Budget(seconds=300))
    causes = {each.elements[0]: each for each in report.findings if each.severity != "note"}
    assert {each.rule for each in causes.values()} == {"callback-deadlock"}
    listed = {
        each.elements[0]: [other.message for other in each.together]
        for cause in causes.values()
        for each in cause.consequences
    }
    assert listed["Has1"] == listed["Has3"] == []
    (hidden,) = listed["Has2"]
    assert hidden.startswith("found if others are fixed: deadlock in node robot")
    assert "/s2" in hidden


@pytest.mark.long
def test_a_change_after_which_no_run_shows_the_circle_is_not_taken_for_a_remedy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A callback that can wait forever, though no run closes its circle, is not settled."""
    subject = base_subject(calling_either())
    monkeypatch.setattr(Walks, "after", lambda *_: [])
    monkeypatch.setattr(Walks, "closed_after", lambda *_: None)
    monkeypatch.setattr(Walks, "found", lambda *_: [])
    search = searching.searched(subject.net, Waiting(subject), Budget(seconds=60).begun(), {"OnTimer"})
    assert search.blocked == ()
    assert not search.is_complete
    assert not search.is_settled
