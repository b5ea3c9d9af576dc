"""What managed nodes lose, and their timers (rule D12): without delay."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language import Made, Meaning, Node, ancestor
from dineros.transformations.rules.coming_and_going import L4, L4Clear, L4Kept, L4Left, L4LeftKept
from dineros.transformations.rules.histories import Publication
from dineros.transformations.rules.lifecycle import L1, L2, Configuring, L2Away, Leaves, StateChange
from dineros.transformations.rules.notation import arc, arcs_at, at_once, inhibit, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.services import Home
from dineros.transformations.rules.timers import C1
from dineros.transformations.rules.times.strikes import D1, D1Late


class D12Discard(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A message that is published while its node is inactive is lost at once."""

    discard = Made(L2.discard)

    prompt = at_once(discard)


class D12Abandon(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A message that is published while its node is not configured is lost at once."""

    abandon = Made(L2Away.abandon)

    prompt = at_once(abandon)


class D12Said(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A node changes its state after the messages that it has published are on their way or lost."""

    channel = Node(sym.TopicChannel)
    writer = Node(sym.PublisherPort, channel=channel)
    publication = Made(Publication, of=writer)
    source = Node(pn.Place, of=publication.source)
    node = Node(sym.NodeNet, of=Home(writer.place))
    change = Made(StateChange, of=node)

    waits = inhibit(source, change.move)


class D12Miss(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A message for a reader that is not configured is lost at once."""

    miss = Made(L4.miss)

    prompt = at_once(miss)


class D12MissKept(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A message that is kept for late readers is lost at once if its reader is shut down."""

    miss = Made(L4Kept.miss)

    prompt = at_once(miss)


class D12Left(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Messages on their way to a reader are lost as soon as it leaves."""

    left = Made(L4Left.left)

    prompt = at_once(left)


class D12LeftKept(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Messages that are kept for a late reader are lost as soon as it is shut down."""

    left = Made(L4LeftKept.left)

    prompt = at_once(left)


class D12Clear(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Messages in the history of a reader are lost as soon as it leaves."""

    gone = Made(L4Clear.gone)
    clear = Made(L4Clear.clear)

    at_gone = at_once(gone)
    at_clear = at_once(clear)


class D12(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The timers of a node stop when the node leaves, and restart when it is configured again."""

    page = Node(sym.CallbackPage, kind="timer")
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle)
    away = Made(L1.away, of=node)
    start = Made(D1.start, of=page)
    clock = Made(D1.clock, of=page)
    idle = Made(C1.idle, of=page)
    due = Made(C1.due, of=page)

    stop = transition(
        "{page.id}.stop", means=Meaning("the timer of {callback} stops with its node"), at_once=True
    )
    forget = transition(
        "{page.id}.forget",
        means=Meaning("the timer of {callback} is not due any more: its node is not configured"),
        at_once=True,
    )
    arcs = [
        *arcs_at(stop, [clock], [start], reads=[away]),
        *arcs_at(forget, [due], [idle], reads=[away]),
    ]

    where = [Leaves(life)]


class D12Late(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A late strike of a timer is lost when its node leaves."""

    page = Node(sym.CallbackPage, kind="timer")
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle)
    away = Made(L1.away, of=node)
    late = Made(D1Late.late, of=page)

    never = transition(
        "{page.id}.never",
        means=Meaning("the timer of {callback} does not strike any more: its node is not configured"),
        at_once=True,
    )
    arcs = [arc(late, never), read(away, never)]

    where = [Leaves(life)]


class D12Again(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A node is configured when its timers have stopped."""

    page = Node(sym.CallbackPage, kind="timer")
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle, cleansUp=True)
    change = Made(Configuring, of=node)
    start = Made(D1.start, of=page)
    struck = Made(D1.struck, of=page)
    idle = Made(C1.idle, of=page)

    stopped = [read(start, change.move), inhibit(struck, change.move), read(idle, change.move)]


class D12AgainLate(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A node is configured when no strike of its timers is late."""

    page = Node(sym.CallbackPage, kind="timer")
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle, cleansUp=True)
    change = Made(Configuring, of=node)
    late = Made(D1Late.late, of=page)

    on_time = inhibit(late, change.move)
