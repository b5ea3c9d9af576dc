"""Executors and goals (families A and E together), as observed with `rclpy`.

A server takes goals and cancel requests in callbacks of its group. The callback that executes a goal is in no
group: it has a thread from the acceptance of the goal until the end of the goal, or, if it awaits, one for
each of its steps.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language import Made, Node
from dineros.transformations.rules.actions.ends import End
from dineros.transformations.rules.actions.goals import A1, A2, Heard, Taken
from dineros.transformations.rules.actions.slots import SlotCallback
from dineros.transformations.rules.executors import AwaitingExecution, Beginning, Execution, FreeThreads, Lock
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
    """The execution of a goal takes a thread when the goal is accepted."""

    served = SlotCallback()
    accept = Made(A2.accept, of=[served.action, served.slot])
    on = Execution(served.callback)

    begins = [arc(on.threads, accept), arc(accept, on.running)]


class E3AcceptAwaiting(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A goal that is worked on by a callback that awaits is accepted only if a thread is free."""

    served = SlotCallback()
    accept = Made(A2.accept, of=[served.action, served.slot])
    on = FreeThreads(served.callback)

    needs_thread = read(on.threads, accept)

    where = [~HoldsThread(served.callback)]


class E3AcceptExclusive(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A goal is accepted while no callback of the server's exclusive group runs."""

    served = SlotCallback()
    accept = Made(A2.accept, of=[served.action, served.slot])
    lock = Made(Lock, of=Group(served.callback))

    needs_lock = read(lock.lock, accept)


class E3Step(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """Each step of a callback that works on a goal and awaits needs a thread."""

    page = Node(sym.CallbackPage)
    move = Node(pn.Transition, of=Steps(page))
    on = FreeThreads(page)

    needs_thread = read(on.threads, move)


class E4End(StandardRule, phase=Phase.endings, middleware="ros2"):
    """The execution of a goal ends with the goal."""

    served = SlotCallback()
    end = Made(End, of=[served.action, served.slot])
    on = Execution(served.callback)

    ends = [arc(on.running, end.move), arc(end.move, on.threads)]


class E5Serve(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A free thread refuses goals and takes requests to cancel."""

    served = SlotCallback(upto=1)
    taken = Made(Taken, of=served.action)
    on = FreeThreads(served.callback)

    needs_thread = read(on.threads, taken.move)


class E5ServeExclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """Goals are refused, and requests to cancel taken, while the server's exclusive group is free."""

    served = SlotCallback(upto=1)
    taken = Made(Taken, of=served.action)
    lock = Made(Lock, of=Group(served.callback))

    needs_lock = read(lock.lock, taken.move)


class E5Answer(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A free thread takes results, refusals and feedback between callbacks."""

    client = Node(sym.ActionClientPort)
    heard = Made(Heard, of=client)
    on = FreeThreads(client.goal)

    needs_thread = read(on.threads, heard.move)

    where = [~BeginsAnswer(client, heard.move), ~GoesOn(client, heard.move)]


class E5AnswerExclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """Results, refusals and feedback are taken while the client's exclusive group is free."""

    client = Node(sym.ActionClientPort)
    heard = Made(Heard, of=client)
    lock = Made(Lock, of=Group(client))

    needs_lock = read(lock.lock, heard.move)

    where = [~BeginsAnswer(client, heard.move)]


class E6Answer(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A result, refusal or feedback begins its own callback, if it has one."""

    client = Node(sym.ActionClientPort)
    heard = Made(Heard, of=client)
    page = Node(sym.CallbackPage, of=Callback(Told(client, heard.move)))
    on = Execution(page)

    beginning = Beginning(heard.move, on.threads, on.running)

    where = [BeginsAnswer(client, heard.move)]


class E6AnswerExclusive(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A message of an action that begins a callback outside of the client's group needs that group, too."""

    client = Node(sym.ActionClientPort)
    heard = Made(Heard, of=client)
    page = Node(sym.CallbackPage, of=Callback(Told(client, heard.move)))
    lock = Made(Lock, of=Group(client))

    needs_lock = read(lock.lock, heard.move)

    where = [BeginsAnswer(client, heard.move), Group(page) != Group(client)]


class E7Send(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that awaits its goal gives its thread back when it sends the goal."""

    client = Node(sym.ActionClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.goal))
    send = Made(A1.send, of=client)
    on = AwaitingExecution(page)

    sends = [arc(on.running, send), arc(send, on.threads), arc(send, on.awaiting)]

    where = [GoalAwaited(client)]


class E7Answer(StandardRule, phase=Phase.exclusion, middleware="ros2"):
    """A callback that has awaited its goal takes a thread when it continues with the answer."""

    client = Node(sym.ActionClientPort)
    heard = Made(Heard, of=client)
    page = Node(sym.CallbackPage, of=Callback(client.goal))
    on = AwaitingExecution(page)

    goes_on = [arc(on.awaiting, heard.move), arc(on.threads, heard.move), arc(heard.move, on.running)]

    where = [GoesOn(client, heard.move)]
