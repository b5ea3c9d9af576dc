"""Consequences fold under their causes, and only what is gone where these are fixed."""

from __future__ import annotations

from typing import Any

import pytest

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.checks.check import check
from dineros.analysis.checks.unused import unused_parts
from dineros.analysis.consequences import cause_fixes, circle_fixes, folding
from dineros.analysis.consequences.folding import fold_consequences
from dineros.analysis.consequences.used import disproved
from dineros.analysis.model.subject import base_subject
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, node_net, place, step
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import channels, find
from examples.callbacks.models import node, program, timer, topic
from tests.support.own_time import CLOCK
from tests.support.ros2_systems.deliveries import deliveries
from tests.support.ros2_systems.managed_systems import talk
from tests.support.ros2_systems.waiting_models import awaiting_result, sharing_a_lock

pytestmark = pytest.mark.usefixtures("own_time")  # folding a cause has a share of the time


@pytest.fixture
def only_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fold nothing by runs that need no search."""
    monkeypatch.setattr(folding, "folded_quickly", lambda *_: ())


def folded(model: sym.SystemModel, budget: Budget = UNLIMITED) -> Report:
    budget = budget.begun()
    report = check(model, budget)
    fold_consequences(model, report, budget)
    return report


def faults(findings: list[Finding]) -> list[str]:
    return [each.rule for each in findings if each.severity != "note"]


def consequences(finding: Finding) -> list[tuple[str, str]]:
    return [(each.rule, each.elements[0]) for each in finding.consequences]


@pytest.mark.long
def test_what_a_circle_causes() -> None:
    """A goal whose result is never taken: one fault, and what comes of it."""
    report = folded(awaiting_result())
    assert faults(report.findings) == ["callback-deadlock"]
    assert consequences(report.findings[0]) == [("dead-transition", "Go"), ("result-not-fetched", "Act")]
    assert report.consequences == list(report.findings[0].consequences)


def unrelated(model: sym.SystemModel) -> sym.SystemModel:
    """Add a node with a transition that never fires, whatever else is fixed."""
    other = sym.NodeNet(id="other", net=model)
    flow(sym.Place(id="Never", page=other), sym.Transition(id="Idle", page=other))
    flow(sym.Place(id="Once", tokens=1, page=other), sym.Transition(id="Begin", page=other))
    return model


def calling_on_each_response(other_cause: bool = False) -> sym.SystemModel:
    """Return a node whose callback for responses calls again: no number of threads is enough."""
    model = sym.SystemModel(id="again", middleware="ros2")
    server = node_net(model, "server", execution="callbacks")
    serves = callback(server, "OnAsked", "server")
    asked, answered = place(serves, "Asked"), place(serves, "Answered")
    step(serves, "Serve", [asked], [answered])
    user = node_net(model, "user", execution="callbacks")
    tick, response = callback(user, "OnTick", "timer", 1.0), callback(user, "OnResponse", "client")
    request, came = place(tick, "Request"), place(response, "Came")
    step(tick, "Send", [], [request])
    second, got, waits = place(response, "Second"), place(response, "Got"), place(response, "Waits")
    step(response, "Call", [came], [second, waits])
    step(response, "Has", [got, waits, *([place(response, "Never")] if other_cause else [])], [])
    clients = [
        sym.ClientPort(client="first", request=request, response=came),
        sym.ClientPort(client="second", request=second, response=got),
    ]
    port = sym.ServerPort(page=serves, entry=asked, exit=answered)
    model.channels.append(sym.ServiceChannel(id="Ask", service="/ask", depth=1, server=port, clients=clients))
    return model


def test_what_a_circle_causes_that_no_thread_fixes() -> None:
    """Its calls get time-outs: what comes after them is a consequence."""
    report = folded(calling_on_each_response(), Budget(seconds=300))
    (found,) = (each for each in report.findings if each.rule == "callback-deadlock")
    assert ("dead-transition", "Has") in consequences(found)


def test_what_a_circle_does_not_cause_stays_with_time_outs() -> None:
    """The transition that comes after the call lacks a token that nothing gives."""
    report = folded(calling_on_each_response(other_cause=True))
    assert ("dead-transition", ("Has",)) in [(each.rule, each.elements) for each in report.findings]


def calling_in_turn() -> sym.SystemModel:
    """Return a node whose timer calls two services, one after the other, in the group of their responses."""
    model = sym.SystemModel(id="in_turn", middleware="ros2")
    server = node_net(model, "server", execution="callbacks")
    tick = callback(node_net(model, "user", execution="callbacks"), "OnTick", "timer", 1.0)
    got: list[sym.Place] = []
    for number in ("First", "Second"):
        serves = callback(server, f"On{number}", "server")
        asked, answered = place(serves, f"{number}Asked"), place(serves, f"{number}Answered")
        step(serves, f"{number}Serve", [asked], [answered])
        request, waits, response = (
            place(tick, f"{number}{each}") for each in ("Request", "Waits", "Response")
        )
        step(tick, f"{number}Call", got, [request, waits])
        got = [waits, response]
        client = sym.ClientPort(client="user", request=request, response=response)
        port = sym.ServerPort(page=serves, entry=asked, exit=answered)
        model.channels.append(
            sym.ServiceChannel(
                id=number, service=f"/{number.lower()}", depth=1, server=port, clients=[client]
            )
        )
    step(tick, "Done", got, [])
    return model


def test_a_circle_behind_another_one_is_removed_by_time_outs_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second call waits in a circle once the first one ends."""
    monkeypatch.setattr(circle_fixes, "CHANGES", Share(time=0.0))
    report = folded(calling_in_turn(), Budget(seconds=300))
    assert faults(report.findings) == ["callback-deadlock"]
    dead = {element for rule, element in consequences(report.findings[0]) if rule == "dead-transition"}
    assert {"SecondCall", "Done"} <= dead


