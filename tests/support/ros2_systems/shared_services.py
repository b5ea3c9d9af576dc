"""Clients in nodes of their own that share one service."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import callback, place, step


def shared_model(clients: int = 2, middleware: str = "ros2") -> sym.SystemModel:
    """Nodes with a timer that blocks in a call of one service, and another timer."""
    model = sym.SystemModel(id="shared", middleware=middleware)
    battery = sym.NodeNet(id="battery", net=model, execution="callbacks")
    serve = callback(battery, "OnBattery", "server")
    entry, exit = place(serve, "Asked"), place(serve, "Answered")
    step(serve, "Measure", [entry], [exit])
    service = sym.ServiceChannel(
        id="Battery",
        service="/battery",
        model=model,
        server=sym.ServerPort(page=serve, entry=entry, exit=exit),
    )
    for number in range(clients):
        node = sym.NodeNet(id=f"user{number}", net=model, execution="callbacks", executor="multi", threads=2)
        tick = callback(node, f"OnTick{number}", "timer", timer=1.0)
        request, response = place(tick, f"Request{number}"), place(tick, f"Response{number}")
        step(tick, f"Ask{number}", [], [request])
        step(tick, f"Note{number}", [response])
        step(callback(node, f"OnOther{number}", "timer", timer=2.0), f"Rest{number}")
        client = sym.ClientPort(client=f"user{number}", request=request, response=response)
        client.group = sym.CallbackGroup(id=f"Answers{number}")
        node.callbackGroups.append(client.group)
        service.clients.append(client)
    return model
