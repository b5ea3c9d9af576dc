"""When a client of an action asks for a result (rule D11): once it knows that its goal is accepted.

The acceptance, the request for the result and the result are three messages, each with a latency. The result
of a goal that is shorter than the first two comes after them. A client with one goal under way also asks to
cancel it only when it knows of the acceptance (rule A9).

The net does not tell the goals of a client with several ones apart. While all its acceptances and requests
have arrived, it takes the next result within the latency; while some are under way, at any time.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.transformations.language import Absent, Fragment, Index, Made, Meaning, New, Node
from dineros.transformations.rules.actions.goals import (
    A1,
    A2,
    A3,
    RESULT,
    A1Result,
    Heard,
    Result,
    Taken,
)
from dineros.transformations.rules.actions.outcomes import Exits
from dineros.transformations.rules.actions.slots import slots
from dineros.transformations.rules.clients.acceptances import Acceptance
from dineros.transformations.rules.notation import (
    Bound,
    action_with_client,
    arc,
    arcs_at,
    inhibit,
    place,
    read,
    transition,
)
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.message_times import ResultsInTime
from dineros.transformations.rules.services import Home


class D11Learn(StandardRule, phase=Phase.outcomes, middleware="ros2", times=True):
    """A client without a place for the acceptance of its goal learns of it, too."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action, outstanding=1)

    told = place(
        "{action.id}.client.{client.client}.accepted",
        means=Meaning("acceptance for {client} of action {action} under way"),
    )
    learn = transition(
        "{action.id}.client.{client.client}.learn",
        means=Meaning("{client} learns that its goal of action {action} is accepted"),
    )
    takes = arc(told, learn)

    message = Acceptance(told, learn)
    heard = Heard(learn)

    accepted = Node(pn.Place, of=client.accepted)
    where = [ResultsInTime(client, Home(action.server.entry))]
    absent = [Absent(accepted)]


