"""Public reports, with times: no alarm for the healthy setting, the right finding for the sick one."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.consequences.folding import fold_consequences
from dineros.analysis.consequences.in_time import gone_in_time
from dineros.analysis.consequences.precautions import about_precautions
from dineros.analysis.timed_checks.timed_check import ask_timed, check_timed
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import sym
from dineros.metamodel.build import callback, here, inhibit, node_net, place, read, seconds, step
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from tests.support.ros2_systems import late_answers

QUICK = (0.0, 0.001)
"""How long middleware takes, in seconds."""


def findings(model: sym.SystemModel) -> set[str]:
    """Return the rules of which a check with times finds something; all questions have answers."""
    assert [each for each in validate(model) if each.severity == "error"] == []
    report = check_timed(model)
    assert not report.unknown, report.unknown
    return {each.rule for each in report.findings}


def talks(
    model: sym.SystemModel, id: str, out: sym.Place, heard: sym.Place, limit: int = 10
) -> sym.TopicChannel:
    return sym.TopicChannel(
        id=id,
        topic=f"/{id.lower()}",
        publishers=[sym.PublisherPort(place=out, limit=limit)],
        subscribers=[sym.SubscriberPort(place=heard, limit=limit)],
        latency=seconds(*QUICK),
        model=model,
    )


def timer(node: sym.NodeNet, id: str, period: float, work: tuple[float, float] = QUICK) -> sym.CallbackPage:
    page = callback(node, id, "timer")
    page.timer, page.offset, page.duration = period, seconds(0, 0), seconds(*work)
    return page


def slow_timer(work: float, threads: int = 1, order: str = "rclpy") -> sym.SystemModel:
    """A timer of 100 ms works for some time; a subscription of its group copies what comes each 0.4 s."""
    model = sym.SystemModel(id="slow_timer", middleware="ros2")
    page = timer(node_net(model, "source", execution="callbacks"), "OnSend", 0.4)
    sent = place(page, "Sent")
    step(page, "Send", [], [sent])
    worker = node_net(model, "worker", execution="callbacks", threads=threads, order=order)
    step(timer(worker, "OnProcess", 0.1, (work, work)), "Process")
    copy = callback(worker, "OnData")
    copy.duration = seconds(0.001, 0.001)
    data = place(copy, "Data")
    step(copy, "Copy", [data])
    talks(model, "Data_", sent, data)
    model.properties.append(
        sym.Property(id="DataIsCopied", text="Data_.reader.Data.Load >= 1 leads to fired(Copy)")
    )
    return model


@pytest.mark.long
@pytest.mark.parametrize(
    ("work", "threads", "order", "starves"),
    [
        (0.01, 1, "rclpy", False),
        (0.01, 4, "rclpy", False),
        (0.12, 1, "rclpy", False),
        (0.12, 1, "any", True),
        (0.12, 4, "rclpy", True),
    ],
)
def test_a_timer_slower_than_its_period(work: float, threads: int, order: str, starves: bool) -> None:
    """Its callback runs less often in any case; whether the other one starves depends on the order."""
    slow = {"timer-loses-ticks"} if work > 0.1 else set()
    starving = {"queue-overflow", "property-violated"} if starves else set()
    assert findings(slow_timer(work, threads, order)) == slow | starving


def camera(work: tuple[float, float], period: float = 0.03) -> sym.SystemModel:
    """A camera publishes an image each 30 ms; a node keeps it for some time."""
    model = sym.SystemModel(id="images", middleware="ros2")
    page = timer(node_net(model, "camera", execution="callbacks"), "OnFrame", period)
    image = place(page, "ImageOut")
    step(page, "Grab", [], [image])
    keep = callback(node_net(model, "fusion", execution="callbacks"), "OnImage")
    keep.duration = seconds(*work)
    came = place(keep, "ImageIn")
    step(keep, "Keep", [came])
    talks(model, "Images", image, came, limit=2)
    return model


@pytest.mark.long
def test_a_camera_overflows_only_a_node_that_is_too_slow() -> None:
    assert findings(camera((0.005, 0.025))) == set()
    assert findings(camera((0.005, 0.045))) == {"queue-overflow"}


def sleeping(rate: float, commands: float, threads: int = 1, inhibits: bool = True) -> sym.SystemModel:
    """A callback sleeps until a timer of a rate rings, which its own executor has to serve."""
    model = sym.SystemModel(id="sleeping", middleware="ros2")
    page = timer(node_net(model, "source", execution="callbacks"), "OnSay", commands)
    out = place(page, "Out")
    step(page, "Say", [], [out])
    node = node_net(model, "node", execution="callbacks", threads=threads)
    ring = timer(node, "OnRate", rate, (0.0, 0.0))
    group = sym.CallbackGroup(id="rate")
    node.callbackGroups.append(group)
    ring.group = group
    wake = place(node, "Wake")
    wake.capacity = 1
    first = step(ring, "Ring", [], [wake])
    if inhibits:
        inhibit(here(wake, ring), first)
    read(here(wake, ring), step(ring, "AlreadyRung"))
    sleeper = callback(node, "OnCommand")
    came, asleep = place(sleeper, "Command"), place(sleeper, "Asleep")
    step(sleeper, "FallAsleep", [came], [asleep]).interval = seconds(0, 0)
    step(sleeper, "WakeUp", [asleep, wake]).interval = seconds(0, 0)
    talks(model, "Commands", out, came)
    return model


@pytest.mark.long
def test_a_callback_that_sleeps_for_a_rate_of_its_own_executor() -> None:
    """With one thread it sleeps forever; with two, 20 Hz serve 10 Hz, and 1 Hz does not serve 10 Hz."""
    assert "queue-overflow" in findings(sleeping(0.05, 0.1))
    assert findings(sleeping(0.05, 0.1, threads=2)) == set()
    assert "queue-overflow" in findings(sleeping(1.0, 0.1, threads=2))


@pytest.mark.long
def test_runs_that_sleep_at_the_same_time_all_wake_up() -> None:
    """They share the clock of the step that wakes them, which fires at once."""
    model = sleeping(0.05, 0.1, threads=2)
    sleeper = find(model, "OnCommand", sym.CallbackPage)
    sleeper.group = sym.CallbackGroup(id="commands", kind="reentrant")
    find(model, "node", sym.NodeNet).callbackGroups.append(sleeper.group)
    assert findings(model) == set()


def test_a_timer_does_not_begin_with_a_step_that_has_no_room() -> None:
    """Only the capacity of a place keeps the first step from firing; the other one tells that it is full."""
    assert findings(sleeping(0.05, 0.1, threads=2, inhibits=False)) == set()


def current_state(threads: int = 1, own_group: bool = False) -> sym.SystemModel:
    """A service's callback waits for a message that its own executor has to take."""
    model = sym.SystemModel(id="current_state", middleware="ros2")
    page = timer(node_net(model, "arm", execution="callbacks"), "OnJoints", 0.05)
    out = place(page, "JointsOut")
    step(page, "Tell", [], [out])
    mover = node_net(model, "mover", execution="callbacks", threads=threads)
    fresh = place(mover, "StateIsFresh")
    fresh.capacity = 1
    listens = callback(mover, "OnState")
    listens.duration = seconds(0.001, 0.001)
    if own_group:
        listens.group = sym.CallbackGroup(id="states")
        mover.callbackGroups.append(listens.group)
    heard = place(listens, "Joints")
    inhibit(here(fresh, listens), step(listens, "Update", [heard], [fresh]))
    read(here(fresh, listens), step(listens, "Renew", [heard]))
    talks(model, "JointStates", out, heard)
    serves = callback(mover, "OnMove", "server")
    asked, answered, waiting = (
        place(serves, "MoveIn"),
        place(serves, "MoveOut"),
        place(serves, "WaitsForState"),
    )
    step(serves, "BeginStale", [asked, fresh], [waiting]).interval = seconds(0, 0)
    begin = step(serves, "Begin", [asked], [waiting])
    begin.interval = seconds(0, 0)
    inhibit(here(fresh, serves), begin)
    step(serves, "Move", [waiting, fresh], [answered]).interval = seconds(0.002, 0.005)
    user = node_net(model, "user")
    user.reaction = seconds(0.01, 0.2)
    idle, ask, got = place(user, "Idle", 1), place(user, "Ask"), place(user, "Got")
    step(user, "Call", [idle], [ask])
    step(user, "Take", [got], [idle])
    service = sym.ServiceChannel(id="MoveArm", service="/move_arm", latency=seconds(*QUICK), model=model)
    service.server = sym.ServerPort(page=serves, entry=asked, exit=answered)
    service.clients.append(sym.ClientPort(client="user", request=ask, response=got))
    return model


