"""Models that break the constraints of `requests`."""

from __future__ import annotations

from typing import Any

from dineros.metamodel import sym
from dineros.metamodel.build import flow
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small

CASES = Cases()
CLIENT = "client port 'c1' of service channel 'ask'"


def _client(small: Small) -> Any:
    small.net.middleware = "ros2"
    flow(small["Tick"], sym.Transition(id="AtTick", page=small["clock"]))
    return small["ask"].clients[0]


@CASES.breaks(
    "request-depth-positive",
    "service channel 'ask' keeps 0 requests",
    "give it a depth of 1 or more",
)
def nothing_kept(small: Small) -> None:
    small["ask"].depth = 0


@CASES.breaks(
    "outstanding-positive",
    f"{CLIENT} has 0 requests under way at most",
    "use 1 or more, or -1 for any number",
)
def nothing_outstanding(small: Small) -> None:
    _client(small).outstanding = 0


@CASES.breaks(
    "timeout-positive",
    f"{CLIENT} has the time-out inf",
    "use a time in seconds above 0, or none",
)
def endless_timeout(small: Small) -> None:
    _client(small).timeout = float("inf")


@CASES.breaks(
    "timed-out-has-timeout",
    f"{CLIENT} names the place 'Late' for time-outs, but waits forever",
    "give it a time-out, or name no place",
)
def told_of_nothing(small: Small) -> None:
    _client(small).timedOut = sym.Place(id="Late", page=small["talker"])


@CASES.breaks(
    "timed-out-in-one-node-net",
    f"{CLIENT} has its request in node net 'talker' and the place of its time-outs in node net 'listener'",
    "put both places into the node net of the client",
)
def told_another_node(small: Small) -> None:
    client = _client(small)
    client.timeout, client.timedOut = 1.0, sym.Place(id="Late", page=small["listener"])


@CASES.breaks(
    "timed-out-in-one-instance",
    "client port 'inner' of service channel 'ask' has its request outside "
    "and the place of its time-outs on the server page 'serve'",
    "put both places on the same server page, or both outside of it",
)
def told_an_instance(small: Small) -> None:
    net = small["listener"]
    _client(small)
    places = [sym.Place(id=id, page=net) for id in ("Inside", "Back")]
    late = sym.Place(id="Late", page=small["serve"])
    small["ask"].clients.append(
        sym.ClientPort(client="inner", request=places[0], response=places[1], timeout=1.0, timedOut=late)
    )


@CASES.breaks(
    "calls-of-ros2",
    f"{CLIENT} has 2 requests under way and a time-out of 0.5 s, which the rules of ros1 do not have",
    "set the model's middleware to ros2, or remove it",
)
def calls_under_ros1(small: Small) -> None:
    small["ask"].clients[0].outstanding = 2
    small["ask"].clients[0].timeout = 0.5


def _callbacks(small: Small) -> Any:
    """Return the client of a callback that waits for the response."""
    net, client = small["talker"], _client(small)
    page = sym.CallbackPage(id="asks", kind="timer", timer=1.0, page=net)
    request, response = sym.Place(id="Request", page=page), sym.Place(id="Response", page=page)
    flow(sym.Transition(id="Begin", page=page), request)
    flow(response, sym.Transition(id="End", page=page))
    client.request, client.response, client.timeout = request, response, 1.0
    net.execution = "callbacks"
    return client


@CASES.breaks(
    "waiting-callback-is-told",
    f"{CLIENT} gives up without a token, and its callback 'asks' never continues",
    "name a place for time-outs on that callback page",
)
def nobody_told(small: Small) -> None:
    _callbacks(small)


@CASES.breaks(
    "timed-out-begins-no-callback",
    f"{CLIENT} names the place 'Late' for time-outs on callback page 'later', "
    "which a time-out does not start",
    "put the place on the callback page that asks, or on none",
)
def another_callback_told(small: Small) -> None:
    client = _callbacks(small)
    later = sym.CallbackPage(id="later", kind="timer", timer=1.0, page=small["talker"])
    client.timedOut = sym.Place(id="Late", page=later)
    flow(sym.Transition(id="Also", page=later), client.timedOut, sym.Transition(id="Then", page=later))
