"""Actions: nets of generated models do what the interpreter says, and every arc of a net counts."""

from __future__ import annotations

from random import Random

import pytest
from hypothesis import given, settings

from dineros.analysis.model.subject import base_subject
from dineros.analysis.questions.state_space import state_space
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, place, read, step
from dineros.metamodel.elements import arcs, find, transitions
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.phases import OverflowVariant
from tests.support.equal_behaviour import compare
from tests.support.reachability import ReachabilityGraph
from tests.support.references.executors import ExecutorInterpreter
from tests.support.references.flattening import PlainNet, plain_net_of
from tests.support.ros2_systems.action_models import action_models
from tests.support.ros2_systems.deliveries import deliveries, regretting_any_time
from tests.support.ros2_systems.hasty_clients import hasty

FIGURES = {
    "no cancels, no refusals": (deliveries(1, cancels=0, rejects=False), 10),
    "one office": (deliveries(), 48),
    "with feedback": (deliveries(feedback=True), 124),
    "one slot for two": (deliveries(2, 1), 1863),
    "a slot for each": (deliveries(2), 3879),
}


@pytest.mark.long
@given(action_models())
@settings(max_examples=6, deadline=None)
def test_generated_models(model: sym.SystemModel) -> None:
    """T5a and T5b make nets that do the same."""
    interpreter = ExecutorInterpreter(model)
    for overflow in ("weighted", "inhibitor"):
        found = compare(plain_net_of(flatten(model, "none", overflow).net), interpreter, 300)
        assert found.difference == ""


@pytest.mark.long
@pytest.mark.parametrize("overflow", ["weighted", "inhibitor"])
@pytest.mark.parametrize("name", FIGURES)
def test_figures(name: str, overflow: OverflowVariant) -> None:
    model, states = FIGURES[name]
    subject = base_subject(model, overflow=overflow)
    counts = [state_space(subject.net, engine) for engine in ("explicit", "symbolic")]
    expected = ExecutorInterpreter(model).count()
    assert expected[0] == states
    assert [each.states for each in counts] == [states, states]
    assert counts[0].arcs == expected[1]


@pytest.mark.parametrize(("outstanding", "cancels", "states"), [(2, 1, 1128), (2, 3, 2000), (3, 2, 2000)])
def test_requests_to_cancel_of_a_client_of_several_goals(outstanding: int, cancels: int, states: int) -> None:
    """Regretted at any time: some find a goal, and others are more than the goals under way."""
    model = deliveries(1, 2, goals=outstanding + 1, cancels=cancels)
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel)
    channel.clients[0].outstanding = outstanding
    regretting_any_time(model)
    net = plain_net_of(flatten(model, "none").net)
    found = compare(net, ExecutorInterpreter(model), states)
    assert found.difference == ""


@pytest.mark.parametrize(
    ("rare", "full"),
    [
        ((".accept[", ".reject"), {"goals.drop"}),
        (
            ("Know", "take", ".learn", ".refused", ".result."),
            {
                *("answers.accepted.drop", "answers.accepted.instead"),
                *("answers.rejected.drop", "answers.rejected.instead"),
                *("results.At.drop", "results.At.instead.Lost"),
                *("results.Lost.drop", "results.Lost.instead.At"),
            },
        ),
    ],
)
def test_full_histories_of_goals_answers_and_results(rare: tuple[str, ...], full: set[str]) -> None:
    """A client that does not wait, on long walks where each step that one can do is one that both can do."""
    model, port = hasty()
    hasty_node = find(model, "hasty", sym.NodeNet)
    on_accepted = callback(hasty_node, "OnAccepted", "client")
    port.accepted, port.cancel = place(on_accepted, "Known"), place(hasty_node, "Hasty.regrets", 2)
    step(on_accepted, "Know", [port.accepted], [])
    graph = ReachabilityGraph(plain_net_of(flatten(model, "none").net))
    interpreter = ExecutorInterpreter(model)
    fired, chance = set(), Random(0)
    for _ in range(4):
        marking, state = graph.start, interpreter.start
        for _ in range(600):
            in_net, in_model = dict(graph.successors(marking)), dict(interpreter.successors(state))
            assert in_net.keys() == in_model.keys()
            names = sorted(map(str, in_net))
            usual = [name for name in names if not any(word in name for word in rare)]
            name = chance.choice(usual if usual and chance.random() < 0.98 else names)
            marking, state = in_net[name], in_model[name]
            fired.add(name.removeprefix("Delivery.client.hasty."))
    assert full <= fired


def test_a_result_that_takes_the_place_of_another_keeps_its_data() -> None:
    """What waits for the client is what came, whatever the result was that is lost."""
    model, _ = hasty()
    model.tokenType = sym.TokenType(id="Token", fields=[sym.TokenField(name="ok", kind="boolean")])
    find(model, "Hasty.take", sym.Transition).guard = "ok = true"
    net = flatten(model, "none").net
    prefix, colours = "Delivery.client.hasty.", set()
    for each in transitions(net):
        if each.id.startswith(f"{prefix}results.At.instead.Lost"):
            taken = {arc.source.id for arc in arcs(net) if arc.target is each}
            put = {arc.target.id for arc in arcs(net) if arc.source is each}
            (came,) = (id for id in taken if id.startswith(f"{prefix}over.At["))
            (lost,) = (id for id in taken if id.startswith(f"{prefix}kept.Lost["))
            assert came.replace("over", "kept") in put
            colours.add((came[-5:], lost[-5:]))
    assert colours == {(one, other) for one in ("true]", "alse]") for other in ("true]", "alse]")}


