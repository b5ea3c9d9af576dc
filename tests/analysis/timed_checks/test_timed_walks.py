"""Random runs with times: each is a run of the net, and what they meet is found in a net of any size."""

from __future__ import annotations

from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.checks.unused import TRANSITION
from dineros.analysis.consequences.folding import fold_consequences
from dineros.analysis.consequences.in_time import gone_in_time
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.nets.witness import replay
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.schedules import schedule
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.analysis.timed_checks.timed_walks import Walked, walk_in_time, walk_late, walk_towards
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import sym
from dineros.metamodel.build import flow, seconds
from examples.callbacks.models import node, program, timer
from tests.analysis.callbacks.test_waiting import CIRCLES
from tests.analysis.timed.time_nets import lively_net

FEW = Budget(seconds=60, states=4)


@pytest.mark.parametrize("seed", range(60))
def test_every_run_has_a_schedule(seed: int) -> None:
    net = lively_net(Random(seed), has_priorities=seed % 2 == 0).net
    walked = walk_in_time(net, Budget(seconds=60), runs=6, steps=60)
    assert len(walked.runs) == 6
    for run in walked.runs:
        schedule(net, run)
    for transition, way in walked.ways.items():
        assert way[-1] == transition and transition not in way[:-1]


@pytest.mark.parametrize("seed", range(40))
def test_runs_meet_a_part_of_what_all_classes_have(seed: int) -> None:
    net = lively_net(Random(seed), has_priorities=seed % 3 == 0).net
    explored = explore_timed(net, Budget(seconds=60))
    walked = walk_in_time(net, Budget(seconds=60), runs=6, steps=100)
    assert walked.ways.keys() <= explored.ways.keys()
    ends = {tuple(explored.markings[row].tolist()) for row, _ in explored.ends}
    for run in walked.ends:
        assert tuple(replay(net.untimed, run)[-1]) in ends


def queue_net(end: Interval) -> TimedNet:
    """A message in each second, and a reader that takes so long; 40 messages that wait overflow."""
    at_once = Interval(latest=Fraction(0))
    return TimedNet.build(
        {"timer": 1, "queue": 0, "idle": 1, "busy": 0},
        [
            Transition("strike", {"timer": 1}, {"timer": 1, "queue": 1}),
            Transition("begin", {"queue": 1, "idle": 1}, {"busy": 1}),
            Transition("end", {"busy": 1}, {"idle": 1}),
            Transition("overflow", {"queue": 40}, {}),
        ],
        {
            "strike": Interval(Fraction(1), Fraction(1)),
            "begin": at_once,
            "end": end,
            "overflow": at_once,
        },
    )


def test_a_queue_fills_up_where_its_reader_is_slow() -> None:
    net = queue_net(Interval())
    walked = walk_in_time(net, Budget(seconds=60), runs=2, steps=200)
    assert 3 not in walked.ways
    walk_towards(net, [3], walked, Budget(seconds=60))
    way = walked.ways[3]
    assert way.count(0) >= 40
    schedule(net, way)


def test_a_queue_does_not_fill_up_where_its_reader_is_quick() -> None:
    net = queue_net(Interval(latest=Fraction(1, 2)))
    walked = walk_in_time(net, Budget(seconds=60), runs=6, steps=400)
    walk_towards(net, [3], walked, Budget(seconds=60))
    assert walked.ways.keys() == {0, 1, 2}


def clocked(name: str) -> sym.SystemModel:
    """A program beside a clock that never waits, with times."""
    model = program(name)
    page = timer(node(model, "clock"), 1.0)
    page.id = "OnClock"
    page.duration = seconds(0, 0.1)
    flow(sym.Transition(id="Tick", page=page))
    return model


def circles(report: Report) -> list[Finding]:
    return [each for each in report.findings if each.rule == "callback-deadlock"]


def test_a_circle_is_found_though_there_are_too_many_classes() -> None:
    model = clocked("same_group")
    report = check_timed(model, FEW)
    (finding,) = circles(report)
    assert finding.message == CIRCLES["same_group"]
    assert finding.witness is not None and finding.witness.subject is not None
    index = finding.witness.subject.transition_index
    trace = [index[step.transition] for step in finding.witness.steps]
    schedule(timed_base_subject(model).timed, trace)
    assert "random runs" in report.by
    fold_consequences(model, report, Budget(seconds=60), again=gone_in_time)
    (finding,) = circles(report)
    assert ("NoteLevel",) in {each.elements for each in finding.consequences}
    assert ("NoteLevel",) not in {each.elements for each in report.findings}


def test_no_circle_is_found_where_there_is_none() -> None:
    assert not circles(check_timed(clocked("own_group"), FEW))


def test_what_can_be_used_once_its_cause_is_gone_is_a_consequence() -> None:
    """In the model that is fixed a transition fires in time; another one never does."""
    model = program("own_group")
    page = timer(node(model, "idle"), 1.0)
    page.id = "OnIdle"
    page.duration = seconds(0, 0.1)
    unused = sym.Transition(id="Unused", page=page)
    flow(sym.Place(id="Empty", page=page), unused)
    some = [
        TRANSITION.found("Unused", transition="Unused", where=""),
        TRANSITION.found("AskLevel", transition="AskLevel", where=""),
    ]
    assert gone_in_time(model, (), some, Budget(seconds=60)) == some[1:]


@pytest.mark.parametrize(("scale", "room"), [(1, 10), (1 << 36, 0)])
def test_a_queue_that_fills_up_slowly_overflows_in_a_late_run(scale: int, room: int) -> None:
    """A machine works for all of its period, and then rests for a moment: each round it is later by one.

    The schedule of such a run took hours, as the lateness of each round follows from all rounds before. Large
    bounds are counted with Python's integers.
    """
    steps = [
        Transition("strike", {"clock": 1}, {"clock": 1, "due": 1}),
        Transition("arrive", {"due": 1, "free": 1}, {"queue": 1}),
        Transition("lose", {"due": 1}, {}, inhibitors={"free": 1}),
        Transition("begin", {"queue": 1, "idle": 1}, {"works": 1, "free": 1}),
        Transition("end", {"works": 1}, {"rests": 1}),
        Transition("rested", {"rests": 1}, {"idle": 1}),
    ]
    now, work = Interval(Fraction(0), Fraction(0)), Interval(Fraction(100 * scale), Fraction(100 * scale))
    times = {"strike": work, "arrive": now, "lose": now, "begin": now, "end": work}
    times["rested"] = Interval(Fraction(0), Fraction((1 if room else 60) * scale))
    places = {"clock": 1, "due": 0, "free": room or 1, "queue": 0, "idle": 1, "works": 0, "rests": 0}
    net = TimedNet.build(places, steps, times)
    found = Walked()
    walk_late(net, found, UNLIMITED)
    way = found.ways[2]
    # Each round takes 101, so after 1000 rounds 1010 strikes came.
    assert len(way) > 5_000 if room else len(way) < 100
    last = schedule(net, way)[-1]
    assert last.transition == 2
    assert not last.at % (100 * scale)