class D11Fetch(StandardRule, phase=Phase.outcomes, middleware="ros2", times=True):
    """A client that has learned of the acceptance asks the server for the result."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action, outstanding=1)
    message = Made(Acceptance, of=client)

    fetching = place(
        "{action.id}.client.{client.client}.fetching",
        means=Meaning("request of {client} for the result of action {action} under way"),
    )
    take = transition(
        "{action.id}.client.{client.client}.fetch",
        means=Meaning("action {action} receives the request of {client} for the result"),
    )
    arcs = [arc(message.learn, fetching), arc(fetching, take)]
    bound = Bound(
        fetching, 1, means=Meaning("no request of {client} for the result of action {action}", rests=True)
    )

    taken = Taken(take)

    where = [ResultsInTime(client, Home(action.server.entry))]


class D11Result(StandardRule, phase=Phase.outcomes, middleware="ros2", times=True):
    """The server sends the result when the goal is over and it has that request."""

    client = Node(sym.ActionClientPort)
    bound = Made(D11Fetch.bound, of=client)
    answer = Made(A1Result.answer, of=client)

    waits = read(bound.free, answer.move)


class UnderWay(Fragment):
    """Whether messages of one kind are under way. Each new message begins their time again.

    The net does not count them: all of them have arrived when the last one has.

    Parameters
    ----------
    id : str
        Prefix of the ids of its elements; may have placeholders.
    words : str
        Description of the messages.
    """

    roles: Mapping[str, type[EObject]] = {"sent": pn.Place, "some": pn.Place}

    def __init__(self, id: str, words: str) -> None:
        super().__init__()
        self.sent = place(f"{id}.sent", means=Meaning(f"{words} are sent"))
        self.some = place(f"{id}.some", means=Meaning(f"{words} are under way"))
        self.first = transition(f"{id}.first", Meaning(f"{words} leave, with none under way"), at_once=True)
        self.more = transition(f"{id}.more", Meaning(f"{words} leave, with others under way"), at_once=True)
        self.arcs = [
            *arcs_at(self.first, [self.sent], [self.some], without=[self.some]),
            *arcs_at(self.more, [self.sent, self.some], [self.some]),
        ]
        self.bound = Bound(self.sent, 1, means=Meaning(f"no {words} are sent", rests=True))


class D11Several(StandardRule, phase=Phase.outcomes, middleware="ros2", times=True):
    """A client with several goals under way learns of each acceptance, and asks for each result."""

    action, client = action_with_client()

    acceptances = UnderWay(
        "{action.id}.client.{client.client}.acceptances", "acceptances for {client} of action {action}"
    )
    requests = UnderWay(
        "{action.id}.client.{client.client}.fetching",
        "requests of {client} for results of action {action}",
    )
    learn = transition(
        "{action.id}.client.{client.client}.acceptances.learn",
        Meaning("{client} learns that its goals of action {action} are accepted"),
    )
    take = transition(
        "{action.id}.client.{client.client}.fetching.take",
        Meaning("action {action} receives the requests of {client} for results"),
    )
    arcs = [
        *arcs_at(learn, [acceptances.some], [requests.sent]),
        *arcs_at(take, [requests.some]),
    ]
    turn = place(
        "{action.id}.client.{client.client}.turn",
        tokens=1,
        means=Meaning("{client} takes one result of action {action} at a time", rests=True),
    )

    heard = Heard(learn)
    taken = Taken(take)

    where = [client.outstanding != 1, ResultsInTime(client, Home(action.server.entry))]


class D11Accepted(StandardRule, phase=Phase.outcomes, middleware="ros2", times=True):
    """The server answers each goal that it accepts."""

    action, client = action_with_client()
    slot = Index(upto=slots(action))
    accept = Made(A2.accept, of=[client, slot])
    several = Made(D11Several.acceptances, of=client)

    answers = arc(accept, several.sent)


class D11Known(StandardRule, phase=Phase.outcomes, middleware="ros2", times=True):
    """Results come within the latency while the server knows of all requests for them."""

    client = Node(sym.ActionClientPort)
    acceptances = Made(D11Several.acceptances, of=client)
    requests = Made(D11Several.requests, of=client)
    answer = Made(A1Result.answer, of=client)

    waits = [inhibit(acceptances.some, answer.move), inhibit(requests.some, answer.move)]


class D11Any(StandardRule, phase=Phase.goals, middleware="ros2", times=True):
    """Results for a client with several goals under way may also come at any time."""

    action, client = action_with_client()
    exit = Node(pn.Place, of=Exits(action.server))
    ready = Made(A1.ready, of=client)
    result = Made(A1Result.result, of=[client, exit])

    answer = Result("{action.id}.client.{client.client}.result.{exit.id}.any", result, ready, RESULT)

    where = [client.outstanding != 1, ResultsInTime(client, Home(action.server.entry))]


class D11Turn(StandardRule, phase=Phase.outcomes, middleware="ros2", times=True):
    """A client with several goals takes one result at a time; the latency of the next result begins then."""

    client = Node(sym.ActionClientPort)
    turn = Made(D11Several.turn, of=client)
    answer = Made(Result, of=client)

    waits = [arc(turn, answer.move), arc(answer.move, turn)]


class D11AnyTime(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """Results that may come at any time have no latest time of arrival."""

    answer = Made(D11Any.answer)
    move = Node(pn.Transition, of=answer.move)

    any_time = New(pn.TimeInterval, into=move.interval)


class D11Unknown(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """A client with several goals asks to cancel one at any time, as the net does not know what it knows."""

    action, client = action_with_client()
    slot = Index(upto=slots(action))
    ask = Made(A3.asks, of=[client, slot])
    move = Node(pn.Transition, of=ask.move)

    any_time = New(pn.TimeInterval, into=move.interval)

    where = [client.outstanding > 1, ResultsInTime(client, Home(action.server.entry))]
