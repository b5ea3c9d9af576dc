"""The case study as a system model: two arms sort coloured objects in a shared space (paper, Sect. 4 and 6).

``python case_study/build.py`` writes `sorting.sym.xmi`, `sorting.pnml` and its variant `one_topic.sym.xmi`
beside this file. The numbers in
the comments are the parts of the paper's Fig. 14.
"""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find
from dineros.metamodel.files import save

HOME = Path(__file__).resolve().parent
CELLS = ("L", "R")
RETRY_TIME = 0.1
"""Seconds before the sensor is asked again while it is unsafe."""
SENSE_TIME = 0.02
"""Seconds that the sensor measures: also while there is danger, the safety loop turns no faster."""


class NodeNetBuilder:
    """One node net and shorthands for the nodes on its pages."""

    def __init__(self, model: sym.SystemModel, id: str) -> None:
        self.net = sym.NodeNet(id=id, name=id, package=f"sorting_{id}", net=model)

    def page(self, id: str) -> pn.Page:
        return pn.Page(id=id, name=id, page=self.net)

    def callback(self, id: str, kind: str) -> sym.CallbackPage:
        return sym.CallbackPage(id=id, name=id, kind=kind, page=self.net)

    def signal(self, id: str) -> None:
        sym.InputSignal(id=id, name=id, node=self.net)


def place(id: str, page: pn.Page, tokens: int = 0) -> sym.Place:
    return sym.Place(id=id, name=id, tokens=tokens, page=page)


def transition(
    id: str, page: pn.Page, clause: str | None = None, earliest: float | None = None
) -> sym.Transition:
    """Return a transition; `earliest` paces it: so many seconds it is ready before it fires."""
    made = sym.Transition(id=id, name=id, page=page)
    if earliest is not None:
        made.interval = pn.TimeInterval(earliest=earliest)
    if clause:
        set_clause(made, clause, name=f"IC{id.removeprefix('T')}")
    return made


def reference(target: pn.Place, page: pn.Page) -> pn.ReferencePlace:
    return pn.ReferencePlace(id=f"{target.id}@{page.id}", name=target.name, target=target, page=page)


def selector(model: sym.SystemModel) -> dict[str, sym.Place]:
    """User input (1): a pool of objects per colour, each selected by a signal."""
    node = NodeNetBuilder(model, "selector")
    sorts = {}
    for color in ("Red", "Blue", "Green"):
        node.signal(color)
        pool = place(f"{color}Objects", node.net, tokens=1)
        pool.balloons.append(sym.BalloonToken(data=f'{{"color": "{color.lower()}"}}'))
        sorts[color] = place(f"Sort{color}", node.net)
        flow(pool, transition(f"Select{color}", node.net, clause=color), sorts[color])
    return sorts


def controller(model: sym.SystemModel) -> dict[str, sym.Place]:
    """Two robot controllers (2), one per cell: get control, pick, place, give control back, report."""
    node = NodeNetBuilder(model, "controller")
    made: dict[str, sym.Place] = {}
    for cell in CELLS:
        request = node.callback(f"ReceiveObject{cell}", "subscriber")
        entry = place(f"ReqControl{cell}", request)
        page = node.page(f"RobotController{cell}")
        names = (
            f"GetReq{cell} GetRes{cell} PickReq{cell} PickRes{cell} PlaceReq{cell} PlaceRes{cell} "
            f"EndReq{cell} EndRes{cell} Result{cell}"
        )
        cell_places = {name: place(name, page) for name in names.split()}
        made |= {entry.id: entry} | cell_places
        steps = [
            (reference(entry, page), f"TReqControl{cell}", cell_places[f"GetReq{cell}"]),
            (cell_places[f"GetRes{cell}"], f"TStartPick{cell}", cell_places[f"PickReq{cell}"]),
            (cell_places[f"PickRes{cell}"], f"TStartPlace{cell}", cell_places[f"PlaceReq{cell}"]),
            (cell_places[f"PlaceRes{cell}"], f"TRelease{cell}", cell_places[f"EndReq{cell}"]),
            (cell_places[f"EndRes{cell}"], f"TReport{cell}", cell_places[f"Result{cell}"]),
        ]
        for before, step, after in steps:
            flow(before, transition(step, page), after)
    return made


