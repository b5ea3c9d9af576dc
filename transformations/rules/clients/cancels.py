"""Cancel requests that do not find a goal are dropped at once (rule A8).

The request of a client with one goal is for that goal. It waits only while that goal is sent and not
answered, or while another cancel request for it is under way. Otherwise it reaches the goal, or is dropped
before the client takes the next event of the goal. A request made while no goal is under way is dropped
before the next goal is sent. So a cancel request never affects a goal that is sent after the request was
made.

A request of a client with several goals is for one of those under way. No more requests wait than goals are
under way: the others are dropped before the next goal is sent, and before the client takes the next result
or refusal. For that, the room of their place grows with each goal. A client that does not wait may always
drop a request; so no more than those of one firing wait.
"""

from __future__ import annotations

from dineros.metamodel import calls, pn, sym
from dineros.metamodel.records import Cancel
from dineros.transformations.language import Expression, Made, Meaning, Node, greatest, less
from dineros.transformations.rules.actions.goals import A1, A2Reject, Answer, Wish
from dineros.transformations.rules.notation import Bound, action_with_client, arc, inhibit, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.tokens import MostPut


def _firing(wish: Node) -> Expression:
    """Return the number of cancel requests that one firing makes at most."""
    return greatest(1, wish.tokens, MostPut(wish))


def _room(wish: Node) -> Expression:
    """Return the maximum number of cancel requests: one that waits, and those of one firing."""
    return less(_firing(wish), -1)


class A8(StandardRule, phase=Phase.goals):
    """A request to cancel has no effect if the goal is refused."""

    action, client = action_with_client()
    wish = Node(pn.Place, of=client.cancel)
    refused = Made(A2Reject.refused, of=client)

    ask = transition(
        "{action.id}.client.{client.client}.tooLate.rejected",
        means=Meaning(
            "{client} asks to cancel its goal of action {action}, which is refused: the request is discarded",
            step=Cancel,
            part="nothing",
        ),
    )
    arcs = [arc(wish, ask), read(refused, ask)]

    asks = Wish(ask)

    where = [client.outstanding > 0]


class A8Twice(StandardRule, phase=Phase.goals):
    """A request to cancel that comes while another one waits changes nothing."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action, outstanding=1)
    wish = Node(pn.Place, of=client.cancel)

    ask = transition(
        "{action.id}.client.{client.client}.twice",
        means=Meaning(
            "{client} asks twice to cancel its goal of action {action}: one request is discarded",
            step=Cancel,
            part="twice",
        ),
    )
    arcs = [arc(wish, ask, weight=2), arc(ask, wish)]

    asks = Wish(ask)


class A8Room(StandardRule, phase=Phase.rooms):
    """The number of waiting requests to cancel is limited for a client with one goal under way."""

    client = Node(sym.ActionClientPort, outstanding=1)
    wish = Node(pn.Place, of=client.cancel)

    bound = Bound(wish, _room(wish), means=Meaning("no request of {client} to cancel", rests=True))


class A8Answer(StandardRule, phase=Phase.rooms):
    """Waiting requests to cancel are removed before the client receives the outcome of its goal."""

    client = Node(sym.ActionClientPort, outstanding=1)
    wish = Node(pn.Place, of=client.cancel)
    bound = Made(A8Room.bound, of=client)
    answer = Made(Answer, of=client)

    waits = read(bound.free, answer.move, weight=_room(wish))


class A8Send(StandardRule, phase=Phase.rooms):
    """Waiting requests to cancel are removed before the client sends its next goal."""

    client = Node(sym.ActionClientPort, outstanding=1)
    wish = Node(pn.Place, of=client.cancel)
    bound = Made(A8Room.bound, of=client)
    send = Made(A1.send, of=client)

    waits = read(bound.free, send, weight=_room(wish))


class A8More(StandardRule, phase=Phase.goals):
    """A request to cancel is discarded if more of them wait than the client has goals under way."""

    action, client = action_with_client()
    wish = Node(pn.Place, of=client.cancel)

    ask = transition(
        "{action.id}.client.{client.client}.more",
        means=Meaning(
            "{client} asks to cancel too many goals of action {action}: one request is discarded",
            step=Cancel,
            part="more",
        ),
    )
    arcs = [arc(wish, ask)]

    asks = Wish(ask)

    where = [client.outstanding > 1]


class A8MoreRoom(StandardRule, phase=Phase.rooms):
    """Requests to cancel may wait: one for each goal under way, and those of one firing."""

    client = Node(sym.ActionClientPort)
    wish = Node(pn.Place, of=client.cancel)

    bound = Bound(wish, _firing(wish), means=Meaning("no request of {client} to cancel", rests=True))

    where = [client.outstanding > 1]


class A8MoreGone(StandardRule, phase=Phase.rooms):
    """No request to cancel is discarded while at most as many wait as goals are under way."""

    client = Node(sym.ActionClientPort)
    wish = Node(pn.Place, of=client.cancel)
    bound = Made(A8MoreRoom.bound, of=client)
    more = Made(A8More.ask, of=client)

    waits = inhibit(bound.free, more, weight=_firing(wish))


class A8MoreAnswer(StandardRule, phase=Phase.rooms):
    """Requests to cancel a goal are removed before the client takes its result or refusal."""

    client = Node(sym.ActionClientPort)
    wish = Node(pn.Place, of=client.cancel)
    bound = Made(A8MoreRoom.bound, of=client)
    answer = Made(Answer, of=client)

    waits = [
        arc(bound.free, answer.move, weight=less(_firing(wish), -1)),
        arc(answer.move, bound.free, weight=_firing(wish)),
    ]


class A8MoreSend(StandardRule, phase=Phase.rooms):
    """Requests to cancel that refer to no goal are removed before the client sends its next goal."""

    client = Node(sym.ActionClientPort)
    wish = Node(pn.Place, of=client.cancel)
    bound = Made(A8MoreRoom.bound, of=client)
    send = Made(A1.send, of=client)

    waits = [
        arc(bound.free, send, weight=_firing(wish)),
        arc(send, bound.free, weight=less(_firing(wish), -1)),
    ]


class A8Any(StandardRule, phase=Phase.rooms):
    """A client that does not wait sends each request to cancel at once."""

    client = Node(sym.ActionClientPort, outstanding=calls.UNLIMITED)
    wish = Node(pn.Place, of=client.cancel)

    bound = Bound(wish, _firing(wish), means=Meaning("no request of {client} to cancel", rests=True))
