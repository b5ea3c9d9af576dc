"""Executors and callback groups of ROS 2 (rules E1 to E7), for nodes that run callbacks.

A callback begins when the executor has a free thread and no other callback of its exclusive group runs; it
keeps both until it ends. The choice among several ready callbacks is left open: all orders are explored.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.transformations.language import Expression, Fragment, Meaning, New
from dineros.transformations.language.functions import ancestor, count
from dineros.transformations.language.patterns import Absent, Index, Made, Node, Pattern
from dineros.transformations.rules.histories import R3
from dineros.transformations.rules.notation import arc, arcs_at, place, read
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.callbacks import (
    Awaited,
    BeginsCallback,
    Callback,
    Ends,
    Group,
    HoldsThread,
    Members,
    Threads,
)
from dineros.transformations.rules.requests import AbandonedCall
from dineros.transformations.rules.services import S1, S4, Answering, Serving, instances
from dineros.transformations.rules.starts import Start


class Lock(Fragment):
    """The lock of an exclusive callback group: free while none of its callbacks runs.

    Parameters
    ----------
    id : str
        Id of its place; may have placeholders.
    group : str
        Meaning of the place while the group is free.
    """

    roles: Mapping[str, type[EObject]] = {"lock": pn.Place}
    lock: New

    def __init__(self, id: str, group: str) -> None:
        super().__init__()
        self.lock = place(id, tokens=1, means=Meaning(group, part="lock", rests=True))


class Beginning(Fragment):
    """A callback begins.

    Parameters
    ----------
    move : Expression
        The transition by which it begins.
    threads, running : Expression
        Places of the node's free threads, and of the running callback.
    """

    roles: Mapping[str, type[EObject]] = {"move": pn.Transition}

    def __init__(self, move: Expression, threads: Expression, running: Expression) -> None:
        super().__init__(move=move)
        self.arcs = [arc(threads, move), arc(move, running)]


class Ending(Fragment):
    """A callback ends; the parameters are those of `Beginning`."""

    roles: Mapping[str, type[EObject]] = {"move": pn.Transition}

    def __init__(self, move: Expression, threads: Expression, running: Expression) -> None:
        super().__init__(move=move)
        self.arcs = [arc(running, move), arc(move, threads)]


class E1(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """The threads of a node's executor."""

    node = Node(sym.NodeNet, execution="callbacks")

    threads = place(
        "{node.id}.threads",
        tokens=Threads(node),
        means=Meaning("a free thread of node net {node}", part="threads", rests=True),
    )


class FreeThreads(Pattern):
    """The node around a place or page, and the free threads of its executor.

    `inside`: the place or page.
    """

    def __init__(self, inside: Expression) -> None:
        self.node = Node(sym.NodeNet, of=ancestor(inside, sym.NodeNet))
        self.threads = Made(E1.threads, of=self.node)


