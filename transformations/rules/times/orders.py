"""The order in which an executor takes callbacks (rule E8): from a wait result, timers before messages.

A wait result is a set of tokens, one for each callback that was ready when the executor waited. There are two
sets: the executor processes one, and callbacks that become ready meanwhile are in the other. When the first
set is empty, the two are exchanged. So the callbacks that are ready at one moment form one set, for any
number of callbacks.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.transformations.language import Expression, Fragment, Index, Made, Meaning, New, Node
from dineros.transformations.language.functions import ancestor, less
from dineros.transformations.rules.executors import E1, Beginning, Ending
from dineros.transformations.rules.histories import R3
from dineros.transformations.rules.notation import arc, arcs_at, inhibit, place, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.callbacks import Callback
from dineros.transformations.rules.queries.times import KeepsOrder
from dineros.transformations.rules.timers import C1


class E8(StandardRule, phase=Phase.publications, middleware="ros2", times=True):
    """An executor with an order takes one callback at a time; the following rules change what they need."""

    node = Node(sym.NodeNet)

    chooser = place(
        "{node.id}.chooser", tokens=1, means=Meaning("the executor of {node} takes no callback", rests=True)
    )
    unsure = place("{node.id}.unsure", means=Meaning("a callback of {node} has ended"))

    where = [KeepsOrder(node)]


class E8Result(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """An executor with an order works on one of two wait results: sets of callbacks that are ready."""

    node = Node(sym.NodeNet)
    chooser = Made(E8.chooser, of=node)
    number = Index(upto=2)

    now = place(
        "{node.id}.result[{number}]",
        tokens=less(2, number),
        means=Meaning("the executor of {node} runs the callbacks that were ready"),
    )
    timers = place("{node.id}.timers[{number}]", means=Meaning("a timer of {node} is in a wait result"))
    messages = place("{node.id}.messages[{number}]", means=Meaning("a message of {node} is in a wait result"))


class Wait(Fragment):
    """The executor checks which callbacks are ready.

    Parameters
    ----------
    id : str
        Id of the transition.
    now, after : Expression
        Places with a token before and after the check.
    some : Expression
        Place with a token if some callback is ready.
    needs, without : list of Expression
        Places that must have a token, and places that must have none.
    """

    roles: Mapping[str, type[EObject]] = {"wait": pn.Transition}
    wait: New

    def __init__(
        self, id: str, *, now: Expression, after: Expression, some: Expression, needs: list[Expression],
        without: list[Expression],
    ) -> None:  # fmt: skip
        super().__init__()
        self.wait = transition(
            id, Meaning("the executor of {node} collects the callbacks that are ready"), at_once=True
        )
        self.arcs = [
            arc(now, self.wait),
            arc(self.wait, after),
            *(read(each, self.wait) for each in (some, *needs)),
            *(inhibit(each, self.wait) for each in without),
        ]


class E8Wait(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """When its thread is free and the wait result is empty, the executor swaps the two sets."""

    node = Node(sym.NodeNet)
    chooser = Made(E8.chooser, of=node)
    unsure = Made(E8.unsure, of=node)
    threads = Made(E1.threads, of=node)
    number = Index(upto=2)
    now = Made(E8Result.now, of=[node, number])
    timers = Made(E8Result.timers, of=[node, number])
    messages = Made(E8Result.messages, of=[node, number])
    after = Made(E8Result.now, of=[node, less(3, number)])
    next_timers = Made(E8Result.timers, of=[node, less(3, number)])
    next_messages = Made(E8Result.messages, of=[node, less(3, number)])

    for_timers = Wait(
        "{node.id}.wait[{number}].timers",
        now=now, after=after, some=next_timers,
        needs=[chooser, threads], without=[timers, messages, unsure],
    )  # fmt: skip
    for_messages = Wait(
        "{node.id}.wait[{number}].messages",
        now=now, after=after, some=next_messages,
        needs=[chooser, threads], without=[timers, messages, unsure],
    )  # fmt: skip


class Turn(Fragment):
    """The state of a callback that an executor takes in order.

    `id`: prefix of the ids of its elements.
    """

    roles: Mapping[str, type[EObject]] = {"out": pn.Place, "taken": pn.Place, "ended": pn.Place}
    out: New
    taken: New
    ended: New

    def __init__(self, id: str) -> None:
        super().__init__()
        self.out = place(f"{id}.out", tokens=1, means=Meaning("{callback} is in no wait result", rests=True))
        self.taken = place(f"{id}.taken", means=Meaning("the executor takes {callback}"))
        self.ended = place(f"{id}.ended", means=Meaning("{callback} has just ended"))


class E8Turn(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Each callback of an executor with an order is in a wait result or not."""

    page = Node(sym.CallbackPage)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    chooser = Made(E8.chooser, of=node)

    turn = Turn("{page.id}.turn")


