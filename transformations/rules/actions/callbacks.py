"""What executors do about goals (families A and E together), as `rclpy` was seen to do it.

A server takes goals and requests to cancel in callbacks of its group. What works on a goal is in no group: it
has a thread from when the goal is accepted until it is over, or, where it awaits, one for each of its steps.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language.functions import ancestor
from dineros.transformations.language.patterns import Index, Made, Node
from dineros.transformations.rules.actions.ends import End
from dineros.transformations.rules.actions.goals import A1, A2, Heard, Taken
from dineros.transformations.rules.actions.slots import A6, slots
from dineros.transformations.rules.executors import E1, E3, E7, Beginning, Lock
from dineros.transformations.rules.notation import arc, read
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.callbacks import (
    BeginsAnswer,
    Callback,
    GoalAwaited,
    GoesOn,
    Group,
    HoldsThread,
    Steps,
    Told,
)


class E3Accept(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """What works on a goal has a thread once it is accepted."""

    action = Node(sym.ActionChannel)
    slot = Index(upto=slots(action))
    copy = Made(A6.page, of=[action, slot])
    page = Node(sym.CallbackPage, of=copy)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    accept = Made(A2.accept, of=[action, slot])
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    begins = [arc(threads, accept), arc(accept, running)]


class E3AcceptAwaiting(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """Where it awaits, a thread is needed to accept the goal."""

    action = Node(sym.ActionChannel)
    slot = Index(upto=slots(action))
    copy = Made(A6.page, of=[action, slot])
    page = Node(sym.CallbackPage, of=copy)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    accept = Made(A2.accept, of=[action, slot])
    threads = Made(E1.threads, of=node)

    needs_thread = read(threads, accept)

    where = [~HoldsThread(page)]


class E3AcceptExclusive(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A goal is accepted while no callback of the server's exclusive group runs."""

    action = Node(sym.ActionChannel)
    slot = Index(upto=slots(action))
    copy = Made(A6.page, of=[action, slot])
    page = Node(sym.CallbackPage, of=copy)
    accept = Made(A2.accept, of=[action, slot])
    lock = Made(Lock, of=Group(page))

    needs_lock = read(lock.lock, accept)


class E3Step(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """Each step of what works on a goal and awaits needs a thread."""

    page = Node(sym.CallbackPage)
    move = Node(pn.Transition, of=Steps(page))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    threads = Made(E1.threads, of=node)

    needs_thread = read(threads, move)


class E4End(StandardRule, phase=Phase.endings, middleware="ros2"):
    """What works on a goal ends with it."""

    action = Node(sym.ActionChannel)
    slot = Index(upto=slots(action))
    copy = Made(A6.page, of=[action, slot])
    page = Node(sym.CallbackPage, of=copy)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    end = Made(End, of=[action, slot])
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    ends = [arc(running, end.move), arc(end.move, threads)]


class E5Serve(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """Goals are refused, and requests to cancel taken, by a thread that is free."""

    action = Node(sym.ActionChannel)
    any_slot = Index(upto=1)
    copy = Made(A6.page, of=[action, any_slot])
    page = Node(sym.CallbackPage, of=copy)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    taken = Made(Taken, of=action)
    threads = Made(E1.threads, of=node)

    needs_thread = read(threads, taken.move)


class E5ServeExclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """And while no callback of the server's exclusive group runs."""

    action = Node(sym.ActionChannel)
    any_slot = Index(upto=1)
    copy = Made(A6.page, of=[action, any_slot])
    page = Node(sym.CallbackPage, of=copy)
    taken = Made(Taken, of=action)
    lock = Made(Lock, of=Group(page))

    needs_lock = read(lock.lock, taken.move)


class E5Answer(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """Results, refusals and feedback are taken between callbacks, by a thread that is free."""

    client = Node(sym.ActionClientPort)
    node = Node(sym.NodeNet, of=ancestor(client.goal, sym.NodeNet))
    heard = Made(Heard, of=client)
    threads = Made(E1.threads, of=node)

    needs_thread = read(threads, heard.move)

    where = [~BeginsAnswer(client, heard.move), ~GoesOn(client, heard.move)]


class E5AnswerExclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """Where the client is in an exclusive group, while no callback of that group runs."""

    client = Node(sym.ActionClientPort)
    heard = Made(Heard, of=client)
    lock = Made(Lock, of=Group(client))

    needs_lock = read(lock.lock, heard.move)

    where = [~BeginsAnswer(client, heard.move)]


class E6Answer(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """What has a callback of its own begins it."""

    client = Node(sym.ActionClientPort)
    heard = Made(Heard, of=client)
    page = Node(sym.CallbackPage, of=Callback(Told(client, heard.move)))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    beginning = Beginning(heard.move, threads, running)

    where = [BeginsAnswer(client, heard.move)]


class E6AnswerExclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """The client's exclusive group must be free, too, where that callback is in another one."""

    client = Node(sym.ActionClientPort)
    heard = Made(Heard, of=client)
    page = Node(sym.CallbackPage, of=Callback(Told(client, heard.move)))
    lock = Made(Lock, of=Group(client))

    needs_lock = read(lock.lock, heard.move)

    where = [BeginsAnswer(client, heard.move), Group(page) != Group(client)]


class E7Send(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that awaits its goal gives its thread back when it sends it."""

    client = Node(sym.ActionClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.goal))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    send = Made(A1.send, of=client)
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)
    awaiting = Made(E7.awaiting, of=page)

    sends = [arc(running, send), arc(send, threads), arc(send, awaiting)]

    where = [GoalAwaited(client)]


class E7Answer(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """It takes one when it goes on with the answer."""

    client = Node(sym.ActionClientPort)
    heard = Made(Heard, of=client)
    page = Node(sym.CallbackPage, of=Callback(client.goal))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)
    awaiting = Made(E7.awaiting, of=page)

    goes_on = [arc(awaiting, heard.move), arc(threads, heard.move), arc(heard.move, running)]

    where = [GoesOn(client, heard.move)]
