"""Ticks of timers (rule D1): periodic, independent of their callbacks."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.transformations.language import Made, Meaning, Node, ancestor
from dineros.transformations.rules.lifecycle import L1
from dineros.transformations.rules.notation import arc, at_once, place, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.times import HasPeriod, Jitter, Offset, Period, Seconds
from dineros.transformations.rules.timers import C1


class D1(StandardRule, phase=Phase.beginnings, middleware="ros2", times=True):
    """A timer strikes at its period, first after its offset; a tick that finds it due is lost."""

    page = Node(sym.CallbackPage, kind="timer")
    tick = Made(C1.tick, of=page)
    due = Made(C1.due, of=page)

    start = place(
        "{page.id}.start", tokens=1, means=Meaning("the timer of {callback} has not struck yet", rests=True)
    )
    clock = place("{page.id}.clock", means=Meaning("the timer of {callback} runs", rests=True))
    struck = place("{page.id}.struck", means=Meaning("the timer of {callback} has struck"))
    first = transition(
        "{page.id}.first", means=Meaning("the timer of {callback} strikes first"), within=Offset(page)
    )
    strike = transition(
        "{page.id}.strike", means=Meaning("the timer of {callback} strikes"), within=Period(page)
    )
    miss = transition(
        "{page.id}.miss",
        means=Meaning("the timer of {callback} loses a tick: it is due already", part="miss"),
        at_once=True,
    )
    arcs = [
        arc(start, first),
        arc(first, clock),
        arc(clock, strike),
        arc(strike, clock),
        arc(struck, tick),
        arc(struck, miss),
        read(due, miss),
    ]
    prompt = at_once(tick)

    where = [HasPeriod(page)]


class D1Exact(StandardRule, phase=Phase.beginnings, middleware="ros2", times=True):
    """A timer without jitter ticks when it strikes."""

    page = Node(sym.CallbackPage, kind="timer")
    first = Made(D1.first, of=page)
    strike = Made(D1.strike, of=page)
    struck = Made(D1.struck, of=page)

    arcs = [arc(first, struck), arc(strike, struck)]

    where = [Seconds(page.jitter) == 0.0]


class D1Late(StandardRule, phase=Phase.beginnings, middleware="ros2", times=True):
    """A timer with jitter ticks later than it strikes; the next strike does not shift."""

    page = Node(sym.CallbackPage, kind="timer")
    first = Made(D1.first, of=page)
    strike = Made(D1.strike, of=page)
    struck = Made(D1.struck, of=page)

    late = place("{page.id}.late", means=Meaning("the timer of {callback} is late"))
    pass_on = transition(
        "{page.id}.passOn", means=Meaning("the timer of {callback} strikes, after its jitter"),
        within=Jitter(page),
    )  # fmt: skip
    arcs = [arc(first, late), arc(strike, late), arc(late, pass_on), arc(pass_on, struck)]

    where = [Seconds(page.jitter) > 0.0]


class D1Managed(StandardRule, phase=Phase.lifecycle, middleware="ros2", times=True):
    """The timer of a managed node runs while the node is configured; a tick that comes later is lost."""

    page = Node(sym.CallbackPage, kind="timer")
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    first = Made(D1.first, of=page)
    strike = Made(D1.strike, of=page)
    struck = Made(D1.struck, of=page)
    configured = Made(L1.configured, of=node)
    away = Made(L1.away, of=node)

    gone = transition(
        "{page.id}.gone",
        means=Meaning("the timer of {callback} strikes, but its node is not configured"),
        at_once=True,
    )
    runs = [read(configured, first), read(configured, strike)]
    arcs = [arc(struck, gone), read(away, gone)]
