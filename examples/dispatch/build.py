"""A dispatcher and n robots that share a narrow aisle, as a model with n for a parameter.

``python examples/dispatch/build.py`` writes `dispatch.sym.xmi` next to this file, with three robots, and an
earlier version of it, with two, and with a fault that `check` finds: `gives_up_waiting.sym.xmi`. Commands
that ask or write models take this file, too: ``dineros sweep examples/dispatch/build.py --vary robots=1..5``.

* The **dispatcher** gives each order to a robot that is free: a goal. While the operator stops the floor, it
  sends nothing and recalls who is on the way. An order that was not delivered waits again.
* A **robot** asks for the aisle, crosses it, leaves it, and delivers. It turns back when it is recalled or
  blocked, and leaves the aisle in any case.
* The **traffic** manager lets one robot at a time into the aisle.
* The **board** lists what was delivered.
"""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel import sym
from dineros.metamodel.build import callback, inhibit, node_net, place, step
from dineros.metamodel.files import save

HOME = Path(__file__).resolve().parent
Places = dict[str, sym.Place]


def dispatcher(model: sym.SystemModel, robots: int, orders: int) -> Places:
    """Orders become goals; return the places with ports."""
    net = node_net(model, "dispatcher", ["FloorStopped"], package="dispatch_dispatcher")
    pool, closed = place(net, "Orders", tokens=orders), place(net, "Closed")
    pool.balloons.extend(
        sym.BalloonToken(data=f'{{"number": {number}, "bay": {1 + number % 5}}}')
        for number in range(1, orders + 1)
    )
    ports: Places = {}
    for n in range(1, robots + 1):
        free, under_way, recalled = (
            place(net, f"{id}{n}", tokens) for id, tokens in (("Free", 1), ("UnderWay", 0), ("Recalled", 0))
        )
        goal, cancel, succeeded, aborted, canceled = (
            place(net, f"{id}{n}") for id in ("Goal", "Cancel", "Succeeded", "Aborted", "Canceled")
        )
        # A recall that has not left yet would be of the next goal.
        cancel.capacity = 1
        assign = step(net, f"Assign{n}", [pool, free], [goal, under_way], clause="!FloorStopped")
        inhibit(cancel, assign)
        step(net, f"Recall{n}", [under_way], [recalled, cancel], clause="FloorStopped")
        # A recall may come too late, so each end is taken whether the robot was recalled or not.
        step(net, f"Close{n}", [succeeded, under_way], [closed, free])
        step(net, f"CloseAnyway{n}", [succeeded, recalled], [closed, free])
        step(net, f"Retry{n}", [aborted, under_way], [pool, free])
        step(net, f"RetryAnyway{n}", [aborted, recalled], [pool, free])
        step(net, f"Return{n}", [canceled, recalled], [pool, free])
        ports |= {each.id: each for each in (goal, cancel, succeeded, aborted, canceled)}
    return ports


def robot(model: sym.SystemModel, n: int, *, gives_up_waiting: bool) -> tuple[sym.ActionServerPort, Places]:
    """One robot; return its action, and the places where it talks to others."""
    net = node_net(model, f"robot{n}", [f"Blocked{n}"], package=f"dispatch_robot{n}")
    page = callback(net, f"Deliver{n}", "goal")
    order, waiting, aisle, across, aback, stuck, done, failed, back, halt = (
        place(page, f"{id}{n}")
        for id in (
            "Order",
            "Waiting",
            "InAisle",
            "Across",
            "Aback",
            "Stuck",
            "Delivered",
            "Failed",
            "Back",
            "Halt",
        )
    )
    ports = {id: place(page, f"{id}{n}") for id in ("EnterReq", "EnterRes", "LeaveReq", "LeaveRes", "Told")}
    step(page, f"Depart{n}", [order], [waiting, ports["EnterReq"]])
    step(page, f"Stay{n}", [order, halt], [back])
    step(page, f"Enter{n}", [waiting, ports["EnterRes"]], [aisle])
    if gives_up_waiting:
        ports["EnterReq"].capacity = 1
        step(page, f"GiveUp{n}", [waiting, halt], [back])
    else:
        step(page, f"GiveUp{n}", [waiting, ports["EnterRes"], halt], [aback, ports["LeaveReq"]])
    cross = step(page, f"Cross{n}", [aisle], [across, ports["LeaveReq"]], clause=f"!Blocked{n}")
    inhibit(halt, cross)
    step(page, f"TurnBack{n}", [aisle, halt], [aback, ports["LeaveReq"]])
    step(page, f"Block{n}", [aisle], [stuck, ports["LeaveReq"]], clause=f"Blocked{n}")
    step(page, f"Unload{n}", [across, ports["LeaveRes"]], [done, ports["Told"]])
    step(page, f"Come{n}", [aback, ports["LeaveRes"]], [back])
    step(page, f"Report{n}", [stuck, ports["LeaveRes"]], [failed])
    server = sym.ActionServerPort(
        page=page, entry=order, succeeded=done, aborted=failed, canceled=back, cancel=halt
    )
    return server, ports


