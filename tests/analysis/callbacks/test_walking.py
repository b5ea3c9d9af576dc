"""Callbacks that wait forever where not all markings can be seen."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.callbacks.walking import Walks
from dineros.analysis.checks.check import check
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import transitions
from dineros.metamodel.errors import DinerosError
from examples.callbacks.models import PROGRAMS, program
from tests.analysis.callbacks.test_waiting import CIRCLES
from tests.support.ros2_systems.executor_models import executor_models

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
    others = "every other callback" if circles else "every callback"
    assert f"{others} that has begun can end" in report.proved


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
        assert each.circle is None or waiting.circle(last) == each.circle


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
