"""The start of timer callbacks: with their first transition, or, if time is modelled, just before it."""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.transformations.language import Expression, Fragment, Made, Meaning, New, Node
from dineros.transformations.rules.notation import SHEET, arc, place, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.callbacks import Beginnings
from dineros.transformations.rules.queries.times import RunsCallbacks


class Start(Fragment):
    """A timer callback starts.

    `begin`: the transition that takes its tick.
    """

    roles: Mapping[str, type[EObject]] = {"begin": pn.Transition}

    def __init__(self, begin: Expression) -> None:
        super().__init__(begin=begin)


class C1Start(StandardRule, phase=Phase.beginnings, middleware="ros2", times=False):
    """The callback of a timer starts with its first transition."""

    page = Node(sym.CallbackPage, kind="timer")
    move = Node(pn.Transition, of=Beginnings(page))

    start = Start(move)


class C1StartEngine(StandardRule, phase=Phase.beginnings, middleware="ros2", times=True):
    """With times, the callback of a timer starts with its first transition in a node with an engine, too."""

    page = Node(sym.CallbackPage, kind="timer")
    move = Node(pn.Transition, of=Beginnings(page))

    start = Start(move)

    where = [~RunsCallbacks(page)]


class D2Start(StandardRule, phase=Phase.beginnings, middleware="ros2", times=True):
    """With times, an executor starts a callback at once; the first transition may fire later."""

    page = Node(sym.CallbackPage, kind="timer")
    move = Node(pn.Transition, of=Beginnings(page))

    begun = place("{move.id}.begun", means=Meaning("{callback} has begun"))
    begin = transition("{move.id}.begin", means=Meaning("{callback} begins"), at_once=True)
    arcs = [arc(begin, begun), arc(begun, move)]
    start = Start(begin)

    where = [RunsCallbacks(page)]


class D2Needs(StandardRule, phase=Phase.beginnings, middleware="ros2", times=True):
    """A callback starts only if its first transition is enabled, and reserves the tokens for it."""

    page = Node(sym.CallbackPage, kind="timer")
    move = Node(pn.Transition, of=Beginnings(page))
    begun = Made(D2Start.begun, of=[page, move])
    begin = Made(D2Start.begin, of=[page, move])
    past = Node(pn.Arc, target=move)
    needed = Node(pn.Node, of=past.source)

    taken = New(
        pn.Arc, page=SHEET, id="{past.id}.begin", source=needed, target=begin, weight=past.weight,
        kind=past.kind,
    )  # fmt: skip

    where = [needed != begun]
    deletes = [past]
