"""Shorthands of the Petri-net rules: places, transitions, arcs, and the overflow queue, written once."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.metamodel import pn, pnm
from dineros.transformations.creation import Fragment, New
from dineros.transformations.expressions import Expression, Text, as_expression
from dineros.transformations.patterns import Context

SHEET = Context(pnm.Sheet)
"""The page that gets what the rules make."""


def place(id: str, tokens: object = 0) -> New:
    """Make a place."""
    return New(pn.Place, page=SHEET, id=id, tokens=tokens)


def transition(id: str) -> New:
    """Make a transition."""
    return New(pn.Transition, page=SHEET, id=id)


def arc(source: Expression, target: Expression, weight: object = 1) -> New:
    """Make a normal arc."""
    return _arc(source, target, weight, "normal", "")


def read(source: Expression, target: Expression, weight: object = 1) -> New:
    """Make a read arc from a place to a transition."""
    return _arc(source, target, weight, "read", "-read")


def inhibit(source: Expression, target: Expression, weight: object = 1) -> New:
    """Make an inhibitor arc from a place to a transition."""
    return _arc(source, target, weight, "inhibitor", "-inhibitor")


def _arc(source: Expression, target: Expression, weight: object, kind: str, suffix: str) -> New:
    id = Text("{source.id}-{target.id}" + suffix, source=source, target=target)
    return New(
        pn.Arc, page=SHEET, id=id, source=source, target=target, weight=as_expression(weight), kind=kind
    )


class OverflowQueue(Fragment):
    """Bounded queue that drops what arrives while it is full (paper, Fig. 8).

    Parameters
    ----------
    id : str
        Prefix of the ids of its elements; may hold placeholders.
    source : Expression
        The place whose tokens enter.
    limit : Expression
        Its capacity.
    sinks : sequence of Expression
        Places that get a token for each token that leaves.
    """

    roles = {
        "load": pn.Place,
        "capacity": pn.Place,
        "enter": pn.Transition,
        "leave": pn.Transition,
        "drop": pn.Transition,
    }
    load: New
    capacity: New
    enter: New
    leave: New
    drop: New

    def __init__(
        self, id: str, *, source: Expression, limit: Expression, sinks: Sequence[Expression] = ()
    ) -> None:
        super().__init__()
        self.load = place(f"{id}.Load")
        self.capacity = place(f"{id}.Capacity", tokens=limit)
        self.enter = transition(f"{id}.in")
        self.leave = transition(f"{id}.out")
        self.drop = transition(f"{id}.drop")
        self.arcs = [
            arc(source, self.enter),
            arc(self.capacity, self.enter),
            arc(self.enter, self.load),
            arc(self.load, self.leave),
            arc(self.leave, self.capacity),
            *(arc(self.leave, sink) for sink in sinks),
            arc(source, self.drop),
        ]


class SignalChange(Fragment):
    """The two transitions that set and clear a signal (paper, Fig. 11 and 12).

    Parameters
    ----------
    to_true, to_false : str
        Ids of the transitions; may hold placeholders.
    true, false : Expression
        The places that tell the signal's value.
    """

    roles = {"to_true": pn.Transition, "to_false": pn.Transition}
    to_true: New
    to_false: New

    def __init__(self, to_true: str, to_false: str, *, true: Expression, false: Expression) -> None:
        super().__init__()
        self.to_true = transition(to_true)
        self.to_false = transition(to_false)
        self.arcs = [
            arc(false, self.to_true),
            arc(self.to_true, true),
            arc(true, self.to_false),
            arc(self.to_false, false),
        ]
