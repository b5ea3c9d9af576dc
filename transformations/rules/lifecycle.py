"""Managed nodes of ROS 2 (rules L1 to L3): their states, and what a node does in each state.

Before a node is configured, it does nothing. While it is inactive, it takes messages, its timers tick and it
serves requests, but messages that it publishes are lost (ROS 2 design article *Managed nodes*; observed with
rclpy 7.1.6). Rules L4 and L5 are about messages between nodes that start and stop.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.records import Drop, Lifecycle
from dineros.transformations.language import TRUTH, Expression, Fragment, Meaning, New
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.language.functions import Query, ancestor
from dineros.transformations.language.patterns import Absent, Index, Made, Node, Pattern
from dineros.transformations.rules.executors import E1, Lock
from dineros.transformations.rules.histories import R3, Publication
from dineros.transformations.rules.notation import arc, place, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.callbacks import Callback
from dineros.transformations.rules.requests import AbandonedCall
from dineros.transformations.rules.services import S1, S4, Answering, Home, Serving, instances
from dineros.transformations.rules.starts import Start
from dineros.transformations.rules.timers import C1

LANGUAGE.add(__name__)


class Leaves(Query):
    """Whether a managed node may be cleaned up or shut down."""

    datatype = TRUTH
    _words = "{} may be cleaned up or shut down"

    @staticmethod
    def _answer(life: sym.Lifecycle) -> bool:
        return life.cleansUp or life.shutsDown


class Working(Query):
    """The state in which a managed node works: active if it pauses while inactive, else configured."""

    eclass = pn.Place
    _words = "{1} where {0} pauses, else {2}"

    @staticmethod
    def _answer(life: sym.Lifecycle, active: pn.Place, configured: pn.Place) -> pn.Place:
        return active if life.pauses else configured


def _state(name: str, words: str = "", tokens: int = 0) -> New:
    words = f"node net {{node}} {words or f'is {name}'}"
    return place(f"{{node.id}}.{name}", tokens, Meaning(words, part=f"state.{name}", rests=True))


class StateChange(Fragment):
    """A managed node changes its state.

    Parameters
    ----------
    part : str
        The requested change, and whether it fails: ``configure``, ``configure.fails``.
    words : str
        Description of the change.
    before, after : sequence of Expression
        Places that lose a token, and places that get one.
    state : str
        The state before the change, if one rule makes several changes.
    """

    roles: Mapping[str, type[EObject]] = {"move": pn.Transition}
    move: New

    def __init__(
        self, part: str, words: str, before: list[Expression], after: list[Expression], *, state: str = ""
    ) -> None:
        super().__init__()
        id = f"{{node.id}}.{part}.{state}" if state else f"{{node.id}}.{part}"
        self.move = transition(id, Meaning(f"node net {{node}} {words}", step=Lifecycle, part=part))
        self.arcs = [*(arc(each, self.move) for each in before), *(arc(self.move, each) for each in after)]


class Configuring(StateChange):
    """A managed node is configured, or its configuration fails."""


class Activating(StateChange):
    """A managed node is activated, or its activation fails."""


class Leaving(StateChange):
    """A managed node that is configured is cleaned up or shut down."""


class L1(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A managed node is in one of four states."""

    node = Node(sym.NodeNet)
    life = Node(sym.Lifecycle, of=node.lifecycle)

    unconfigured = _state("unconfigured", tokens=1)
    inactive = _state("inactive")
    active = _state("active")
    finalized = _state("finalized")
    configured = _state("configured")
    away = _state("absent", "is not configured", tokens=1)
    configure = Configuring("configure", "is configured", [unconfigured, away], [inactive, configured])
    activate = Activating("activate", "is activated", [inactive], [active])


