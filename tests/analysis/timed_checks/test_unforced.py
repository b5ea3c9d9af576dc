"""Nets in which nothing ever has to fire: engines without times answer as regions and state classes do."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.questions.engines import Timed
from dineros.analysis.questions.net_questions import Branching, Enabled, Linear, Marking, Question
from dineros.analysis.timed.schedules import schedule
from dineros.analysis.timed_checks.timed_check import ask_timed, check_timed
from dineros.analysis.timed_checks.unforced import BY
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import find
from tests.analysis.timed.time_nets import RandomNet, random_net
from tests.analysis.timed_checks.test_timed_check import found, model_of
from tests.support.references.regions import RegionGraph, State
from tests.support.systems.talker import talker


def unforced_net(random: Random) -> RandomNet:
    """Return a random net with some earliest bounds, no latest ones, and at least 4 markings."""
    while True:
        net = random_net(random)
        steps = [replace(each, latest=None, is_open_above=False) for each in net.transitions]
        steps[0] = replace(steps[0], earliest=max(1, steps[0].earliest))
        net = replace(net, transitions=steps)
        try:
            if len(net.regions(3_000).markings) >= 4:
                return net
        except OverflowError:
            continue


@pytest.mark.parametrize("seed", range(25))
def test_a_check_answers_as_the_regions_do(seed: int) -> None:
    net = unforced_net(Random(seed))
    regions, report = net.regions(), Report()
    assert ask_timed(model_of(net), report) is None
    assert report.times is not None and report.by.endswith(BY)
    fires = {net.transitions[t].name for fired in regions.fires.values() for t, _ in fired}
    never = {one.name for one in net.transitions} - fires
    assert {each for one in found(report, "dead-transition") for each in one.elements} == never
    assert bool(found(report, "deadlock")) == any(not clocks for _, clocks in regions.fires)
    crowded = any(tokens > 1 for marking in regions.markings for tokens in marking)
    assert bool(found(report, "not-one-safe")) == crowded
    for finding in report.findings:
        if finding.witness is not None:
            assert all(step.time is not None for step in finding.witness.steps)


def reaching(regions: RegionGraph, goal: set[State]) -> set[State]:
    """Return the states from which one of some states can be reached."""
    before: dict[State, set[State]] = defaultdict(set)
    for state, later in regions.waits.items():
        before[later].add(state)
    for state, fired in regions.fires.items():
        for _, after in fired:
            before[after].add(state)
    known, todo = set(goal), list(goal)
    while todo:
        new = before[todo.pop()] - known
        known |= new
        todo += new
    return known


@pytest.mark.parametrize("seed", range(40))
def test_questions_about_markings_have_the_answers_of_regions(seed: int) -> None:
    random = Random(seed)
    made = unforced_net(random)
    net, regions = made.net, made.regions()
    fires = regions.fires
    names, budget = NetNames(net.untimed), Budget(seconds=60)
    p, q = random.sample(range(len(net.untimed.places)), 2)
    tokens, t = random.randint(1, 2), random.randrange(3)
    condition, every = f"p{p} + p{q} >= {tokens}", set(fires)
    many = {state for state in every if state[0][p] + state[0][q] >= tokens}
    one = {state for state in every if state[0][p] >= 1}
    other = {state for state in every if state[0][q] >= 1}
    ends = {state for state in every if not state[1]}
    steps = {state for state in every if any(fired == t for fired, _ in fires[state])}
    stays_away = every - reaching(regions, many)
    asked: list[tuple[Question, bool]] = [
        (Marking(net.untimed, names, condition), bool(many)),
        (Enabled(net.untimed, names, f"t{t}"), bool(steps)),
        (Linear(net.untimed, names, f"G !(fired(t{t}) & p{p} >= 1)"), not steps & one),
        (Branching(net.untimed, names, f"AG EF ({condition})"), not stays_away),
        (Branching(net.untimed, names, f"EF AG !({condition})"), bool(stays_away)),
        (Branching(net.untimed, names, f"AG (p{p} >= 1 -> EF p{q} >= 1)"), one <= reaching(regions, other)),
        (Branching(net.untimed, names, f"EF (deadlock & {condition})"), bool(ends & many)),
    ]
    for question, expected in asked:
        answer = Timed(net).answer(question, budget)
        assert (answer.status in ("reachable", "holds")) == expected, question
        assert answer.status != "unknown" and answer.by.endswith("without times"), question
        schedule(net, answer.stem)


def test_what_a_run_may_leave_undone_is_asked_with_times() -> None:
    """With times, a run may stay where nothing has to fire: what comes without times need not come."""
    model = talker()
    find(model, "Say", sym.Transition).interval = pn.TimeInterval(earliest=1)
    model.properties.append(sym.Property(id="comes", text="Noted >= 1 happens"))
    model.properties.append(sym.Property(id="late", text="fired(Say) leads to Noted >= 1 within 5"))
    model.properties.append(sym.Property(id="stays", text="never Noted >= 9"))
    report = check_timed(model)
    assert not report.unknown
    violated = {each.elements[0] for each in found(report, "property-violated")}
    assert violated == {"comes", "late"}
    assert any("property stays holds" in line for line in report.proved)


def test_a_latest_bound_forces() -> None:
    model = talker()
    find(model, "Say", sym.Transition).interval = pn.TimeInterval(earliest=1, latest=2)
    assert ask_timed(model, Report()) is not None
