"""What is proved without times if there are too many state classes: no more than what holds with times."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.questions.engines import Timed
from dineros.analysis.questions.net_questions import Branching, Linear, Marking
from dineros.analysis.timed.exploring import explore_timed, fire_far_away
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.schedules import schedule
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.analysis.timed_checks.without_times import time_goes_on
from dineros.metamodel import files, sym
from dineros.metamodel.build import seconds
from dineros.metamodel.elements import find, node_net_of
from tests.analysis.timed.time_nets import lively_net
from tests.analysis.timed_checks.test_timed_check import model_of

FEW = Budget(seconds=60, states=4)


@pytest.mark.parametrize("seed", range(60))
def test_nothing_is_proved_that_is_not_so(seed: int) -> None:
    """A search that ends after a few classes proves and finds a part of what the whole one does."""
    net = model_of(lively_net(Random(seed), has_priorities=seed % 3 == 0))
    whole, part = check_timed(net, Budget(seconds=60)), check_timed(net, FEW)
    if whole.unknown:
        return
    for text in part.proved:
        assert "without its times" in text or text in whole.proved, text
    found = {(each.rule, each.elements) for each in whole.findings}
    assert {(each.rule, each.elements) for each in part.findings if each.rule != "dead-transition"} <= found


@pytest.mark.parametrize("seed", range(60))
def test_questions_have_the_answers_of_all_classes(seed: int) -> None:
    random = Random(seed)
    net = lively_net(random, has_priorities=seed % 3 == 0).net
    names = NetNames(net.untimed)
    condition = f"p0 + p1 >= {random.randint(1, 3)}"
    step = f"!fired(t{random.randrange(3)})"
    for question in (
        Marking(net.untimed, names, condition),
        Linear(net.untimed, names, f"G !({condition})"),
        Linear(net.untimed, names, f"G {step}"),
        Branching(net.untimed, names, f"AG !({condition})"),
    ):
        all_classes = Timed(net).answer(question, Budget(seconds=60))
        few = Timed(net).answer(question, FEW)
        assert few.status in ("unknown", all_classes.status), question


@pytest.mark.parametrize("seed", range(40))
def test_what_fires_far_away_has_a_schedule(seed: int) -> None:
    net = lively_net(Random(seed), has_priorities=seed % 3 == 0).net
    all_ways = explore_timed(net, Budget(seconds=60)).ways
    ways, others = fire_far_away(net, (), Budget(seconds=60))
    assert ways.keys() == all_ways.keys() and not others
    for way in ways.values():
        schedule(net, way)


def test_weights_prove_that_time_goes_on() -> None:
    now = Interval(latest=Fraction(0))
    falls = Transition("falls", {"high": 1}, {"low": 3})
    ends = Transition("ends", {"low": 2}, {})
    rises = Transition("rises", {"low": 1}, {"high": 1})
    places = {"high": 1, "low": 0}
    assert time_goes_on(TimedNet.build(places, [falls, ends], {"falls": now, "ends": now}))
    assert time_goes_on(TimedNet.build(places, [falls, ends, rises], {"falls": now, "ends": now}))
    assert not time_goes_on(TimedNet.build(places, [falls, rises], {"falls": now, "rises": now}))


def test_the_timer_of_a_managed_node_runs_while_it_is_configured() -> None:
    """Its strikes do not gather while the node is not configured, and none of them counts as missed."""
    model = files.load(Path(__file__).parents[3] / "examples/callbacks/sensor.sym.xmi")
    assert isinstance(model, sym.SystemModel)
    page = find(model, "OnTimer")
    assert isinstance(page, sym.CallbackPage)
    page.duration = seconds(0, 0.001)
    node = node_net_of(page)
    assert node is not None
    node.lifecycle = sym.Lifecycle(cleansUp=True)
    explored = explore_timed(timed_base_subject(model).timed, Budget(seconds=100))
    assert explored.is_complete
    names = explored.net.untimed.places
    struck, due = (explored.markings[:, names.index(f"OnTimer.{each}")] for each in ("struck", "due"))
    assert struck.max() == 1 and due.max() == 1
    fired = {explored.net.untimed.transitions[t] for t in explored.ways}
    assert {"OnTimer.tick", "OnTimer.gone"} <= fired
    assert "OnTimer.miss" not in fired
