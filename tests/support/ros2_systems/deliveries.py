"""A delivery robot as an action: goals that are accepted or refused, canceled, and end in three ways."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import arcs, find


def deliveries(
    clients: int = 1,
    slots: int | None = None,
    *,
    goals: int = 1,
    cancels: int = 1,
    rejects: bool = True,
    feedback: bool = False,
    heeds: bool = True,
) -> sym.SystemModel:
    """Return a robot that delivers parcels for offices.

    Parameters
    ----------
    clients : int
        Offices, each with a node net of its own.
    slots : int or None
        Goals that the robot works on at once; one for each office where it is None.
    goals, cancels : int
        How many parcels each office orders, and how many orders it may regret and ask to cancel.
    rejects : bool
        Whether the robot may refuse goals.
    feedback : bool
        Whether it tells that it has started.
    heeds : bool
        Whether it gives up when it is asked to cancel.
    """
    model = sym.SystemModel(id="deliveries", middleware="ros2")
    robot = sym.NodeNet(id="robot", net=model)
    page = sym.CallbackPage(id="Deliver", kind="goal", page=robot)
    entry, driving, arrived, failed = (
        sym.Place(id=id, page=page) for id in ("Parcel", "Driving", "At", "Lost")
    )
    start = sym.Transition(id="Start", page=page)
    flow(entry, start, driving, sym.Transition(id="Arrive", page=page), arrived)
    flow(driving, sym.Transition(id="Break", page=page), failed)
    server = sym.ActionServerPort(
        page=page, entry=entry, succeeded=arrived, aborted=failed, mayReject=rejects
    )
    if cancels:
        server.cancel, server.canceled = sym.Place(id="Stop", page=page), sym.Place(id="Back", page=page)
        if heeds:
            give_up = sym.Transition(id="Return", page=page)
            flow(driving, give_up, server.canceled)
            flow(server.cancel, give_up)
    if feedback:
        server.feedback = sym.Place(id="Progress", page=page)
        flow(start, server.feedback)
    channel = sym.ActionChannel(id="Delivery", action="/deliver", instances=slots, server=server, model=model)
    for number in range(clients):
        channel.clients.append(_office(model, number, goals, cancels, feedback))
    return model


def _office(
    model: sym.SystemModel, number: int, goals: int, cancels: int, feedback: bool
) -> sym.ActionClientPort:
    office = sym.NodeNet(id=f"office{number}", net=model)

    def place(name: str, tokens: int = 0) -> pn.Place:
        return sym.Place(id=f"{name}{number}", tokens=tokens, page=office)

    send, recall = place("Send", 0 if cancels else goals), None
    if cancels:
        ordered, recall = place("Ordered"), place("Recall")
        order = sym.Transition(id=f"Order{number}", page=office)
        flow(place("Wanted", goals), order, send)
        regret = sym.Transition(id=f"Regret{number}", page=office)
        flow(order, ordered, regret, recall)
        flow(place("Doubt", cancels), regret)
    return sym.ActionClientPort(
        client=f"office{number}",
        goal=send,
        succeeded=place("Delivered"),
        aborted=place("Failed"),
        rejected=place("Refused"),
        canceled=place("Canceled") if cancels else None,
        cancel=recall,
        feedback=place("Heard") if feedback else None,
    )


def regretting_any_time(model: sym.SystemModel) -> sym.SystemModel:
    """Let the first office of a model ask to cancel orders that it never placed; return the model."""
    regret = find(model, "Regret0", pn.Transition)
    for arc in [each for each in arcs(model) if each.target is regret and each.source.id == "Ordered0"]:
        assert arc.page is not None
        arc.page.arcs.remove(arc)
        arc.source.outgoing.remove(arc)
        regret.incoming.remove(arc)
    return model
