"""Models that break the constraints of `actions`."""

from __future__ import annotations

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.build import flow
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small
from tests.support.ros2_systems.deliveries import deliveries

CASES = Cases()
_SERVER = "action server port of action channel 'Delivery'"
_CLIENT = "action client port 'office0' of action channel 'Delivery'"


def acting() -> Small:
    """Return a system model of a robot that delivers for two offices."""
    model = deliveries(2, feedback=True)
    for net in model.pages:
        assert isinstance(net, sym.NodeNet)
        net.callbackGroups.append(sym.CallbackGroup(id=f"group.{net.id}"))
    return Small(model)


def running() -> Small:
    """Return the run-time model of a node that has both ends of an action."""
    model = rtm.RuntimeModel(id="node", systemModel="small")
    model.node = net = sym.NodeNet(id="robot", net=model)
    page = sym.CallbackPage(id="Deliver", kind="goal", page=net)
    entry, at, send, done, heard = (
        rtm.Place(id=id, page=page if id in ("Parcel", "At") else net)
        for id in ("Parcel", "At", "Send", "Done", "Heard")
    )
    entry.ports.append(rtm.ActionServerPort(channel="a", action="/deliver", page=page, succeeded=at))
    client = rtm.ActionClientPort(
        channel="a", action="/deliver", client="own", succeeded=done, feedback=heard
    )
    send.ports.append(client)
    return Small(model)


@CASES.breaks("action-has-client", "action channel 'Delivery' has no client", "add a client port", of=acting)
def no_client(small: Small) -> None:
    small["Delivery"].clients.clear()


@CASES.breaks(
    "action-slots",
    "action channel 'Delivery' works on 0 goals at once",
    "let it work on 1 goal or more, or leave the number out to have a slot for each client",
    of=acting,
)
def no_slot(small: Small) -> None:
    small["Delivery"].instances = 0


@CASES.breaks(
    "feedback-depth-positive",
    "action channel 'Delivery' keeps 0 feedback messages",
    "let it keep 1 or more",
    of=acting,
)
def no_depth(small: Small) -> None:
    small["Delivery"].depth = 0


@CASES.breaks(
    "goal-places-on-page",
    f"{_SERVER} has place 'Away' outside of the page 'Deliver' that works on goals",
    "move the place to that page",
    of=acting,
)
def place_elsewhere(small: Small) -> None:
    small["Delivery"].server.aborted = sym.Place(id="Away", page=small["robot"])


@CASES.breaks(
    "goal-places-differ", f"{_SERVER} uses place 'At' twice", "use a place for each purpose", of=acting
)
def one_place(small: Small) -> None:
    small["Delivery"].server.aborted = small["At"]


@CASES.breaks(
    "goals-end",
    f"{_SERVER} has no place where a goal ends",
    "name a place for results of goals that succeed, or are aborted",
    of=acting,
)
def no_exit(small: Small) -> None:
    server = small["Delivery"].server
    server.succeeded = server.aborted = server.canceled = None


@CASES.breaks(
    "canceled-is-asked-for",
    f"{_SERVER} has a place for results of goals that are canceled, but none for requests to cancel",
    "name a place that gets a token when the goal is to be canceled",
    of=acting,
)
def never_canceled(small: Small) -> None:
    small["Delivery"].server.cancel = None
    for client in small["Delivery"].clients:
        client.cancel = None


@CASES.breaks(
    "goal-page-of-its-own",
    "action server port of action channel 'Other' has a server page that is all of node net 'other'",
    "put what works on goals on a page of its own inside a node net",
    of=acting,
)
def whole_node_net(small: Small) -> None:
    _other(small, sym.NodeNet(id="other", net=small.net))


@CASES.breaks(
    "goal-page-of-its-own",
    "action server port of action channel 'Other' has a server page inside callback page 'Deliver', "
    "which is one too",
    "put what works on goals on a page of its own inside a node net",
    of=acting,
)
def page_in_page(small: Small) -> None:
    _other(small, pn.Page(id="inner", page=small["Deliver"]))


def _other(small: Small, page: pn.Page) -> None:
    """Add an action whose server has a page."""
    entry, done = sym.Place(id="Other.in", page=page), sym.Place(id="Other.out", page=page)
    flow(entry, sym.Transition(id="Other.work", page=page), done)
    office = small["office0"]
    client = sym.ActionClientPort(
        client="c", goal=sym.Place(id="Ask", page=office), succeeded=sym.Place(id="Got", page=office)
    )
    server = sym.ActionServerPort(page=page, entry=entry, succeeded=done)
    sym.ActionChannel(id="Other", action="/other", server=server, clients=[client], model=small.net)


@CASES.breaks(
    "goal-places-empty",
    f"{_SERVER} has tokens at the start in place 'Stop', where no goal is worked on yet",
    "make the places empty at the start",
    of=acting,
)
def marked(small: Small) -> None:
    small["Stop"].tokens = 1


@CASES.breaks(
    "cancels-come-from-clients",
    f"{_SERVER} is asked to cancel by transition 'Arrive' of its own page",
    "take the arc away: only requests of clients put tokens on that place",
    of=acting,
)
def asks_itself(small: Small) -> None:
    flow(small["Arrive"], small["Stop"])


@CASES.breaks(
    "goals-begin-callback",
    f"{_SERVER} works on goals on callback page 'Deliver', and the node runs callbacks",
    "use a callback page of the kind goal",
    of=acting,
)
def wrong_kind(small: Small) -> None:
    small["robot"].execution = "callbacks"
    small["Deliver"].kind = "server"


