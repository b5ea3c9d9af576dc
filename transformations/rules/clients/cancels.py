"""Cancel requests of a client with one goal under way leave first (rule A8).

Such a request is for the client's current goal. It waits only while that goal is sent and not answered, or
while another cancel request for it is under way. Otherwise it reaches the goal, or is dropped before the
client takes the next event of the goal. A request made while no goal is under way is dropped before the next
goal is sent. So a cancel request never affects a goal that is sent after the request was made.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.records import Cancel
from dineros.transformations.language.expressions import Expression
from dineros.transformations.language.functions import greatest, less
from dineros.transformations.language.meaning import Meaning
from dineros.transformations.language.patterns import Made, Node
from dineros.transformations.rules.actions.goals import A1, A2Reject, Answer, Wish
from dineros.transformations.rules.notation import Bound, arc, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.tokens import MostPut


def _room(wish: Node) -> Expression:
    """Return the maximum number of cancel requests: one that waits, and those of one firing."""
    return less(greatest(1, wish.tokens, MostPut(wish)), -1)


class A8(StandardRule, phase=Phase.goals):
    """A request to cancel comes too late where the goal is refused."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action, outstanding=1)
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


class A8Twice(StandardRule, phase=Phase.goals):
    """One that comes while another one waits changes nothing."""

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
    """So few of them wait."""

    client = Node(sym.ActionClientPort, outstanding=1)
    wish = Node(pn.Place, of=client.cancel)

    bound = Bound(wish, _room(wish), means=Meaning("no request of {client} to cancel", rests=True))


class A8Answer(StandardRule, phase=Phase.rooms):
    """They are gone before the client takes what it is told of its goal."""

    client = Node(sym.ActionClientPort, outstanding=1)
    wish = Node(pn.Place, of=client.cancel)
    bound = Made(A8Room.bound, of=client)
    answer = Made(Answer, of=client)

    waits = read(bound.free, answer.move, weight=_room(wish))


class A8Send(StandardRule, phase=Phase.rooms):
    """They are gone before the client sends its next goal."""

    client = Node(sym.ActionClientPort, outstanding=1)
    wish = Node(pn.Place, of=client.cancel)
    bound = Made(A8Room.bound, of=client)
    send = Made(A1.send, of=client)

    waits = read(bound.free, send, weight=_room(wish))
