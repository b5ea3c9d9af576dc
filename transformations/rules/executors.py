"""Executors and callback groups of ROS 2 (rules E1 to E7), for nodes that run callbacks.

A callback begins when the executor has a thread for it and no other callback of its exclusive group runs,
and keeps both until it ends. Which of several that are ready the executor picks is left open: all orders are
explored.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.transformations.language.creation import Fragment, New
from dineros.transformations.language.expressions import Expression
from dineros.transformations.language.functions import ancestor, count
from dineros.transformations.language.meaning import Meaning
from dineros.transformations.language.patterns import Absent, Index, Made, Node
from dineros.transformations.rules.histories import R3
from dineros.transformations.rules.notation import arc, place, read
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.callbacks import (
    Awaited,
    Beginnings,
    BeginsCallback,
    Callback,
    Ends,
    Group,
    HoldsThread,
    Members,
    Threads,
)
from dineros.transformations.rules.requests import GiveUp
from dineros.transformations.rules.services import S1, S4, Answering, Serving, instances


class Lock(Fragment):
    """What an exclusive callback group has while none of its callbacks runs.

    Parameters
    ----------
    id : str
        Of its place; may hold placeholders.
    group : str
        What it is while the group is free.
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
        Places of its node's free threads, and of itself.
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


class E2(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """An exclusive callback group runs one callback at a time."""

    group = Node(sym.CallbackGroup, kind="exclusive")
    node = ancestor(group, sym.NodeNet)

    lock = Lock("{node.id}.{group.id}.lock", "free callback group {group} of node net {node}")

    where = [node.execution == "callbacks", count(Members(group)) > 0]


class E2Default(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """So does the group of the callbacks and clients that name none."""

    node = Node(sym.NodeNet, execution="callbacks")

    lock = Lock("{node.id}.lock", "free default callback group of node net {node}")

    where = [count(Members(node)) > 0]


class E3(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """How often a callback runs."""

    page = Node(sym.CallbackPage)
    node = Node(sym.NodeNet, execution="callbacks", of=ancestor(page, sym.NodeNet))

    running = place("{page.id}.running", means=Meaning("{callback} runs", part="running"))

    where = [HoldsThread(page)]


class E3Take(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A subscriber's callback begins when a message is taken from the reader history."""

    reader = Node(sym.SubscriberPort)
    page = Node(sym.CallbackPage, of=Callback(reader.place))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    queue = Made(R3.queue, of=reader)
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    beginning = Beginning(queue.leave, threads, running)


class E3Tick(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A timer's callback begins with its first transition."""

    page = Node(sym.CallbackPage)
    begin = Node(pn.Transition, of=Beginnings(page))
    end = Node(pn.Transition, of=Ends(page))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    beginning = Beginning(begin, threads, running)

    absent = [Absent(end, where=[end == begin])]


class E3Serve(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A server's callback begins when its instance takes a request, a late one too."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))
    copy = Made(S4.page, of=[service, instance])
    page = Node(sym.CallbackPage, of=copy)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    serving = Made(Serving, of=[service, instance])
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    beginning = Beginning(serving.t_call, threads, running)


class E3Once(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A timer's callback of a single transition begins and ends at once."""

    page = Node(sym.CallbackPage)
    move = Node(pn.Transition, of=Beginnings(page))
    end = Node(pn.Transition, of=Ends(page))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    threads = Made(E1.threads, of=node)

    needs_thread = read(threads, move)

    where = [end == move]


class E3Exclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that begins takes the lock of its exclusive group."""

    page = Node(sym.CallbackPage)
    beginning = Made(Beginning, of=page)
    lock = Made(Lock, of=Group(page))

    takes = arc(lock.lock, beginning.move)


class E4(StandardRule, phase=Phase.endings, middleware="ros2"):
    """A callback ends with the transitions that nothing of it comes after."""

    page = Node(sym.CallbackPage)
    end = Node(pn.Transition, of=Ends(page))
    begin = Node(pn.Transition, of=Beginnings(page))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    ending = Ending(end, threads, running)

    absent = [Absent(begin, where=[begin == end])]


class E4Reply(StandardRule, phase=Phase.endings, middleware="ros2"):
    """A server's callback ends with its response, be it to nobody."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))
    copy = Made(S4.page, of=[service, instance])
    page = Node(sym.CallbackPage, of=copy)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    answering = Made(Answering, of=[service, instance])
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    ending = Ending(answering.t_return, threads, running)


class E4Exclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that ends gives it back."""

    page = Node(sym.CallbackPage)
    ending = Made(Ending, of=page)
    lock = Made(Lock, of=Group(page))

    gives = arc(ending.move, lock.lock)


class E3OnceExclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """Where it is in an exclusive group, none of that group may run."""

    page = Node(sym.CallbackPage)
    move = Node(pn.Transition, of=Beginnings(page))
    end = Node(pn.Transition, of=Ends(page))
    lock = Made(Lock, of=Group(page))

    needs_lock = read(lock.lock, move)

    where = [end == move]


class E5(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A response is taken between callbacks, by a thread that is free."""

    client = Node(sym.ClientPort)
    node = Node(sym.NodeNet, of=ancestor(client.response, sym.NodeNet))
    t_res = Made(S1.t_res, of=client)
    threads = Made(E1.threads, of=node)

    needs_thread = read(threads, t_res)

    where = [~BeginsCallback(client), ~Awaited(client)]


class E5Exclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """Where the client is in an exclusive group, while no callback of that group runs."""

    client = Node(sym.ClientPort)
    t_res = Made(S1.t_res, of=client)
    lock = Made(Lock, of=Group(client))

    needs_lock = read(lock.lock, t_res)

    where = [~BeginsCallback(client)]


class E6(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A response that has a callback of its own begins it, on a thread, and in a group if it names one."""

    client = Node(sym.ClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.response))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    t_res = Made(S1.t_res, of=client)
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    beginning = Beginning(t_res, threads, running)

    where = [BeginsCallback(client)]


class E6Exclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """The client's exclusive group must be free, too, where that callback is in none, or in another one."""

    client = Node(sym.ClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.response))
    t_res = Made(S1.t_res, of=client)
    lock = Made(Lock, of=Group(client))

    needs_lock = read(lock.lock, t_res)

    where = [BeginsCallback(client), Group(page) != Group(client)]


class E7(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """How often a callback awaits a response."""

    page = Node(sym.CallbackPage, awaits=True)
    running = Made(E3.running, of=page)

    awaiting = place("{page.id}.awaiting", means=Meaning("{callback} awaits a response", part="awaiting"))


class E7Call(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that awaits gives its thread back when it asks, and takes one when it goes on."""

    client = Node(sym.ClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.request))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    t_req = Made(S1.t_req, of=client)
    t_res = Made(S1.t_res, of=client)
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)
    awaiting = Made(E7.awaiting, of=page)

    asks = [arc(running, t_req), arc(t_req, threads), arc(t_req, awaiting)]
    goes_on = [arc(awaiting, t_res), arc(threads, t_res), arc(t_res, running)]

    where = [Awaited(client)]


class E7GiveUp(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that awaits takes a thread when it gives up, too, and goes on."""

    client = Node(sym.ClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.request))
    given = Made(GiveUp, of=client)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)
    awaiting = Made(E7.awaiting, of=page)

    goes_on = [arc(awaiting, given.give_up), arc(threads, given.give_up), arc(given.give_up, running)]

    where = [Awaited(client)]