@pytest.mark.long
def test_a_service_that_waits_for_a_message_of_its_own_executor() -> None:
    """A second thread alone does not help: the callbacks are in one group."""
    for sick in (current_state(), current_state(threads=2)):
        assert {"waits-forever", "queue-overflow"} & findings(sick)
    assert findings(current_state(threads=2, own_group=True)) == set()


@pytest.mark.long
def test_what_is_lost_because_a_callback_waits_forever_follows_from_that() -> None:
    """The reader overflows since the callback that would take the messages never runs."""
    for sick in (current_state(), current_state(threads=2)):
        report, budget = Report(), UNLIMITED.begun()
        assert ask_timed(sick, report, budget) is not None
        fold_consequences(sick, report, budget, again=gone_in_time)
        (cause,) = [each for each in report.findings if each.severity != "note"]
        assert cause.rule == "callback-deadlock"
        assert "queue-overflow" in {each.rule for each in cause.consequences}


def late_configure(work: tuple[float, float], patience: float = 10.0) -> sym.SystemModel:
    """A spawner gives a request up and asks again; the server refuses to configure twice."""
    model = sym.SystemModel(id="spawning", middleware="ros2")
    manager = node_net(model, "controller_manager", execution="callbacks")
    page = callback(manager, "OnConfigure", "server")
    asked, answered = place(page, "in"), place(page, "out")
    new, configured = place(manager, "Unconfigured", 1), place(manager, "Configured")
    step(page, "Configure", [asked, here(new, page)], [answered, configured])
    again = step(page, "IsConfigured", [asked], [answered, here(place(manager, "Refusals"), page)])
    read(here(configured, page), again)
    page.duration = seconds(*work)
    spawner = node_net(model, "spawner")
    spawner.reaction = seconds(*QUICK)
    ask, got, late = place(spawner, "Ask"), place(spawner, "Got"), place(spawner, "Late")
    step(spawner, "First", [place(spawner, "Start", 1)], [ask])
    step(spawner, "TryAgain", [late, place(spawner, "Tries", 1)], [ask])
    step(spawner, "Finish", [got], [place(spawner, "Finished")])
    service = sym.ServiceChannel(id="Configuring", service="/configure", latency=seconds(*QUICK), model=model)
    service.server = sym.ServerPort(page=page, entry=asked, exit=answered)
    service.clients.append(
        sym.ClientPort(client="spawner", request=ask, response=got, timeout=patience, timedOut=late)
    )
    model.properties.append(sym.Property(id="NeverRefused", text="never Refusals >= 1"))
    return model


