"""Two mobile robots with a charging dock, a mission dispatcher and a map service, as a system model.

``python examples/fleet/build.py`` writes `fleet.sym.xmi` beside this file.

* The **dispatcher** turns orders into missions, at most two under way, and sends each to one of the robots.
* A **robot** asks the map for a route, drives until it is there (or asks again where it is blocked),
  says where it arrived, and lets its battery be charged after two missions.
* The **dock** has one bay for both robots, and has the **charger** switched on and off.
* The **map** knows routes once it is loaded.

Arrivals are `geometry_msgs/msg/PoseStamped`, and the charger is switched by `std_srvs/srv/SetBool`: programs
that know nothing of DiNeROS can listen to the one and take the place of the other.
"""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, read
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.files import save

HOME = Path(__file__).resolve().parent
ROBOTS = ("Ada", "Bob")
MISSIONS_UNDER_WAY = 2
MISSIONS_PER_CHARGE = 2
Client = tuple[sym.Place, sym.Place]


def place(page: pn.Page, id: str, tokens: int = 0) -> sym.Place:
    """Add a place."""
    return sym.Place(id=id, name=id, tokens=tokens, page=page)


def transition(page: pn.Page, id: str, clause: str | None = None) -> sym.Transition:
    """Add a transition."""
    made = sym.Transition(id=id, name=id, page=page)
    if clause:
        set_clause(made, clause)
    return made


def refer(target: pn.Place, page: pn.Page) -> pn.ReferencePlace:
    """Let a page use a place of another one."""
    return pn.ReferencePlace(id=f"{target.id}@{page.id}", name=target.name, target=target, page=page)


def node_net(model: sym.SystemModel, id: str, package: str, *signals: str) -> sym.NodeNet:
    """Add a node net with its signals."""
    net = sym.NodeNet(id=id, name=id, package=package, net=model)
    for signal in signals:
        sym.InputSignal(id=signal, name=signal, node=net)
    return net


def dispatcher(model: sym.SystemModel) -> tuple[dict[str, sym.Place], sym.Place]:
    """Give missions to robots; return the places missions are sent from, and that of arrivals."""
    net = node_net(model, "dispatcher", "fleet_dispatcher", "Paused", "NewOrder")
    orders, closed = place(net, "Orders", tokens=3), place(net, "Closed")
    orders.balloons.extend(
        sym.BalloonToken(data=f'{{"order": {number}, "x": {x}, "y": {y}}}')
        for number, (x, y) in enumerate([(4.0, 1.0), (2.5, 3.0), (0.5, 2.0)], start=1)
    )
    slots = place(net, "Slots", tokens=MISSIONS_UNDER_WAY)
    missions = {}
    for robot in ROBOTS:
        missions[robot] = place(net, f"Send{robot}")
        assign = transition(net, f"TAssign{robot}", clause="!Paused")
        flow(orders, assign, missions[robot])
        flow(slots, assign)
    again = transition(net, "TReorder", clause="NewOrder")
    flow(closed, again, orders)
    page = sym.CallbackPage(id="OnArrival", name="OnArrival", page=net)
    arrived, close = place(page, "Arrived"), transition(page, "TClose")
    flow(arrived, close, refer(closed, page))
    flow(close, refer(slots, page))
    return missions, arrived


def robot(model: sym.SystemModel, name: str) -> dict[str, sym.Place]:
    """One robot; return the places with ports, without the robot's name."""
    net = node_net(
        model, name.lower(), f"fleet_{name.lower()}", f"{name}AtGoal", f"{name}Blocked", f"{name}Stopped"
    )
    net.namespace = "/fleet"
    page = sym.CallbackPage(id=f"OnMission{name}", name=f"OnMission{name}", page=net)
    mission = place(page, f"Mission{name}")
    names = (
        "Idle",
        "Driving",
        "Charged",
        "Used",
        "RouteReq",
        "RouteRes",
        "ChargeReq",
        "ChargeRes",
        "Arrival",
    )
    tokens = {"Idle": 1, "Charged": MISSIONS_PER_CHARGE}
    own = {kind: place(net, f"{kind}{name}", tokens.get(kind, 0)) for kind in names}

    accept = transition(net, f"TAccept{name}", clause=f"!{name}Stopped")
    flow(refer(mission, net), accept, own["RouteReq"])
    flow(own["Idle"], accept)
    flow(own["Charged"], accept, own["Used"])
    flow(own["RouteRes"], transition(net, f"TDrive{name}", clause=f"!{name}Stopped"), own["Driving"])
    replan = transition(net, f"TReplan{name}", clause=f"{name}Blocked & !{name}AtGoal")
    flow(own["Driving"], replan, own["RouteReq"])
    arrive = transition(net, f"TArrive{name}", clause=f"{name}AtGoal")
    flow(own["Driving"], arrive, own["Arrival"])
    flow(arrive, own["Idle"])
    charge, ready = transition(net, f"TCharge{name}"), transition(net, f"TReady{name}")
    flow(own["Idle"], charge, own["ChargeReq"])
    flow(own["Used"], charge, weight=MISSIONS_PER_CHARGE)
    flow(own["ChargeRes"], ready, own["Idle"])
    flow(ready, own["Charged"], weight=MISSIONS_PER_CHARGE)
    return {"Mission": mission, **own}


