"""Goals of an action: sent, accepted or refused, canceled, and ended (rules A1 to A4).

A server accepts a goal only if a slot is free. Results are kept until the client takes them. A client has as
many goals under way as the model allows, one by default.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.records import Accept, Cancel, Canceling, Goal, Outcome, Reject, Transfer
from dineros.transformations.language import Expression, Fragment, Meaning, New, image
from dineros.transformations.language.functions import greatest
from dineros.transformations.language.patterns import Absent, Index, Made, Node
from dineros.transformations.rules.actions.outcomes import Exits, Fetched
from dineros.transformations.rules.actions.slots import A6, A7, A7Ask, A7Cancel, SlotPage, slots
from dineros.transformations.rules.notation import action_with_client, arc, arcs_at, place, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule


class Known(Fragment):
    """A transition made by another rule, classified by its effect.

    `move`: the transition.
    """

    roles: Mapping[str, type[EObject]] = {"move": pn.Transition}

    def __init__(self, move: Expression) -> None:
        super().__init__(move=move)


class Taken(Known):
    """A server takes a goal that it refuses, or a cancel request, between callbacks."""


class Wish(Known):
    """A client asks to cancel its goal."""


class Heard(Known):
    """A client takes an answer or feedback."""


class Answer(Heard):
    """A client takes the answer for which it waits, and may then send another goal.

    Parameters
    ----------
    id : str
        Id of its transition; may have placeholders.
    waiting, ready : Expression
        Places of the answer, and of the client's readiness.
    means : Meaning
        Meaning of the transition.
    """

    move: New

    def __init__(self, id: str, waiting: Expression, ready: Expression, means: Meaning) -> None:
        Fragment.__init__(self)
        self.move = transition(id, means)
        self.arcs = [arc(waiting, self.move), arc(self.move, ready)]


class Result(Answer):
    """A client takes the result of its goal."""


RESULT = Meaning("{client} learns that its goal of action {action} is {outcome}", step=Outcome, part="result")


class A1(StandardRule, phase=Phase.goals):
    """A client's goals: one at a time, or as many as it specifies."""

    action, client = action_with_client()
    goal = Node(pn.Place, of=client.goal)

    ready = place(
        "{action.id}.client.{client.client}.ready",
        tokens=greatest(1, client.outstanding),
        means=Meaning("{client} of action {action} is ready", part="ready", rests=True),
    )
    requested = place(
        "{action.id}.client.{client.client}.requested",
        means=Meaning("goal of {client} of action {action} under way", part="waits"),
        carries=True,
    )
    send = transition(
        "{action.id}.client.{client.client}.send",
        means=Meaning("{client} sends a goal of action {action}", step=Goal),
    )
    arcs = [arc(goal, send), arc(ready, send), arc(send, requested)]


class A1Result(StandardRule, phase=Phase.goals):
    """A client takes the results of one kind."""

    action, client = action_with_client()
    exit = Node(pn.Place, of=Exits(action.server))
    ready = Made(A1.ready, of=client)

    result = place(
        "{action.id}.client.{client.client}.over.{exit.id}",
        means=Meaning(
            "result for {client} of action {action}, whose goal is {outcome}, under way", part="over"
        ),
        carries=True,
    )
    answer = Result("{action.id}.client.{client.client}.result.{exit.id}", result, ready, RESULT)


class A1Fetch(StandardRule, phase=Phase.goals):
    """Results go to the place that the client names for them; without one, no client fetches them."""

    action, client = action_with_client()
    exit = Node(pn.Place, of=Exits(action.server))
    fetched = Node(pn.Place, of=Fetched(client, exit))
    answer = Made(Result, of=[client, exit])

    fetches = arc(answer.move, fetched)


class A2(StandardRule, phase=Phase.goals):
    """Each client's goals may be accepted into each slot."""

    action, client = action_with_client()
    slot = Index(upto=slots(action))
    requested = Made(A1.requested, of=client)
    idle = Made(A7.idle, of=[action, slot])
    executing = Made(A7.executing, of=[action, slot])
    page = Made(A6.page, of=[action, slot])
    entry = Node(pn.Place, of=image(action.server.entry, page))

    in_use = place(
        "{action.id}.client.{client.client}.inUse[{slot}]",
        means=Meaning("slot {instance} of action {action} works for {client}", part="works"),
    )
    accept = transition(
        "{action.id}.client.{client.client}.accept[{slot}]",
        means=Meaning("slot {instance} of action {action} accepts the goal of {client}", step=Accept),
    )
    arcs = arcs_at(accept, [requested, idle], [entry, executing, in_use])


class A2Reject(StandardRule, phase=Phase.goals):
    """A server that may refuse goals refuses one, and the client learns that."""

    action = Node(sym.ActionChannel)
    server = Node(sym.ActionServerPort, channel=action, mayReject=True)
    client = Node(sym.ActionClientPort, channel=action)
    requested = Made(A1.requested, of=client)
    ready = Made(A1.ready, of=client)

    refused = place(
        "{action.id}.client.{client.client}.rejected",
        means=Meaning("refusal for {client} of action {action} under way"),
    )
    reject = transition(
        "{action.id}.client.{client.client}.reject",
        means=Meaning("action {action} refuses the goal of {client}", step=Transfer, part="reject"),
    )
    arcs = [arc(requested, reject), arc(reject, refused)]
    answer = Answer(
        "{action.id}.client.{client.client}.refused",
        refused,
        ready,
        Meaning("{client} learns that its goal of action {action} is refused", step=Reject),
    )

    taken = Taken(reject)