def synchronizer(model: sym.SystemModel) -> dict[str, sym.ServerPort]:
    """Exclusive use of the shared space (3, 5) by one token on the control state page (4)."""
    node = NodeNetBuilder(model, "synchronizer")
    state = node.page("ControlState")
    free, taken = place("StateGet", state, tokens=1), place("StateEnd", state)
    servers = {}
    for operation, before, after in (("Get", free, taken), ("End", taken, free)):
        page = node.callback(f"{operation}ControlServer", "server")
        entry, exit_ = place(f"{operation}Entry", page), place(f"{operation}Exit", page)
        step = transition(f"T{operation}", page)
        flow(entry, step, exit_)
        flow(reference(before, page), step, reference(after, page))
        servers[f"{operation}Control"] = sym.ServerPort(entry=entry, exit=exit_, page=page)
    return servers


def executor(model: sym.SystemModel) -> tuple[dict[str, sym.ServerPort], sym.Place, sym.Place]:
    """Picking and placing (6) under a shared safety model (7) that asks the sensor again and again (8)."""
    node = NodeNetBuilder(model, "executor")
    for signal in ("RobotIsIdle", "RobotHasFinished", "ObjectIsPicked", "ObjectIsPlaced", "Danger"):
        node.signal(signal)
    safety = node.page("Safety")
    safe, unsafe = place("Safe", safety), place("Unsafe", safety, tokens=1)
    request, response = place("SensorReq", safety), place("SensorRes", safety)
    flow(unsafe, transition("TRetry", safety, earliest=RETRY_TIME), request)
    flow(response, transition("TSafe", safety), safe)
    flow(response, transition("TUnsafe", safety), unsafe)
    flow(safe, transition("TStop", safety, clause="Danger"), request)
    servers = {}
    for operation in ("Pick", "Place"):
        page = node.callback(f"{operation}Server", "server")
        entry, run, exit_ = (place(f"{operation}{role}", page) for role in ("Entry", "Run", "Exit"))
        start = transition(f"T{operation}", page)
        abort = transition(f"T{operation}Abort", page)
        safe_here, unsafe_here = reference(safe, page), reference(unsafe, page)
        done = f"ObjectIs{operation.removesuffix('e')}ed"
        flow(entry, start, run)
        flow(safe_here, start, safe_here)
        for outcome, literal in (("Success", done), ("Fail", f"!{done}")):
            clause = f"(RobotIsIdle | RobotHasFinished) & {literal}"
            flow(run, transition(f"T{operation}{outcome}", page, clause), exit_)
        flow(run, abort, exit_)
        flow(unsafe_here, abort, unsafe_here)
        servers[operation] = sym.ServerPort(entry=entry, exit=exit_, page=page)
    return servers, request, response


def sensorics(model: sym.SystemModel) -> sym.ServerPort:
    """The sensor (9): data is there while the signal holds (10)."""
    node = NodeNetBuilder(model, "sensorics")
    node.signal("Sensor")
    page = node.callback("SensorServer", "server")
    entry, exit_ = place("SensorEntry", page), place("SensorExit", page)
    flow(entry, transition("TSense", page, "Sensor", SENSE_TIME), exit_)
    return sym.ServerPort(entry=entry, exit=exit_, page=page)


def feedback(model: sym.SystemModel) -> sym.Place:
    """The user interface (11) shows each result."""
    node = NodeNetBuilder(model, "feedback")
    received = place("Feedback", node.callback("ReceiveResult", "subscriber"))
    page = received.page
    assert page is not None
    flow(received, transition("TShowResult", page), place("Shown", page))
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


def build(id: str = "sorting") -> sym.SystemModel:
    """Return the case study."""
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
