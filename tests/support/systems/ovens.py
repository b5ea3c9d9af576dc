"""Bakers who ask one oven, in the ways of ROS 2: it keeps a number of requests, and bakers may give up."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import flow


def oven(
    bakers: int = 3,
    depth: int = 1,
    outstanding: int = 1,
    timeout: float | None = None,
    tells: bool = False,
    again: bool = True,
) -> sym.SystemModel:
    """Return a service of one instance and its clients, each in a node net of its own.

    Bakers who are fed, or are told of a time-out, are hungry again, if `again`.
    """
    model = sym.SystemModel(id="bakery", middleware="ros2")
    page = sym.CallbackPage(id="Bake", kind="server", page=sym.NodeNet(id="oven", net=model))
    dough, bread = sym.Place(id="Dough", page=page), sym.Place(id="Bread", page=page)
    flow(dough, sym.Transition(id="Heat", page=page), bread)
    service = sym.ServiceChannel(
        id="Oven",
        service="/bake",
        depth=depth,
        instances=1,
        server=sym.ServerPort(entry=dough, exit=bread, page=page),
        model=model,
    )
    for number in range(bakers):
        net = sym.NodeNet(id=f"baker{number}", net=model)
        hungry, ask, got = (
            sym.Place(id=f"{stem}{number}", tokens=tokens, page=net)
            for stem, tokens in (("Hungry", outstanding), ("Ask", 0), ("Got", 0))
        )
        flow(hungry, sym.Transition(id=f"Order{number}", page=net), ask)
        eat = sym.Transition(id=f"Eat{number}", page=net)
        flow(got, eat, *([hungry] if again else []))
        client = sym.ClientPort(
            client=f"baker{number}", request=ask, response=got, outstanding=outstanding, timeout=timeout
        )
        if tells:
            client.timedOut = sym.Place(id=f"Late{number}", page=net)
            flow(client.timedOut, sym.Transition(id=f"Complain{number}", page=net), hungry)
        service.clients.append(client)
    return model
