"""Small systems to start with, with what they are and positions on the canvas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeVar

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause

E = TypeVar("E", bound=pn.Element)


def _at(x: float, y: float, element: E) -> E:
    element.graphics = pn.Graphics(positions=[pn.Point(x=x, y=y)])
    return element


def _place(id: str, x: float, y: float, tokens: int = 0) -> sym.Place:
    return _at(x, y, sym.Place(id=id, tokens=tokens))


def _end(id: str, x: float, y: float) -> sym.Place:
    """Return a place in which a finished application may keep tokens; that is not a fault."""
    return _at(x, y, sym.Place(id=id, kind="end"))


def _step(id: str, x: float, y: float) -> sym.Transition:
    return _at(x, y, sym.Transition(id=id))


def _model(pages: list[pn.Page], channel: sym.Channel) -> sym.SystemModel:
    return sym.SystemModel(id="template", pages=pages, channels=[channel])


def talker_and_listener() -> sym.SystemModel:
    """A topic: one ROS node publishes words, another one subscribes to them."""
    words, say, said = _place("Words", 80, 80, tokens=3), _step("Say", 200, 80), _place("Said", 320, 80)
    talker = _at(120, 80, sym.NodeNet(id="talker", objects=[words, say, said]))
    flow(words, say, said)
    heard, listen, noted = _place("Heard", 80, 80), _step("Listen", 200, 80), _end("Noted", 320, 80)
    callback = _at(140, 80, sym.CallbackPage(id="OnChatter", objects=[heard, listen, noted]))
    flow(heard, listen, noted)
    listener = _at(520, 80, sym.NodeNet(id="listener", objects=[callback]))
    topic = sym.TopicChannel(
        id="Chatter",
        topic="chatter",
        publishers=[sym.PublisherPort(place=said)],
        subscribers=[sym.SubscriberPort(place=heard)],
    )
    return _model([talker, listener], _at(320, 180, topic))


def _server(id: str, page: str, steps: tuple[str, str, str]) -> tuple[sym.NodeNet, sym.ServerPort]:
    """Return a ROS node that answers requests in one step."""
    entry, work, exit_ = _place(steps[0], 80, 80), _step(steps[1], 200, 80), _place(steps[2], 320, 80)
    callback = _at(140, 80, sym.CallbackPage(id=page, kind="server", objects=[entry, work, exit_]))
    flow(entry, work, exit_)
    node = _at(520, 80, sym.NodeNet(id=id, objects=[callback]))
    return node, sym.ServerPort(entry=entry, exit=exit_, page=callback)


def service() -> sym.SystemModel:
    """A service: one ROS node calls it, another one serves it."""
    wishes, ask, asked = _place("Wishes", 80, 80, tokens=1), _step("Ask", 200, 80), _place("Asked", 320, 80)
    answered, use, used = _place("Answered", 80, 180), _step("Use", 200, 180), _end("Used", 320, 180)
    client = _at(120, 80, sym.NodeNet(id="client", objects=[wishes, ask, asked, answered, use, used]))
    flow(wishes, ask, asked)
    flow(answered, use, used)
    server, port = _server("server", "Answer", ("Request", "Work", "Response"))
    channel = sym.ServiceChannel(
        id="Question",
        service="question",
        server=port,
        clients=[sym.ClientPort(client="client", request=asked, response=answered)],
    )
    return _model([client, server], _at(320, 180, channel))


def safety_loop() -> sym.SystemModel:
    """A safety loop: a ROS node calls a sensor repeatedly, and works only while the response is safe."""
    unsafe, retry, request = (
        _place("Unsafe", 80, 160, tokens=1),
        _step("Retry", 180, 240),
        _place("SenseRequest", 320, 240),
    )
    response, safe = _place("SenseResponse", 320, 80), _place("Safe", 80, 60)
    is_safe, is_unsafe, stop = _step("IsSafe", 200, 60), _step("IsUnsafe", 200, 130), _step("Stop", 180, 190)
    retry.interval = pn.TimeInterval(earliest=0.1)
    waiting, work, done = (
        _place("Waiting", 460, 80, tokens=1),
        _step("Work", 460, 160),
        _place("Done", 460, 240),
    )
    danger = sym.InputSignal(id="Danger")
    node = sym.NodeNet(
        id="worker",
        objects=[safe, unsafe, request, response, retry, is_safe, is_unsafe, stop, waiting, work, done],
        signals=[danger],
    )
    flow(unsafe, retry, request)
    flow(response, is_safe, safe, stop, request)
    flow(response, is_unsafe, unsafe)
    flow(waiting, work, done)
    flow(safe, work, safe)
    set_clause(stop, "Danger")
    server, port = _server("sensor", "Sense", ("SenseEntry", "Measure", "SenseExit"))
    channel = sym.ServiceChannel(
        id="Sensing",
        service="sensing",
        server=port,
        clients=[sym.ClientPort(client="worker", request=request, response=response)],
    )
    return _model([_at(120, 80, node), server], _at(320, 180, channel))


def action() -> sym.SystemModel:
    """An action: one ROS node sends goals, another one executes them; each succeeds, fails or is canceled."""
    goal, start, working = _place("Goal", 80, 120), _step("Start", 160, 120), _place("Working", 240, 120)
    finish, reached = _step("Finish", 340, 60), _place("Reached", 440, 60)
    fail, failed = _step("Fail", 340, 120), _place("Failed", 440, 120)
    give_up, canceled = _step("GiveUp", 340, 190), _place("Canceled", 440, 190)
    cancel = _place("Cancel", 240, 210)
    page = _at(
        140,
        80,
        sym.CallbackPage(
            id="OnGoal",
            kind="goal",
            awaits=True,  # else the only thread could not take a request to cancel
            objects=[goal, working, reached, failed, canceled, cancel, start, finish, fail, give_up],
        ),
    )
    flow(goal, start, working, finish, reached)
    flow(working, fail, failed)
    flow(working, give_up, canceled)
    flow(cancel, give_up)
    server = _at(520, 80, sym.NodeNet(id="server", objects=[page], execution="callbacks"))
    send, done, not_done = (
        _place("Send", 80, 60, tokens=1),
        _end("Done", 240, 60),
        _end("NotDone", 240, 140),
    )
    doubt, regret, recall = (
        _place("Doubt", 80, 220, tokens=1),
        _step("Regret", 160, 220),
        _place("Recall", 240, 220),
    )
    client = _at(120, 80, sym.NodeNet(id="client", objects=[send, done, not_done, doubt, regret, recall]))
    flow(doubt, regret, recall)
    channel = sym.ActionChannel(
        id="Task",
        action="task",
        server=sym.ActionServerPort(
            page=page, entry=goal, succeeded=reached, aborted=failed, canceled=canceled, cancel=cancel
        ),
        clients=[
            sym.ActionClientPort(
                client="client", goal=send, succeeded=done, aborted=not_done, canceled=not_done, cancel=recall
            )
        ],
    )
    return _model([client, server], _at(320, 180, channel))


TEMPLATES: Mapping[str, Callable[[], sym.SystemModel]] = MappingProxyType(
    {
        "talker and listener": talker_and_listener,
        "service": service,
        "safety loop": safety_loop,
        "action": action,
    }
)
"""What can be added to a system model, by name; the first line of each docstring describes it."""