def judged(model: sym.SystemModel) -> Report:
    """Return what a check with times finds, where precautions are notes."""
    report = Report()
    checked = ask_timed(model, report)
    assert checked is not None
    return about_precautions(checked.timed, report, UNLIMITED)


@pytest.mark.long
def test_a_request_that_is_served_late() -> None:
    """10 ms of work are safe against 10 s of patience; 12 s are not."""
    healthy = judged(late_configure((0.01, 0.01)))
    assert not healthy.unknown
    never = {each.elements for each in healthy.findings if each.rule == "dead-transition"}
    assert never == {("IsConfigured",), ("TryAgain",)}, "they follow a time-out that never comes"
    assert {each.severity for each in healthy.findings} == {"note"}
    model = late_configure((0.01, 0.01))
    spawner = find(model, "spawner", sym.NodeNet)
    step(spawner, "Useless", [place(spawner, "Nothing")])
    faults = {each.elements for each in judged(model).findings if each.severity != "note"}
    assert faults == {("Useless",)}, "what can never fire at all stays a warning"
    late = check_timed(late_configure((9.0, 12.0)))
    assert "property-violated" in {each.rule for each in late.findings}


@pytest.mark.long
def test_precautions_without_time_to_judge_them_are_unknown() -> None:
    """A transition that perhaps only a time-out leads to is unknown: it is not reported as a fault."""
    report = Report()
    checked = ask_timed(late_configure((0.01, 0.01)), report)
    assert checked is not None
    over = Budget(seconds=0.0).begun()
    judged = about_precautions(checked.timed, report, over)
    assert not [each for each in judged.findings if each.severity != "note"]
    assert any("IsConfigured" in str(each) for each in judged.unknown)
    assert all(each.may_be_fault for each in judged.unknown)


@pytest.mark.long
def test_an_answer_that_says_that_a_late_request_was_served() -> None:
    """The same with a field of the answer, which decides what the spawner does next."""
    for work, sick in (((0.01, 0.01), False), ((9.0, 12.0), True)):
        model = late_answers.late_configure()
        find(model, "OnConfigure", sym.CallbackPage).duration = seconds(*work)
        find(model, "spawner", sym.NodeNet).reaction = seconds(*QUICK)
        find(model, "Configuring", sym.ServiceChannel).latency = seconds(*QUICK)
        report = check_timed(model)
        assert ("property-violated" in {each.rule for each in report.findings}) is sick
        assert sick or not report.unknown
        assert "deadlock" not in {each.rule for each in report.findings if each.severity != "note"}
