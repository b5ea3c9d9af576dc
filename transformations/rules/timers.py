"""Timers of ROS 2 (rule C1): a timer that is due waits for its callback; missed ticks are lost."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.transformations.language import Made, Meaning, Node
from dineros.transformations.rules.notation import arc, place, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.starts import Start


class C1(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """A timer is due from its tick on until its callback begins."""

    page = Node(sym.CallbackPage, kind="timer")

    idle = place(
        "{page.id}.idle",
        tokens=1,
        means=Meaning("the timer of {callback} is not due", part="idle", rests=True),
    )
    due = place("{page.id}.due", means=Meaning("the timer of {callback} is due", part="due"))
    tick = transition("{page.id}.tick", means=Meaning("the timer of {callback} ticks", part="unrecorded"))
    arcs = [arc(idle, tick), arc(tick, due)]


class C1Begins(StandardRule, phase=Phase.beginnings, middleware="ros2"):
    """The callback of a timer begins by taking the timer's token."""

    page = Node(sym.CallbackPage, kind="timer")
    idle = Made(C1.idle, of=page)
    due = Made(C1.due, of=page)
    start = Made(Start, of=page)

    begins = [arc(due, start.begin), arc(start.begin, idle)]
