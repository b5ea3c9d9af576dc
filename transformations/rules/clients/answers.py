"""Answers to the goals of a client that does not wait (rules G3).

Acceptances and refusals share a history, like the responses of a service. Since they are of two kinds, a full
history may lose an answer of the other kind instead of the new one.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import UNLIMITED
from dineros.transformations.language import TRUTH, Made, Meaning, Node, Query
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.rules.actions.goals import A2Reject
from dineros.transformations.rules.clients.acceptances import A9
from dineros.transformations.rules.clients.goals import Replaced, capacity_of, load_of, replaces
from dineros.transformations.rules.notation import Bound, action_with_client, arc, place
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.requests import Entrance, entering

LANGUAGE.add(__name__)

ANSWERS = "answer history of {client} of action {action}"


class HearsAnswers(Query):
    """Whether the answer to a goal affects its client, apart from asking for the result."""

    datatype = TRUTH
    _words = "{} gets the answers whether goals are accepted"

    @staticmethod
    def _answer(client: sym.ActionClientPort) -> bool:
        assert client.channel is not None
        return client.accepted is not None or bool(client.channel.server.mayReject)


class G3(StandardRule, phase=Phase.outcomes, middleware="ros2"):
    """History of the answers to the goals of a client that does not wait: accepted or refused."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action, outstanding=UNLIMITED)

    load = load_of("{action.id}.client.{client.client}.answers", "answer", ANSWERS)
    capacity = capacity_of("{action.id}.client.{client.client}.answers", "answer", ANSWERS)

    where = [HearsAnswers(client)]


class G3Accepted(StandardRule, phase=Phase.outcomes, middleware="ros2"):
    """Acceptances go through the history of answers."""

    action, client = action_with_client()
    load = Made(G3.load, of=client)
    capacity = Made(G3.capacity, of=client)
    told = Made(A9.told, of=client)
    learn = Made(A9.learn, of=client)
    past = Node(pn.Arc, source=told, target=learn)

    kept = place(
        "{action.id}.client.{client.client}.kept.accepted",
        means=Meaning("acceptance for {client} of action {action}"),
    )
    queue = Entrance(
        "{action.id}.client.{client.client}.answers.accepted",
        source=told,
        load=load,
        capacity=capacity,
        enters=entering("answer", ANSWERS, "enter", "{queue} takes an acceptance"),
        drops=entering("answer", ANSWERS, "drop", "an acceptance for {client} of action {action} is lost"),
        kept=[kept],
    )
    takes = [arc(kept, learn), arc(load, learn), arc(learn, capacity)]
    sending = Bound(
        told,
        1,
        means=Meaning("room for an acceptance for {client} of action {action}", part="way", rests=True),
    )

    deletes = [past]


class G3Refused(StandardRule, phase=Phase.outcomes, middleware="ros2"):
    """Refusals go through the history of answers."""

    action, client = action_with_client()
    load = Made(G3.load, of=client)
    capacity = Made(G3.capacity, of=client)
    refused = Made(A2Reject.refused, of=client)
    answer = Made(A2Reject.answer, of=client)
    learn = Node(pn.Transition, of=answer.move)
    past = Node(pn.Arc, source=refused, target=learn)

    kept = place(
        "{action.id}.client.{client.client}.kept.rejected",
        means=Meaning("refusal for {client} of action {action}"),
    )
    queue = Entrance(
        "{action.id}.client.{client.client}.answers.rejected",
        source=refused,
        load=load,
        capacity=capacity,
        enters=entering("answer", ANSWERS, "enter", "{queue} takes a refusal"),
        drops=entering("answer", ANSWERS, "drop", "a refusal for {client} of action {action} is lost"),
        kept=[kept],
    )
    takes = [arc(kept, learn), arc(load, learn), arc(learn, capacity)]
    sending = Bound(
        refused,
        1,
        means=Meaning("room for a refusal for {client} of action {action}", part="way", rests=True),
    )

    deletes = [past]


class G3Instead(StandardRule, phase=Phase.outcomes, middleware="ros2"):
    """A full history may lose an answer of the other kind, instead of the one that comes."""

    action, client = action_with_client()
    load = Made(G3.load, of=client)
    told = Made(A9.told, of=client)
    refused = Made(A2Reject.refused, of=client)
    acceptance = Made(G3Accepted.kept, of=client)
    refusal = Made(G3Refused.kept, of=client)

    accepts = Replaced(
        "{action.id}.client.{client.client}.answers.accepted.instead",
        replaces(
            "answer",
            ANSWERS,
            "{queue} takes an acceptance, and loses a refusal",
        ),
        source=told,
        kept=acceptance,
        lost=refusal,
        load=load,
    )
    refuses = Replaced(
        "{action.id}.client.{client.client}.answers.rejected.instead",
        replaces(
            "answer",
            ANSWERS,
            "{queue} takes a refusal, and loses an acceptance",
        ),
        source=refused,
        kept=refusal,
        lost=acceptance,
        load=load,
    )
