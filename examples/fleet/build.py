"""Two mobile robots with a charging dock, a mission dispatcher and a map service, as a system model.

``python examples/fleet/build.py`` writes `fleet.sym.xmi` next to this file.

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

from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, here, node_net, place, read, step
from dineros.metamodel.files import save

HOME = Path(__file__).resolve().parent
ROBOTS = ("Ada", "Bob")
MISSIONS_UNDER_WAY = 2
MISSIONS_PER_CHARGE = 2
Client = tuple[sym.Place, sym.Place]


def dispatcher(model: sym.SystemModel) -> tuple[dict[str, sym.Place], sym.Place]:
    """Give missions to robots; return the places missions are sent from, and that of arrivals."""
    net = node_net(model, "dispatcher", ["Paused", "NewOrder"], package="fleet_dispatcher")
    orders, closed = place(net, "Orders", tokens=3), place(net, "Closed")
    orders.balloons.extend(
        sym.BalloonToken(data=f'{{"order": {number}, "x": {x}, "y": {y}}}')
        for number, (x, y) in enumerate([(4.0, 1.0), (2.5, 3.0), (0.5, 2.0)], start=1)
    )
    slots = place(net, "Slots", tokens=MISSIONS_UNDER_WAY)
    missions = {}
    for robot in ROBOTS:
        missions[robot] = place(net, f"Send{robot}")
        assign = step(net, f"TAssign{robot}", clause="!Paused")
        flow(orders, assign, missions[robot])
        flow(slots, assign)
    step(net, "TReorder", [closed], [orders], clause="NewOrder")
    page = callback(net, "OnArrival")
    arrived = place(page, "Arrived")
    step(page, "TClose", [arrived], [closed, slots])
    return missions, arrived


def robot(model: sym.SystemModel, name: str) -> dict[str, sym.Place]:
    """One robot; return the places with ports, without the robot's name."""
    signals = (f"{name}{signal}" for signal in ("AtGoal", "Blocked", "Stopped"))
    net = node_net(model, name.lower(), signals, package=f"fleet_{name.lower()}")
    net.namespace = "/fleet"
    page = callback(net, f"OnMission{name}")
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

    accept = step(net, f"TAccept{name}", clause=f"!{name}Stopped")
    flow(here(mission, net), accept, own["RouteReq"])
    flow(own["Idle"], accept)
    flow(own["Charged"], accept, own["Used"])
    step(net, f"TDrive{name}", [own["RouteRes"]], [own["Driving"]], clause=f"!{name}Stopped")
    blocked = f"{name}Blocked & !{name}AtGoal"
    step(net, f"TReplan{name}", [own["Driving"]], [own["RouteReq"]], clause=blocked)
    step(net, f"TArrive{name}", [own["Driving"]], [own["Arrival"], own["Idle"]], clause=f"{name}AtGoal")
    charge, ready = step(net, f"TCharge{name}"), step(net, f"TReady{name}")
    flow(own["Idle"], charge, own["ChargeReq"])
    flow(own["Used"], charge, weight=MISSIONS_PER_CHARGE)
    flow(own["ChargeRes"], ready, own["Idle"])
    flow(ready, own["Charged"], weight=MISSIONS_PER_CHARGE)
    return {"Mission": mission, **own}


def map_server(model: sym.SystemModel) -> sym.ServerPort:
    """Routes, once the map is loaded."""
    net = node_net(model, "map_server", ["MapAvailable"], package="fleet_map")
    missing, loaded = place(net, "MapMissing", tokens=1), place(net, "MapLoaded")
    step(net, "TLoadMap", [missing], [loaded], clause="MapAvailable")
    page = callback(net, "PlanServer", "server")
    entry, exit_ = place(page, "PlanEntry"), place(page, "PlanExit")
    plan = step(page, "TPlan", [entry], [exit_])
    read(here(loaded, page), plan)
    return sym.ServerPort(entry=entry, exit=exit_, page=page)


def dock(model: sym.SystemModel) -> tuple[sym.ServerPort, Client]:
    """One bay for both robots; return the server, and the places where an instance switches the charger."""
    net = node_net(model, "dock", ["BatteryFull"], package="fleet_dock")
    free = place(net, "BayFree", tokens=1)
    page = callback(net, "ChargeServer", "server")
    entry, plugged, charging, leaving, exit_ = (
        place(page, id) for id in ("ChargeEntry", "Plugged", "Charging", "Leaving", "ChargeExit")
    )
    power, answer = place(page, "PowerReq"), place(page, "PowerRes")
    bay = here(free, page)
    enter, start = step(page, "TEnter"), step(page, "TStart")
    full, leave = step(page, "TFull", clause="BatteryFull"), step(page, "TLeave")
    flow(entry, enter, plugged, start, charging, full, leaving, leave, exit_)
    flow(bay, enter, power)
    flow(answer, start)
    flow(full, power)
    flow(answer, leave, bay)
    return sym.ServerPort(entry=entry, exit=exit_, page=page), (power, answer)


def charger(model: sym.SystemModel) -> sym.ServerPort:
    """The charger's power switch."""
    net = node_net(model, "charger", package="fleet_charger")
    page = callback(net, "PowerServer", "server")
    entry, exit_ = place(page, "PowerEntry"), place(page, "PowerExit")
    step(page, "TSwitch", [entry], [exit_])
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
