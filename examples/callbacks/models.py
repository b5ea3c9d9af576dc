"""Models of the programs next to this file.

``python examples/callbacks/models.py`` writes `answer.sym.xmi`, `battery.sym.xmi` and so on next to it.
Which model with which settings is which program, `PROGRAMS` says.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, inhibit
from dineros.metamodel.files import save
from dineros.metamodel.settings import apply

HOME = Path(__file__).resolve().parent
OWN = "Level.client.monitor.group=calls"
TWO_THREADS = ("monitor.executor=multi", "monitor.threads=2")
PROGRAMS: dict[str, tuple[str, tuple[str, ...]]] = {
    "same_group": ("battery", TWO_THREADS),
    "one_thread": ("battery", (OWN,)),
    "own_group": ("battery", (OWN, *TWO_THREADS)),
    "reentrant": ("battery", (OWN, "OnTimer.group=calls", "calls.kind=reentrant", *TWO_THREADS)),
    "awaiting": ("battery", ("OnTimer.awaits=true",)),
    "awaiting_own_group": ("battery", (OWN, "OnTimer.awaits=true")),
    "answer_one_thread": ("answer", ()),
    "answer_two_threads": ("answer", TWO_THREADS),
    "calling_each_other": ("planner", ()),
    "calling_each_other_fixed": (
        "planner",
        ("Position.client.planner.group=answers", "planner.executor=multi", "planner.threads=2"),
    ),
    "fast_sensor": ("sensor", ()),
    "fast_sensor_fixed": ("sensor_fixed", ()),
}
"""The model of each program, and what is set in it."""


def node(model: sym.SystemModel, id: str, threads: int = 1) -> sym.NodeNet:
    """Add a node that is written by hand."""
    executor = "single" if threads == 1 else "multi"
    return sym.NodeNet(id=id, net=model, execution="callbacks", executor=executor, threads=threads)


def timer(node: sym.NodeNet, period: float) -> sym.CallbackPage:
    """Add a timer's callback."""
    return sym.CallbackPage(id="OnTimer", kind="timer", timer=period, page=node)


def asking(page: sym.CallbackPage, name: str) -> sym.ClientPort:
    """Let a timer's callback ask, wait for the answer, and end."""
    request, response = sym.Place(id=f"{name}Request", page=page), sym.Place(id=f"{name}Response", page=page)
    flow(sym.Transition(id=f"Ask{name}", page=page), request)
    flow(response, sym.Transition(id=f"Note{name}", page=page))
    return sym.ClientPort(
        client=str(page.page.id if page.page else page.id), request=request, response=response
    )


def server(node: sym.NodeNet, name: str, work: str) -> tuple[sym.ServerPort, pn.Transition]:
    """Add a server's callback, which does one thing; return its port and the transition that does it."""
    page = sym.CallbackPage(id=f"On{name}", kind="server", page=node)
    entry, exit_ = sym.Place(id=f"{name}In", page=page), sym.Place(id=f"{name}Out", page=page)
    does = sym.Transition(id=work, page=page)
    flow(entry, does, exit_)
    return sym.ServerPort(entry=entry, exit=exit_, page=page), does


def service(model: sym.SystemModel, name: str, port: sym.ServerPort, client: sym.ClientPort) -> None:
    """Add a service with a client."""
    sym.ServiceChannel(id=name, service=name.lower(), server=port, clients=[client], model=model)


def battery() -> sym.SystemModel:
    """`same_group` and its like: a monitor that asks the battery for its level."""
    model = sym.SystemModel(id="battery_monitor", middleware="ros2")
    client = asking(timer(node(model, "monitor"), 0.03), "Level")
    service(model, "Level", server(node(model, "battery"), "Level", "Measure")[0], client)
    return model


def answer() -> sym.SystemModel:
    """`answer_one_thread`: a monitor that asks once more in what the answer of the battery begins."""
    model = sym.SystemModel(id="battery_answer", middleware="ros2")
    monitor = node(model, "monitor")
    on_timer = timer(monitor, 0.03)
    on_level = sym.CallbackPage(id="OnLevel", kind="client", page=monitor)
    idle = sym.Place(id="Idle", tokens=1, page=monitor)
    here, there = (
        pn.ReferencePlace(id=f"Idle@{page.id}", target=idle, page=page) for page in (on_timer, on_level)
    )
    first, second = sym.Place(id="Request", page=on_timer), sym.Place(id="RequestAgain", page=on_level)
    level, again = sym.Place(id="Response", page=on_level), sym.Place(id="ResponseAgain", page=on_level)
    flow(here, sym.Transition(id="Ask", page=on_timer), first)
    inhibit(here, sym.Transition(id="Skip", page=on_timer))
    flow(level, sym.Transition(id="AskAgain", page=on_level), second)
    flow(again, sym.Transition(id="Note", page=on_level), there)
    port, _ = server(node(model, "battery"), "Battery", "Measure")
    service(model, "Level", port, sym.ClientPort(client="monitor", request=first, response=level))
    model.channels[0].clients.append(  # type: ignore[attr-defined]
        sym.ClientPort(client="again", request=second, response=again)
    )
    return model


