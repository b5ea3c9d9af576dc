"""The case study as a system model: two arms sort coloured objects in a shared space (paper, Sect. 4 and 6).

``python case_study/build.py`` writes `sorting.sym.xmi`, `sorting.pnml` and its variant `one_topic.sym.xmi`
next to this file. The numbers in the comments are the parts of the paper's Fig. 14. The model has the paper's
rules for queues. On ROS 2 its nodes run by the rules of `ros2`: check it with ``--middleware ros2`` as well.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, here, node_net, place
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find
from dineros.metamodel.files import save

HOME = Path(__file__).resolve().parent
CELLS = ("L", "R")
RETRY_TIME = 0.1
"""Seconds before the sensor is asked again while it is unsafe."""
SENSE_TIME = 0.02
"""Seconds that the sensor measures: also while there is danger, the safety loop turns no faster."""


def transition(
    page: pn.Page, id: str, clause: str | None = None, earliest: float | None = None
) -> sym.Transition:
    """Return a transition; `earliest` paces it: so many seconds it is ready before it fires."""
    made = sym.Transition(id=id, name=id, page=page)
    if earliest is not None:
        made.interval = pn.TimeInterval(earliest=earliest)
    if clause:
        set_clause(made, clause, name=f"IC{id.removeprefix('T')}")
    return made


def selector(model: sym.SystemModel) -> dict[str, sym.Place]:
    """User input (1): a pool of objects per colour, each selected by a signal."""
    colors = ("Red", "Blue", "Green")
    net = node_net(model, "selector", colors, package="sorting_selector")
    sorts = {}
    for color in colors:
        pool = place(net, f"{color}Objects", tokens=1)
        pool.balloons.append(sym.BalloonToken(data=f'{{"color": "{color.lower()}"}}'))
        sorts[color] = place(net, f"Sort{color}")
        flow(pool, transition(net, f"Select{color}", clause=color), sorts[color])
    return sorts


def controller(model: sym.SystemModel) -> dict[str, sym.Place]:
    """Two robot controllers (2), one per cell: get control, pick, place, give control back, report."""
    net = node_net(model, "controller", package="sorting_controller")
    made: dict[str, sym.Place] = {}
    for cell in CELLS:
        request = callback(net, f"ReceiveObject{cell}")
        entry = place(request, f"ReqControl{cell}")
        page = pn.Page(id=f"RobotController{cell}", name=f"RobotController{cell}", page=net)
        names = (
            f"GetReq{cell} GetRes{cell} PickReq{cell} PickRes{cell} PlaceReq{cell} PlaceRes{cell} "
            f"EndReq{cell} EndRes{cell} Result{cell}"
        )
        cell_places = {name: place(page, name) for name in names.split()}
        made |= {entry.id: entry} | cell_places
        steps = [
            (here(entry, page), f"TReqControl{cell}", cell_places[f"GetReq{cell}"]),
            (cell_places[f"GetRes{cell}"], f"TStartPick{cell}", cell_places[f"PickReq{cell}"]),
            (cell_places[f"PickRes{cell}"], f"TStartPlace{cell}", cell_places[f"PlaceReq{cell}"]),
            (cell_places[f"PlaceRes{cell}"], f"TRelease{cell}", cell_places[f"EndReq{cell}"]),
            (cell_places[f"EndRes{cell}"], f"TReport{cell}", cell_places[f"Result{cell}"]),
        ]
        for before, step, after in steps:
            flow(before, transition(page, step), after)
    return made


def synchronizer(model: sym.SystemModel) -> dict[str, sym.ServerPort]:
    """Exclusive use of the shared space (3, 5) by one token on the control state page (4)."""
    net = node_net(model, "synchronizer", package="sorting_synchronizer")
    state = pn.Page(id="ControlState", name="ControlState", page=net)
    free, taken = place(state, "StateGet", tokens=1), place(state, "StateEnd")
    servers = {}
    for operation, before, after in (("Get", free, taken), ("End", taken, free)):
        page = callback(net, f"{operation}ControlServer", "server")
        entry, exit_ = place(page, f"{operation}Entry"), place(page, f"{operation}Exit")
        step = transition(page, f"T{operation}")
        flow(entry, step, exit_)
        flow(here(before, page), step, here(after, page))
        servers[f"{operation}Control"] = sym.ServerPort(entry=entry, exit=exit_, page=page)
    return servers


def executor(model: sym.SystemModel) -> tuple[dict[str, sym.ServerPort], sym.Place, sym.Place]:
    """Picking and placing (6) under a shared safety model (7) that asks the sensor again and again (8)."""
    signals = ("RobotIsIdle", "RobotHasFinished", "ObjectIsPicked", "ObjectIsPlaced", "Danger")
    net = node_net(model, "executor", signals, package="sorting_executor")
    safety = pn.Page(id="Safety", name="Safety", page=net)
    safe, unsafe = place(safety, "Safe"), place(safety, "Unsafe", tokens=1)
    request, response = place(safety, "SensorReq"), place(safety, "SensorRes")
    flow(unsafe, transition(safety, "TRetry", earliest=RETRY_TIME), request)
    flow(response, transition(safety, "TSafe"), safe)
    flow(response, transition(safety, "TUnsafe"), unsafe)
    flow(safe, transition(safety, "TStop", clause="Danger"), request)
    servers = {}
    for operation in ("Pick", "Place"):
        page = callback(net, f"{operation}Server", "server")
        entry, run, exit_ = (place(page, f"{operation}{role}") for role in ("Entry", "Run", "Exit"))
        start = transition(page, f"T{operation}")
        abort = transition(page, f"T{operation}Abort")
        safe_here, unsafe_here = here(safe, page), here(unsafe, page)
        done = f"ObjectIs{operation.removesuffix('e')}ed"
        flow(entry, start, run)
        flow(safe_here, start, safe_here)
        for outcome, literal in (("Success", done), ("Fail", f"!{done}")):
            clause = f"(RobotIsIdle | RobotHasFinished) & {literal}"
            flow(run, transition(page, f"T{operation}{outcome}", clause), exit_)
        flow(run, abort, exit_)
        flow(unsafe_here, abort, unsafe_here)
        servers[operation] = sym.ServerPort(entry=entry, exit=exit_, page=page)
    return servers, request, response


def sensorics(model: sym.SystemModel) -> sym.ServerPort:
    """The sensor (9): data is there while the signal holds (10)."""
    net = node_net(model, "sensorics", ["Sensor"], package="sorting_sensorics")
    page = callback(net, "SensorServer", "server")
    entry, exit_ = place(page, "SensorEntry"), place(page, "SensorExit")
    flow(entry, transition(page, "TSense", "Sensor", SENSE_TIME), exit_)
    return sym.ServerPort(entry=entry, exit=exit_, page=page)


def feedback(model: sym.SystemModel) -> sym.Place:
    """The user interface (11) shows each result."""
    net = node_net(model, "feedback", package="sorting_feedback")
    received = place(callback(net, "ReceiveResult"), "Feedback")
    page = received.page
    assert page is not None
    flow(received, transition(page, "TShowResult"), place(page, "Shown"))
    return received


def topic(model: sym.SystemModel, id: str, sends: list[sym.Place], receives: list[sym.Place]) -> None:
    sym.TopicChannel(
        id=id,
        name=id,
        topic=id,
        publishers=[sym.PublisherPort(place=sent, limit=10) for sent in sends],
        subscribers=[sym.SubscriberPort(place=received, limit=10) for received in receives],
        model=model,
    )


def service(
    model: sym.SystemModel, id: str, server: sym.ServerPort, clients: dict[str, tuple[sym.Place, sym.Place]]
) -> None:
    sym.ServiceChannel(
        id=id,
        name=id,
        service=id,
        server=server,
        clients=[
            sym.ClientPort(client=client, request=request, response=response)
            for client, (request, response) in clients.items()
        ],
        instances=len(clients),
        model=model,
    )


def token_type() -> sym.TokenType:
    """Return what every token carries."""
    return sym.TokenType(
        id="SortingToken",
        name="SortingToken",
        fields=[
            sym.TokenField(name="color"),
            sym.TokenField(name="name"),
            sym.TokenField(name="pose", kind="list", elementKind="number", length=6),
            sym.TokenField(name="pickSuccess", kind="boolean"),
            sym.TokenField(name="placeSuccess", kind="boolean"),
            sym.TokenField(name="humanDetected", kind="boolean"),
            sym.TokenField(name="sensorData"),
            sym.TokenField(name="errors", kind="list"),
        ],
    )


def build(
    id: str = "sorting",
    executor: Callable[[sym.SystemModel], tuple[dict[str, sym.ServerPort], sym.Place, sym.Place]] = executor,
    feedback: Callable[[sym.SystemModel], sym.Place] = feedback,
) -> sym.SystemModel:
    """Return the case study, in which variants build two of the nodes in other ways."""
    model = sym.SystemModel(id=id, name=id, tokenType=token_type())
    sorts = selector(model)
    cells = controller(model)
    state_servers = synchronizer(model)
    arm_servers, sensor_request, sensor_response = executor(model)
    sensor_server = sensorics(model)
    received = feedback(model)

    topic(model, "LeftCellObjects", [sorts["Red"], sorts["Blue"]], [cells["ReqControlL"]])
    topic(model, "RightCellObjects", [sorts["Green"]], [cells["ReqControlR"]])
    topic(model, "UITopic", [cells["ResultL"], cells["ResultR"]], [received])
    for name, server in (state_servers | arm_servers).items():
        short = name.removesuffix("Control")
        clients = {cell: (cells[f"{short}Req{cell}"], cells[f"{short}Res{cell}"]) for cell in CELLS}
        service(model, name, server, clients)
    service(model, "SensorService", sensor_server, {"safety": (sensor_request, sensor_response)})
    return model


def build_one_topic() -> sym.SystemModel:
    """Return the case study after its developer sent all colours to the left arm (paper, Sect. 9.2.1)."""
    model = build("one_topic")
    left, right = (find(model, topic, sym.TopicChannel) for topic in ("LeftCellObjects", "RightCellObjects"))
    left.publishers.extend(right.publishers)
    return model


def main() -> None:
    """Write the model in both formats, and its variant."""
    model = build()
    save(model, HOME / "sorting.sym.xmi")
    save(model, HOME / "sorting.pnml")
    save(build_one_topic(), HOME / "one_topic.sym.xmi")


if __name__ == "__main__":
    main()