class A2Tell(StandardRule, phase=Phase.goals):
    """A refusal puts a token on a place of the client, if the client names one."""

    client = Node(sym.ActionClientPort)
    rejected = Node(pn.Place, of=client.rejected)
    answer = Made(A2Reject.answer, of=client)

    tells = arc(answer.move, rejected)


class A3(StandardRule, phase=Phase.goals):
    """A client asks to cancel its goal, which a slot executes."""

    action, client = action_with_client()
    wish = Node(pn.Place, of=client.cancel)
    slot = Index(upto=slots(action))
    in_use = Made(A2.in_use, of=[client, slot])
    executing = Made(A7.executing, of=[action, slot])
    asked = Made(A7Ask.asked, of=[action, slot])

    ask = transition(
        "{action.id}.client.{client.client}.cancel[{slot}]",
        means=Meaning(
            "{client} asks to cancel its goal in slot {instance} of action {action}", step=Cancel, part="ask"
        ),
    )
    arcs = [arc(wish, ask), arc(executing, ask), arc(ask, asked), read(in_use, ask)]

    asks = Wish(ask)


class A3Again(StandardRule, phase=Phase.goals):
    """A second request to cancel the same goal changes nothing."""

    action, client = action_with_client()
    wish = Node(pn.Place, of=client.cancel)
    slot = Index(upto=slots(action))
    in_use = Made(A2.in_use, of=[client, slot])
    canceling = Made(A7Cancel.canceling, of=[action, slot])

    ask = transition(
        "{action.id}.client.{client.client}.again[{slot}]",
        means=Meaning(
            "{client} asks again to cancel its goal in slot {instance} of action {action}", step=Cancel
        ),
    )
    arcs = [arc(wish, ask), read(canceling, ask), read(in_use, ask)]

    asks = Wish(ask)


class A3Nothing(StandardRule, phase=Phase.goals):
    """A request to cancel is discarded if the client has no goal under way."""

    action, client = action_with_client()
    wish = Node(pn.Place, of=client.cancel)
    ready = Made(A1.ready, of=client)

    ask = transition(
        "{action.id}.client.{client.client}.nothing",
        means=Meaning(
            "{client} of action {action} asks to cancel, and has no goal under way",
            step=Cancel,
            part="nothing",
        ),
    )
    arcs = [arc(wish, ask), read(ready, ask, weight=client.outstanding)]

    asks = Wish(ask)

    where = [client.outstanding > 0]


class A3Former(StandardRule, phase=Phase.goals):
    """A client that does not wait may ask to cancel a goal that is over or not yet accepted."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action, outstanding=UNLIMITED)
    wish = Node(pn.Place, of=client.cancel)

    ask = transition(
        "{action.id}.client.{client.client}.nothing",
        means=Meaning(
            "{client} of action {action} asks to cancel a goal that is over or not accepted",
            step=Cancel,
            part="nothing",
        ),
    )
    arcs = [arc(wish, ask)]

    asks = Wish(ask)


class A3Over(StandardRule, phase=Phase.goals):
    """A client may ask to cancel a goal that is over before it knows that."""

    action, client = action_with_client()
    wish = Node(pn.Place, of=client.cancel)
    exit = Node(pn.Place, of=Exits(action.server))
    result = Made(A1Result.result, of=[client, exit])

    ask = transition(
        "{action.id}.client.{client.client}.tooLate.{exit.id}",
        means=Meaning(
            "{client} asks to cancel its goal of action {action}, which is {outcome} already: "
            "the request to cancel it comes too late",
            step=Cancel,
            part="too late",
        ),
    )
    arcs = [arc(wish, ask), read(result, ask)]

    asks = Wish(ask)


class A3Hear(StandardRule, phase=Phase.outcomes):
    """The server takes a request to cancel a goal, and informs the callback that works on the goal."""

    served = SlotPage()
    noted = Node(pn.Place, of=image(served.action.server.cancel, served.page))
    asked = Made(A7Ask.asked, of=[served.action, served.slot])
    canceling = Made(A7Cancel.canceling, of=[served.action, served.slot])

    hear = transition(
        "{action.id}[{slot}].cancel",
        means=Meaning(
            "slot {instance} of action {action} receives the request to cancel its goal", step=Canceling
        ),
    )
    arcs = [arc(asked, hear), arc(hear, canceling), arc(hear, noted)]

    taken = Taken(hear)


class A3Refuse(StandardRule, phase=Phase.outcomes):
    """A server without a place for cancel requests refuses them, and the goal continues."""

    action = Node(sym.ActionChannel)
    server = Node(sym.ActionServerPort, channel=action)
    slot = Index(upto=slots(action))
    asked = Made(A7Ask.asked, of=[action, slot])
    executing = Made(A7.executing, of=[action, slot])

    refuse = transition(
        "{action.id}[{slot}].refuse",
        means=Meaning(
            "slot {instance} of action {action} refuses to cancel its goal", step=Transfer, part="refuse"
        ),
    )
    arcs = [arc(asked, refuse), arc(refuse, executing)]

    taken = Taken(refuse)
    noted = Node(pn.Place, of=server.cancel)
    absent = [Absent(noted)]