def planner() -> sym.SystemModel:
    """`calling_each_other`: a robot asks a planner for a route, which asks it where it is."""
    model = sym.SystemModel(id="route_planner", middleware="ros2")
    robot = node(model, "robot", threads=2)
    others = sym.CallbackGroup(id="others")
    robot.callbackGroups.append(others)
    route = asking(timer(robot, 0.03), "Route")
    port, _ = server(robot, "Position", "Locate")
    route.group = port.page.group = others  # type: ignore[attr-defined]
    plans, plan = server(node(model, "planner"), "Route", "Plan")
    page = plans.page
    request, response = (
        sym.Place(id="PositionRequest", page=page),
        sym.Place(id="PositionResponse", page=page),
    )
    (entering,) = plan.incoming
    entering.target = ask = sym.Transition(id="AskPosition", page=page)
    flow(ask, request)
    flow(response, plan)
    service(model, "Route", plans, route)
    service(model, "Position", port, sym.ClientPort(client="planner", request=request, response=response))
    return model


def sensor(fixed: bool = False) -> sym.SystemModel:
    """`fast_sensor`: a sensor sends scans to a mapper, which says when it is done where this is fixed."""
    model = sym.SystemModel(id="sensor_mapper", middleware="ros2")
    sends, mapper = node(model, "sensor"), node(model, "mapper")
    on_timer = timer(sends, 0.005)
    send, sent = sym.Transition(id="Send", page=on_timer), sym.Place(id="Sent", page=on_timer)
    flow(send, sent)
    on_scan = sym.CallbackPage(id="OnScan", page=mapper)
    scan, work = sym.Place(id="Scan", page=on_scan), sym.Transition(id="Work", page=on_scan)
    flow(scan, work)
    topic(model, "Scans", sent, scan)
    if fixed:
        may_send = sym.Place(id="MaySend", tokens=3, page=sends)
        here = pn.ReferencePlace(id="MaySend@OnTimer", target=may_send, page=on_timer)
        flow(here, send)
        inhibit(here, sym.Transition(id="Skip", page=on_timer))
        done = sym.Place(id="Done", page=on_scan)
        flow(work, done)
        on_done = sym.CallbackPage(id="OnDone", page=sends)
        heard = sym.Place(id="Heard", page=on_done)
        again = pn.ReferencePlace(id="MaySend@OnDone", target=may_send, page=on_done)
        flow(heard, sym.Transition(id="Count", page=on_done), again)
        topic(model, "Dones", done, heard)
    return model


def sensor_timed() -> sym.SystemModel:
    """Return the sensor and its mapper with times, in seconds: nothing is lost, and data is new."""
    model = sensor()
    times = {"OnTimer.duration": 0.001, "OnScan.duration": 0.002, "Scans.latency": 0.001}
    for name, latest in times.items():
        apply(model, f"{name}.latest={latest}")
    model.properties.append(sym.Property(id="ScansAreNew", text="OnTimer to OnScan within 0.005"))
    return model


def topic(model: sym.SystemModel, name: str, source: sym.Place, sink: sym.Place) -> None:
    """Join two places by a topic that keeps five messages at either end."""
    sym.TopicChannel(
        id=name,
        topic=name.lower(),
        publishers=[sym.PublisherPort(place=source, limit=5)],
        subscribers=[sym.SubscriberPort(place=sink, limit=5)],
        model=model,
    )


def program(name: str) -> sym.SystemModel:
    """Return the model of a program."""
    base, settings = PROGRAMS[name]
    model = MODELS[base]()
    for setting in settings:
        apply(model, setting)
    return model


MODELS: dict[str, Callable[[], sym.SystemModel]] = {
    "answer": answer,
    "battery": battery,
    "planner": planner,
    "sensor": sensor,
    "sensor_fixed": partial(sensor, fixed=True),
    "sensor_timed": sensor_timed,
}


if __name__ == "__main__":
    for name, make in MODELS.items():
        save(make(), HOME / f"{name}.sym.xmi")