def test_what_has_another_cause_stays() -> None:
    report = folded(unrelated(program("same_group")))
    assert faults(report.findings) == ["callback-deadlock", "dead-transition"]
    assert consequences(report.findings[0]) == [("dead-transition", "NoteLevel")]
    assert report.findings[1].elements == ("Idle",)


def unmatched() -> sym.SystemModel:
    """Return a camera and a display that asks for more than the camera offers."""
    model = sym.SystemModel(id="unmatched", middleware="ros2")
    pictures(model)
    return model


def pictures(model: sym.SystemModel) -> None:
    camera, display = node(model, "camera"), node(model, "display")
    page = timer(camera, 1.0)
    page.id = "OnCamera"
    said = sym.Place(id="Said", page=page)
    flow(sym.Transition(id="Say", page=page), said)
    hears = sym.CallbackPage(id="OnHeard", page=display)
    heard = sym.Place(id="Heard", page=hears)
    flow(heard, sym.Transition(id="Show", page=hears))
    topic(model, "Pictures", said, heard)
    channel = find(model, "Pictures", sym.TopicChannel)
    channel.publishers[0].qos = sym.QualityOfService(reliability="bestEffort")
    channel.subscribers[0].qos = sym.QualityOfService(reliability="reliable", durability="volatile")


@pytest.mark.long
def test_each_cause_has_its_own() -> None:
    """A circle, ports that do not match, and a clause that can never be true."""
    model = program("same_group")
    pictures(model)
    lamp = sym.NodeNet(id="lamp", net=model)
    sym.InputSignal(id="dark", node=lamp)
    light = sym.Transition(id="Light", page=lamp)
    flow(sym.Place(id="Off", tokens=1, page=lamp), light, sym.Place(id="On", page=lamp))
    set_clause(light, "dark & !dark")
    report = folded(model)
    found = {each.rule: consequences(each) for each in report.findings if each.severity != "note"}
    assert found["callback-deadlock"] == [("dead-transition", "NoteLevel")]
    assert ("dead-transition", "Show") in found["ports-not-matched"]
    assert set(found["unsatisfiable-clause"]) == {("dead-node-net", "lamp"), ("dead-transition", "Light")}
    assert not set(found) & {"dead-transition", "dead-node-net", "unused-topic"}