class E2(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """An exclusive callback group runs one callback at a time."""

    group = Node(sym.CallbackGroup, kind="exclusive")
    node = ancestor(group, sym.NodeNet)

    lock = Lock("{node.id}.{group.id}.lock", "free callback group {group} of node net {node}")

    where = [node.execution == "callbacks", count(Members(group)) > 0]


class E2Default(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """The group of callbacks and clients that name no group runs one callback at a time, too."""

    node = Node(sym.NodeNet, execution="callbacks")

    lock = Lock("{node.id}.lock", "free default callback group of node net {node}")

    where = [count(Members(node)) > 0]


class E3(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """How often a callback runs."""

    page = Node(sym.CallbackPage)
    node = Node(sym.NodeNet, execution="callbacks", of=ancestor(page, sym.NodeNet))

    running = place("{page.id}.running", means=Meaning("{callback} runs", part="running"))

    where = [HoldsThread(page)]


class Execution(FreeThreads):
    """The threads that a callback needs, and the place of the running callback."""

    def __init__(self, page: Node) -> None:
        super().__init__(page)
        self.running = Made(E3.running, of=page)


class InstanceCallback(Pattern):
    """The callback page of an instance of a server."""

    def __init__(self) -> None:
        self.service = Node(sym.ServiceChannel)
        self.instance = Index(upto=instances(self.service))
        self.copy = Made(S4.page, of=[self.service, self.instance])
        self.page = Node(sym.CallbackPage, of=self.copy)


class E3Take(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A subscriber's callback begins when a message is taken from the reader history."""

    reader = Node(sym.SubscriberPort)
    page = Node(sym.CallbackPage, of=Callback(reader.place))
    queue = Made(R3.queue, of=reader)
    on = Execution(page)

    beginning = Beginning(queue.leave, on.threads, on.running)


class E3Tick(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A timer's callback begins with its first transition."""

    page = Node(sym.CallbackPage)
    start = Made(Start, of=page)
    end = Node(pn.Transition, of=Ends(page))
    on = Execution(page)

    beginning = Beginning(start.begin, on.threads, on.running)

    absent = [Absent(end, where=[end == start.begin])]


class E3Serve(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A server's callback begins when its instance takes a request, a late one too."""

    server = InstanceCallback()
    serving = Made(Serving, of=[server.service, server.instance])
    on = Execution(server.page)

    beginning = Beginning(serving.t_call, on.threads, on.running)


class E3Once(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A timer's callback of a single transition begins and ends at once."""

    page = Node(sym.CallbackPage)
    start = Made(Start, of=page)
    end = Node(pn.Transition, of=Ends(page))
    on = FreeThreads(page)

    needs_thread = read(on.threads, start.begin)

    where = [end == start.begin]


class E3Exclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that begins takes the lock of its exclusive group."""

    page = Node(sym.CallbackPage)
    beginning = Made(Beginning, of=page)
    lock = Made(Lock, of=Group(page))

    takes = arc(lock.lock, beginning.move)


class E4(StandardRule, phase=Phase.endings, middleware="ros2"):
    """A callback ends with its transitions that no other one of the callback follows."""

    page = Node(sym.CallbackPage)
    end = Node(pn.Transition, of=Ends(page))
    start = Made(Start, of=page)
    on = Execution(page)

    ending = Ending(end, on.threads, on.running)

    absent = [Absent(start, where=[end == start.begin])]


class E4Reply(StandardRule, phase=Phase.endings, middleware="ros2"):
    """A server's callback ends with its response, even if no client waits for it."""

    server = InstanceCallback()
    answering = Made(Answering, of=[server.service, server.instance])
    on = Execution(server.page)

    ending = Ending(answering.t_return, on.threads, on.running)


class E4Exclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that ends releases the lock of its exclusive group."""

    page = Node(sym.CallbackPage)
    ending = Made(Ending, of=page)
    lock = Made(Lock, of=Group(page))

    gives = arc(ending.move, lock.lock)


class E3OnceExclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A timer's callback of a single transition needs the lock of its exclusive group to be free."""

    page = Node(sym.CallbackPage)
    start = Made(Start, of=page)
    end = Node(pn.Transition, of=Ends(page))
    lock = Made(Lock, of=Group(page))

    needs_lock = read(lock.lock, start.begin)

    where = [end == start.begin]


class E5(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A free thread takes a response between callbacks."""

    client = Node(sym.ClientPort)
    t_res = Made(S1.t_res, of=client)
    on = FreeThreads(client.response)

    needs_thread = read(on.threads, t_res)

    where = [~BeginsCallback(client), ~Awaited(client)]


class E5Exclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A response is taken while the client's exclusive group is free."""

    client = Node(sym.ClientPort)
    t_res = Made(S1.t_res, of=client)
    lock = Made(Lock, of=Group(client))

    needs_lock = read(lock.lock, t_res)

    where = [~BeginsCallback(client)]


class E6(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A response begins its own callback, if it has one, on a thread and in the group that it names."""

    client = Node(sym.ClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.response))
    t_res = Made(S1.t_res, of=client)
    on = Execution(page)

    beginning = Beginning(t_res, on.threads, on.running)

    where = [BeginsCallback(client)]


class E6Exclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A response that begins a callback outside of the client's exclusive group needs that group, too."""

    client = Node(sym.ClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.response))
    t_res = Made(S1.t_res, of=client)
    lock = Made(Lock, of=Group(client))

    needs_lock = read(lock.lock, t_res)

    where = [BeginsCallback(client), Group(page) != Group(client)]


class E7(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """How many runs of a callback await a response."""

    page = Node(sym.CallbackPage, awaits=True)
    running = Made(E3.running, of=page)

    awaiting = place("{page.id}.awaiting", means=Meaning("{callback} awaits a response", part="awaiting"))


class AwaitingExecution(Execution):
    """The same for a callback that may await a response."""

    def __init__(self, page: Node) -> None:
        super().__init__(page)
        self.awaiting = Made(E7.awaiting, of=page)


class E7Call(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that awaits gives its thread back when it asks, and takes one when it continues."""

    client = Node(sym.ClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.request))
    t_req = Made(S1.t_req, of=client)
    t_res = Made(S1.t_res, of=client)
    on = AwaitingExecution(page)

    asks = [arc(on.running, t_req), arc(t_req, on.threads), arc(t_req, on.awaiting)]
    goes_on = [arc(on.awaiting, t_res), arc(on.threads, t_res), arc(t_res, on.running)]

    where = [Awaited(client)]


class E7GiveUp(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that awaits takes a thread when it gives up, too, and continues."""

    client = Node(sym.ClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.request))
    given = Made(AbandonedCall, of=client)
    on = AwaitingExecution(page)

    goes_on = arcs_at(given.give_up, [on.awaiting, on.threads], [on.running])

    where = [Awaited(client)]
