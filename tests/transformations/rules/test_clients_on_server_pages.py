"""Clients of services on pages of servers: their copies keep all that is stated of them."""

from __future__ import annotations

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import channels
from dineros.transformations.flattening.flatten import flatten
from tests.support.ros2_systems.deserted_services import ask


def asking(server: str, copies: int) -> sym.SystemModel:
    """Return a server that asks a managed node, for which it waits, and that has a client of its own."""
    model = ask(sym.Lifecycle(), [])
    (maps,) = channels(model, sym.ServiceChannel)
    maps.latency = seconds(0, 5)
    robot = node_net(model, "robot", execution="callbacks")
    page = callback(robot, "Drive", "goal" if server == "action" else "server")
    target, there, wanted, known = (place(page, name) for name in ("Target", "There", "Wanted", "Known"))
    step(page, "Look", [target], [wanted])
    step(page, "Arrive", [known], [there])
    maps.clients.append(
        sym.ClientPort(
            client="robot", request=wanted, response=known, waitsForService=True, latency=seconds(1, 2)
        )
    )
    user = node_net(model, "user", execution="callbacks")
    wish, done = place(user, "Wish"), place(user, "Done")
    step(user, "Send", [place(user, "Wishes", 2)], [wish])
    step(user, "Note", [done])
    if server == "action":
        sym.ActionChannel(
            id="Drives",
            action="/drive",
            instances=copies,
            server=sym.ActionServerPort(page=page, entry=target, succeeded=there),
            clients=[sym.ActionClientPort(client="user", goal=wish, succeeded=done)],
            model=model,
        )
    else:
        sym.ServiceChannel(
            id="Drives",
            service="/drive",
            instances=copies,
            server=sym.ServerPort(page=page, entry=target, exit=there),
            clients=[sym.ClientPort(client="user", request=wish, response=done)],
            model=model,
        )
    assert [str(each) for each in validate(model) if each.severity == "error"] == []
    return model


@pytest.mark.parametrize("copies", [1, 2])
@pytest.mark.parametrize("server", ["action", "service"])
def test_copies_wait_for_their_service(server: str, copies: int) -> None:
    waits = [link for link in flatten(asking(server, copies), "none").trace if link.rule == "L6Wait"]
    assert len(waits) == copies


@pytest.mark.parametrize("server", ["action", "service"])
def test_copies_have_the_latency_of_their_client(server: str) -> None:
    net = flatten(asking(server, 2), "none", times=True).net
    found = {
        each.id: (each.interval.earliest, each.interval.latest)
        for each in net.eAllContents()
        if isinstance(each, pn.Transition)
        and ".robot.way[" in each.id
        and each.interval
        and each.interval.latest
    }
    assert set(found.values()) == {(1, 2)}
    assert {name.split(".")[2] for name in found} == {"Drives[1]", "Drives[2]"}
