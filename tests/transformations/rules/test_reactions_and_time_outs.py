"""Reactions of engines and time-outs of clients: small systems whose facts are counted by hand."""

from __future__ import annotations

import pytest

from dineros.analysis.logic.language.bounded import read_bounded
from dineros.analysis.timed.durations.bounded_response import decide_bounded
from dineros.analysis.timed.exploring import Explored
from dineros.analysis.timed.linear_time import verify_timed_ltl
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import transitions
from dineros.transformations.flattening.flatten import flatten
from tests.support.ros2_systems.deserted_services import Asking, ask
from tests.transformations.rules.test_times import explored


def spawner(
    work: tuple[float, float],
    latency: tuple[float, float] | None = (0.0, 0.001),
    patience: float = 10.0,
) -> sym.SystemModel:
    """Return a client that asks once, gives up after its time-out, and asks a second time then."""
    model = sym.SystemModel(id="spawning", middleware="ros2")
    manager = node_net(model, "manager", execution="callbacks")
    page = callback(manager, "OnConfigure", "server")
    page.duration = seconds(*work)
    entry, out = place(page, "in"), place(page, "out")
    step(page, "Configure", [entry], [out])
    spawner = node_net(model, "spawner")
    spawner.reaction = seconds(0, 0.001)
    ask, got, late = place(spawner, "Ask"), place(spawner, "Got"), place(spawner, "Late")
    step(spawner, "First", [place(spawner, "Start", 1)], [ask])
    step(spawner, "Again", [late, place(spawner, "Tries", 1)], [ask])
    step(spawner, "Finish", [got], [place(spawner, "Finished")])
    service = sym.ServiceChannel(id="Configuring", service="/configure", model=model)
    service.server = sym.ServerPort(page=page, entry=entry, exit=out)
    service.latency = None if latency is None else seconds(*latency)
    service.clients.append(
        sym.ClientPort(client="spawner", request=ask, response=got, timeout=patience, timedOut=late)
    )
    assert [each for each in validate(model) if each.severity == "error"] == []
    return model


def gives_up(found: Explored) -> bool:
    names = found.net.untimed.transitions
    return any(".giveUp." in names[t] for t in found.ways)


@pytest.mark.parametrize(
    ("work", "is_patient"),
    [((0.01, 0.01), True), ((9.0, 9.9), True), ((9.0, 9.999), False), ((9.0, 11.0), False)],
)
def test_a_client_gives_up_only_after_its_time_out(work: tuple[float, float], is_patient: bool) -> None:
    """With 1 ms each way, 9.999 s of work can end after 10 s, and 9.9 s cannot."""
    assert gives_up(explored(spawner(work))) == (not is_patient)


def test_a_client_may_give_up_while_its_response_is_on_its_way() -> None:
    found = explored(spawner((9.0, 9.0), latency=(0.4, 0.6)))
    names = [found.net.untimed.transitions[t] for t in found.ways]
    assert "Configuring.client.spawner.giveUp.back[1]" in names
    assert "Configuring.client.spawner.giveUp.inUse[1]" not in names


def test_a_request_that_can_be_on_its_way_for_any_time_is_given_up() -> None:
    assert gives_up(explored(spawner((0.01, 0.01), latency=None)))
    assert gives_up(explored(spawner((0.01, 0.01), latency=(0.0, 11.0))))


def test_a_second_request_has_its_own_time_out() -> None:
    """The first one is given up at 10 s; the second is served at 11 s, when the server is free."""
    found = explored(spawner((11.0, 11.0), latency=(0.0, 0.0)))
    top = dict(zip(found.net.untimed.places, found.markings.max(axis=0).tolist(), strict=True))
    assert gives_up(found)
    assert top["Late"] == 1


@pytest.mark.parametrize("server", [None, sym.Lifecycle()], ids=["there", "managed"])
@pytest.mark.parametrize("asking", ["once", "waits", "gives up", "engine", "engine gives up"])
@pytest.mark.parametrize("latency", [None, (0.0, 0.1), (0.5, 1.5)])
def test_all_kinds_of_clients_have_certificates(
    server: sym.Lifecycle | None, asking: Asking, latency: tuple[float, float] | None
) -> None:
    """Flattening checks them; a client that does not wait has any number of requests under way."""
    model = ask(server, [asking, "gives up"], times=2)
    model.channels[0].latency = None if latency is None else seconds(*latency)
    net = flatten(model, "none", times=True).net
    names = {each.id for each in transitions(net)}
    has_ring = "Ask.client.c0.ring" in names
    assert has_ring == (asking == "engine gives up" and server is None)


@pytest.mark.parametrize(("latest", "is_bounded"), [(0.002, True), (None, False)])
def test_an_engine_fires_within_its_reaction(latest: float | None, is_bounded: bool) -> None:
    model = sym.SystemModel(id="plain", middleware="ros2")
    node = node_net(model, "node")
    node.reaction = seconds(0.001, latest)
    step(node, "Go", [place(node, "Start", 1)], [place(node, "End")])
    subject = timed_base_subject(model)
    answer = verify_timed_ltl(subject.timed, "F (End >= 1)")
    assert (answer.status == "holds") == is_bounded


def test_a_transition_keeps_its_own_interval_and_one_with_a_handler_takes_its_time_too() -> None:
    model = sym.SystemModel(id="plain", middleware="ros2")
    node = node_net(model, "node")
    node.reaction = seconds(0, 0.002)
    slow = step(node, "Slow", [place(node, "Start", 1)])
    slow.interval = seconds(1, 2)
    handled = step(node, "Handled", [place(node, "Begin", 1)])
    handled.duration = seconds(0, 5)
    net = timed_base_subject(model).timed
    intervals = dict(zip(net.untimed.transitions, map(str, net.intervals), strict=True))
    assert intervals == {"Slow": "[1,2]", "Handled": "[0,2501/500]"}


@pytest.mark.parametrize(("reaction", "latency"), [((0, 2), (0, 1)), ((1, 1), (2, 3))])
def test_an_engine_takes_a_request_within_its_reaction(
    reaction: tuple[float, float], latency: tuple[float, float]
) -> None:
    """Twice the latency; the server takes and answers, and the client takes, each within a reaction."""
    model = sym.SystemModel(id="asking", middleware="ros2")
    server, client = node_net(model, "server"), node_net(model, "client")
    server.reaction = client.reaction = None
    model.times = sym.DefaultTimes(reaction=seconds(*reaction), latency=seconds(*latency))
    page = callback(server, "Serve", "server")
    entry, out = place(page, "in"), place(page, "out")
    step(page, "Answer", [entry], [out])
    ask, got = place(client, "Ask"), place(client, "Got")
    step(client, "Begin", [place(client, "Start", 1)], [ask])
    service = sym.ServiceChannel(id="Serving", service="/serve", model=model)
    service.server = sym.ServerPort(page=page, entry=entry, exit=out)
    service.clients.append(sym.ClientPort(client="client", request=ask, response=got))
    assert [each for each in validate(model) if each.severity == "error"] == []
    most = 2 * latency[1] + 3 * reaction[1]
    net = timed_base_subject(model).timed
    for bound, expected in ((most, "holds"), (most - 1, "violated")):
        formula = read_bounded(f"G (fired(Begin) -> F[<={bound}] (Got >= 1))")
        assert formula is not None
        assert decide_bounded(net, formula).status == expected
