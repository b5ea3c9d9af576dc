"""Small systems of ROS 2 whose clients ask a managed node that comes and goes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

from dineros.metamodel import sym
from dineros.metamodel.build import flow

Asking: TypeAlias = Literal["once", "waits", "gives up", "engine", "engine gives up"]
"""A client sends each request once, waits for the service before it sends, or has a time-out; or it runs our
engine, with a time-out or without."""


def ask(
    server: sym.Lifecycle | None,
    clients: Sequence[Asking],
    *,
    threads: int = 1,
    written_by_hand: bool = True,
    times: int = 1,
) -> sym.SystemModel:
    """Return a service of one instance and its clients.

    Parameters
    ----------
    server : sym.Lifecycle or None
        The life of the server's node.
    clients : sequence of Asking
        What each client does.
    threads : int
        Of the server's node.
    written_by_hand : bool
        Whether the server's node is; else it runs our engine.
    times : int
        How often each client may ask.
    """
    model = sym.SystemModel(id="asking", middleware="ros2")
    execution = "callbacks" if written_by_hand else "net"
    serving = sym.NodeNet(
        id="server", net=model, lifecycle=server, execution=execution, executor="multi", threads=threads
    )
    page = sym.CallbackPage(id="Serve", kind="server", page=serving)
    serving.callbackGroups.append(sym.CallbackGroup(id="serving"))
    page.group = serving.callbackGroups[0]
    asked, answer = sym.Place(id="Asked", page=page), sym.Place(id="Answer", page=page)
    flow(asked, sym.Transition(id="Work", page=page), answer)
    service = sym.ServiceChannel(
        id="Ask",
        service="/ask",
        instances=1,
        depth=1,
        server=sym.ServerPort(entry=asked, exit=answer, page=page),
        model=model,
    )
    for number, asking in enumerate(clients):
        service.clients.append(_client(model, f"c{number}", asking, times))
    return model


def _client(model: sym.SystemModel, name: str, asking: Asking, times: int) -> sym.ClientPort:
    execution = "net" if asking.startswith("engine") else "callbacks"
    node = sym.NodeNet(id=name, net=model, execution=execution)
    wish = sym.Place(id=f"{name}.wish", tokens=times, page=node)
    request, response = sym.Place(id=f"{name}.ask", page=node), sym.Place(id=f"{name}.got", page=node)
    flow(wish, sym.Transition(id=f"{name}.Ask", page=node), request)
    flow(response, sym.Transition(id=f"{name}.Use", page=node))
    port = sym.ClientPort(client=name, request=request, response=response, waitsForService=asking == "waits")
    if asking.endswith("gives up"):
        port.timeout, port.timedOut = 1.0, wish
    return port