class L1ConfigureFails(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """Configuring may fail, if the model allows it."""

    node = Node(sym.NodeNet)
    life = Node(sym.Lifecycle, of=node.lifecycle, configureFails=True)
    unconfigured = Made(L1.unconfigured, of=node)

    fails = Configuring("configure.fails", "fails to be configured", [unconfigured], [unconfigured])


class L1ActivateFails(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """Activating may fail, if the model allows it."""

    node = Node(sym.NodeNet)
    life = Node(sym.Lifecycle, of=node.lifecycle, activateFails=True)
    inactive = Made(L1.inactive, of=node)

    fails = Activating("activate.fails", "fails to be activated", [inactive], [inactive])


class L1Deactivate(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A managed node may be deactivated, if the model allows it."""

    node = Node(sym.NodeNet)
    life = Node(sym.Lifecycle, of=node.lifecycle, deactivates=True)
    inactive = Made(L1.inactive, of=node)
    active = Made(L1.active, of=node)

    deactivate = StateChange("deactivate", "is deactivated", [active], [inactive])


class L1Cleanup(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A managed node may be cleaned up."""

    node = Node(sym.NodeNet)
    life = Node(sym.Lifecycle, of=node.lifecycle, cleansUp=True)
    unconfigured = Made(L1.unconfigured, of=node)
    inactive = Made(L1.inactive, of=node)
    configured = Made(L1.configured, of=node)
    away = Made(L1.away, of=node)

    cleanup = Leaving("cleanup", "is cleaned up", [inactive, configured], [unconfigured, away])


class L1Shutdown(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A managed node may be shut down in any state, and stays so."""

    node = Node(sym.NodeNet)
    life = Node(sym.Lifecycle, of=node.lifecycle, shutsDown=True)
    unconfigured = Made(L1.unconfigured, of=node)
    inactive = Made(L1.inactive, of=node)
    active = Made(L1.active, of=node)
    finalized = Made(L1.finalized, of=node)
    configured = Made(L1.configured, of=node)
    away = Made(L1.away, of=node)

    existing = _state("existing", "is not finalized", tokens=1)
    at_once = StateChange(
        "shutdown", "is shut down", [unconfigured, existing], [finalized], state="unconfigured"
    )
    while_inactive = Leaving(
        "shutdown", "is shut down", [inactive, existing, configured], [finalized, away], state="inactive"
    )
    while_active = Leaving(
        "shutdown", "is shut down", [active, existing, configured], [finalized, away], state="active"
    )


class StartOrder(Pattern):
    """Two managed nodes, each with its lifecycle, whose steps in the start order are compared."""

    def __init__(self) -> None:
        self.node = Node(sym.NodeNet)
        self.life = Node(sym.Lifecycle, of=self.node.lifecycle)
        self.other = Node(sym.NodeNet)
        self.earlier = Node(sym.Lifecycle, of=self.other.lifecycle)


class L1Configured(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A node is configured after those that an earlier step of the start order configures."""

    order = StartOrder()
    change = Made(Configuring, of=order.node)
    configured = Made(L1.configured, of=order.other)

    waits = read(configured, change.move)

    where = [order.earlier.configureStep > 0, order.earlier.configureStep < order.life.configureStep]


class L1ConfiguredActive(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A node is configured after those that an earlier step activates."""

    order = StartOrder()
    change = Made(Configuring, of=order.node)
    active = Made(L1.active, of=order.other)

    waits = read(active, change.move)

    where = [
        order.other != order.node,
        order.earlier.activateStep > 0,
        order.earlier.activateStep < order.life.configureStep,
    ]


class L1Activated(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A node is activated after those that an earlier step configures."""

    order = StartOrder()
    change = Made(Activating, of=order.node)
    configured = Made(L1.configured, of=order.other)

    waits = read(configured, change.move)

    where = [
        order.other != order.node,
        order.earlier.configureStep > 0,
        order.earlier.configureStep < order.life.activateStep,
    ]


class L1ActivatedActive(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A node is activated after those that an earlier step activates."""

    order = StartOrder()
    change = Made(Activating, of=order.node)
    active = Made(L1.active, of=order.other)

    waits = read(active, change.move)

    where = [order.earlier.activateStep > 0, order.earlier.activateStep < order.life.activateStep]


class L1Thread(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A change of state is a request that a thread of the executor serves."""

    node = Node(sym.NodeNet)
    change = Made(StateChange, of=node)
    threads = Made(E1.threads, of=node)

    needs_thread = read(threads, change.move)


class L1Exclusive(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A change of state is served while no callback of the node's default group runs."""

    node = Node(sym.NodeNet)
    change = Made(StateChange, of=node)
    lock = Made(Lock, of=node)

    needs_lock = read(lock.lock, change.move)


class L2(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A node publishes while it is active; what it publishes while it is inactive is lost."""

    channel = Node(sym.TopicChannel)
    writer = Node(sym.PublisherPort, channel=channel)
    publication = Made(Publication, of=writer)
    source = Node(pn.Place, of=publication.source)
    node = Node(sym.NodeNet, of=Home(writer.place))
    active = Made(L1.active, of=node)
    inactive = Made(L1.inactive, of=node)

    discard = transition(
        "{channel.id}.publisher.{source.id}.discard",
        Meaning(
            "a message of {publisher} on topic {topic} is lost: node net {writing} is inactive",
            step=Drop,
            queue="publisher",
            part="discard",
        ),
    )
    arcs = [
        read(active, publication.publish),
        arc(source, discard),
        read(inactive, discard),
    ]


class L2Away(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """Messages of a callback that still runs when its node is cleaned up or shut down are lost, too."""

    channel = Node(sym.TopicChannel)
    writer = Node(sym.PublisherPort, channel=channel)
    publication = Made(Publication, of=writer)
    source = Node(pn.Place, of=publication.source)
    node = Node(sym.NodeNet, of=Home(writer.place))
    life = Node(sym.Lifecycle, of=node.lifecycle)
    away = Made(L1.away, of=node)

    abandon = transition(
        "{channel.id}.publisher.{source.id}.abandon",
        Meaning(
            "a message of {publisher} on topic {topic} is lost: node net {writing} is not configured",
            step=Drop,
            queue="publisher",
            part="abandon",
        ),
    )
    arcs = [arc(source, abandon), read(away, abandon)]

    where = [Leaves(life)]


class WorkingNode(Pattern):
    """A managed node of an execution, around an element, and the place of its state in which it works."""

    def __init__(self, inside: Expression, execution: str) -> None:
        self.node = Node(sym.NodeNet, execution=execution, of=ancestor(inside, sym.NodeNet))
        self.life = Node(sym.Lifecycle, of=self.node.lifecycle)
        self.active = Made(L1.active, of=self.node)
        self.configured = Made(L1.configured, of=self.node)
        self.works = Node(pn.Place, of=Working(self.life, self.active, self.configured))


class L3(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """No transition of a node fires before the node is configured, or active if it pauses while inactive."""

    move = Node(pn.Transition)
    on = WorkingNode(move, "net")

    waits = read(on.works, move)


class L3Begin(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """No timer's callback of a managed node begins before the node is configured or active."""

    page = Node(sym.CallbackPage)
    start = Made(Start, of=page)
    on = WorkingNode(page, "callbacks")

    waits = read(on.works, start.begin)


class L3Outside(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """No transition outside of the callbacks of a managed node fires before it is configured or active."""

    move = Node(pn.Transition)
    on = WorkingNode(move, "callbacks")
    page = Node(sym.CallbackPage, of=Callback(move))

    waits = read(on.works, move)

    absent = [Absent(page)]


class L3Tick(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """No timer of a managed node ticks before the node is configured."""

    page = Node(sym.CallbackPage, kind="timer")
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    tick = Made(C1.tick, of=page)
    configured = Made(L1.configured, of=node)

    waits = read(configured, tick)


class L3Take(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A managed node takes no message before it is configured."""

    reader = Node(sym.SubscriberPort)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    queue = Made(R3.queue, of=reader)
    configured = Made(L1.configured, of=node)

    waits = read(configured, queue.leave)


class L3Serve(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A managed node takes no request before it is configured."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))
    copy = Made(S4.page, of=[service, instance])
    node = Node(sym.NodeNet, of=ancestor(copy, sym.NodeNet))
    serving = Made(Serving, of=[service, instance])
    configured = Made(L1.configured, of=node)

    waits = read(configured, serving.t_call)


class L3Answer(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A managed node sends no response before it is configured."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))
    copy = Made(S4.page, of=[service, instance])
    node = Node(sym.NodeNet, of=ancestor(copy, sym.NodeNet))
    answering = Made(Answering, of=[service, instance])
    configured = Made(L1.configured, of=node)

    waits = read(configured, answering.t_return)


class L3Ask(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A managed node sends no request and takes no response before it is configured."""

    client = Node(sym.ClientPort)
    node = Node(sym.NodeNet, of=ancestor(client.request, sym.NodeNet))
    t_req = Made(S1.t_req, of=client)
    t_res = Made(S1.t_res, of=client)
    configured = Made(L1.configured, of=node)

    waits = [read(configured, t_req), read(configured, t_res)]


class L3GiveUp(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A client of a managed node does not give up before the node is configured."""

    client = Node(sym.ClientPort)
    node = Node(sym.NodeNet, of=ancestor(client.request, sym.NodeNet))
    given = Made(AbandonedCall, of=client)
    configured = Made(L1.configured, of=node)

    waits = read(configured, given.give_up)
