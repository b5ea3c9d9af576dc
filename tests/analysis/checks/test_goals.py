"""What a check finds of goals: hanging, overtaking, canceled too late or never, and over for nobody."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, assume, given, settings

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.callbacks import refining
from dineros.analysis.checks.boundedness import Boundedness
from dineros.analysis.checks.check import check
from dineros.analysis.checks.goals import Goals
from dineros.analysis.checks.overflow import Overflow
from dineros.analysis.checks.ways import overtaking
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import moves
from dineros.analysis.parts.part import PARTS_TOO_LARGE
from dineros.analysis.questions.held_back import held_back
from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, here, node_net, place, step
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.callbacks.under_way import free_slots, goal_counts
from dineros.metamodel.calls import UNLIMITED as ANY_NUMBER
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find, node_net_of, transitions
from tests.support.ros2_systems.action_models import action_models
from tests.support.ros2_systems.deliveries import deliveries
from tests.support.ros2_systems.hasty_clients import hasty


def asked(model: sym.SystemModel) -> Report:
    """Return the report of a check that asks about goals alone."""
    return check(model, questions=[Boundedness(), Goals()])


def of_rule(report: Report, rule: str) -> list[Finding]:
    return [finding for finding in report.findings if finding.rule == rule]


def channel_of(model: sym.SystemModel) -> sym.ActionChannel:
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel)
    return channel


def last_step(finding: Finding) -> str:
    assert finding.witness is not None
    return finding.witness.steps[-1].text


def test_goals_that_come_to_an_end() -> None:
    report = asked(deliveries(2, 1, cancels=0))
    assert report.findings == []
    assert "every goal that was sent can end" in report.proved


def test_a_goal_that_is_never_over() -> None:
    """The robot waits at the door for somebody to open, and nobody does."""
    model = deliveries(cancels=0)
    page = find(model, "Deliver", pn.Page)
    door, wait = sym.Place(id="Open", page=page), sym.Transition(id="Wait", page=page)
    waiting = sym.Place(id="Waiting", page=page)
    flow(find(model, "Driving", pn.Place), wait, waiting)
    enter = sym.Transition(id="Enter", page=page)
    flow(waiting, enter, find(model, "At", pn.Place))
    flow(door, enter)
    (finding,) = of_rule(asked(model), "goal-never-ends")
    assert finding.severity == "error" and finding.elements == ("Delivery", "Send0")
    assert finding.message == (
        "a goal of client office0 of action /deliver can be accepted and never be over"
    )
    assert last_step(finding) == "Wait of slot 1"


def test_a_goal_that_ends_as_canceled_though_nobody_asked() -> None:
    """The goal state machine does not allow it, and the slot is stuck until somebody asks."""
    model = deliveries(cancels=0)
    server = channel_of(model).server
    page = server.page
    server.cancel, server.canceled = sym.Place(id="Stop", page=page), sym.Place(id="Back", page=page)
    flow(find(model, "Driving", pn.Place), sym.Transition(id="Lazy", page=page), server.canceled)
    (finding,) = of_rule(asked(model), "goal-never-ends")
    assert last_step(finding) == "Lazy of slot 1"


def test_a_goal_that_is_never_accepted() -> None:
    """Once one goal hangs in the only slot, those of others wait forever."""
    model = deliveries(2, 1, cancels=0, rejects=False)
    page = find(model, "Deliver", pn.Page)
    flow(find(model, "Driving", pn.Place), sym.Transition(id="Vanish", page=page))
    report = asked(model)
    assert [found.elements for found in of_rule(report, "goal-never-accepted")] == [
        ("Delivery", "Send0"),
        ("Delivery", "Send1"),
    ]


def test_a_cancel_that_comes_too_late() -> None:
    (finding,) = of_rule(asked(deliveries()), "cancel-too-late")
    assert finding.severity == "note"
    assert last_step(finding).startswith(
        "client office0 asks to cancel its goal of action /deliver, which is "
    )
    assert last_step(finding).endswith("the request to cancel it comes too late")


def callbacks(threads: int, awaits: bool) -> sym.SystemModel:
    """Return the deliveries of one office by a robot that runs callbacks."""
    model = deliveries()
    robot = find(model, "robot", sym.NodeNet)
    robot.execution = "callbacks"
    robot.executor, robot.threads = "multi", threads
    find(model, "Deliver", sym.CallbackPage).awaits = awaits
    return model


@pytest.mark.parametrize(
    ("threads", "awaits", "is_heard"), [(1, False, False), (2, False, True), (1, True, True)]
)
def test_a_cancel_that_is_never_heard(threads: int, awaits: bool, is_heard: bool) -> None:
    """As seen with rclpy: a plain body has the only thread, and every request to cancel comes too late."""
    report = asked(callbacks(threads, awaits))
    found = of_rule(report, "cancel-never-heard")
    assert [each.message for each in found] == (
        []
        if is_heard
        else [
            "no request of client office0 to cancel a goal of action /deliver ever reaches the server: while "
            "a goal is executed, it holds the only thread of node net robot"
        ]
    )
    assert of_rule(report, "cancel-too-late")


@pytest.mark.parametrize(("threads", "awaits", "at_once"), [(1, False, 1), (2, False, 2), (1, True, 2)])
def test_how_many_goals_are_worked_on_at_once(threads: int, awaits: bool, at_once: int) -> None:
    """As seen with rclpy: what works on a goal needs a thread and no group, unless it awaits."""
    from dineros.analysis.questions.state_space import state_space

    model = callbacks(threads, awaits)
    two = deliveries(2, cancels=0)
    robot = find(two, "robot", sym.NodeNet)
    original = find(model, "robot", sym.NodeNet)
    robot.execution, robot.executor, robot.threads = original.execution, original.executor, original.threads
    find(two, "Deliver", sym.CallbackPage).awaits = awaits
    subject = base_subject(two)
    executing = [f"Delivery[{number}].executing" for number in (1, 2)]
    net = subject.net
    seen, most = {tuple(net.initial.tolist())}, 0
    pending = list(seen)
    for marking in pending:
        most = max(most, sum(marking[subject.place_index[place]] for place in executing))
        for transition in range(len(net.transitions)):
            if net.is_enabled(transition, marking):
                after = tuple(net.fire(transition, marking))
                if after not in seen:
                    seen.add(after)
                    pending.append(after)
    assert most == at_once
    assert len(seen) == state_space(net, "symbolic").states


def test_goals_that_overtake_each_other() -> None:
    model = deliveries(1, 2, goals=2, cancels=0, rejects=False)
    assert not of_rule(asked(model), "goals-overtake")
    channel_of(model).clients[0].outstanding = 2
    (finding,) = of_rule(asked(model), "goals-overtake")
    assert finding.message == (
        "goals of client office0 of action /deliver can overtake each other: one accepted later can end first"
    )
    assert finding.witness is not None
    accepted = [step.text for step in finding.witness.steps if "accepts" in step.text]
    assert accepted == [
        f"slot {number} of action /deliver accepts the goal of client office0" for number in (1, 2)
    ]
    assert last_step(finding).startswith("the goal of client office0 in slot 2 of action /deliver is ")


def test_one_slot_keeps_the_order() -> None:
    model = deliveries(1, 1, goals=2, cancels=0, rejects=False)
    channel_of(model).clients[0].outstanding = 2
    assert not of_rule(asked(model), "goals-overtake")


def test_a_race_that_cannot_be_lost() -> None:
    """What ends the second goal needs the first one to be over."""
    subject = base_subject(deliveries(1, 2, goals=2, cancels=0, rejects=False))
    places, index = subject.place_index, subject.transition_index
    slots = places["Delivery.client.office0.inUse[1]"], index["Delivery.client.office0.accept[2]"]
    assert overtaking(subject.net, *slots, ()) == (None, True)


def test_a_result_that_nobody_fetches() -> None:
    model = deliveries(cancels=0)
    channel_of(model).clients[0].aborted = None
    (finding,) = of_rule(asked(model), "result-not-fetched")
    assert (
        finding.message
        == "no client fetches the result if a goal of client office0 of action /deliver ends as aborted"
    )
    for transition in ("Break",):
        page = find(model, "Deliver", pn.Page)
        broken = find(model, transition, pn.Transition)
        for arc in [arc for arc in page.arcs if broken in (arc.source, arc.target)]:
            page.arcs.remove(arc)
        page.objects.remove(broken)
    assert not of_rule(asked(model), "result-not-fetched")


def test_a_result_that_the_client_cannot_take() -> None:
    """Its timer's callback waits for the result, in the callback group that has to take it."""
    model = deliveries(cancels=0, rejects=False)
    office = find(model, "office0", sym.NodeNet)
    office.execution = "callbacks"
    page = sym.CallbackPage(id="OnTimer", kind="timer", timer=1.0, page=office)
    goal, done = sym.Place(id="Goal", page=page), sym.Place(id="Done", page=page)
    flow(sym.Transition(id="Begin", page=page), goal)
    flow(done, sym.Transition(id="End", page=page))
    (client,) = channel_of(model).clients
    client.goal, client.succeeded, client.aborted, client.rejected = goal, done, done, None
    found = of_rule(asked(model), "result-not-fetched")
    assert [finding.message.rpartition(" ")[2] for finding in found] == ["succeeded", "aborted"]
    office.executor, office.threads = "multi", 2
    assert of_rule(asked(model), "result-not-fetched"), "the callback has the group, whatever thread is free"
    office.callbackGroups.append(sym.CallbackGroup(id="own"))
    client.group = office.callbackGroups[0]
    assert not of_rule(asked(model), "result-not-fetched")


