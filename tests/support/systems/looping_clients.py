"""A system model with exponentially many semiflows: clients that ask services in turn, forever."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow

#: Markings and arcs by (clients, services).
COUNTS = {(2, 2): (401, 854), (3, 2): (14_901, 48_699), (2, 3): (901, 1_940)}


def looping_clients(clients: int, services: int) -> sym.SystemModel:
    """Return a model of nodes that each ask all services in turn, and begin again.

    Each service has as many instances as there are clients; they take turns by a lock.
    """
    model = sym.SystemModel(id="looping")
    channels = [_service(model, number, clients) for number in range(services)]
    for number in range(clients):
        _client(model, number, channels)
    return model


def _service(model: sym.SystemModel, number: int, instances: int) -> sym.ServiceChannel:
    net = sym.NodeNet(id=f"server{number}", net=model)
    lock = sym.Place(id=f"Lock{number}", tokens=1, page=net)
    page = sym.CallbackPage(id=f"Serve{number}", kind="server", page=net)
    entry, work, exit = (sym.Place(id=f"{name}{number}", page=page) for name in ("Entry", "Work", "Exit"))
    begin, end = (sym.Transition(id=f"{name}{number}", page=page) for name in ("Begin", "End"))
    flow(entry, begin, work, end, exit)
    flow(end, pn.ReferencePlace(id=f"LockOf{number}", target=lock, page=page), begin)
    return sym.ServiceChannel(
        id=f"Service{number}",
        service=f"/service{number}",
        server=sym.ServerPort(entry=entry, exit=exit, page=page),
        instances=instances,
        model=model,
    )


def _client(model: sym.SystemModel, number: int, channels: list[sym.ServiceChannel]) -> None:
    net = sym.NodeNet(id=f"client{number}", net=model)
    before = idle = sym.Place(id=f"Idle{number}", tokens=1, page=net)
    for turn, channel in enumerate(channels):
        request = sym.Place(id=f"Request{number}_{turn}", page=net)
        response = sym.Place(id=f"Response{number}_{turn}", page=net)
        channel.clients.append(sym.ClientPort(client=f"client{number}", request=request, response=response))
        # The answer of one is what the next is asked with; after the last one the client rests.
        flow(before, sym.Transition(id=f"Ask{number}_{turn}", page=net), request)
        before = response
    flow(before, sym.Transition(id=f"Rest{number}", page=net), idle)