def thorough_office() -> sym.SystemModel:
    """Return the deliveries of one office in which whatever may happen to a goal happens."""
    model = deliveries(1, goals=2, cancels=2, feedback=True, heeds=False)
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel)
    channel.depth = 1
    server, page = channel.server, channel.server.page
    assert server.cancel is not None and server.canceled is not None
    office = find(model, "office0", sym.NodeNet)
    for name in ("Delivered", "Failed", "Canceled", "Refused", "Heard"):
        flow(find(model, f"{name}0", pn.Place), sym.Transition(id=f"Look.{name}", page=office))
    driving, noted = find(model, "Driving", pn.Place), sym.Place(id="Noted", page=page)
    flow(server.cancel, sym.Transition(id="Note", page=page), noted)
    home, panic = sym.Transition(id="Home", page=page), sym.Transition(id="Panic", page=page)
    flow(noted, home, server.canceled)
    flow(driving, home)
    read(server.cancel, panic)
    flow(driving, panic, server.canceled)
    return model


def unnoticed(model: sym.SystemModel, word: str = "") -> set[tuple[str, str]]:
    """Return the arcs without which a net still does what the model does.

    Those count that have a word in their ends' ids, and of whose ends none is a transition that never fires.
    """
    net, interpreter = plain_net_of(flatten(model, "none").net), ExecutorInterpreter(model)
    found = compare(net, interpreter, 8000)
    assert (found.complete, found.difference) == (True, "")
    graph = ReachabilityGraph(net)
    seen, fired = [graph.start], set()
    known = set(seen)
    for marking in seen:
        for name, after in graph.successors(marking):
            fired.add(name)
            if after not in known:
                known.add(after)
                seen.append(after)
    same = set()
    for number, (source, target, *_) in enumerate(net.arcs):
        if word not in f"{source} {target}" or not fired & {source, target}:
            continue
        altered = PlainNet(net.places, net.transitions, [*net.arcs[:number], *net.arcs[number + 1 :]])
        if not compare(altered, interpreter, 8000).difference:
            same.add((str(source), str(target)))
    return same


@pytest.mark.long
def test_every_arc_counts() -> None:
    """But where one client with one goal at a time leaves no other way."""
    client = "Delivery.client.office0"
    assert unnoticed(thorough_office(), "Delivery") == {
        (f"{client}.inUse[1]", f"{client}.{word}[1]") for word in ("cancel", "again", "feedback")
    }


def test_who_has_a_slot_counts() -> None:
    assert unnoticed(deliveries(2, 1, rejects=False), "inUse[1]") == set()


@pytest.mark.parametrize("counts", ["threads", "lock"])
def test_threads_and_locks_count(counts: str) -> None:
    """A timer of another group has the only thread, or one of two threads while it runs in the same group."""
    model = deliveries(cancels=0)
    for id in ("robot", "office0"):
        net = find(model, id, sym.NodeNet)
        net.execution = "callbacks"
        net.executor, net.threads = "multi", 1 if counts == "threads" else 2
        timer = sym.CallbackPage(id=f"Timer.{id}", kind="timer", timer=1.0, page=net)
        between = sym.Place(id=f"Between.{id}", page=timer)
        flow(
            sym.Transition(id=f"Begin.{id}", page=timer), between, sym.Transition(id=f"End.{id}", page=timer)
        )
        if counts == "threads":
            net.callbackGroups.append(sym.CallbackGroup(id=f"own.{id}", kind="reentrant"))
            timer.group = net.callbackGroups[0]
    assert unnoticed(model, counts) == set()


def test_certificates() -> None:
    found = {
        each.name: (each.value, {term.place.id for term in each.terms})
        for each in flatten(deliveries(2, 1), "none").net.certificate
    }
    slot, client = "Delivery[1].", "Delivery.client.office0."
    states = {slot + state for state in ("idle", "executing", "asked", "canceling")}
    assert found[f"{slot}idle or a goal"] == (1, states)
    owners = {f"Delivery.client.office{number}.inUse[1]" for number in (0, 1)}
    assert found[f"{slot}idle or a client's"] == (1, {f"{slot}idle", *owners})
    parts = ("ready", "requested", "rejected", "inUse[1]", "over.At", "over.Lost", "over.Back")
    assert found[f"{client}ready or one goal under way"] == (1, {client + part for part in parts})


def test_several_goals_of_one_client() -> None:
    model = deliveries(1, 2, goals=3, cancels=2)
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel)
    channel.clients[0].outstanding = 2
    found = compare(plain_net_of(flatten(model, "none").net), ExecutorInterpreter(model), 2000)
    assert found.difference == ""


def test_a_server_that_refuses_to_cancel() -> None:
    model = deliveries()
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel)
    channel.server.cancel = None
    net = flatten(model, "none").net
    found = compare(plain_net_of(net), ExecutorInterpreter(model), 2000)
    assert (found.difference, found.complete) == ("", True)
    assert not any("heeded" in node.id for node in net.pages[0].objects)