@pytest.mark.parametrize("blocks", [False, True])
def test_a_client_that_is_shut_down_fetches_no_result(blocks: bool) -> None:
    """That is as it should be; one that has no thread for its result while it is there is at fault."""
    model = deliveries(cancels=0, rejects=False)
    office = find(model, "office0", sym.NodeNet)
    office.lifecycle = sym.Lifecycle(shutsDown=True)
    if blocks:
        office.execution = "callbacks"
        page = sym.CallbackPage(id="OnTimer", kind="timer", timer=1.0, page=office)
        goal, done = place(page, "Goal"), place(page, "Done")
        step(page, "Begin", [], [goal])
        step(page, "End", [done], [])
        (client,) = channel_of(model).clients
        client.goal, client.succeeded, client.aborted, client.rejected = goal, done, done, None
    found = of_rule(asked(model), "result-not-fetched")
    assert [each.message.rpartition(" ")[2] for each in found] == (["succeeded", "aborted"] if blocks else [])


def test_work_on_a_goal_that_waits_for_its_own_thread() -> None:
    """What works on a goal calls a service of its node, whose only thread it has."""
    model = deliveries(cancels=0)
    robot = find(model, "robot", sym.NodeNet)
    robot.execution = "callbacks"
    page = find(model, "Deliver", sym.CallbackPage)
    ask, got = sym.Place(id="Ask", page=page), sym.Place(id="Got", page=page)
    flow(find(model, "Driving", pn.Place), sym.Transition(id="Call", page=page), ask)
    flow(got, sym.Transition(id="GoOn", page=page), find(model, "At", pn.Place))
    serve = sym.CallbackPage(id="Map", kind="server", page=robot)
    entry, exit_ = sym.Place(id="In", page=serve), sym.Place(id="Out", page=serve)
    flow(entry, sym.Transition(id="Look", page=serve), exit_)
    sym.ServiceChannel(
        id="Where",
        service="/where",
        server=sym.ServerPort(entry=entry, exit=exit_, page=serve),
        clients=[sym.ClientPort(client="robot", request=ask, response=got)],
        model=model,
    )
    (circle,) = of_rule(check(model), "callback-deadlock")
    assert circle.message == (
        "deadlock in node robot: goal callback Deliver (slot 1) blocks in a call of service /where; the "
        "response needs the only thread, which Deliver (slot 1) itself holds"
    )
    page.awaits = True
    assert not of_rule(check(model), "callback-deadlock")


