"""A small system model with a token type, a topic and a service, and the changes its modeller makes to it."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, read
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find


def kitchen() -> sym.SystemModel:
    """Return a waiter who orders dishes from a cook, and a board that shows what was served."""
    hungry, order, wanted = (
        sym.Place(id="Hungry", tokens=2),
        sym.Transition(id="TOrder"),
        sym.Place(id="Wanted"),
    )
    dish, serve, served = sym.Place(id="Dish"), sym.Transition(id="TServe"), sym.Place(id="Served")
    hungry.balloons.append(sym.BalloonToken(data='{"dish": "soup", "table": 3}'))
    waiter = sym.NodeNet(
        id="waiter",
        objects=[hungry, order, wanted, dish, serve, served],
        signals=[sym.InputSignal(id="Open", initial=True)],
    )
    flow(hungry, order, wanted)
    flow(dish, serve, served)
    set_clause(order, "Open")

    ticket, cook, done = sym.Place(id="Ticket"), sym.Transition(id="TCook"), sym.Place(id="Done")
    stove = sym.Place(id="Stove", tokens=1)
    page = sym.CallbackPage(id="Kitchen", kind="server", objects=[ticket, cook, done])
    cook_net = sym.NodeNet(id="cook", package="kitchen_cook", namespace="/back", objects=[stove, page])
    shared = pn.ReferencePlace(id="Stove@Kitchen", target=stove, page=page)
    flow(ticket, cook, done)
    read(shared, cook)

    shown, show, kept = sym.Place(id="Shown"), sym.Transition(id="TShow"), sym.Place(id="Kept")
    callback = sym.CallbackPage(id="OnServed", objects=[shown, show, kept])
    board = sym.NodeNet(id="board", objects=[callback])
    flow(shown, show, kept)

    return sym.SystemModel(
        id="kitchen",
        tokenType=sym.TokenType(
            id="Meal",
            fields=[
                sym.TokenField(name="dish"),
                sym.TokenField(name="table", kind="integer"),
                sym.TokenField(name="isHot", kind="boolean"),
                sym.TokenField(name="prices", kind="list", elementKind="number", length=2),
                sym.TokenField(name="notes", kind="map", elementKind="text"),
                sym.TokenField(name="guest", default='"nobody"'),
            ],
        ),
        pages=[waiter, cook_net, board],
        channels=[
            sym.ServiceChannel(
                id="Cook",
                service="cook",
                server=sym.ServerPort(entry=ticket, exit=done, page=page),
                clients=[sym.ClientPort(client="waiter", request=wanted, response=dish)],
                instances=2,
            ),
            sym.TopicChannel(
                id="ServedMeals",
                topic="/served",
                publishers=[sym.PublisherPort(place=served, limit=4)],
                subscribers=[sym.SubscriberPort(place=shown, limit=5)],
            ),
        ],
    )


def add_transition(model: sym.SystemModel, id: str = "TPay") -> None:
    """Let guests pay instead of being served."""
    waiter = find(model, "waiter", sym.NodeNet)
    paid, pay = sym.Place(id="Paid", page=waiter), sym.Transition(id=id, page=waiter)
    flow(find(model, "Hungry", sym.Place), pay, paid)


def remove_transition(model: sym.SystemModel, id: str) -> None:
    """Remove a transition with its arcs."""
    transition = find(model, id, pn.Transition)
    page = transition.page
    assert page is not None
    for arc in list(page.arcs):
        if transition in (arc.source, arc.target):
            page.arcs.remove(arc)
    page.objects.remove(transition)


def change_field(model: sym.SystemModel, field_name: str, **features: object) -> None:
    """Change a field of the token type."""
    assert model.tokenType is not None
    (field,) = (field for field in model.tokenType.fields if field.name == field_name)
    for feature, value in features.items():
        setattr(field, feature, value)


def rename_node(model: sym.SystemModel, old: str, new: str) -> None:
    """Give a node net another id, and with it another package."""
    find(model, old, sym.NodeNet).id = new
