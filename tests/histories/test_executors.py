"""Timers, executors and callback groups: the design's figures, and generated models, step by step."""

from __future__ import annotations

from typing import get_args

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.analysis.model.subject import subject_of
from dineros.analysis.questions.state_space import state_space
from dineros.analysis.reductions import reduce
from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.constraints import validate
from dineros.transformations.flattening.flatten import Flattened, flatten
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.histories.comparing import variants
from tests.support.equal_behaviour import compare
from tests.support.references.executors import ExecutorInterpreter
from tests.support.references.flattening import PlainNet, plain_net_of
from tests.support.ros2_systems.executor_cases import FIGURES, Case, case_model
from tests.support.ros2_systems.executor_models import executor_models

AWAITING = [(Case(awaits=True), (12, 15, 1)), (Case(awaits=True, client="own"), (14, 20, 0))]
"""In one exclusive group an answer that is awaited does not come; else one thread is enough for it."""


@pytest.mark.long
@pytest.mark.parametrize("overflow", get_args(OverflowVariant))
@pytest.mark.parametrize(("case", "figures"), [*FIGURES, *AWAITING])
def test_the_figures(case: Case, figures: tuple[int, int, int], overflow: OverflowVariant) -> None:
    model = case_model(case)
    assert validate(model) == []
    assert ExecutorInterpreter(model).count() == figures
    net = subject_of(model, "none", overflow).net
    explicit, symbolic = state_space(net, "explicit"), state_space(net, "symbolic")
    assert (explicit.states, explicit.arcs, explicit.deadlocks) == figures
    assert (symbolic.states, symbolic.deadlocks) == (figures[0], figures[2])
    reduction = reduce(net, {"state_space_size"})
    smaller = state_space(reduction.net, "symbolic")
    assert smaller.states is not None
    assert smaller.states * reduction.count_factor == figures[0]


@pytest.mark.long
@given(
    executor_models(), st.sampled_from(get_args(SignalVariant)), st.sampled_from(get_args(OverflowVariant))
)
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_generated_models(model: sym.SystemModel, signals: SignalVariant, overflow: OverflowVariant) -> None:
    assert [found for found in validate(model) if found.severity == "error"] == []
    for _, _, found in variants(model, 200, [signals], [overflow]):
        assert found.difference == ""


@pytest.mark.parametrize("case", [Case(kind="reentrant", threads=2), Case(awaits=True, client="own")])
def test_a_difference_is_noticed(case: Case) -> None:
    model = case_model(case)
    flattened = flatten(model, "none")
    net, interpreter = plain_net_of(flattened.net), ExecutorInterpreter(model)
    made = _arcs(flattened, "C1", "C1Begins", "E3Tick", "E4", "E7Call")
    for number, (source, target, _, _) in enumerate(net.arcs):
        if f"{source}-{target}" in made:
            altered = PlainNet(net.places, net.transitions, [*net.arcs[:number], *net.arcs[number + 1 :]])
            found = compare(altered, interpreter, 200)
            assert found.difference or not found.complete, (source, target)


def _clock(
    middleware: str = "ros2", execution: str = "callbacks"
) -> tuple[sym.SystemModel, sym.CallbackPage]:
    model = sym.SystemModel(id="clock", middleware=middleware)
    net = sym.NodeNet(id="node", net=model, execution=execution)
    page = sym.CallbackPage(id="OnTimer", kind="timer", timer=1.0, page=net)
    return model, page


def _arcs(flattened: Flattened, *rules: str) -> set[str]:
    (page,) = flattened.net.pages
    return {arc.id for arc in page.arcs if flattened.trace.origin(arc).rule in rules}


def test_a_timer_of_one_transition_begins_and_ends_at_once() -> None:
    model, page = _clock()
    flow(sym.Transition(id="Work", page=page), sym.Place(id="Worked", page=page, capacity=2))
    flattened = flatten(model, "none")
    assert _arcs(flattened, "C1", "C1Begins") == {
        "OnTimer.idle-OnTimer.tick",
        "OnTimer.tick-OnTimer.due",
        "OnTimer.due-Work",
        "Work-OnTimer.idle",
    }
    assert _arcs(flattened, "E3Once", "E3OnceExclusive") == {"node.threads-Work-read", "node.lock-Work-read"}
    assert ExecutorInterpreter(model).count() == (6, 5, 1)


@pytest.mark.parametrize(("middleware", "execution"), [("ros1", "net"), ("ros2", "net")])
def test_what_does_not_run_callbacks_has_no_threads(middleware: str, execution: str) -> None:
    model, page = _clock(middleware, execution)
    flow(sym.Transition(id="Work", page=page), sym.Place(id="Worked", page=page, capacity=2))
    nodes = {node.id for node in flatten(model, "none").net.pages[0].objects}
    ticking = {"OnTimer.idle", "OnTimer.due", "OnTimer.tick"}
    assert nodes == {"Work", "Worked", "Worked.free"} | (ticking if middleware == "ros2" else set())


