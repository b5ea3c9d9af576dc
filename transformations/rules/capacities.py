"""Capacities of places: those in the model, and those of ports (rules B1 to B4).

They run after all other rules, when all arcs exist. The place of free room is the complement of the bounded
place (Reisig, Petri Nets, 1985, Sect. 6.3).
"""

from __future__ import annotations

from dineros.metamodel import calls, pn, sym
from dineros.transformations.language import ForAll, Made, Meaning, Node, count, either, greatest, less
from dineros.transformations.rules.histories import Publication
from dineros.transformations.rules.notation import Bound, DeclaredBound, arc, read
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.callbacks import Beginnings
from dineros.transformations.rules.queries.times import RunsOn
from dineros.transformations.rules.queries.tokens import Change, Lowering, MostNeeded, MostPut, Raising
from dineros.transformations.rules.starts import D2Start

ANY_NUMBER = -1
"""Value of `inHand` with which a node takes any number of messages."""


class B1(StandardRule, phase=Phase.bounds):
    """Capacity that the model gives to a place."""

    bounded = Node(pn.Place)

    bound = DeclaredBound(bounded, bounded.capacity, means=Meaning("free room at {place}", rests=True))

    where = [bounded.capacity > 0]


class B2(StandardRule, phase=Phase.bounds, middleware="ros2"):
    """Messages that wait to be published: at most those of one firing, since `publish` sends them at once."""

    port = Node(sym.PublisherPort)
    publication = Made(Publication, of=port)

    bound = Bound(
        publication.source,
        greatest(1, publication.source.tokens, MostPut(publication.source)),
        means=Meaning("free room at {publisher}{writer}", rests=True),
    )

    where = [either(port.place.capacity, 0) == 0]


class B2Ask(StandardRule, phase=Phase.bounds, middleware="ros2"):
    """Requests that wait to be sent; a client that does not wait sends each one at once."""

    client = Node(sym.ClientPort, outstanding=calls.UNLIMITED)
    request = Node(pn.Place, of=client.request)

    bound = Bound(
        request,
        greatest(1, request.tokens, MostPut(request)),
        means=Meaning("free room at {place}", rests=True),
    )

    where = [either(request.capacity, 0) == 0]


class B2Goal(StandardRule, phase=Phase.bounds, middleware="ros2"):
    """Goals that wait to be sent; a client that does not wait sends each one at once."""

    client = Node(sym.ActionClientPort, outstanding=calls.UNLIMITED)
    goal = Node(pn.Place, of=client.goal)

    bound = Bound(
        goal, greatest(1, goal.tokens, MostPut(goal)), means=Meaning("free room at {place}", rests=True)
    )

    where = [either(goal.capacity, 0) == 0]


class B3(StandardRule, phase=Phase.bounds, middleware="ros2", times=False):
    """Messages that a node has taken and not yet processed, if something takes them."""

    port = Node(sym.SubscriberPort)
    sink = Node(pn.Place, of=port.place)

    bound = Bound(
        sink,
        either(port.inHand, greatest(1, sink.tokens, MostNeeded(sink))),
        means=Meaning("free room at {subscriber}", rests=True),
    )

    where = [
        either(sink.capacity, 0) == 0,
        either(port.inHand, 0) != ANY_NUMBER,
        count(Lowering(sink)) > 0,
    ]


class B3Runs(StandardRule, phase=Phase.bounds, middleware="ros2", times=True):
    """With times, each run of a callback holds its message while it works."""

    port = Node(sym.SubscriberPort)
    sink = Node(pn.Place, of=port.place)

    bound = Bound(
        sink,
        either(port.inHand, greatest(1, sink.tokens, MostNeeded(sink), RunsOn(sink))),
        means=Meaning("free room at {subscriber}", rests=True),
    )

    where = [
        either(sink.capacity, 0) == 0,
        either(port.inHand, 0) != ANY_NUMBER,
        count(Lowering(sink)) > 0,
    ]


class B1Begin(StandardRule, phase=Phase.wiring, middleware="ros2", times=True):
    """With times, a timer's callback begins only if a place has the room that its first step needs."""

    page = Node(sym.CallbackPage, kind="timer")
    move = Node(pn.Transition, of=Beginnings(page))
    begin = Made(D2Start.begin, of=[page, move])
    bound = Made(DeclaredBound)
    raising = Node(pn.Transition, of=Raising(bound.place))

    has_room = read(bound.free, begin, weight=Change(bound.place, raising))

    where = [raising == move]


class B4(StandardRule, phase=Phase.wiring):
    """A transition takes free room for tokens that it adds, and gives it back for tokens that it removes."""

    bound = Made(Bound)
    raising = Node(pn.Transition, of=Raising(bound.place))
    lowering = Node(pn.Transition, of=Lowering(bound.place))

    takes = ForAll([raising], make=[arc(bound.free, raising, weight=Change(bound.place, raising))])
    gives = ForAll(
        [lowering], make=[arc(lowering, bound.free, weight=less(0, Change(bound.place, lowering)))]
    )
