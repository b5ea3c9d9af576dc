"""Models that break the constraints of `node_nets`."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small

CASES = Cases()


@CASES.breaks(
    "node-net-not-nested",
    "node net 'inner' is inside node net 'talker'",
    "put it next to the other node net; node nets do not nest",
)
def node_net_in_a_node_net(small: Small) -> None:
    sym.NodeNet(id="inner", page=small["state"])


@CASES.breaks(
    "node-in-node-net",
    "place 'Alone' is outside of all node nets",
    "move it into the node net of the ROS node that it is part of",
)
def place_on_a_page_outside(small: Small) -> None:
    page = pn.Page(id="outside", net=small.net)
    sym.Place(id="Alone", page=page)


@CASES.breaks(
    "node-in-node-net",
    "place 'Alone' is outside of all node nets",
    "move it into the node net of the ROS node that it is part of",
)
def place_reached_from_one_node_net(small: Small) -> None:
    page = pn.Page(id="outside", net=small.net)
    small["BusyHere"].target = sym.Place(id="Alone", page=page)


@CASES.breaks(
    "node-in-node-net",
    "reference place 'Alone' is outside of all node nets",
    "move it into the node net of the ROS node that it is part of",
)
def reference_outside(small: Small) -> None:
    page = pn.Page(id="outside", net=small.net)
    pn.ReferencePlace(id="Alone", target=small["Idle"], page=page)


@CASES.breaks(
    "node-not-shared",
    "place 'Shared' joins node net 'talker' and node net 'listener' outside of them",
    "put it into one of them and join them by a topic or a service",
)
def place_reached_from_two_node_nets(small: Small) -> None:
    page = pn.Page(id="outside", net=small.net)
    small["BusyHere"].target = small["CountHere"].target = sym.Place(id="Shared", page=page)


@CASES.breaks(
    "reference-within-node-net",
    "reference place 'BusyHere' refers to place 'Count' of another node net",
    "join the node nets by a topic or a service",
)
def reference_across(small: Small) -> None:
    small["BusyHere"].target = small["Count"]


@CASES.breaks(
    "overrides-within-node-net",
    "transition 'Talk' overrides transition 'Serve' of another node net",
    "remove the priority; ROS nodes do not wait for each other's transitions",
)
def priority_across(small: Small) -> None:
    small["Talk"].overrides.append(small["Serve"])


@CASES.breaks(
    "threads-positive",
    "node net 'listener' has 0 threads",
    "give it 1 thread or more",
)
def no_thread(small: Small) -> None:
    small["listener"].threads = 0


@CASES.breaks(
    "threads-need-multi",
    "node net 'talker' has 2 threads but a single-threaded executor",
    "set the executor to multi or the threads to 1",
)
def single_with_threads(small: Small) -> None:
    small["talker"].executor = "single"


@CASES.breaks(
    "callback-page-in-node-net",
    "callback page 'lost' is outside of all node nets",
    "move it into the node net of the ROS node that calls it",
)
def callback_page_outside(small: Small) -> None:
    sym.CallbackPage(id="lost", kind="timer", timer=1.0, net=small.net)


@CASES.breaks(
    "callback-page-not-nested",
    "callback page 'inner' is inside callback page 'clock'",
    "put it next to that",
)
def timer_in_a_timer(small: Small) -> None:
    sym.CallbackPage(id="inner", kind="timer", timer=1.0, page=small["clock"])


@CASES.breaks(
    "callback-group-of-node-net",
    "callback page 'clock' is in callback group 'others' of another node net",
    "use a callback group of its own node net",
)
def foreign_group(small: Small) -> None:
    small["clock"].group = small["others"]


@CASES.breaks(
    "timer-positive",
    "callback page 'clock' is called by a timer with no period",
    "set timer to a period above 0",
)
def no_period(small: Small) -> None:
    small["clock"].timer = None


@CASES.breaks(
    "timer-positive",
    "callback page 'clock' is called by a timer with the period 0.0",
    "set timer to a period above 0",
)
def period_0(small: Small) -> None:
    small["clock"].timer = 0.0


@CASES.breaks(
    "timer-used",
    "callback page 'hear' has a timer but is called by a subscriber",
    "remove the timer or set the kind to timer",
)
def subscriber_with_a_timer(small: Small) -> None:
    small["hear"].timer = 1.0


@CASES.breaks(
    "callback-page-called",
    "callback page 'deaf' is a subscriber callback, but no subscriber has a place on it",
    "set its kind to what calls it, or add the port",
)
def no_subscriber(small: Small) -> None:
    sym.CallbackPage(id="deaf", page=small["listener"])


@CASES.breaks(
    "callback-page-called",
    "callback page 'idle' is a server callback, but it is not the server page of a service",
    "set its kind to what calls it, or add the port",
)
def no_server(small: Small) -> None:
    sym.CallbackPage(id="idle", kind="server", page=small["listener"])


@CASES.breaks(
    "callback-page-called",
    "callback page 'serve' is a subscriber callback, but it is the server page of a service",
    "set its kind to what calls it, or add the port",
)
def server_page_of_another_kind(small: Small) -> None:
    small["serve"].kind = "subscriber"


@CASES.breaks(
    "callback-page-called",
    "callback page 'answered' is a client callback, but it does not receive the response to a request from "
    "another page",
    "set its kind to what calls it, or add the port",
)
def no_response(small: Small) -> None:
    sym.CallbackPage(id="answered", kind="client", page=small["talker"])


@CASES.breaks(
    "timed-transition-has-interval",
    "transition 'Done' is timed but has no interval",
    "set its interval, or its kind to discrete",
)
def timed_without_interval(small: Small) -> None:
    small["Done"].kind = "timed"


@CASES.breaks(
    "timer-outside-server-page",
    "callback page 'often' is called by a timer but is on the server page 'work': all instances have "
    "one timer in common",
    "put it next to the server page",
)
def timer_on_a_server_page(small: Small) -> None:
    small["serve"].kind = "timer"
    small["serve"].timer = 1.0
    page, server = pn.Page(id="work", page=small["listener"]), small["ask"].server
    server.entry, server.exit = sym.Place(id="Entry2", page=page), sym.Place(id="Exit2", page=page)
    server.page = page
    sym.CallbackPage(id="often", kind="timer", timer=1.0, page=page)


@CASES.breaks(
    "lifecycle-has-effect",
    "node net 'talker' has a lifecycle, which the rules of ros1 do not know",
    "set the middleware of the model to ros2, or remove it",
)
def lifecycle_of_ros1(small: Small) -> None:
    small["talker"].lifecycle = sym.Lifecycle()


@CASES.breaks(
    "start-steps-positive",
    "lifecycle of node net 'talker' has the activate step -1",
    "use a step of 1 or more, or 0 for any time",
)
def step_before_the_first(small: Small) -> None:
    small.net.middleware = "ros2"
    small["talker"].lifecycle = sym.Lifecycle(activateStep=-1)


@CASES.breaks(
    "configured-before-active",
    "lifecycle of node net 'talker' is configured in step 2, and activated in step 2",
    "set a later step for its activation",
)
def active_before_configured(small: Small) -> None:
    small.net.middleware = "ros2"
    small["talker"].lifecycle = sym.Lifecycle(configureStep=2, activateStep=2)