def map_server(model: sym.SystemModel) -> sym.ServerPort:
    """Routes, once the map is loaded."""
    net = node_net(model, "map_server", "fleet_map", "MapAvailable")
    missing, loaded = place(net, "MapMissing", tokens=1), place(net, "MapLoaded")
    flow(missing, transition(net, "TLoadMap", clause="MapAvailable"), loaded)
    page = sym.CallbackPage(id="PlanServer", name="PlanServer", kind="server", page=net)
    entry, exit_ = place(page, "PlanEntry"), place(page, "PlanExit")
    plan = transition(page, "TPlan")
    flow(entry, plan, exit_)
    read(refer(loaded, page), plan)
    return sym.ServerPort(entry=entry, exit=exit_, page=page)


def dock(model: sym.SystemModel) -> tuple[sym.ServerPort, Client]:
    """One bay for both robots; return the server, and the places where an instance switches the charger."""
    net = node_net(model, "dock", "fleet_dock", "BatteryFull")
    free = place(net, "BayFree", tokens=1)
    page = sym.CallbackPage(id="ChargeServer", name="ChargeServer", kind="server", page=net)
    entry, plugged, charging, leaving, exit_ = (
        place(page, id) for id in ("ChargeEntry", "Plugged", "Charging", "Leaving", "ChargeExit")
    )
    power, answer = place(page, "PowerReq"), place(page, "PowerRes")
    bay = refer(free, page)
    enter, start = transition(page, "TEnter"), transition(page, "TStart")
    full, leave = transition(page, "TFull", clause="BatteryFull"), transition(page, "TLeave")
    flow(entry, enter, plugged, start, charging, full, leaving, leave, exit_)
    flow(bay, enter, power)
    flow(answer, start)
    flow(full, power)
    flow(answer, leave, bay)
    return sym.ServerPort(entry=entry, exit=exit_, page=page), (power, answer)


def charger(model: sym.SystemModel) -> sym.ServerPort:
    """The charger's power switch."""
    net = node_net(model, "charger", "fleet_charger")
    page = sym.CallbackPage(id="PowerServer", name="PowerServer", kind="server", page=net)
    entry, exit_ = place(page, "PowerEntry"), place(page, "PowerExit")
    flow(entry, transition(page, "TSwitch"), exit_)
    return sym.ServerPort(entry=entry, exit=exit_, page=page)


def mapping(message_field: str, token_field: str, part: str = "message") -> sym.FieldMapping:
    """Let a field of an existing interface carry a field of the token."""
    return sym.FieldMapping(part=part, messageField=message_field, tokenField=token_field)


def token_type() -> sym.TokenType:
    """Return what every token carries."""
    return sym.TokenType(
        id="Mission",
        name="Mission",
        fields=[
            sym.TokenField(name="order", kind="integer"),
            sym.TokenField(name="robot"),
            sym.TokenField(name="x", kind="number"),
            sym.TokenField(name="y", kind="number"),
            sym.TokenField(name="route", kind="list", elementKind="number"),
            sym.TokenField(name="cargo", kind="map", elementKind="integer"),
            sym.TokenField(name="powerOn", kind="boolean"),
            sym.TokenField(name="powerOk", kind="boolean"),
            sym.TokenField(name="note", default='"none"'),
        ],
    )


def build() -> sym.SystemModel:
    """Return the fleet."""
    model = sym.SystemModel(id="fleet", name="fleet", tokenType=token_type())
    missions, arrived = dispatcher(model)
    robots = {name: robot(model, name) for name in ROBOTS}
    plan_server = map_server(model)
    charge_server, power = dock(model)
    power_server = charger(model)

    for name, own in robots.items():
        sym.TopicChannel(
            id=f"Missions{name}",
            topic=f"/fleet/{name.lower()}/missions",
            publishers=[sym.PublisherPort(place=missions[name], limit=MISSIONS_UNDER_WAY)],
            subscribers=[sym.SubscriberPort(place=own["Mission"], limit=MISSIONS_UNDER_WAY)],
            model=model,
        )
    sym.TopicChannel(
        id="Arrivals",
        topic="/fleet/arrivals",
        type="geometry_msgs/msg/PoseStamped",
        mappings=[
            mapping("header.frame_id", "robot"),
            mapping("pose.position.x", "x"),
            mapping("pose.position.y", "y"),
        ],
        publishers=[sym.PublisherPort(place=own["Arrival"], limit=2) for own in robots.values()],
        subscribers=[sym.SubscriberPort(place=arrived, limit=4)],
        model=model,
    )
    for id, service, server, request in (
        ("PlanRoute", "/fleet/plan_route", plan_server, "Route"),
        ("Charge", "/fleet/charge", charge_server, "Charge"),
    ):
        sym.ServiceChannel(
            id=id,
            service=service,
            server=server,
            clients=[
                sym.ClientPort(client=name, request=own[f"{request}Req"], response=own[f"{request}Res"])
                for name, own in robots.items()
            ],
            model=model,
        )
    sym.ServiceChannel(
        id="Power",
        service="/fleet/charger_power",
        type="std_srvs/srv/SetBool",
        mappings=[
            mapping("data", "powerOn", "request"),
            mapping("success", "powerOk", "response"),
            mapping("message", "note", "response"),
        ],
        server=power_server,
        clients=[sym.ClientPort(client="dock", request=power[0], response=power[1])],
        instances=1,
        model=model,
    )
    return model


def main() -> None:
    """Write the model."""
    save(build(), HOME / "fleet.sym.xmi")


if __name__ == "__main__":
    main()