def test_models_without_actions_are_not_asked() -> None:
    model = sym.SystemModel(id="empty", middleware="ros2")
    sym.Place(id="Place", page=sym.NodeNet(id="node", net=model))
    assert not [each for each in asked(model).proved if "goal" in each]


def test_markings_without_end() -> None:
    """A counter that grows: what fires is found, what hangs is decided on parts of the net."""
    model, counting = deliveries(), deliveries()
    office = find(counting, "office0", sym.NodeNet)
    count = sym.Place(id="Count", page=office)
    flow(sym.Transition(id="Tick", page=office), count)
    report, expected = asked(counting), asked(model)
    assert of_rule(report, "cancel-too-late")
    assert {finding.rule for finding in report.findings} >= {finding.rule for finding in expected.findings}
    ends = [text for text in expected.proved if "can end" in text]
    assert ends and [text for text in report.proved if "can end" in text] == ends
    assert not [each for each in report.unknown if "goals can wait forever" in str(each)]


@pytest.mark.parametrize(
    ("seconds", "error", "reason"),
    [
        (-1.0, None, "time ran out"),
        (60.0, DiagramMemoryError(), "memory ran out"),
        (60.0, BudgetExceededError(PARTS_TOO_LARGE), PARTS_TOO_LARGE),
    ],
    ids=["time", "memory", "size"],
)
def test_why_it_is_not_known_whether_goals_wait(
    monkeypatch: pytest.MonkeyPatch, seconds: float, error: Exception | None, reason: str
) -> None:
    """A limit of what the parts may take is the reason, not that of the search for all markings."""
    model, of_all = deliveries(), refining.Endings.of_all
    office = find(model, "office0", sym.NodeNet)
    flow(sym.Transition(id="Tick", page=office), sym.Place(id="Count", page=office))

    def refuse(*_: object) -> None:
        assert error is not None
        raise error

    if error is not None:
        monkeypatch.setattr(refining, "_RefinedPart", refuse)
    monkeypatch.setattr(
        refining.Endings, "of_all", lambda self, places, _: of_all(self, places, Budget(seconds=seconds))
    )
    (left,) = (each for each in asked(model).unknown if each.question == "whether goals can wait forever")
    assert left.reason == reason


