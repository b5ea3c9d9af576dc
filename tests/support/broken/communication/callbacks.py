"""Models that break the constraints of `callbacks`."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, callbacks, system

CASES = Cases()

_BY_CALLBACKS = "set the execution of its node net to callbacks and the middleware of the model to ros2"
OWN_EXECUTOR = "for an executor of its own: a callback group of its own and one more thread for the node net"


@CASES.breaks(
    "callbacks-under-ros2",
    "node net 'listener' runs callbacks, which the rules of ros1 do not know",
    "set the middleware of the model to ros2, or the execution of the node net to net",
)
def callbacks_of_ros1(small: Small) -> None:
    flow(small["Heard"], sym.Transition(id="Note", page=small["hear"]))
    small["listener"].execution = "callbacks"


@CASES.breaks(
    "timer-callback-begins",
    "callback page 'Clock' has no transition from which it is clear that it begins its callback",
    "set the kind of the transition that begins it to start",
    of=callbacks,
)
def timer_in_a_circle(small: Small) -> None:
    state, end = sym.Place(id="State", tokens=1, page=small["Clock"]), small["Finish"]
    flow(end, state, small["Begin"])
    end.kind = "end"


@CASES.breaks(
    "callback-ends",
    "callback page 'Hear' has no transition from which it is clear that it ends its callback",
    "set the kind of the transition that ends it to end",
    of=callbacks,
)
def nothing_ends(small: Small) -> None:
    flow(small["Note"], small["Noted"], sym.Transition(id="Again", page=small["Hear"]), small["Heard"])


@CASES.breaks(
    "subscriber-begins-callback",
    "subscriber port 'News' of topic channel 'Topic' takes messages on callback page 'Clock', and the node "
    "runs callbacks",
    f"put its place on a callback page of the kind subscriber; {OWN_EXECUTOR}",
    of=callbacks,
)
def messages_of_a_timer(small: Small) -> None:
    news = sym.Place(id="News", page=small["Clock"])
    flow(news, small["Finish"])
    small["Topic"].subscribers.append(sym.SubscriberPort(place=news))


@CASES.breaks(
    "subscriber-begins-callback",
    "subscriber port 'News' of topic channel 'Topic' takes messages on no callback page, and the node runs "
    "callbacks",
    f"put its place on a callback page of the kind subscriber; {OWN_EXECUTOR}",
    of=callbacks,
)
def messages_of_no_callback(small: Small) -> None:
    news = sym.Place(id="News", page=small["node"])
    small["Topic"].subscribers.append(sym.SubscriberPort(place=news))


@CASES.breaks(
    "server-begins-callback",
    "server port of service channel 'Service' serves on callback page 'Serve', and the node runs callbacks",
    f"use a callback page of the kind server; {OWN_EXECUTOR}",
    of=callbacks,
)
def requests_of_a_timer(small: Small) -> None:
    small["Serve"].kind = "subscriber"


@CASES.breaks(
    "server-begins-callback",
    "server port of service channel 'Plain' serves on page 'Plainly', and the node runs callbacks",
    f"use a callback page of the kind server; {OWN_EXECUTOR}",
    of=callbacks,
)
def requests_of_a_plain_page(small: Small) -> None:
    page = pn.Page(id="Plainly", page=small["node"])
    entry, exit_ = sym.Place(id="PlainIn", page=page), sym.Place(id="PlainOut", page=page)
    flow(entry, sym.Transition(id="ServePlainly", page=page), exit_)
    client = sym.ClientPort(
        client="c",
        request=sym.Place(id="AskPlain", page=small["other"]),
        response=sym.Place(id="GotPlain", page=small["other"]),
    )
    server = sym.ServerPort(entry=entry, exit=exit_, page=page)
    small.net.channels.append(
        sym.ServiceChannel(id="Plain", service="/plain", server=server, clients=[client])
    )


@CASES.breaks(
    "callbacks-begin-later",
    "place 'Heard' holds 1 tokens at the start, which began no callback",
    "make it empty at the start",
    of=callbacks,
)
def message_at_the_start(small: Small) -> None:
    small["Heard"].tokens = 1


@CASES.breaks(
    "client-group-of-node-net",
    "client port 'clock' of service channel 'Service' is in callback group 'others' of another node net",
    "use a callback group of its own node net",
    of=callbacks,
)
def client_in_a_foreign_group(small: Small) -> None:
    small["Service"].clients[0].group = small["others"]


@CASES.breaks(
    "callback-group-has-effect",
    "callback page 'clock' is in callback group 'group', which has no effect",
    f"{_BY_CALLBACKS}, or do not rely on it",
)
def own_group(small: Small) -> None:
    small["clock"].group = small["group"]


@CASES.breaks(
    "client-group-has-effect",
    "client port 'clock' of service channel 'Service' is in callback group 'own', which has no effect",
    f"{_BY_CALLBACKS}, or do not rely on it",
    of=callbacks,
)
def group_of_a_net(small: Small) -> None:
    small["node"].execution = "net"
    small["Clock"].awaits = False


@CASES.breaks(
    "response-callback-group",
    "responses to client port 'clock' of service channel 'Service' begin callback page 'OnAnswer' in "
    "callback group 'apart', in which its client is not",
    "let the page name no group (rclpy), or page and client the same one (rclcpp)",
    of=callbacks,
)
def response_in_a_group_of_its_own(small: Small) -> None:
    small["Clock"].awaits = False
    small["node"].callbackGroups.append(sym.CallbackGroup(id="apart"))
    page = sym.CallbackPage(id="OnAnswer", kind="client", page=small["node"], group=small["apart"])
    answered = sym.Place(id="Answered", page=page)
    flow(answered, sym.Transition(id="NoteIt", page=page))
    small["Service"].clients[0].response = answered


@CASES.breaks(
    "awaits-has-effect",
    "callback page 'clock' awaits responses, but its node does not run callbacks",
    f"{_BY_CALLBACKS}, or remove it",
    of=system,
)
def net_that_awaits(small: Small) -> None:
    small["clock"].awaits = True


@CASES.breaks(
    "awaits-has-effect",
    "callback page 'Hear' awaits responses, but it calls nothing on its page",
    "put request and response of a client there, or remove it",
    of=callbacks,
)
def nothing_to_await(small: Small) -> None:
    small["Hear"].awaits = True


@CASES.breaks(
    "awaits-in-turn",
    "callback page 'Clock' awaits one response at a time, but continues in several ways after "
    "transition 'Begin'",
    "put one call after the other, or set awaits to false",
    of=callbacks,
)
def two_calls_at_once(small: Small) -> None:
    page = small["Clock"]
    ask, got = sym.Place(id="AskToo", page=page), sym.Place(id="GotToo", page=page)
    flow(small["Begin"], ask)
    flow(got, small["Finish"])
    small["Service"].clients.append(
        sym.ClientPort(client="too", request=ask, response=got, group=small["own"])
    )