def traffic(model: sym.SystemModel) -> dict[str, sym.ServerPort]:
    """The aisle, as one token."""
    net = node_net(model, "traffic", package="dispatch_traffic")
    free, taken = place(net, "AisleFree", tokens=1), place(net, "AisleTaken")
    servers = {}
    for name, before, after in (("Enter", free, taken), ("Leave", taken, free)):
        page = callback(net, f"{name}Server", "server")
        entry, exit_ = place(page, f"{name}Entry"), place(page, f"{name}Exit")
        step(page, f"Let{name}", [entry, before], [exit_, after])
        servers[name] = sym.ServerPort(entry=entry, exit=exit_, page=page)
    return servers


def board(model: sym.SystemModel) -> sym.Place:
    """What was delivered; return where it is heard."""
    net = node_net(model, "board", package="dispatch_board")
    page = callback(net, "OnDelivery")
    heard = place(page, "Heard")
    step(page, "List", [heard], [place(page, "Listed")])
    return heard


def token_type() -> sym.TokenType:
    """Return what every token carries."""
    return sym.TokenType(
        id="Errand",
        fields=[
            sym.TokenField(name="number", kind="integer", ros="uint32"),
            sym.TokenField(name="bay", kind="integer", ros="uint8"),
            sym.TokenField(name="robot"),
            sym.TokenField(name="attempts", kind="integer", ros="uint16"),
        ],
    )


def properties(model: sym.SystemModel, robots: int, orders: int) -> None:
    """What has to hold, in the words of the model."""
    numbers = range(1, robots + 1)
    inside = " + ".join(f"InAisle{n}" for n in numbers)
    out = " + ".join(f"UnderWay{n} + Recalled{n}" for n in numbers)
    model.properties.extend(
        [
            sym.Property(id="OneInTheAisle", text=f"always {inside} <= 1"),
            sym.Property(id="NoOrderIsLost", text=f"always Orders + {out} + Closed == {orders}"),
            sym.Property(id="AllCanBeDelivered", text=f"Listed >= {orders} stays possible"),
        ]
    )


def build(robots: int = 3, orders: int = 3, gives_up_waiting: bool = False) -> sym.SystemModel:
    """Return the fleet.

    Parameters
    ----------
    robots : int
        How many there are.
    orders : int
        How many wait for them.
    gives_up_waiting : bool
        Whether it is the earlier version, in which a robot that is recalled no longer waits for the aisle.
    """
    id = "gives_up_waiting" if gives_up_waiting else "dispatch"
    model = sym.SystemModel(id=id, name=id, middleware="ros2", tokenType=token_type())
    ports = dispatcher(model, robots, orders)
    servers = traffic(model)
    heard = board(model)
    fleet = [robot(model, n, gives_up_waiting=gives_up_waiting) for n in range(1, robots + 1)]
    for n, (server, _) in enumerate(fleet, 1):
        sym.ActionChannel(
            id=f"Delivery{n}",
            action=f"/robot{n}/deliver",
            server=server,
            clients=[
                sym.ActionClientPort(
                    client="dispatcher",
                    goal=ports[f"Goal{n}"],
                    cancel=ports[f"Cancel{n}"],
                    succeeded=ports[f"Succeeded{n}"],
                    aborted=ports[f"Aborted{n}"],
                    canceled=ports[f"Canceled{n}"],
                )
            ],
            model=model,
        )
    for name, server_port in servers.items():
        sym.ServiceChannel(
            id=f"{name}Aisle",
            service=f"/aisle/{name.lower()}",
            server=server_port,
            clients=[
                sym.ClientPort(client=f"robot{n}", request=own[f"{name}Req"], response=own[f"{name}Res"])
                for n, (_, own) in enumerate(fleet, 1)
            ],
            instances=1,
            depth=max(robots, 1),
            model=model,
        )
    sym.TopicChannel(
        id="Deliveries",
        topic="/deliveries",
        qos=sym.QualityOfService(reliability="reliable", durability="transientLocal"),
        publishers=[sym.PublisherPort(place=own["Told"], limit=orders) for _, own in fleet],
        subscribers=[sym.SubscriberPort(place=heard, limit=orders)],
        model=model,
    )
    properties(model, robots, orders)
    return model


def main() -> None:
    """Write the model, and its earlier version."""
    for model in (build(), build(robots=2, orders=1, gives_up_waiting=True)):
        save(model, HOME / f"{model.id}.sym.xmi")


if __name__ == "__main__":
    main()
