"""Callbacks that wait for each other: found exactly where they block, and told as a circle."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, assume, given, settings

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.blocking import blocked
from dineros.analysis.callbacks.circles import Circle
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.checks.check import check
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.witness import replay
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, place, step
from dineros.metamodel.constraints import validate
from dineros.metamodel.errors import DinerosError
from examples.callbacks.models import PROGRAMS, asking, node, program, server, service, timer
from tests.runtime.ros.test_callbacks import BLOCK, KEEPS, LOSES, RUN
from tests.support.references.histories import TooManyStatesError
from tests.support.ros2_systems.blocking_callbacks import some_waits_for_ever
from tests.support.ros2_systems.executor_cases import FIGURES, Case, case_model
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.waiting_models import awaiting_result, sharing_a_lock

MONITOR = (
    "deadlock in node monitor: timer callback OnTimer blocks in a call of service level; the response needs"
)
CIRCLES = {
    "same_group": f"{MONITOR} the default callback group, which OnTimer itself holds",
    "one_thread": f"{MONITOR} the only thread, which OnTimer itself holds",
    "reentrant": f"{MONITOR} one of the 2 threads, all of which OnTimer itself holds",
    "awaiting": f"{MONITOR} the default callback group, which OnTimer itself holds",
    "answer_one_thread": "deadlock in node monitor: answer callback OnLevel blocks in a call of service "
    "level; the response needs the only thread, which OnLevel itself holds",
    "calling_each_other": "deadlock in node planner: service callback OnRoute (instance 1) blocks in a call "
    "of service position; the response needs the default callback group and the only thread, which OnRoute "
    "(instance 1) itself holds",
}


def found(model: sym.SystemModel, *rules: str) -> list[Finding]:
    return [each for each in check(model, Budget(seconds=60)).findings if each.rule in rules]


def circles(model: sym.SystemModel) -> list[Circle | None]:
    """Return the circles of a model; each is closed where its witness leads."""
    subject = base_subject(model)
    waiting, space = Waiting(subject), symbolic_state_space(subject.net)
    each = list(blocked(space, waiting))
    assert [waiting.circle(replay(subject.net, one.trace)[-1], one.callback) for one in each] == [
        one.circle for one in each
    ]
    return [one.circle for one in each]


@pytest.mark.long
@pytest.mark.parametrize("name", PROGRAMS)
def test_programs_block_or_lose_where_check_says(name: str) -> None:
    """What real rclpy does with each program, `tests/runtime/ros/test_callbacks.py` sees."""
    model = program(name)
    assert [problem for problem in validate(model) if problem.severity == "error"] == []
    blocking, losing = found(model, "deadlock", "callback-deadlock", "callback-never-ends"), name == LOSES
    assert [finding.message for finding in blocking] == ([CIRCLES[name]] if name in BLOCK else [])
    assert bool(found(model, "queue-overflow")) == losing
    assert {*BLOCK, *RUN, LOSES, KEEPS} == set(PROGRAMS)


@pytest.mark.long
@pytest.mark.parametrize("case", [case for case, _ in FIGURES], ids=str)
def test_an_independent_reading_blocks_alike(case: Case) -> None:
    """In the graph of the interpreter, a callback waits forever where no way leads to its end."""
    model = case_model(case)
    assert bool(circles(model)) == some_waits_for_ever(model)
    assert None not in circles(model)


@pytest.mark.long
@settings(max_examples=5, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow])
@given(executor_models())
def test_generated_models_block_alike(model: sym.SystemModel) -> None:
    for part in model.eAllContents():
        if isinstance(part, sym.Transition):
            part.clause = None  # the interpreter leaves them out; `check` knows those that can never be true
    try:
        subject, waits = base_subject(model), some_waits_for_ever(model, most=400)
    except (DinerosError, TooManyStatesError):
        assume(False)
    found = list(blocked(symbolic_state_space(subject.net), Waiting(subject)))
    assert bool(found) == waits


def test_a_circle_is_found_while_other_nodes_go_on() -> None:
    model = program("same_group")
    page = timer(node(model, "clock"), 1.0)
    page.id = "OnClock"
    flow(sym.Transition(id="Tick", page=page))
    assert found(model, "deadlock") == []
    (finding,) = found(model, "callback-deadlock")
    assert finding.message == CIRCLES["same_group"]
    assert finding.elements == ("OnTimer", "Level", "monitor")
    assert finding.circle[-1] == "the default callback group of node monitor"


def test_two_nodes_that_ask_each_other() -> None:
    """Each runs alone; both at once wait for each other."""
    model = sym.SystemModel(id="both", middleware="ros2")
    pages = {}
    for name in ("left", "right"):
        owner = node(model, name)
        pages[name] = owner, server(owner, name.title(), f"Work{name}")[0], timer(owner, 1.0)
        pages[name][2].id = f"OnTimer{name}"
    for name, other in (("left", "right"), ("right", "left")):
        owner, _, page = pages[name]
        client = asking(page, f"Of{name}")
        client.group = sym.CallbackGroup(id=f"answers_{name}")
        owner.callbackGroups.append(client.group)
        owner.executor, owner.threads = sym.Executor.multi, 2
        service(model, other.title(), pages[other][1], client)
    (circle,) = circles(model)
    assert [waiter.kind for waiter in circle.waiters] == ["callback", "response", "group"] * 2  # type: ignore[union-attr]
    assert circle is not None and circle.elements == (
        "OnTimerleft",
        "Right",
        "right",
        "OnTimerright",
        "Left",
        "left",
    )


def test_threads_that_several_callbacks_have() -> None:
    model = case_model(Case(kind="reentrant", threads=2, timers=2))
    texts = [str(circle) for circle in circles(model)]
    assert (
        "deadlock in node A: timer callback OnTimer blocks in a call of service /work; the response needs "
        "one of the 2 threads, all of which OnTimer and timer callback OnTimer1 hold; OnTimer1 blocks in a "
        "call of service /work"
    ) in texts


def test_every_reason_is_named() -> None:
    """Two server instances and a timer share two threads and a lock: those that hold are named."""
    texts = [str(circle) for circle in circles(sharing_a_lock())]
    start = "deadlock in node n: "
    assert texts[0] == (
        f"{start}service callback OnWork (instance 1) waits for a token in place Lock, which timer callback "
        "OnTimer holds; OnTimer blocks in a call of service /work; the response has to come from OnWork "
        "(instance 1)"
    )
    assert texts[2] == (
        f"{start}timer callback OnTimer blocks in a call of service /work; the response has to come from "
        "service callback OnWork (instance 2), or needs one of the 2 threads, all of which OnWork (instance "
        "2) and OnTimer hold; OnWork (instance 2) waits for a token in place Lock, which OnTimer itself holds"
    )
    by_lock, by_threads = found(sharing_a_lock(), "callback-deadlock")
    assert [by_lock.message, by_threads.message] == [texts[0], texts[2]], "instances are alike"
    response = "the response of service /work to client own"
    assert by_threads.to_dict()["waits"][1] == {
        "waits": response,
        "for": ["one of the 2 threads of node n", "service callback OnWork (instance 2)"],
        "enough": "one",
    }


def test_a_callback_that_waits_for_a_result() -> None:
    """It holds the thread and the group that the result of its goal needs."""
    model = awaiting_result()
    (finding,) = found(model, "callback-deadlock", "callback-never-ends", "deadlock")
    assert finding.message == (
        "deadlock in node boss: timer callback OnTimer blocks for the result of action /act; the result "
        "needs the default callback group and the only thread, which OnTimer itself holds"
    )
    assert finding.to_dict()["waits"] == [
        {
            "waits": "timer callback OnTimer",
            "for": ["the result of action /act for client boss"],
            "enough": "all",
        },
        {
            "waits": "the result of action /act for client boss",
            "for": ["the default callback group of node boss", "the only thread of node boss"],
            "enough": "all",
        },
        *(
            {"waits": each, "for": ["timer callback OnTimer"], "enough": "all"}
            for each in ("the default callback group of node boss", "the only thread of node boss")
        ),
    ]


@pytest.mark.parametrize("awaits", [False, True])
def test_a_goal_that_waits_for_the_one_that_sent_it(awaits: bool) -> None:
    """What works on it is in the same node: it cannot be accepted, or, where it awaits, not continue."""
    model = awaiting_result(threads=1, same=True, awaits=awaits)
    (finding,) = found(model, "callback-deadlock", "callback-never-ends")
    assert "timer callback OnTimer blocks for the result of action /act" in finding.message
    assert "the only thread" in finding.message and "which OnTimer itself holds" in finding.message
    assert not found(awaiting_result(threads=2, same=True, awaits=awaits, own=True), "callback-deadlock")


def test_a_callback_that_waits_for_nobody() -> None:
    """It waits for a token that nothing makes; that is not a circle."""
    model = sym.SystemModel(id="alone", middleware="ros2")
    page = timer(node(model, "n"), 1.0)
    never, between = sym.Place(id="Never", page=page), sym.Place(id="Between", page=page)
    end = sym.Transition(id="End", page=page)
    flow(sym.Transition(id="Begin", page=page), between, end)
    flow(never, end)
    (finding,) = found(model, "callback-never-ends")
    assert finding.message == "timer callback OnTimer can begin and never end"


def test_a_callback_that_waits_for_one_of_its_group() -> None:
    """A flag that another callback of the same group would set."""
    model = sym.SystemModel(id="flag", middleware="ros2")
    owner = node(model, "n", threads=2)
    first, second = timer(owner, 1.0), timer(owner, 1.0)
    second.id = "OnOther"
    flag, between, go_on = (
        sym.Place(id="Flag", page=first, capacity=1),
        sym.Place(id="Between", page=first),
        sym.Transition(id="GoOn", page=first),
    )
    flow(sym.Transition(id="Begin", page=first), between, go_on)
    flow(flag, go_on)
    flow(sym.Transition(id="Set", page=second), pn.ReferencePlace(id="Flag@", target=flag, page=second))
    (circle,) = circles(model)
    assert str(circle) == (
        "deadlock in node n: timer callback OnTimer waits for a token in place Flag, which timer callback "
        "OnOther would give; OnOther needs the default callback group, which OnTimer holds"
    )


def test_a_callback_ends_that_publishes_after_its_node_was_shut_down() -> None:
    """The node is shut down by another thread, outside of the callback's group; the message is lost."""
    model = sym.SystemModel(id="cameras", middleware="ros2")
    camera = sym.NodeNet(
        id="camera", net=model, execution="callbacks", executor="multi", threads=2,
        lifecycle=sym.Lifecycle(cleansUp=True, shutsDown=True),
    )  # fmt: skip
    page = callback(camera, "OnTick", "timer", 0.1)
    page.group = sym.CallbackGroup(id="own")
    camera.callbackGroups.append(page.group)
    runs, image = place(page, "Runs"), place(camera, "Image")
    begin, publish = step(page, "Begin", [], [runs]), step(page, "Publish", [runs], [image])
    begin.kind, publish.kind = "start", "end"
    model.channels.append(
        sym.TopicChannel(id="Images", topic="/image", publishers=[sym.PublisherPort(place=image)])
    )
    assert [each for each in validate(model) if each.severity == "error"] == []
    assert found(model, "callback-never-ends") == []
    assert "every callback that has begun can end" in check(model).proved
