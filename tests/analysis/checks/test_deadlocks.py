"""Deadlocks grouped by what waits for what, against a search over the whole graph."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings

from case_study.build import build
from dineros.analysis.checks.check import check
from dineros.analysis.checks.deadlocks import DeadlockGroup, deadlock_groups, group_text
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, place, step
from dineros.metamodel.elements import find
from dineros.metamodel.settings import apply
from tests.analysis import classic_nets as classic
from tests.analysis.reference_search import reachability_graph, reference_search
from tests.analysis.strategies import nets
from tests.support.ros2_systems.deserted_services import ask


def groups_of(net: CompiledNet) -> list[DeadlockGroup]:
    return deadlock_groups(Subject(pn.Net(id="net"), net), symbolic_state_space(net))


@pytest.mark.long
@given(nets())
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_groups_share_out_all_dead_markings(net: CompiledNet) -> None:
    if reference_search(net, 1_000) is None:
        return
    dead = [marking for marking, after in reachability_graph(net).succ.items() if not after]
    groups = groups_of(net)
    assert sum(group.markings for group in groups) == len(dead)
    for group in groups:
        marking = net.initial.tolist()
        for transition in group.trace:
            marking = net.fire(transition, marking)
        assert tuple(marking) in dead
        for cause in group.causes:  # by the plain firing rule
            assert cause.arrived
            assert set(cause.missing) == {p for p, w in net.pre.row(cause.transition) if marking[p] < w}
            assert set(cause.blocking) == {
                p for p, w in net.inhibitor.row(cause.transition) if marking[p] >= w
            }
        if not group.causes and groups == [group] and len(dead) == 1:
            moved = {p for p, tokens in enumerate(marking) if tokens > net.initial[p]}
            assert not any(place in moved for t in range(len(net.transitions)) for place, _ in net.pre.row(t))


def test_philosophers_wait_in_a_circle() -> None:
    net = classic.philosophers(3)
    left, right = groups_of(net)
    names = {net.transitions[cause.transition] for cause in left.causes}
    assert names in ({"left_eat0", "left_eat1", "left_eat2"}, {"right_eat0", "right_eat1", "right_eat2"})
    assert {net.places[place] for cause in left.causes for place in cause.missing} == {
        "fork0",
        "fork1",
        "fork2",
    }
    assert left.markings == right.markings == 1
    assert len(left.trace) == len(right.trace) == 3


def test_an_inhibitor_arc_holds_up() -> None:
    net = CompiledNet.build(
        {"a": 1, "b": 0, "c": 1, "d": 0}, [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"d": 1}, {"c": 1})]
    )
    (group,) = groups_of(net)
    text = group_text(Subject(pn.Net(id="net"), net), group)
    assert text == "one marking has no enabled transition: u (is blocked by: c)"


def texts(model: sym.SystemModel) -> list[str]:
    subject = base_subject(model)
    groups = deadlock_groups(subject, symbolic_state_space(subject.net))
    return [group_text(subject, group) for group in groups]


def test_a_consequence_is_no_cause() -> None:
    """Pick waits for a safe place, the controller for Pick: the sensor that never answers is why."""
    model = build()
    apply(model, "TSense.clause=Sensor & !Sensor")
    assert texts(model) == [
        "8 markings have no enabled transition: instance 1 of service SensorService answers client safety "
        "(waits for: SensorExit of server instance 1)"
    ]


RESTS = "nothing is left to do, everything that was started has ended"


def finishing(*ends: str) -> sym.SystemModel:
    """Return a model with a node whose tokens end in one of two places; some are of the kind `end`."""
    begin, middle = sym.Place(id="Begin", tokens=2), sym.Place(id="Middle")
    done, broken = sym.Place(id="Done"), sym.Place(id="Broken")
    first, second, third = (sym.Transition(id=id) for id in ("First", "Second", "Third"))
    node = sym.NodeNet(id="node", objects=[begin, middle, done, broken, first, second, third])
    flow(begin, first, middle, second, done)
    flow(middle, third, broken)
    for each in (done, broken):
        each.kind = sym.PlaceKind.end if each.id in ends else sym.PlaceKind.ordinary
    return sym.SystemModel(id="model", pages=[node])


@pytest.mark.parametrize("ends", [(), ("Done", "Broken")])
def test_a_finished_application_waits_for_nothing(ends: tuple[str, ...]) -> None:
    """Nodes that say nothing of ends have them where nothing takes tokens; it is a note."""
    model = finishing(*ends)
    assert texts(model) == [f"the application can come to rest in 3 markings: {RESTS}"]
    (finding,) = (found for found in check(model).findings if found.rule == "deadlock")
    assert finding.severity == "note"


def test_where_a_node_has_final_places_others_are_not_final() -> None:
    model = finishing("Done")
    rests, stuck = sorted(texts(model), reverse=True)
    assert rests == f"the application can come to rest: {RESTS}"
    assert stuck == (
        "2 markings have no enabled transition: nothing waits, but tokens remain on places that are not "
        "final: Broken"
    )
    found = [found.severity for found in check(model).findings if found.rule == "deadlock"]
    assert sorted(found) == ["note", "warning"]


def test_a_final_condition_decides_instead() -> None:
    """Whether or not something waits, and whatever places are of the kind `end`."""
    model = finishing("Done")
    model.finalCondition = "Broken >= 1"
    found = {found.severity: found.message for found in check(model).findings if found.rule == "deadlock"}
    assert found == {
        "note": "the application can come to rest in 2 markings: nothing is left to do, its final condition "
        "holds",
        "warning": "one marking has no enabled transition: nothing waits, but the final condition of the "
        "model does not hold",
    }
    find(model, "Second", sym.Transition).page.objects.append(never := sym.Place(id="Never"))  # type: ignore[union-attr]
    flow(never, find(model, "Second", sym.Transition))
    flow(never, find(model, "Third", sym.Transition))
    model.finalCondition = "Middle == 2"
    (finding,) = (found for found in check(model).findings if found.rule == "deadlock")
    assert (finding.severity, finding.elements) == ("note", ("model",))


def test_a_final_condition_without_a_state_space() -> None:
    """Where the net has no bound, a deadlock that is found on the way is asked by itself."""
    model = finishing()
    heap, burns = sym.Place(id="Heap", page=model.pages[0]), sym.Transition(id="Burn", page=model.pages[0])
    begin, grows = find(model, "Begin", sym.Place), sym.Transition(id="Grow", page=model.pages[0])
    flow(begin, burns, heap)
    flow(begin, grows, begin)
    flow(grows, heap)
    for text, severity in (("Begin == 0", "note"), ("Begin >= 1", "warning")):
        model.finalCondition = text
        (finding,) = (found for found in check(model).findings if found.rule == "deadlock")
        assert finding.severity == severity


@pytest.mark.parametrize("text", ["Nowhere >= 1", "Done >=", "F Done >= 1"])
def test_a_final_condition_that_cannot_be_read(text: str) -> None:
    model = finishing()
    model.finalCondition = text
    (finding,) = (found for found in check(model).findings if found.rule == "property-unreadable")
    assert finding.message.startswith("the final condition of the model cannot be decided: ")


def test_what_waits_is_not_finished() -> None:
    model = finishing("Done", "Broken")
    find(model, "Second", sym.Transition).page.objects.append(never := sym.Place(id="Never"))  # type: ignore[union-attr]
    flow(never, find(model, "Second", sym.Transition))
    flow(never, find(model, "Third", sym.Transition))
    (finding,) = (found for found in check(model).findings if found.rule == "deadlock")
    assert finding.severity == "warning"


def shut_down(*, ends: bool = False) -> sym.SystemModel:
    """Return a node that takes a message, and may be shut down before it has worked on it."""
    model = sym.SystemModel(id="shut", middleware="ros2")
    talker = sym.NodeNet(id="talker", net=model)
    out = place(talker, "Out")
    step(talker, "Say", [place(talker, "Pool", tokens=1)], [out])
    node = sym.NodeNet(id="node", net=model, lifecycle=sym.Lifecycle(shutsDown=True))
    page = callback(node, "OnMessage")
    taken = place(page, "In")
    step(page, "Use", [taken], [])
    if ends:
        place(node, "End").kind = sym.PlaceKind.end
        step(node, "Work", [place(node, "Begin", tokens=1)], [place(node, "Between")])
    model.channels.append(
        sym.TopicChannel(
            id="Topic",
            topic="/topic",
            publishers=[sym.PublisherPort(place=out, limit=1)],
            subscribers=[sym.SubscriberPort(place=taken, limit=1)],
        )
    )
    return model


@pytest.mark.parametrize("ends", [False, True])
def test_a_node_that_is_shut_down_waits_for_nothing(ends: bool) -> None:
    """What it has in hand ends with it: no fault of the scenario, nor of places that are not final."""
    assert [text for text in texts(shut_down(ends=ends)) if "nothing is left to do" not in text] == []


def test_a_node_that_waits_beside_one_that_is_shut_down_is_stuck() -> None:
    """Another node got a token and waits for an event that never comes."""
    model = shut_down()
    other = sym.NodeNet(id="other", net=model)
    held = place(other, "Held")
    step(other, "Get", [place(other, "Begin", tokens=1)], [held])
    step(other, "Proceed", [held, place(other, "Event")], [])
    found = [text for text in texts(model) if "nothing is left to do" not in text]
    assert len(found) == 1 and "Proceed (waits for: Event)" in found[0] and "Use" not in found[0]
    subject = base_subject(model)
    dead = [after for after in reachability_graph(subject.net).succ.values() if not after]
    groups = deadlock_groups(subject, symbolic_state_space(subject.net))
    assert sum(group.markings for group in groups) == len(dead)


def test_who_waits_for_a_node_that_is_shut_down_still_waits() -> None:
    """A client of our engine asks again and again, and the server is gone forever."""
    report = check(ask(sym.Lifecycle(shutsDown=True), ["engine"]))
    assert any(each.rule == "deadlock" and each.severity == "warning" for each in report.findings)


def test_nets_that_are_no_applications_have_no_final_places() -> None:
    model = pn.Net(id="net")
    page = pn.Page(id="page", net=model)
    flow(pn.Place(id="a", tokens=1, page=page), pn.Transition(id="t", page=page), pn.Place(id="b", page=page))
    (finding,) = (found for found in check(model).findings if found.rule == "deadlock")
    assert finding.severity == "warning"


def test_a_finding_has_its_way_and_names_what_waits() -> None:
    model = build()
    apply(model, "TSense.clause=Sensor & !Sensor")
    (finding,) = (found for found in check(model).findings if found.rule == "deadlock")
    assert finding.elements == ("SensorService", "sorting")
    assert finding.witness is not None
    net = base_subject(model).net
    marking = net.initial.tolist()
    for each in finding.witness.steps:
        marking = net.fire(net.transitions.index(each.transition), marking)
    assert not any(net.is_enabled(t, marking) for t in range(len(net.transitions)))


def test_many_causes_end_in_one_group() -> None:
    """2^6 ways to end, each with places of its own that wait."""
    places = {f"{kind}{i}": int(kind == "s") for i in range(6) for kind in ("s", "a", "b", "never")}
    net = CompiledNet.build(
        places,
        [
            transition
            for i in range(6)
            for transition in (
                (f"a{i}", {f"s{i}": 1}, {f"a{i}": 1}),
                (f"b{i}", {f"s{i}": 1}, {f"b{i}": 1}),
                (f"wait_a{i}", {f"a{i}": 1, f"never{i}": 1}, {}),
                (f"wait_b{i}", {f"b{i}": 1, f"never{i}": 1}, {}),
            )
        ],
    )
    groups = groups_of(net)
    assert sum(group.markings for group in groups) == 64
    assert [group.is_rest for group in groups] == [False] * (len(groups) - 1) + [True]
    assert len(groups) == 25
    assert "more markings have no enabled transition, such as one where wait_" in group_text(
        Subject(pn.Net(id="net"), net), groups[-1]
    )


def test_a_model_without_channels_and_clauses_is_flattened() -> None:
    """One node net, two loops, of which one is dead as marked."""
    on, off, to_off, to_on = (
        sym.Place(id="On", tokens=1),
        sym.Place(id="Off"),
        sym.Transition(id="ToOff"),
        sym.Transition(id="ToOn"),
    )
    up, down, to_down, to_up = (
        sym.Place(id="Up"),
        sym.Place(id="Down"),
        sym.Transition(id="ToDown"),
        sym.Transition(id="ToUp"),
    )
    node = sym.NodeNet(id="node", objects=[on, off, to_off, to_on, up, down, to_down, to_up])
    flow(on, to_off, off, to_on, on)
    flow(up, to_down, down, to_up, up)
    model = sym.SystemModel(id="model", pages=[node])
    report = check(model)
    assert [(found.rule, found.elements) for found in report.findings if found.severity != "note"] == [
        ("dead-transition", ("ToDown",)),
        ("dead-transition", ("ToUp",)),
    ]
    links = base_subject(model).links()
    assert {link.target.id for link in links} >= {"On", "ToOff", "Down"}
    assert all(link.sources for link in links)


def test_a_clause_that_is_never_true_is_not_live() -> None:
    first, second, again = sym.Place(id="A", tokens=1), sym.Place(id="B"), sym.Transition(id="Again")
    back, never = sym.Transition(id="Back"), sym.Transition(id="Never")
    node = sym.NodeNet(id="node", objects=[first, second, again, back, never])
    node.signals.append(sym.InputSignal(id="S"))
    flow(first, again, second, back, first)
    flow(first, never, second)
    model = sym.SystemModel(id="model", pages=[node])
    apply(model, "Never.clause=S & !S")
    report = check(model)
    assert not any("live" in line for line in report.proved)
    (finding,) = (found for found in report.findings if found.rule == "not-live")
    assert "Never" in finding.message
