"""The sorting cell with pick and place as actions, which are canceled when a person comes near.

``python examples/sorting_actions/build.py`` writes `cell.sym.xmi` next to this file, and two earlier versions
of it with faults that `check` finds: `only_asks.sym.xmi` and `waits_for_canceled.sym.xmi`.

* The **selector** takes pieces from the pools of their colours.
* The **controller** has two cells, left and right. A cell asks for the shared space, has a piece picked and
  placed, tries again what was canceled, leaves the space, and reports.
* The **synchronizer** gives the shared space to one cell at a time.
* The **arm** picks and places: two actions, whose goals can be canceled.
* The **guard** sees who comes near. It asks the controller to hold, opens the gate when nothing moves,
  shuts it when the person is gone, and lets the controller resume.
* The **display** shows what became of each piece.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Literal, get_args

from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, here, inhibit, node_net, place, step
from dineros.metamodel.files import save

HOME = Path(__file__).resolve().parent
CELLS = {"L": ("Red", "Blue"), "R": ("Green",)}
"""The cells, and the colours of the pieces that each sorts."""
SIDES = {"L": "Left", "R": "Right"}
MOTIONS = ("Pick", "Place")
Version = Literal["only_asks", "waits_for_canceled", "cell"]
"""When the controller says that it holds: once it has asked to cancel, once a goal was canceled, or once it
is over, however it ended."""
Places = dict[str, sym.Place]
Cells = Mapping[str, Sequence[str]]


def selector(model: sym.SystemModel, colors: Sequence[str]) -> Places:
    """Pools of pieces; return where the chosen ones are sent from, by colour."""
    net = node_net(model, "selector", colors, package="cell_selector")
    chosen = {}
    for color in colors:
        pool = place(net, f"{color}Pieces", tokens=1)
        pool.balloons.append(sym.BalloonToken(data=f'{{"color": "{color.lower()}"}}'))
        chosen[color] = place(net, f"Chosen{color}")
        step(net, f"Choose{color}", [pool], [chosen[color]], clause=color)
    return chosen


def controller(
    model: sym.SystemModel, version: Version, access: sym.TokenType, cells: Iterable[str]
) -> Places:
    """The cells, and the services that let a person in; return the places with ports."""
    net = node_net(model, "controller", package="cell_controller")
    zone = pn.Page(id="Zone", name="Zone", page=net)
    # To have something moved takes the permit: a cell has it while its goal is under way, or the person at
    # the gate.
    permit, lent = place(zone, "Permit", tokens=1), place(zone, "Lent")
    wanted = place(zone, "HoldWanted", type=access)
    ports: Places = {}
    for cell in cells:
        ports |= _cell(net, cell, permit, wanted, version)
    hold = callback(net, "HoldServer", "server")
    asked, granted = (place(hold, id, type=access) for id in ("HoldAsked", "HoldGranted"))
    resume = callback(net, "ResumeServer", "server")
    resumes, resumed = (place(resume, id, type=access) for id in ("ResumeAsked", "Resumed"))
    if version == "only_asks":
        step(hold, "HoldIdle", [asked, permit], [granted, permit, wanted])
        step(resume, "GoOn", [resumes, wanted], [resumed])
        stopped = granted
    else:
        stopped = place(hold, "HoldWaiting", type=access)
        step(hold, "HoldIdle", [asked, permit], [granted, lent])
        step(hold, "Grant", [stopped, wanted, permit], [granted, lent])
        step(resume, "GoOn", [resumes, lent], [resumed, permit])
    for name in (f"{motion}{cell}" for motion in MOTIONS for cell in cells):
        under_way = ports[f"UnderWay{name}"]
        then = ports.get(f"Stopping{name}", under_way)
        step(hold, f"Stop{name}", [asked, under_way], [then, ports[f"Cancel{name}"], stopped, wanted])
    return ports | {each.id: each for each in (asked, granted, resumes, resumed)}


def _cell(
    net: sym.NodeNet,
    cell: str,
    permit: sym.Place,
    wanted: sym.Place,
    version: Version,
) -> Places:
    """One cell: space, pick, place, space back, report."""
    page = callback(net, f"OnPiece{cell}")
    ports = {name: place(page, f"{name}{cell}") for name in ("Piece", "GetReq", "GetRes", "EndReq", "EndRes")}
    ready = {motion: place(page, f"ReadyTo{motion}{cell}") for motion in MOTIONS}
    done, result = place(page, f"Done{cell}"), place(page, f"Result{cell}")
    step(page, f"AskForSpace{cell}", [ports["Piece"]], [ports["GetReq"]])
    step(page, f"Enter{cell}", [ports["GetRes"]], [ready["Pick"]])
    follows = {"Pick": ready["Place"], "Place": done}
    for motion in MOTIONS:
        own = {
            role: place(page, f"{role}{motion}{cell}")
            for role in ("Goal", "Succeeded", "Aborted", "Canceled", "Cancel")
        }
        own["Cancel"].capacity = 1
        under_way = own["UnderWay"] = place(page, f"UnderWay{motion}{cell}")
        starts = step(page, f"Start{motion}{cell}", [ready[motion], permit], [own["Goal"], under_way])
        inhibit(here(wanted, page), starts)
        step(page, f"{motion}Succeeded{cell}", [own["Succeeded"], under_way], [follows[motion], permit])
        step(page, f"{motion}Aborted{cell}", [own["Aborted"], under_way], [done, permit])
        ended = under_way
        if version == "waits_for_canceled":
            ended = own["Stopping"] = place(page, f"Stopping{motion}{cell}")
        step(page, f"{motion}Canceled{cell}", [own["Canceled"], ended], [ready[motion], permit])
        ports |= {f"{role}{motion}": made for role, made in own.items()}
    step(page, f"Leave{cell}", [done], [ports["EndReq"]])
    step(page, f"Report{cell}", [ports["EndRes"]], [result])
    ports["Result"] = result
    return {f"{name}{cell}": made for name, made in ports.items()}


def synchronizer(model: sym.SystemModel) -> dict[str, sym.ServerPort]:
    """The shared space, as one token."""
    net = node_net(model, "synchronizer", package="cell_synchronizer")
    state = pn.Page(id="Space", name="Space", page=net)
    free, taken = place(state, "SpaceFree", tokens=1), place(state, "SpaceTaken")
    servers = {}
    for operation, before, after in (("Get", free, taken), ("End", taken, free)):
        page = callback(net, f"{operation}Server", "server")
        entry, exit_ = place(page, f"{operation}Entry"), place(page, f"{operation}Exit")
        step(page, f"{operation}Space", [entry, before], [exit_, after])
        servers[operation] = sym.ServerPort(entry=entry, exit=exit_, page=page)
    return servers


def arm(model: sym.SystemModel) -> dict[str, sym.ActionServerPort]:
    """The arm: what it does about one goal, for picking and for placing."""
    net = node_net(model, "arm", ["AtRest", "Holding"], package="cell_arm")
    servers = {}
    for motion, success in (("Pick", "Holding"), ("Place", "!Holding")):
        page = callback(net, f"{motion}Server", "goal")
        made = {
            role: place(page, f"{motion}{role}")
            for role in ("Asked", "Moving", "Braking", "Done", "Failed", "GivenUp", "Stop")
        }
        fails = "!Holding" if success == "Holding" else "Holding"
        step(page, f"Move{motion}", [made["Asked"]], [made["Moving"]])
        step(page, f"Drop{motion}", [made["Asked"], made["Stop"]], [made["GivenUp"]])
        step(page, f"Finish{motion}", [made["Moving"]], [made["Done"]], clause=f"AtRest & {success}")
        step(page, f"Fail{motion}", [made["Moving"]], [made["Failed"]], clause=f"AtRest & {fails}")
        step(page, f"Brake{motion}", [made["Moving"], made["Stop"]], [made["Braking"]])
        step(page, f"Rest{motion}", [made["Braking"]], [made["GivenUp"]], clause="AtRest")
        servers[motion] = sym.ActionServerPort(
            page=page,
            entry=made["Asked"],
            succeeded=made["Done"],
            aborted=made["Failed"],
            canceled=made["GivenUp"],
            cancel=made["Stop"],
        )
    return servers


def guard(model: sym.SystemModel, access: sym.TokenType) -> Places:
    """Who comes near waits until the gate opens; return the places with ports."""
    net = node_net(model, "guard", ["PersonNear", "GateShut"], package="cell_guard")
    watching = place(net, "Watching", tokens=1, type=access)
    gate = place(net, "GateOpen", type=access)
    shutting = place(net, "GateShutting", type=access)
    ports = {id: place(net, id, type=access) for id in ("HoldReq", "HoldRes", "ResumeReq", "ResumeRes")}
    step(net, "Notice", [watching], [ports["HoldReq"]], clause="PersonNear")
    step(net, "OpenGate", [ports["HoldRes"]], [gate])
    step(net, "ShutGate", [gate], [shutting], clause="!PersonNear")
    step(net, "Release", [shutting], [ports["ResumeReq"]], clause="GateShut")
    step(net, "Watch", [ports["ResumeRes"]], [watching])
    return ports


def display(model: sym.SystemModel) -> sym.Place:
    """What became of each piece; return where it is heard."""
    net = node_net(model, "display", package="cell_display")
    page = callback(net, "OnResult")
    heard = place(page, "ResultHeard")
    step(page, "Show", [heard], [place(page, "Shown")])
    return heard


def token_types() -> tuple[sym.TokenType, sym.TokenType]:
    """Return what goals and results carry, and what the guard asks."""
    piece = [
        sym.TokenField(name="name"),
        sym.TokenField(name="color"),
        sym.TokenField(name="pose", kind="list", elementKind="number", length=6),
        sym.TokenField(name="isSorted", kind="boolean"),
        sym.TokenField(name="interruptions", kind="integer", ros="uint16"),
        sym.TokenField(name="note"),
    ]
    access = [sym.TokenField(name="reason"), sym.TokenField(name="number", kind="integer", ros="uint32")]
    return sym.TokenType(id="Piece", fields=piece), sym.TokenType(id="Access", fields=access)


def topic(
    model: sym.SystemModel,
    id: str,
    name: str,
    sends: list[sym.Place],
    receives: sym.Place,
    depth: int,
    **qos: str,
) -> None:
    """Add a topic."""
    sym.TopicChannel(
        id=id,
        name=id,
        topic=name,
        qos=sym.QualityOfService(**qos),  # type: ignore[arg-type]
        publishers=[sym.PublisherPort(place=sent, limit=depth) for sent in sends],
        subscribers=[sym.SubscriberPort(place=receives, limit=depth)],
        model=model,
    )


def topics(model: sym.SystemModel, cells: Cells, chosen: Places, ports: Places, heard: sym.Place) -> None:
    """Pieces and results, of which none may be lost."""
    kept = {"reliability": "reliable", "durability": "transientLocal"}
    for cell, colors in cells.items():
        side, pieces = SIDES[cell], [chosen[color] for color in colors]
        topic(model, f"{side}Pieces", f"/{side.lower()}/pieces", pieces, ports[f"Piece{cell}"], 4, **kept)
    topic(model, "Results", "/results", [ports[f"Result{cell}"] for cell in cells], heard, 4, **kept)


def services(
    model: sym.SystemModel,
    cells: Iterable[str],
    ports: Places,
    spaces: dict[str, sym.ServerPort],
    gate: Places,
) -> None:
    """The shared space for the cells, and the controller's services for the guard."""
    for name, server in spaces.items():
        sym.ServiceChannel(
            id=f"{name}Control",
            service=f"/space/{name.lower()}",
            server=server,
            clients=[
                sym.ClientPort(
                    client=cell, request=ports[f"{name}Req{cell}"], response=ports[f"{name}Res{cell}"]
                )
                for cell in cells
            ],
            instances=1,
            model=model,
        )
    for name, entry, exit_ in (("Hold", "HoldAsked", "HoldGranted"), ("Resume", "ResumeAsked", "Resumed")):
        sym.ServiceChannel(
            id=name,
            service=f"/controller/{name.lower()}",
            server=sym.ServerPort(entry=ports[entry], exit=ports[exit_], page=ports[entry].page),
            clients=[sym.ClientPort(client="guard", request=gate[f"{name}Req"], response=gate[f"{name}Res"])],
            instances=1,
            model=model,
        )