def _answered_apart(case: Case, group: str) -> sym.SystemModel:
    """Return a case in which another callback, in no group or one of the node's, has the response."""
    model = case_model(case)
    (timer,) = (each for each in model.eAllContents() if isinstance(each, sym.CallbackPage) and each.timer)
    node = timer.page
    assert isinstance(node, sym.NodeNet)
    named = next((each for each in node.callbackGroups if each.id == group), None)
    answered = sym.CallbackPage(id="OnAnswer", kind="client", page=node, group=named)
    for part in [each for each in timer.objects if each.id in ("Got", "Done")]:
        timer.objects.remove(part)
        answered.objects.append(part)
    (ask,) = (each for each in timer.objects if isinstance(each, sym.Place))
    ask.capacity = 1
    (arc,) = (arc for arc in timer.arcs if arc.id == "Got-Done")
    timer.arcs.remove(arc)
    answered.arcs.append(arc)
    return model


@pytest.mark.parametrize(
    ("group", "takes"),
    [("", []), ("A.own", ["A.own.lock"]), ("A.all", ["A.all.lock"])],
    ids=["as rclpy has it", "in a group of its own", "as rclcpp has it"],
)
def test_a_response_begins_a_callback(group: str, takes: list[str]) -> None:
    """It begins while no callback of the client's group runs, and holds only its own group's lock, if any."""
    model = _answered_apart(Case(), group.removeprefix("A."))
    model.channels[0].depth = 1  # type: ignore[attr-defined]  # the client does not wait
    assert [found.constraint for found in validate(model)] == ["response-callback-group"] * (group == "A.own")
    flattened = flatten(model, "none")
    response = "Work.client.timer.res"
    others = [] if group == "A.all" else [f"A.all.lock-{response}-read"]
    arcs = _arcs(flattened, "E6", "E6Exclusive", "E3Exclusive")
    assert {arc for arc in arcs if response in arc} == {
        f"A.threads-{response}",
        f"{response}-OnAnswer.running",
        *others,
        *(f"{lock}-{response}" for lock in takes),
    }
    found = compare(plain_net_of(flattened.net), ExecutorInterpreter(model), 1000)
    assert (found.complete, found.difference) == (True, "")
    assert ExecutorInterpreter(model).count()[2] == 0, "nothing waits for a thread that waits itself"


def test_the_certificate_says_who_has_threads_and_locks() -> None:
    net = flatten(case_model(Case(client="own", threads=2, answers=True)), "none").net
    found = {each.name: ({term.place.id for term in each.terms}, each.value) for each in net.certificate}
    assert found["A.threads or callbacks that run"] == (
        {"A.threads", "OnTimer.running", "Back[1].OnBack.running"},
        2,
    )
    assert found["A.all.lock or a callback that has begun"] == (
        {"A.all.lock", "OnTimer.running", "Back[1].OnBack.running"},
        1,
    )
    assert found["A.own.lock or a callback that has begun"] == ({"A.own.lock"}, 1)
    assert found["OnTimer.idle or due"] == ({"OnTimer.idle", "OnTimer.due"}, 1)


def test_words() -> None:
    subject = subject_of(case_model(Case(awaits=True, answers=True)), "none")
    words = {name: subject.place_text(subject.place_index[name]) for name in subject.net.places}
    assert words["A.threads"] == "a free thread of node net A"
    assert words["A.all.lock"] == "free callback group all of node net A"
    assert words["B.lock"] == "free default callback group of node net B"
    assert words["OnTimer.running"] == "callback OnTimer runs"
    assert words["Work[1].OnWork.running"] == "callback OnWork of server instance 1 runs"
    assert words["OnTimer.awaiting"] == "callback OnTimer awaits a response"
    assert words["OnTimer.due"] == "the timer of callback OnTimer is due"


def test_places_outside_of_callback_pages_are_no_part_of_a_callback() -> None:
    """A timer either counts up or down, by one transition of two: each is a whole callback."""
    model, page = _clock()
    count = sym.Place(id="Count", page=page.page, tokens=1, capacity=2)
    here = pn.ReferencePlace(id="CountHere", target=count, page=page)
    flow(sym.Transition(id="Up", page=page), here)
    flow(here, sym.Transition(id="Down", page=page))
    assert validate(model) == []
    flattened = flatten(model, "none")
    assert _arcs(flattened, "E3Once") == {"node.threads-Up-read", "node.threads-Down-read"}
    assert ExecutorInterpreter(model).count() == (6, 7, 0)
