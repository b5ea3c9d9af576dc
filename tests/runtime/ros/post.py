"""A post office: letters on a topic, a service with two clients, a topic of an existing type."""

from __future__ import annotations

import json

from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause

LETTER = {
    "subject": 'grüße, "all"',
    "number": -(2**40),
    "weight": 0.25,
    "isUrgent": True,
    "stamps": ["red", "blue"],
    "size": [1.0, 2.5, -3.0],
    "visits": [3, 1],
    "seals": [True, False],
    "prices": {"stamp": 0.5, "box": 2.0},
    "counts": {"pages": 4},
    "notes": {"from": "me"},
}


def _letter() -> sym.TokenType:
    return sym.TokenType(
        id="Letter",
        fields=[
            sym.TokenField(name="subject"),
            sym.TokenField(name="number", kind="integer"),
            sym.TokenField(name="weight", kind="number"),
            sym.TokenField(name="isUrgent", kind="boolean"),
            sym.TokenField(name="stamps", kind="list"),
            sym.TokenField(name="size", kind="list", elementKind="number", length=3),
            sym.TokenField(name="visits", kind="list", elementKind="integer"),
            sym.TokenField(name="seals", kind="list", elementKind="boolean"),
            sym.TokenField(name="prices", kind="map", elementKind="number"),
            sym.TokenField(name="counts", kind="map", elementKind="integer"),
            sym.TokenField(name="notes", kind="map", elementKind="text"),
        ],
    )


def post(letters: int = 3, durability: str = "volatile") -> sym.SystemModel:
    """Return the model, with so many letters at first; the first one carries `LETTER`."""
    pile, send, sent = sym.Place(id="Pile", tokens=letters), sym.Transition(id="TSend"), sym.Place(id="Sent")
    pile.balloons.extend(sym.BalloonToken(data=json.dumps(LETTER)) for _ in range(min(letters, 1)))
    office = sym.NodeNet(
        id="office",
        objects=[pile, send, sent],
        signals=[sym.InputSignal(id="Open"), sym.InputSignal(id="too-late")],
    )
    flow(pile, send, sent)
    set_clause(send, "Open & !too-late")

    arrived, read_, read = sym.Place(id="Arrived"), sym.Transition(id="TRead"), sym.Place(id="Read")
    shown, look, seen = sym.Place(id="Shown"), sym.Transition(id="TLook"), sym.Place(id="Seen")
    on_letter = sym.CallbackPage(id="OnLetter", objects=[arrived, read_, read])
    on_shown = sym.CallbackPage(id="OnShown", objects=[shown, look, seen])
    house = sym.NodeNet(id="house", objects=[on_letter, on_shown])
    flow(arrived, read_, read)
    flow(shown, look, seen)

    desk = sym.NodeNet(id="desk")
    clients = []
    for name in ("A", "B"):
        wish = sym.Place(id=f"Wish{name}", tokens=1, page=desk)
        ask, asked = sym.Transition(id=f"TAsk{name}", page=desk), sym.Place(id=f"Asked{name}", page=desk)
        told = sym.Place(id=f"Told{name}", page=desk)
        note, noted = sym.Transition(id=f"TNote{name}", page=desk), sym.Place(id=f"Noted{name}", page=desk)
        flow(wish, ask, asked)
        flow(told, note, noted)
        clients.append(sym.ClientPort(client=f"client{name}", request=asked, response=told))

    entry, weigh, exit_ = sym.Place(id="Entry"), sym.Transition(id="TWeigh"), sym.Place(id="Exit")
    serving = sym.CallbackPage(id="Weighing", kind="server", objects=[entry, weigh, exit_])
    reading, show, shown_out = (
        sym.Place(id="Reading", tokens=1),
        sym.Transition(id="TShow"),
        sym.Place(id="Out"),
    )
    reading.balloons.append(sym.BalloonToken(data='{"weight": 7.5}'))
    scale = sym.NodeNet(id="scale", namespace="/cellar", objects=[serving, reading, show, shown_out])
    flow(entry, weigh, exit_)
    flow(reading, show, shown_out)

    return sym.SystemModel(
        id="post",
        tokenType=_letter(),
        pages=[office, house, desk, scale],
        channels=[
            sym.TopicChannel(
                id="Letters",
                topic="/letters",
                qos=sym.QualityOfService(durability=durability),
                publishers=[sym.PublisherPort(place=sent, limit=5)],
                subscribers=[sym.SubscriberPort(place=arrived, limit=5)],
            ),
            sym.ServiceChannel(
                id="Weigh",
                service="/weigh",
                server=sym.ServerPort(entry=entry, exit=exit_, page=serving),
                clients=clients,
                instances=2,
            ),
            sym.TopicChannel(
                id="Readings",
                topic="/readings",
                type="std_msgs/msg/Float64",
                mappings=[sym.FieldMapping(part="message", messageField="data", tokenField="weight")],
                publishers=[sym.PublisherPort(place=shown_out, limit=5)],
                subscribers=[sym.SubscriberPort(place=shown, limit=5)],
            ),
        ],
    )