def halting(*, waits: bool) -> sym.SystemModel:
    """Return a client that asks to cancel its goal, and continues at once or once the goal is over."""
    model = sym.SystemModel(id="halting", middleware="ros2")
    server, client = node_net(model, "server"), node_net(model, "client")
    page = callback(server, "Execute", "goal")
    new, running, done, stop, canceled = (
        place(page, id) for id in ("New", "Running", "Succeeded", "CancelWanted", "Canceled")
    )
    step(page, "Start", [new], [running])
    step(page, "Finish", [running], [done])
    step(page, "Stop", [running, stop], [canceled])
    idle = place(client, "Idle", tokens=1)
    goal, active, recall, halted, over = (
        place(client, id) for id in ("Goal", "Active", "Recall", "Halted", "Over")
    )
    step(client, "Send", [idle], [goal, active])
    step(client, "Get", [over, active], [idle])
    step(client, "Halt", [active], [recall, halted])
    step(client, "GoOn", [halted, over] if waits else [halted], [idle])
    if not waits:
        step(client, "Forget", [over])
    port = sym.ActionClientPort(
        client="client", goal=goal, succeeded=over, canceled=over, rejected=over, cancel=recall, outstanding=1
    )
    sym.ActionChannel(
        id="Follow",
        action="/follow",
        instances=1,
        model=model,
        server=sym.ActionServerPort(
            page=page, entry=new, succeeded=done, canceled=canceled, cancel=stop, mayReject=True
        ),
        clients=[port],
    )
    model.properties.append(sym.Property(id="NoOrphan", text="never Idle >= 1 and Running >= 1"))
    return model


@pytest.mark.parametrize("waits", [True, False])
def test_a_request_to_cancel_is_gone_with_its_goal(waits: bool) -> None:
    """So none are left over, and the net has an end where the client waits for its goal."""
    report = check(halting(waits=waits))
    unbounded = {element for each in of_rule(report, "unbounded") for element in each.elements}
    assert "Recall" not in unbounded
    assert bool(of_rule(report, "property-violated")) is not waits
    assert bool(unbounded) is not waits


@pytest.mark.parametrize("outstanding", [1, 2])
def test_requests_to_cancel_without_a_goal_never_pile_up(outstanding: int) -> None:
    """A client asks at any time, and any number of times."""
    model = deliveries(1, 2, goals=outstanding + 1)
    office, recall = find(model, "office0", sym.NodeNet), find(model, "Recall0", sym.Place)
    step(office, "Insist", [], [recall])
    (port,) = channel_of(model).clients
    port.outstanding = outstanding
    report = check(model, questions=[Boundedness()])
    assert of_rule(report, "unbounded") == [] and report.unknown == []
    assert [each for each in report.proved if each.startswith("the net is bounded")]


def test_requests_to_cancel_of_a_client_that_does_not_wait_never_pile_up() -> None:
    model, port = hasty()
    node = find(model, "hasty", sym.NodeNet)
    port.cancel = place(node, "Hasty.regrets")
    step(node, "Insist", [], [port.cancel])
    report = check(model, questions=[Boundedness()])
    assert of_rule(report, "unbounded") == [] and report.unknown == []