@CASES.breaks(
    "runtime-action-server",
    "action server port '/deliver' of place 'Parcel' has 0 slots",
    "use places on the page that works on goals and 1 slot or more",
    of=running,
)
def no_slot_at_run_time(small: Small) -> None:
    small["Parcel"].ports[0].instances = 0


@CASES.breaks(
    "goal-client-in-one-node-net",
    f"{_CLIENT} has its goals in node net 'office0', and place 'Delivered1' elsewhere",
    "put all its places into one node net",
    of=acting,
)
def answers_elsewhere(small: Small) -> None:
    small["Delivery"].clients[0].succeeded = small["Delivered1"]


@CASES.breaks(
    "goal-client-places-differ",
    f"{_CLIENT} has place 'Heard0' for several purposes",
    "use a place for each purpose",
    of=acting,
)
def hears_results(small: Small) -> None:
    small["Delivery"].clients[0].succeeded = small["Heard0"]


@CASES.breaks(
    "runtime-goal-client-places-differ",
    "action client port 'own' of place 'Send' has place 'Heard' for several purposes",
    "use a place for each purpose",
    of=running,
)
def hears_results_at_run_time(small: Small) -> None:
    small["Send"].ports[0].succeeded = small["Heard"]


@CASES.breaks(
    "goal-client-unique",
    "action client port 'office0' of action channel 'Delivery' has the id of another client of the action",
    "give it another client id",
    of=acting,
)
def same_id(small: Small) -> None:
    small["Delivery"].clients[1].client = "office0"


@CASES.breaks(
    "goal-client-outside-server-pages",
    f"{_CLIENT} has a place on callback page 'Serve', of which there is one for each call or goal",
    "put its places next to that page, and let the page reach them by references",
    of=acting,
)
def goal_of_a_server(small: Small) -> None:
    office = small["office0"]
    page = sym.CallbackPage(id="Serve", kind="server", page=office)
    entry, done = sym.Place(id="Serve.in", page=page), sym.Place(id="Serve.out", page=page)
    ask, got = sym.Place(id="Ask", page=office), sym.Place(id="Got", page=office)
    sym.ServiceChannel(
        id="Service",
        service="/serve",
        server=sym.ServerPort(entry=entry, exit=done, page=page),
        clients=[sym.ClientPort(client="c", request=ask, response=got)],
        model=small.net,
    )
    small["Delivery"].clients[0].rejected = sym.Place(id="No", page=page)


@CASES.breaks(
    "outstanding-goals-positive",
    f"{_CLIENT} has 0 goals under way at most",
    "set it to 1 goal or more",
    of=acting,
)
def no_goal(small: Small) -> None:
    small["Delivery"].clients[0].outstanding = 0


@CASES.breaks(
    "results-are-fetched",
    f"{_CLIENT} does not fetch results of goals that are aborted or canceled",
    "name a place for them; it may be the same one for all ends of a goal",
    of=acting,
)
def not_fetched(small: Small) -> None:
    client = small["Delivery"].clients[0]
    client.aborted = client.canceled = None


@CASES.breaks(
    "cancels-are-taken",
    f"{_CLIENT} asks to cancel goals, which {_SERVER} refuses",
    "name a place of the server that gets a token when the goal is to be canceled",
    of=acting,
)
def refused(small: Small) -> None:
    server = small["Delivery"].server
    server.cancel = server.canceled = None
    small["Delivery"].clients[1].cancel = None


@CASES.breaks(
    "goal-client-group-of-node-net",
    f"{_CLIENT} is in callback group 'group.robot' of another node net",
    "use a callback group of its own node net",
    of=acting,
)
def group_of_another(small: Small) -> None:
    small["Delivery"].clients[0].group = small["group.robot"]


@CASES.breaks(
    "goal-client-group-has-effect",
    f"{_CLIENT} is in callback group 'group.office0', which has no effect",
    "set the execution of its node net to callbacks and the middleware of the model to ros2, or do not "
    "rely on it",
    of=acting,
)
def group_without_effect(small: Small) -> None:
    small["Delivery"].clients[0].group = small["group.office0"]


@CASES.breaks(
    "action-name-valid",
    "action channel 'Delivery' has the action '/2nd', which is not a ROS action name",
    "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires",
    of=acting,
)
def bad_name(small: Small) -> None:
    small["Delivery"].action = "/2nd"


@CASES.breaks(
    "action-unique",
    "action channel 'Again' is for the action 'deliver', as is action channel 'Delivery'",
    "join their clients in one channel or rename one",
    of=acting,
)
def same_action(small: Small) -> None:
    net = sym.NodeNet(id="second", net=small.net)
    page = sym.CallbackPage(id="Second", kind="goal", page=net)
    entry, done = sym.Place(id="Second.in", page=page), sym.Place(id="Second.out", page=page)
    ask, got = sym.Place(id="Ask", page=net), sym.Place(id="Got", page=net)
    sym.ActionChannel(
        id="Again",
        action="deliver",
        server=sym.ActionServerPort(page=page, entry=entry, succeeded=done),
        clients=[sym.ActionClientPort(client="c", goal=ask, succeeded=got)],
        model=small.net,
    )


@CASES.breaks(
    "parts-of-goals-have-one-type",
    "action channel 'Delivery' has results of different token types: place 'At' has no token type, "
    "place 'Delivered0' has 'Note'",
    "give the places of goals, those of results and those of feedback one token type each",
    of=acting,
)
def two_types(small: Small) -> None:
    small.net.otherTokenTypes.append(sym.TokenType(id="Note"))
    small["Delivered0"].tokenType = small["Note"]
