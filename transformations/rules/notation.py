"""Shorthands for rules: channels with ports, places, transitions, arcs, and the overflow queue."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.records import Drop, Signal, Transfer
from dineros.metamodel.records.schema import Step
from dineros.transformations.language import Expression, Fragment, Made, Meaning, New, Node, Path, Text, less
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.language.expressions import as_expression
from dineros.transformations.language.meaning import QueueKind
from dineros.transformations.language.patterns import Context

LANGUAGE.add(__name__)

SHEET = Context(pnm.Sheet)
"""The page to which the rules add elements."""


def topic_with_ports() -> tuple[Node, Node, Node]:
    """Return a topic, one of its publishers and one of its subscribers."""
    channel = Node(sym.TopicChannel)
    return channel, Node(sym.PublisherPort, channel=channel), Node(sym.SubscriberPort, channel=channel)


def service_with_client() -> tuple[Node, Node]:
    """Return a service and one of its clients."""
    service = Node(sym.ServiceChannel)
    return service, Node(sym.ClientPort, channel=service)


def action_with_client() -> tuple[Node, Node]:
    """Return an action and one of its clients."""
    action = Node(sym.ActionChannel)
    return action, Node(sym.ActionClientPort, channel=action)


def place(id: str, tokens: object = 0, means: Meaning | None = None, *, carries: bool = False) -> New:
    """Make a place.

    Parameters
    ----------
    id : str
        Its id; may have placeholders.
    tokens : expression or int
        Initial number of tokens.
    means : Meaning, optional
        Meaning of its tokens.
    carries : bool
        Whether its tokens carry data that passes through a channel.
    """
    made = New(pn.Place, page=SHEET, id=id, tokens=tokens)
    made.meaning, made.carries = means, carries
    return made


def transition(
    id: str,
    means: Meaning | None = None,
    *,
    at_once: bool = False,
    within: Expression | None = None,
    repeats: bool = False,
) -> New:
    """Make a transition.

    Parameters
    ----------
    id : str
        Its id; may have placeholders.
    means : Meaning, optional
        Meaning of its firing.
    at_once : bool
        If time is modelled, it fires without delay: middleware and executors do not idle.
    within : Expression, optional
        Its firing interval. Without it, it fires at any time.
    repeats : bool
        Whether it repeats the transition of the model that the rule matches, at another time.
    """
    if within is None:
        made = New(pn.Transition, page=SHEET, id=id)
    else:
        made = New(pn.Transition, page=SHEET, id=id, interval=within)
    made.meaning = means
    made.is_prompt, made.repeats = at_once, repeats
    return made


def at_once(transition: Expression) -> New:
    """Let a transition made earlier fire without delay."""
    return New(pn.TimeInterval, into=Path(transition, "interval"), latest=0.0)


def arc(source: Expression, target: Expression, weight: object = 1) -> New:
    """Make a normal arc."""
    return _arc(source, target, weight, "normal", "")


def read(source: Expression, target: Expression, weight: object = 1) -> New:
    """Make a read arc from a place to a transition."""
    return _arc(source, target, weight, "read", "-read")


def inhibit(source: Expression, target: Expression, weight: object = 1) -> New:
    """Make an inhibitor arc from a place to a transition."""
    return _arc(source, target, weight, "inhibitor", "-inhibitor")


def arcs_at(
    move: Expression,
    takes: Sequence[Expression],
    gives: Sequence[Expression] = (),
    *,
    reads: Sequence[Expression] = (),
    without: Sequence[Expression] = (),
) -> list[New]:
    """Make the arcs of a transition: it takes and gives tokens, and tests that places have some or none."""
    return [
        *(arc(each, move) for each in takes),
        *(arc(move, each) for each in gives),
        *(read(each, move) for each in reads),
        *(inhibit(each, move) for each in without),
    ]


def _arc(source: Expression, target: Expression, weight: object, kind: str, suffix: str) -> New:
    id = Text("{source.id}-{target.id}" + suffix, source=source, target=target)
    return New(
        pn.Arc, page=SHEET, id=id, source=source, target=target, weight=as_expression(weight), kind=kind
    )


class History(Fragment):
    """The places of a bounded queue, and the transition by which messages leave it.

    Parameters
    ----------
    id : str
        Prefix of the ids of its elements; may have placeholders.
    limit : Expression
        Its capacity.
    sinks : sequence of Expression
        Places that get a token for each token that leaves.
    kind : {"publisher", "dispatcher", "subscriber"}, optional
        Kind of the queue; without it, its parts have no meaning.
    """

    roles: Mapping[str, type[EObject]] = {
        "load": pn.Place,
        "capacity": pn.Place,
        "leave": pn.Transition,
    }
    load: Expression
    capacity: Expression
    leave: Expression

    def __init__(
        self, id: str, *, limit: Expression, sinks: Sequence[Expression] = (), kind: QueueKind | None = None
    ) -> None:
        super().__init__()
        self.load = place(f"{id}.Load", means=_part(kind, "load"), carries=True)
        self.capacity = place(f"{id}.Capacity", tokens=limit, means=_part(kind, "capacity"))
        self.leave = transition(f"{id}.out", means=_part(kind, "leave"))
        self.arcs = [
            arc(self.load, self.leave),
            arc(self.leave, self.capacity),
            *(arc(self.leave, sink) for sink in sinks),
        ]


_QUEUE_WORDS = {
    "load": "{queue}: load",
    "capacity": "{queue}: free capacity",
    "enter": "{queue} takes a message{writer}",
    "leave": "{queue} passes a message on",
    "drop": "{queue} loses a message{writer}",
}


def _part(
    kind: QueueKind | None, part: str, called: str = Meaning.called, step: type[Step] = Transfer
) -> Meaning | None:
    """Return the meaning of a part of a queue; its transitions are steps of a trace."""
    if kind is None:
        return None
    is_place = part in ("load", "capacity")
    return Meaning(
        _QUEUE_WORDS[part],
        step=None if is_place else step,
        queue=kind,
        called=called,
        part=part,
        rests=part == "capacity",
    )


class OverflowQueue(Fragment):
    """Bounded queue that drops messages that arrive while it is full (paper, Fig. 8).

    Parameters
    ----------
    id : str
        Prefix of the ids of its elements; may have placeholders.
    source : Expression
        The place whose tokens enter.
    limit : Expression, optional
        Its capacity.
    sinks : sequence of Expression
        Places that get a token for each token that leaves.
    history : Made, optional
        A `History` made earlier, which several sources share; it has the limit and the sinks.
    kind : {"publisher", "dispatcher", "subscriber"}, optional
        Kind of the queue; without it, its parts have no meaning.
    called : str, optional
        Name of the queue, if it differs from the usual name for its kind.
    enters, leaves : type of Step
        Steps of a trace in which a message enters or leaves.
    """

    roles: Mapping[str, type[EObject]] = {
        "load": pn.Place,
        "capacity": pn.Place,
        "enter": pn.Transition,
        "leave": pn.Transition,
        "drop": pn.Transition,
    }
    load: Expression
    capacity: Expression
    enter: New
    leave: Expression
    drop: New

    def __init__(
        self,
        id: str,
        *,
        source: Expression,
        limit: Expression | None = None,
        sinks: Sequence[Expression] = (),
        history: Made | None = None,
        kind: QueueKind | None = None,
        called: str = Meaning.called,
        enters: type[Step] = Transfer,
        leaves: type[Step] = Transfer,
    ) -> None:
        super().__init__()
        if history is None:
            assert limit is not None
            self.load = place(f"{id}.Load", means=_part(kind, "load", called), carries=True)
            self.capacity = place(f"{id}.Capacity", tokens=limit, means=_part(kind, "capacity", called))
        else:
            self.load, self.capacity, self.leave = history.load, history.capacity, history.leave
        self.enter = transition(f"{id}.in", means=_part(kind, "enter", called, enters), at_once=True)
        if history is None:
            self.leave = transition(f"{id}.out", means=_part(kind, "leave", called, leaves))
        self.drop = transition(f"{id}.drop", means=_part(kind, "drop", called, Drop), at_once=True)
        self.arcs = [arc(source, self.enter), arc(self.capacity, self.enter), arc(self.enter, self.load)]
        if history is None:
            self.arcs += [
                arc(self.load, self.leave),
                arc(self.leave, self.capacity),
                *(arc(self.leave, sink) for sink in sinks),
            ]
        self.arcs.append(arc(source, self.drop))


class Bound(Fragment):
    """A place with a capacity: adds the place of its free room, to which B4 connects arcs.

    Parameters
    ----------
    bounded : Expression
        The place.
    capacity : Expression or int
        Maximum number of tokens.
    means : Meaning
        Meaning of its free room.
    """

    roles: Mapping[str, type[EObject]] = {"place": pn.Place, "free": pn.Place}
    free: New

    def __init__(self, bounded: Expression, capacity: object, means: Meaning) -> None:
        super().__init__(place=bounded)
        id = Text("{bounded.id}.free", bounded=bounded)
        self.free = New(pn.Place, page=SHEET, id=id, tokens=less(capacity, Path(bounded, "tokens")))
        self.free.meaning = means


class DeclaredBound(Bound):
    """The bound of a place of the model: its `capacity`, or a bound that a rule sets."""


def _change(value: bool) -> Meaning:
    return Meaning(f"signal {{signal}} becomes {str(value).lower()}", step=Signal, value=value)


class SignalChange(Fragment):
    """The two transitions that set and clear a signal (paper, Fig. 11 and 12).

    Parameters
    ----------
    to_true, to_false : str
        Ids of the transitions; may have placeholders.
    true, false : Expression
        The places for the signal's values.
    """

    roles = {"to_true": pn.Transition, "to_false": pn.Transition}
    to_true: New
    to_false: New

    def __init__(self, to_true: str, to_false: str, *, true: Expression, false: Expression) -> None:
        super().__init__()
        self.to_true = transition(to_true, _change(True))
        self.to_false = transition(to_false, _change(False))
        self.arcs = [
            arc(false, self.to_true),
            arc(self.to_true, true),
            arc(true, self.to_false),
            arc(self.to_false, false),
        ]


class ValueChange(Fragment):
    """A transition that gives a signal another value.

    Parameters
    ----------
    change : str
        Its id; may hold placeholders.
    before, after : Expression
        The places of the two values.
    """

    roles = {"change": pn.Transition, "before": pn.Place, "after": pn.Place}
    change: New

    def __init__(self, change: str, *, before: Expression, after: Expression) -> None:
        super().__init__(before=before, after=after)
        meaning = Meaning("signal {signal} becomes {value}", step=Signal, value=True)
        self.change = transition(change, meaning)
        self.arcs = [arc(before, self.change), arc(self.change, after)]