def actions(
    model: sym.SystemModel, cells: Iterable[str], servers: dict[str, sym.ActionServerPort], ports: Places
) -> None:
    """Picking and placing: one slot, as there is one arm."""
    for motion, server in servers.items():
        sym.ActionChannel(
            id=motion,
            name=motion,
            action=f"/arm/{motion.lower()}",
            server=server,
            clients=[
                sym.ActionClientPort(
                    client=cell,
                    goal=ports[f"Goal{motion}{cell}"],
                    succeeded=ports[f"Succeeded{motion}{cell}"],
                    aborted=ports[f"Aborted{motion}{cell}"],
                    canceled=ports[f"Canceled{motion}{cell}"],
                    cancel=ports[f"Cancel{motion}{cell}"],
                )
                for cell in cells
            ],
            instances=1,
            model=model,
        )


def properties(model: sym.SystemModel, cells: Cells) -> None:
    """What has to hold, in the words of the model."""
    moving = " + ".join(f"{motion}{how}" for motion in MOTIONS for how in ("Moving", "Braking"))
    starts = " or ".join(f"fired(Start{motion}{cell})" for motion in MOTIONS for cell in cells)
    pieces = sum(map(len, cells.values()))
    model.properties.extend(
        [
            sym.Property(id="NobodyNearAMovingArm", text=f"always {moving} + GateOpen <= 1"),
            sym.Property(
                id="NothingStartsWhileOpen",
                text=f"after fired(OpenGate) until fired(ShutGate): never {starts}",
            ),
            sym.Property(id="AllCanBeShown", text=f"Shown >= {pieces} stays possible"),
            sym.Property(id="TheGateCanOpen", text="GateOpen >= 1 stays possible"),
        ]
    )


def build(version: Version = "cell", cells: Cells = CELLS) -> sym.SystemModel:
    """Return the application, or an earlier version of it; with some of its cells and colours."""
    piece, access = token_types()
    model = sym.SystemModel(
        id=version,
        name=version,
        middleware="ros2",
        tokenType=piece,
        otherTokenTypes=[access],
    )
    chosen = selector(model, [color for colors in cells.values() for color in colors])
    ports = controller(model, version, access, cells)
    spaces = synchronizer(model)
    motions = arm(model)
    gate = guard(model, access)
    topics(model, cells, chosen, ports, display(model))
    services(model, cells, ports, spaces, gate)
    actions(model, cells, motions, ports)
    properties(model, cells)
    return model


def main() -> None:
    """Write the model and its earlier versions."""
    for version in get_args(Version):
        save(build(version), HOME / f"{version}.sym.xmi")


if __name__ == "__main__":
    main()
