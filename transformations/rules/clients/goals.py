"""Action clients that do not wait for the end of a goal (rules G1, G2 and G4).

Such a client (`dineros.metamodel.callbacks.waiting`) sends as many goals as its node requests. An action of
ROS 2 consists of services, whose histories keep 10 messages. A message that arrives at a full history is
lost, or replaces a waiting message: a goal that waits for the server, or an answer or a result that waits for
the client. The model's histories do not store which message is the oldest, so any message can be the lost
one. For messages of one kind this makes no difference; but results and answers are of several kinds (OMG,
Data Distribution Service 1.4, 2015, Sect. 2.2.3.18).
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import HISTORY_DEPTH, UNLIMITED
from dineros.metamodel.records import Drop
from dineros.transformations.language import TRUTH, Expression, Fragment, Index, Made, Meaning, New, Node
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.language.functions import Query
from dineros.transformations.language.meaning import QueueKind
from dineros.transformations.rules.actions.goals import A1, A2, A1Result, A2Reject, Result
from dineros.transformations.rules.actions.outcomes import Exits
from dineros.transformations.rules.actions.slots import slots
from dineros.transformations.rules.notation import Bound, action_with_client, arc, place, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.requests import Entrance, entering

LANGUAGE.add(__name__)

GOALS = "goal history of action {action}"
RESULTS = "result history of {client} of action {action}"


class GoalsPile(Query):
    """Whether a client of an action has any number of goals under way."""

    datatype = TRUTH
    _words = "goals of {} can pile up"

    @staticmethod
    def _answer(action: sym.ActionChannel) -> bool:
        return any(client.outstanding == UNLIMITED for client in action.clients)


def load_of(id: str, kind: QueueKind, called: str) -> New:
    """Return the place that counts the messages in a history."""
    return place(f"{id}.Load", means=Meaning("{queue}: load", queue=kind, called=called, part="load"))


def capacity_of(id: str, kind: QueueKind, called: str) -> New:
    """Return the place that counts the free room of a history."""
    words = "{queue}: free capacity"
    means = Meaning(words, queue=kind, called=called, part="capacity", rests=True)
    return place(f"{id}.Capacity", tokens=HISTORY_DEPTH, means=means)


class Replaced(Fragment):
    """A message that arrives at a full history replaces one of another kind, which is lost.

    Parameters
    ----------
    id : str
        Id of its transition; may hold placeholders.
    means : Meaning
        Meaning of the transition.
    source, kept : Expression
        The places of the new message: where it arrives, and where it waits in the history.
    lost : Expression
        The place of the history for the kind of the lost message.
    load : Expression
        The place that counts the messages in the history.
    """

    def __init__(
        self,
        id: str,
        means: Meaning,
        *,
        source: Expression,
        kept: Expression,
        lost: Expression,
        load: Expression,
    ) -> None:
        super().__init__()
        self.instead = transition(id, means=means)
        self.arcs = [
            arc(source, self.instead),
            arc(lost, self.instead),
            arc(load, self.instead, weight=HISTORY_DEPTH),
            arc(self.instead, load, weight=HISTORY_DEPTH),
            arc(self.instead, kept),
        ]


def replaces(kind: QueueKind, called: str, words: str) -> Meaning:
    """Return the meaning of a transition in which a message replaces another one."""
    return Meaning(words, step=Drop, queue=kind, called=called, part="instead")


class G1(StandardRule, phase=Phase.goals, middleware="ros2"):
    """History of the goals of an action with a client that does not wait."""

    action = Node(sym.ActionChannel)

    load = load_of("{action.id}.goals", "goal", GOALS)
    capacity = capacity_of("{action.id}.goals", "goal", GOALS)

    where = [GoalsPile(action)]


class G1Client(StandardRule, phase=Phase.goals, middleware="ros2"):
    """The goals of all clients go through the history of goals; a full history loses them."""

    action, client = action_with_client()
    load = Made(G1.load, of=action)
    capacity = Made(G1.capacity, of=action)
    send = Made(A1.send, of=client)
    requested = Made(A1.requested, of=client)
    past = Node(pn.Arc, source=send, target=requested)

    sent = place(
        "{action.id}.client.{client.client}.sent",
        means=Meaning("goal of {client} of action {action} arriving"),
        carries=True,
    )
    through = arc(send, sent)
    queue = Entrance(
        "{action.id}.client.{client.client}.goals",
        source=sent,
        load=load,
        capacity=capacity,
        enters=entering("goal", GOALS, "enter", "{queue} takes the goal of {client}"),
        drops=entering("goal", GOALS, "drop", "a goal of {client} of action {action} is lost"),
        kept=[requested],
    )
    sending = Bound(
        sent, 1, means=Meaning("room for a goal of {client} of action {action}", part="way", rests=True)
    )

    deletes = [past]


class G1Accept(StandardRule, phase=Phase.goals, middleware="ros2"):
    """A goal that is accepted leaves the history of goals."""

    action, client = action_with_client()
    slot = Index(upto=slots(action))
    load = Made(G1.load, of=action)
    capacity = Made(G1.capacity, of=action)
    accept = Made(A2.accept, of=[client, slot])

    room = [arc(load, accept), arc(accept, capacity)]


class G1Reject(StandardRule, phase=Phase.goals, middleware="ros2"):
    """A goal that is refused leaves the history of goals."""

    action, client = action_with_client()
    load = Made(G1.load, of=action)
    capacity = Made(G1.capacity, of=action)
    reject = Made(A2Reject.reject, of=client)

    room = [arc(load, reject), arc(reject, capacity)]


class G1Lost(StandardRule, phase=Phase.goals, middleware="ros2"):
    """A client with a limited number of goals under way waits for a goal that is lost."""

    action, client = action_with_client()
    queue = Made(G1Client.queue, of=client)

    lost = place(
        "{action.id}.client.{client.client}.lost",
        means=Meaning("lost goal of {client} of action {action}"),
    )
    loses = arc(queue.drop, lost)

    where = [client.outstanding > 0]


class G2(StandardRule, phase=Phase.goals, middleware="ros2"):
    """History of the results for a client that does not wait."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action, outstanding=UNLIMITED)

    load = load_of("{action.id}.client.{client.client}.results", "result", RESULTS)
    capacity = capacity_of("{action.id}.client.{client.client}.results", "result", RESULTS)