@pytest.mark.long
def test_what_a_cancel_that_is_never_heard_causes() -> None:
    model = deliveries(cancels=1)
    find(model, "robot", sym.NodeNet).execution = sym.Execution.callbacks
    report = folded(model)
    assert faults(report.findings) == ["cancel-never-heard"]
    assert consequences(report.findings[0]) == [("dead-transition", "Return")]


@pytest.mark.long
def test_what_callbacks_cause_that_share_a_lock() -> None:
    """Threads and groups do not help against a lock; where the call may end, the lock is given back."""
    report = folded(sharing_a_lock(), Budget(seconds=300))
    assert faults(report.findings) == ["callback-deadlock", "callback-deadlock"]
    assert consequences(report.findings[0]) == [("dead-transition", "Unlocks")]


def test_nothing_folds_where_no_change_fixes_the_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(circle_fixes, "_with_time_outs", lambda *_: None)
    before = check(sharing_a_lock())
    after = folded(sharing_a_lock())
    assert faults(before.findings) == faults(after.findings)
    assert not after.consequences


def test_what_no_run_settles_stays_where_the_answer_stays_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run of the fixed model uses the transition; that no result is lost takes all markings."""
    model = awaiting_result()
    report = check(model)

    def undecided(*_: object, **__: object) -> Report:
        return Report(open_rules={"dead-transition", "result-not-fetched"})

    monkeypatch.setattr(folding, "check", undecided)
    fold_consequences(model, report, UNLIMITED.begun())
    assert faults(report.findings) == ["callback-deadlock", "result-not-fetched"]
    assert consequences(report.findings[0]) == [("dead-transition", "Go")]


def test_nothing_folds_where_neither_a_run_nor_a_proof_settles_it(monkeypatch: pytest.MonkeyPatch) -> None:
    model = awaiting_result()
    report = check(model)
    count = len(faults(report.findings))

    def undecided(*_: object, **__: object) -> Report:
        return Report(open_rules={"dead-transition", "result-not-fetched"})

    monkeypatch.setattr(folding, "check", undecided)
    monkeypatch.setattr(folding, "used_in_runs", lambda *_: [])
    fold_consequences(model, report, UNLIMITED.begun())
    assert len(faults(report.findings)) == count
    assert not report.consequences


def test_runs_fold_what_is_never_used_without_all_markings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of ports that do not match it is known what fixes them: no question is asked again."""
    model = unmatched()
    report = check(model)
    monkeypatch.setattr(folding, "check", None)
    fold_consequences(model, report, UNLIMITED.begun())
    assert faults(report.findings) == ["ports-not-matched"]
    assert {rule for rule, _ in consequences(report.findings[0])} == {"dead-node-net", "dead-transition"}


