"""A shop whose server page calls a bakery and publishes: two customers, two instances, an answer for each.

Customers order bread; an instance of the shop's service has it baked by another service, tells the board that
it did, and hands it over. What the board hears is a request of its own: it has it printed.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow


def bakery(instances: int | None = None) -> sym.SystemModel:
    """Return the model; `instances` is how many the shop's service has, by default one for each customer."""
    model = sym.SystemModel(
        id="bakery", tokenType=sym.TokenType(id="Bread", fields=[sym.TokenField(name="label")])
    )
    order, bake, printing = _shop(model, instances), _oven(model), _printer(model)
    page = order.server.page
    bake.clients.append(
        sym.ClientPort(client="baker", request=_on(page, "Dough"), response=_on(page, "Baked"))
    )
    for name in ("ann", "bob"):
        net = sym.NodeNet(id=name, net=model)
        wish, want, got = (sym.Place(id=f"{id}{name}", page=net) for id in ("Wish", "Want", "Got"))
        wish.tokens = 2
        wish.balloons.extend(sym.BalloonToken(data=f'{{"label": "{name}{number}"}}') for number in (1, 2))
        flow(wish, sym.Transition(id=f"Ask{name}", page=net), want)
        order.clients.append(sym.ClientPort(client=name, request=want, response=got))
    board = sym.NodeNet(id="board", net=model)
    callback = sym.CallbackPage(id="OnSold", page=board)
    sold, printed = (sym.Place(id=id, page=callback) for id in ("Sold", "Printed"))
    printing.clients.append(sym.ClientPort(client="board", request=sold, response=printed))
    news = sym.TopicChannel(
        id="Sales",
        topic="/sales",
        publishers=[sym.PublisherPort(place=_on(page, "Told"), limit=4)],
        subscribers=[sym.SubscriberPort(place=sold, limit=4)],
    )
    model.channels.extend([order, bake, printing, news])
    return model


def _on(page: pn.Page, id: str) -> sym.Place:
    return next(node for node in page.objects if isinstance(node, sym.Place) and node.id == id)


def _shop(model: sym.SystemModel, instances: int | None) -> sym.ServiceChannel:
    page = sym.CallbackPage(id="Counter", kind="server", page=sym.NodeNet(id="shop", net=model))
    entry, dough, baked, told, exit_ = (
        sym.Place(id=id, page=page) for id in ("Ordered", "Dough", "Baked", "Told", "Bag")
    )
    hand = sym.Transition(id="HandOver", page=page)
    flow(entry, sym.Transition(id="TakeOrder", page=page), dough)
    flow(baked, hand, exit_)
    flow(hand, told)
    server = sym.ServerPort(entry=entry, exit=exit_, page=page)
    return sym.ServiceChannel(id="Order", service="/order", server=server, instances=instances)


def _oven(model: sym.SystemModel) -> sym.ServiceChannel:
    page = sym.CallbackPage(id="Oven", kind="server", page=sym.NodeNet(id="oven", net=model))
    entry, exit_ = sym.Place(id="Raw", page=page), sym.Place(id="Done", page=page)
    flow(entry, sym.Transition(id="Heat", page=page), exit_)
    return sym.ServiceChannel(
        id="Bake", service="/bake", server=sym.ServerPort(entry=entry, exit=exit_, page=page)
    )


def _printer(model: sym.SystemModel) -> sym.ServiceChannel:
    page = sym.CallbackPage(id="Press", kind="server", page=sym.NodeNet(id="printer", net=model))
    entry, exit_ = sym.Place(id="Blank", page=page), sym.Place(id="Sheet", page=page)
    flow(entry, sym.Transition(id="Stamp", page=page), exit_)
    return sym.ServiceChannel(
        id="Print", service="/print", server=sym.ServerPort(entry=entry, exit=exit_, page=page)
    )


def shared(model: sym.SystemModel) -> sym.SystemModel:
    """Move the client out of the server page and refer to its places: instances then mix up their answers."""
    page = next(each for each in model.channels if each.id == "Order").server.page  # type: ignore[attr-defined]
    net = page.page
    for id in ("Dough", "Baked"):
        place = _on(page, id)
        reference = pn.ReferencePlace(id=f"{id}Here", target=place, page=page)
        for arc in (*place.incoming, *place.outgoing):
            if arc.source is place:
                arc.source = reference
            else:
                arc.target = reference
        net.objects.append(place)
    return model