class G2Result(StandardRule, phase=Phase.goals, middleware="ros2"):
    """Results of each kind go through the client's history of results; a full history loses them."""

    action, client = action_with_client()
    exit = Node(pn.Place, of=Exits(action.server))
    load = Made(G2.load, of=client)
    capacity = Made(G2.capacity, of=client)
    result = Made(A1Result.result, of=[client, exit])

    kept = place(
        "{action.id}.client.{client.client}.kept.{exit.id}",
        means=Meaning("result for {client} of action {action}, whose goal is {outcome}", part="over"),
        carries=True,
    )
    queue = Entrance(
        "{action.id}.client.{client.client}.results.{exit.id}",
        source=result,
        load=load,
        capacity=capacity,
        enters=entering("result", RESULTS, "enter", "{queue} takes a result"),
        drops=entering("result", RESULTS, "drop", "a result for {client} of action {action} is lost"),
        kept=[kept],
    )
    sending = Bound(
        result,
        1,
        means=Meaning("room for a result for {client} of action {action}", part="way", rests=True),
    )


class G2Take(StandardRule, phase=Phase.goals, middleware="ros2"):
    """The client takes them from it."""

    action, client = action_with_client()
    exit = Node(pn.Place, of=Exits(action.server))
    load = Made(G2.load, of=client)
    capacity = Made(G2.capacity, of=client)
    result = Made(A1Result.result, of=[client, exit])
    kept = Made(G2Result.kept, of=[client, exit])
    answer = Made(Result, of=[client, exit])
    learn = Node(pn.Transition, of=answer.move)
    past = Node(pn.Arc, source=result, target=learn)

    takes = [arc(kept, learn), arc(load, learn), arc(learn, capacity)]

    deletes = [past]


class G2Instead(StandardRule, phase=Phase.goals, middleware="ros2"):
    """A full history may lose a result of another kind, instead of the one that comes."""

    action, client = action_with_client()
    exit = Node(pn.Place, of=Exits(action.server))
    other = Node(pn.Place, of=Exits(action.server))
    load = Made(G2.load, of=client)
    result = Made(A1Result.result, of=[client, exit])
    kept = Made(G2Result.kept, of=[client, exit])
    lost = Made(G2Result.kept, of=[client, other])

    replaced = Replaced(
        "{action.id}.client.{client.client}.results.{exit.id}.instead.{other.id}",
        replaces(
            "result",
            RESULTS,
            "{queue} takes a result, and loses one of another outcome",
        ),
        source=result,
        kept=kept,
        lost=lost,
        load=load,
    )

    where = [exit != other]


class G4(StandardRule, phase=Phase.forgetting, middleware="ros2"):
    """A client that does not wait is always ready to send a goal."""

    client = Node(sym.ActionClientPort, outstanding=UNLIMITED)
    ready = Made(A1.ready, of=client)
    past = Node(pn.Arc, target=ready)

    deletes = [past]


class G4Ready(StandardRule, phase=Phase.forgetting, middleware="ros2"):
    """No place counts whether a client that does not wait is ready to send a goal."""

    client = Node(sym.ActionClientPort, outstanding=UNLIMITED)
    counted = Made(A1.ready, of=client)
    ready = Node(pn.Place, of=counted)
    send = Made(A1.send, of=client)
    asks = Node(pn.Arc, source=ready, target=send)

    deletes = [ready, asks]