class E8Begin(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A callback begins when the executor takes it from the wait result."""

    page = Node(sym.CallbackPage)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    chooser = Made(E8.chooser, of=node)
    turn = Made(Turn, of=page)
    beginning = Made(Beginning, of=page)

    arcs = [arc(turn.taken, beginning.move), arc(beginning.move, chooser)]


class E8End(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A callback that has ended may be ready again."""

    page = Node(sym.CallbackPage)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    unsure = Made(E8.unsure, of=node)
    turn = Made(Turn, of=page)
    ending = Made(Ending, of=page)

    arcs = [arc(ending.move, turn.ended), arc(ending.move, unsure)]


class Listing(Fragment):
    """A ready callback becomes part of a wait result.

    Parameters
    ----------
    id : str
        Prefix of the ids of its elements.
    turn : Made
        The state of the callback.
    ready : Expression
        Place with a token while it is ready.
    now, other : Expression
        Places with a token while the executor processes this wait result, or the other one.
    listed : Expression
        Place that counts the callbacks of its kind in this wait result.
    node : Made
        Elements of `E8` for its executor.
    """

    roles: Mapping[str, type[EObject]] = {
        "waits": pn.Place,
        "enter": pn.Transition,
        "again": pn.Transition,
        "take": pn.Transition,
    }
    waits: New
    enter: New
    again: New
    take: New

    def __init__(
        self, id: str, *, turn: Made, ready: Expression, now: Expression, other: Expression,
        listed: Expression, chooser: Expression, unsure: Expression, threads: Expression,
    ) -> None:  # fmt: skip
        super().__init__()
        self.waits = place(id, means=Meaning("{callback} is in a wait result"))
        self.enter = transition(f"{id}.enter", Meaning("{callback} is ready"), at_once=True)
        self.again = transition(f"{id}.again", Meaning("{callback} is still ready"), at_once=True)
        self.take = transition(f"{id}.take", Meaning("the executor takes {callback}"), at_once=True)
        self.arcs = [
            arc(turn.out, self.enter),
            arc(turn.ended, self.again),
            arc(unsure, self.again),
            *(
                each
                for move in (self.enter, self.again)
                for each in (read(ready, move), read(other, move), arc(move, self.waits), arc(move, listed))
            ),
            read(now, self.take),
            read(threads, self.take),
            *arcs_at(self.take, [self.waits, listed, chooser], [turn.taken]),
        ]


class E8Timer(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A timer that is due is in the next wait result."""

    page = Node(sym.CallbackPage, kind="timer")
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    chooser = Made(E8.chooser, of=node)
    unsure = Made(E8.unsure, of=node)
    threads = Made(E1.threads, of=node)
    due = Made(C1.due, of=page)
    turn = Made(Turn, of=page)
    number = Index(upto=2)
    now = Made(E8Result.now, of=[node, number])
    other = Made(E8Result.now, of=[node, less(3, number)])
    timers = Made(E8Result.timers, of=[node, number])

    listing = Listing(
        "{page.id}.ready[{number}]",
        turn=turn, ready=due, now=now, other=other, listed=timers, chooser=chooser, unsure=unsure,
        threads=threads,
    )  # fmt: skip


class E8TimerRests(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A timer that is not due is in no wait result."""

    page = Node(sym.CallbackPage, kind="timer")
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    unsure = Made(E8.unsure, of=node)
    idle = Made(C1.idle, of=page)
    turn = Made(Turn, of=page)

    rest = transition("{page.id}.turn.rest", Meaning("{callback} is not ready"), at_once=True)
    arcs = [read(idle, rest), arc(turn.ended, rest), arc(unsure, rest), arc(rest, turn.out)]


class E8Message(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A subscription with a message is in the next wait result, after all timers."""

    reader = Node(sym.SubscriberPort)
    sink = Node(pn.Place, of=reader.place)
    page = Node(sym.CallbackPage, of=Callback(reader.place))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    chooser = Made(E8.chooser, of=node)
    unsure = Made(E8.unsure, of=node)
    threads = Made(E1.threads, of=node)
    queue = Made(R3.queue, of=reader)
    turn = Made(Turn, of=page)
    number = Index(upto=2)
    now = Made(E8Result.now, of=[node, number])
    other = Made(E8Result.now, of=[node, less(3, number)])
    timers = Made(E8Result.timers, of=[node, number])
    messages = Made(E8Result.messages, of=[node, number])

    listing = Listing(
        "{page.id}.ready[{number}]",
        turn=turn, ready=queue.load, now=now, other=other, listed=messages, chooser=chooser, unsure=unsure,
        threads=threads,
    )  # fmt: skip
    after = inhibit(timers, listing.take)
    free = [inhibit(sink, listing.enter), inhibit(sink, listing.again)]


class E8MessageRests(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A subscription without a message is in no wait result, nor is one whose node holds a message."""

    reader = Node(sym.SubscriberPort)
    sink = Node(pn.Place, of=reader.place)
    page = Node(sym.CallbackPage, of=Callback(reader.place))
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    unsure = Made(E8.unsure, of=node)
    queue = Made(R3.queue, of=reader)
    turn = Made(Turn, of=page)

    rest = transition("{page.id}.turn.rest", Meaning("{callback} is not ready"), at_once=True)
    full = transition("{page.id}.turn.full", Meaning("{callback} is not ready"), at_once=True)
    arcs = [
        read(queue.capacity, rest, reader.limit),
        *arcs_at(rest, [turn.ended, unsure], [turn.out]),
        read(sink, full),
        *arcs_at(full, [turn.ended, unsure], [turn.out]),
    ]