@pytest.mark.usefixtures("only_search")
def test_a_cause_gets_the_time_that_others_leave(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its part of the time is not enough to find what fixes it; the other cause needs hardly any."""
    model = program("same_group")
    pictures(model)
    report, asked = check(model), list[str]()

    def slow(copied: sym.SystemModel, cause: Finding, budget: Budget) -> circle_fixes.Fix | None:
        asked.append(cause.rule)
        if cause.rule == "callback-deadlock" and asked.count(cause.rule) == 1:
            assert budget.left is not None
            CLOCK.advance(budget.left)
            budget.check_time()
        return cause_fixes.fix_of(copied, cause, budget)

    monkeypatch.setattr(folding, "fix_of", slow)
    fold_consequences(model, report, Budget(seconds=20).begun())
    assert asked == ["callback-deadlock", "ports-not-matched", "callback-deadlock"]
    found = {each.rule: consequences(each) for each in report.findings if each.severity != "note"}
    assert set(found) == {"callback-deadlock", "ports-not-matched"}
    assert found["callback-deadlock"] == [("dead-transition", "NoteLevel")]
    assert ("dead-transition", "Show") in found["ports-not-matched"]


@pytest.mark.usefixtures("only_search")
def test_a_cause_whose_changes_took_too_long_is_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search for changes has only a part of the time of its cause, which goes on."""
    model = program("same_group")
    expected = folded(model)
    assert expected.findings[0].consequences
    shares = iter((0.0,))
    share = Budget.share

    def first_is_short(budget: Budget, time: float = 1.0, memory: float = 1.0, **limits: Any) -> Budget:
        if time == circle_fixes.CHANGES.time:
            time = next(shares, time)
        return share(budget, time, memory, **limits)

    monkeypatch.setattr(circle_fixes, "CHANGES", Share(time=0.123))
    monkeypatch.setattr(Budget, "share", first_is_short)
    monkeypatch.setattr(circle_fixes, "_with_time_outs", lambda *_: None)
    report = folded(model, Budget(seconds=600))
    assert faults(report.findings) == faults(expected.findings)
    assert consequences(report.findings[0]) == consequences(expected.findings[0])


def test_nothing_folds_without_time() -> None:
    model = awaiting_result()
    report = check(model)
    before = list(report.findings)
    fold_consequences(model, report, Budget(seconds=1e-9).begun())
    assert report.findings == before


@pytest.mark.long
def test_a_lost_message_is_no_consequence_where_its_run_goes_on() -> None:
    model = program("same_group")
    fast = node(model, "fast")
    page = timer(fast, 0.1)
    page.id = "OnFast"
    said = sym.Place(id="Said", page=page)
    flow(sym.Transition(id="Say", page=page), said)
    hears = sym.CallbackPage(id="OnSaid", page=node(model, "slow"))
    heard = sym.Place(id="Heard", page=hears)
    flow(heard, sym.Transition(id="Hear", page=hears))
    topic(model, "News", said, heard)
    report = folded(model)
    assert faults(report.findings) == ["callback-deadlock", "queue-overflow", "queue-overflow"]
    assert consequences(report.findings[0]) == [("dead-transition", "NoteLevel")]
    alone = folded(program("same_group")).findings[0].witness
    circle = report.findings[0].witness
    assert circle is not None and alone is not None
    assert len(circle.steps) == len(alone.steps)  # it ends where the circle is closed


def test_what_a_subscriber_that_comes_late_causes() -> None:
    """A property that holds once the topic keeps its messages; not where the subscriber stays volatile."""
    model = talk(reader=sym.Lifecycle(), tokens=1, depth=1)
    find(model, "Hear", sym.Transition).outgoing.clear()
    flow(find(model, "Hear", sym.Transition), sym.Place(id="Done", page=find(model, "listener", sym.NodeNet)))
    model.properties.append(sym.Property(id="Heard1", text="Done >= 1 happens"))
    model.assumptions.append(sym.Fairness(id="F", of="all"))
    report = folded(model)
    assert faults(report.findings) == ["subscriber-not-there"]
    assert consequences(report.findings[0]) == [("property-violated", "Heard1")]


def test_a_late_subscriber_of_a_topic_that_keeps_its_messages_is_no_cause() -> None:
    report = folded(unrelated(talk(reader=sym.Lifecycle(), tokens=1, depth=1)))
    assert faults(report.findings) == ["subscriber-not-there", "dead-transition"]
    assert not report.findings[0].consequences


def test_a_latched_topic_with_best_effort_is_fixed_by_reliability() -> None:
    model = talk(reader=sym.Lifecycle(), tokens=1, depth=1)
    find(model, "Hear", sym.Transition).outgoing.clear()
    flow(find(model, "Hear", sym.Transition), sym.Place(id="Done", page=find(model, "listener", sym.NodeNet)))
    model.properties.append(sym.Property(id="Heard1", text="Done >= 1 happens"))
    model.assumptions.append(sym.Fairness(id="F", of="all"))
    (channel,) = channels(model, sym.TopicChannel)
    for port in (*channel.publishers, *channel.subscribers):
        port.qos = sym.QualityOfService(durability="transientLocal", reliability="bestEffort")
    report = folded(model)
    assert faults(report.findings) == ["subscriber-not-there"]
    assert consequences(report.findings[0]) == [("property-violated", "Heard1")]


def test_what_runs_did_not_meet_is_not_disproved() -> None:
    """A service that never returns is not fixed where no run has called it."""
    model = program("same_group")
    subject = base_subject(model)
    found = unused_parts(subject, set(range(len(subject.net.transitions))))
    channel = next(each for each in found if each.rule == "service-never-called")
    never_returns = Finding("service-never-returns", "error", channel.elements, "")
    assert disproved(subject, (), [never_returns]) == []
    assert disproved(subject, range(len(subject.net.transitions)), [never_returns]) == [never_returns]


def counting() -> sym.SystemModel:
    """Return a node that counts what it does, and one that reaches what must not be after two steps."""
    model = sym.SystemModel(id="counting", middleware="ros2")
    page = sym.NodeNet(id="counter", net=model)
    ready = sym.Place(id="Ready", tokens=1, page=page)
    work, done = sym.Transition(id="Work", page=page), sym.Place(id="Done", page=page)
    flow(ready, work, ready)
    flow(work, done)
    other = sym.NodeNet(id="other", net=model)
    flow(sym.Place(id="First", tokens=1, page=other), sym.Transition(id="Go", page=other))
    flow(find(model, "Go", sym.Transition), sym.Place(id="Bad", page=other))
    return model


def test_what_follows_from_growth() -> None:
    """A property about more tokens than a bounded place holds; not one that few of them violate."""
    model = counting()
    for id, text in {
        "Many": "never Done >= 12",
        "Few": "never Done >= 3",
        "Good": "never Bad >= 1",
        "Both": "never Bad >= 1 or Done >= 14",
    }.items():
        model.properties.append(sym.Property(id=id, text=text))
    report = folded(model)
    assert faults(report.findings) == ["unbounded", *["property-violated"] * 3]
    assert consequences(report.findings[0]) == [("property-violated", "Many")]
    assert {each.elements[0] for each in report.findings[1:]} == {"Few", "Good", "Both"}


def test_a_property_about_what_grows_hides_no_other_finding() -> None:
    """A queue that 25 firings fill overflows whether or not the place that counts them is bounded."""
    model = counting()
    sent = sym.Place(id="Sent", page=find(model, "counter", sym.NodeNet))
    flow(find(model, "Work", sym.Transition), sent)
    heard = sym.Place(id="Heard", page=find(model, "other", sym.NodeNet))
    flow(heard, sym.Transition(id="Hear", page=heard.page))
    sym.TopicChannel(
        id="Log",
        topic="log",
        model=model,
        publishers=[sym.PublisherPort(place=sent, limit=25)],
        subscribers=[sym.SubscriberPort(place=heard, limit=25)],
    )
    model.properties.append(sym.Property(id="Many", text="never Done >= 12"))
    report = folded(model)
    assert "queue-overflow" in faults(report.findings)
    assert "queue-overflow" not in [rule for each in report.findings for rule, _ in consequences(each)]


def test_what_needs_some_tokens_is_no_consequence_of_growth() -> None:
    """Five tokens are enough for the violation: that there can be more is another fault."""
    model = counting()
    page = find(model, "counter", sym.NodeNet)
    take, taken = sym.Transition(id="Take", page=page), sym.Place(id="Taken", page=page)
    flow(find(model, "Done", sym.Place), take, taken, sym.Transition(id="Drop", page=page))
    taken.capacity = 1
    model.properties.append(sym.Property(id="Few", text="never Done >= 5"))
    model.properties.append(sym.Property(id="Bounded", text="never Done >= 12"))
    report = folded(model)
    assert faults(report.findings) == ["unbounded", "property-violated"]
    assert consequences(report.findings[0]) == [("property-violated", "Bounded")]