@pytest.mark.parametrize("outstanding", [1, 2])
@pytest.mark.parametrize("together", [True, False])
def test_a_request_to_cancel_never_meets_a_goal_that_is_sent_after_it(
    together: bool, outstanding: int
) -> None:
    """It is gone before, also where the goal comes from the same firing."""
    model = deliveries()
    channel_of(model).clients[0].outstanding = outstanding
    office = find(model, "office0", sym.NodeNet)
    wanted, recall, goal = (find(model, f"{id}0", pn.Place) for id in ("Wanted", "Recall", "Send"))
    find(model, "Doubt0", pn.Place).tokens = 0
    between = place(office, "Between")
    step(office, "Cancel", [wanted], [recall, goal if together else between])
    step(office, "GoOn", [between], [goal])
    model.properties.append(sym.Property(id="NotCanceled", text="never Stop >= 1"))
    report = check(model)
    assert not of_rule(report, "property-violated")
    assert "property NotCanceled holds: never Stop >= 1" in report.proved


def acknowledged(*, waits: bool) -> sym.SystemModel:
    """Return a client that cancels by the handle of its goal, which it has once that is accepted.

    One that does not wait for the handle when it is halted continues without having asked anything.
    """
    model = halting(waits=True)
    client = find(model, "client", sym.NodeNet)
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel)
    active, idle, recall, halted, over = (
        find(model, id, sym.Place) for id in ("Active", "Idle", "Recall", "Halted", "Over")
    )
    channel.clients[0].accepted = accepted = place(client, "Accepted")
    channel.clients[0].rejected = refused = place(client, "Refused")
    handle = place(client, "Handle")
    for id in ("Halt", "Get"):
        old = find(model, id, sym.Transition)
        for arc in (*old.incoming, *old.outgoing):
            client.arcs.remove(arc)
            arc.source = arc.target = None
        client.objects.remove(old)
    step(client, "Know", [accepted, active], [handle])
    step(client, "HaltKnown", [handle], [recall, halted])
    step(client, "GetKnown", [over, handle], [idle])
    step(client, "GetRefused", [refused, active], [idle])
    if waits:
        early = place(client, "HaltedEarly")
        step(client, "HaltEarly", [active], [early])
        step(client, "CancelLater", [accepted, early], [recall, halted])
        step(client, "RefusedLater", [refused, early], [idle])
    else:
        step(client, "HaltEarly", [active], [idle])
        step(client, "Forget", [over])
        step(client, "ForgetHandle", [accepted])
        step(client, "ForgetRefusal", [refused])
    return model


@pytest.mark.parametrize("waits", [True, False])
def test_that_a_goal_is_accepted_is_a_place_of_the_client(waits: bool) -> None:
    """So a client that is halted before its goal is acknowledged, and its remedy, can be told apart."""
    report = check(acknowledged(waits=waits))
    assert [str(each) for each in validate(acknowledged(waits=waits))] == []
    assert bool(of_rule(report, "property-violated")) is not waits
    assert of_rule(report, "unbounded") == [] or not waits


def test_goals_of_a_client_that_does_not_wait_are_lost() -> None:
    """A timer sends a goal at each tick and waits for none; a client with two goals at once is believed."""
    model, port = hasty()
    report = check(model, questions=[Boundedness(), Overflow(), Goals()])
    messages = [each.message for each in of_rule(report, "queue-overflow")]
    assert messages == [
        "goal history of action /deliver can overflow: a goal is lost",
        "result history of client hasty of action /deliver can overflow: a result is lost",
        "answer history of client hasty of action /deliver can overflow: an answer to a goal is lost",
    ]
    assert "every goal that is accepted can end" in report.proved and not report.unknown
    port.outstanding = 2
    believed = check(model, questions=[Boundedness(), Overflow(), Goals()])
    assert not of_rule(believed, "queue-overflow")


def hasty_at_a_robot(awaits: bool, threads: int = 1) -> sym.SystemModel:
    """Return the same with a robot that runs callbacks."""
    model, _ = hasty()
    robot, page = find(model, "robot", sym.NodeNet), find(model, "Deliver", sym.CallbackPage)
    robot.execution, robot.executor = "callbacks", "multi"
    robot.threads, page.awaits = threads, awaits
    return model


def test_nothing_is_proved_of_a_server_that_awaits() -> None:
    """It works on any number of goals at once, and the analysis on two."""
    report = asked(hasty_at_a_robot(awaits=True))
    (left,) = (each for each in report.unknown if "more goals at once" in each.question)
    assert "action /deliver works on at most 2 goals at once" in str(left) and left.may_be_fault
    assert report.proved == [] and report.assumed
    assert report.to_dict("m")["assumed"] == report.assumed
    model = hasty_at_a_robot(awaits=True)
    channel_of(model).instances = 2
    stated = asked(model)
    assert stated.proved and not stated.assumed and not stated.unknown


def test_the_number_of_goals_of_a_server_in_code_is_an_assumption() -> None:
    model = hasty_at_a_robot(awaits=True)
    find(model, "robot", sym.NodeNet).sourceLine = "robot.py:1"
    report = asked(model)
    assert report.proved == [] and report.assumed and not report.unknown
    assert report.to_dict("m")["assumes"] == ["action /deliver works on at most 2 goals at once"]


@pytest.mark.parametrize(("threads", "slots", "is_enough"), [(1, 2, True), (3, 3, True), (4, 3, False)])
def test_a_slot_for_each_thread(threads: int, slots: int, is_enough: bool) -> None:
    model = hasty_at_a_robot(awaits=False, threads=threads)
    (found,) = free_slots(model, goal_counts(model))
    assert (found.number, found.is_enough) == (slots, is_enough)
    ids = {link.target.id for link in base_subject(model).links()}
    assert f"Delivery[{slots}].idle" in ids and f"Delivery[{slots + 1}].idle" not in ids


def test_a_client_whose_last_goal_is_over_waits() -> None:
    """A place that is marked while no goal is under way; with a second token in it, there are two."""
    model, port = hasty()
    free = place(find(model, "OnTick", sym.CallbackPage), "Hasty.free", 1)
    flow(free, find(model, "Hasty.send", sym.Transition))
    take = find(model, "Hasty.take", sym.Transition)
    assert take.page is not None
    flow(take, here(free, take.page))
    assert goal_counts(model)[port] == 1
    free.tokens = 2
    assert goal_counts(model)[port] == ANY_NUMBER
    assert not of_rule(check(model, questions=[Boundedness(), Overflow()]), "queue-overflow")


def all_markings(net: CompiledNet, most: int) -> set[tuple[int, ...]] | None:
    """Return the reachable markings by the plain firing rule; None if there are more."""
    start = tuple(net.initial.tolist())
    seen, todo = {start}, [start]
    while todo:
        for _, after in moves(net, todo.pop()):
            if after not in seen:
                seen.add(after)
                todo.append(after)
        if len(seen) > most:
            return None
    return seen


@given(action_models())
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow]
)
def test_held_back_as_all_markings_tell(model: sym.SystemModel) -> None:
    """The number of slots changes nothing exactly if no marking has a goal that waits while all are busy."""
    for transition in transitions(model):
        transition.overrides.clear()  # engines refuse priorities
    for action in model.channels:
        if isinstance(action, sym.ActionChannel):
            action.instances = None
    subject = base_subject(model)
    markings = all_markings(subject.net, 3000)
    assume(markings is not None)
    assert markings is not None
    wanted = set()
    for slots in free_slots(model, goal_counts(model)):
        id, index = slots.action.id, subject.place_index
        load, idle = index[f"{id}.goals.Load"], [index[f"{id}[{n + 1}].idle"] for n in range(slots.number)]
        is_full = any(marking[load] and not any(marking[each] for each in idle) for marking in markings)
        if is_full and not slots.is_enough:
            wanted.add(slots.action)
    assert {each.slots.action for each in held_back(subject, UNLIMITED.begun())} == wanted


@given(action_models())
@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow]
)
def test_clients_that_wait_never_have_two_goals_under_way(model: sym.SystemModel) -> None:
    """Where their net lets them have two, no marking has them."""
    for transition in transitions(model):
        transition.overrides.clear()
    counts = goal_counts(model)
    waiting = [
        client
        for client, number in counts.items()
        if client.outstanding is None and number == 1 and runs_callbacks(node_net_of(client.goal))
    ]
    assume(waiting)
    for client in waiting:
        client.outstanding = 2
    subject = base_subject(model)
    markings = all_markings(subject.net, 2000)
    assume(markings is not None)
    assert markings is not None
    for client in waiting:
        assert client.channel is not None
        ready = subject.place_index[f"{client.channel.id}.client.{client.client}.ready"]
        assert min(marking[ready] for marking in markings) >= 1
