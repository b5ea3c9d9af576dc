"""The acceptance of a goal as an action client receives it (rule A9).

Only a goal whose acceptance is known has a handle with which `rclpy` and `rclcpp` can cancel it.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.records import Accepted
from dineros.transformations.language import Expression, Fragment, Index, Made, Meaning, Node
from dineros.transformations.rules.actions.goals import A2, A3, A1Result, Heard
from dineros.transformations.rules.actions.slots import slots
from dineros.transformations.rules.notation import Bound, action_with_client, arc, place, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule


class Acceptance(Fragment):
    """The message that a goal is accepted.

    `told`: the place of the message on its way. `learn`: the transition with which the client takes it.
    """

    roles: Mapping[str, type[EObject]] = {"told": pn.Place, "learn": pn.Transition}

    def __init__(self, told: Expression, learn: Expression) -> None:
        super().__init__(told=told, learn=learn)


class A9(StandardRule, phase=Phase.outcomes):
    """A client that names a place for it learns that its goal is accepted."""

    action, client = action_with_client()
    accepted = Node(pn.Place, of=client.accepted)

    told = place(
        "{action.id}.client.{client.client}.accepted",
        means=Meaning("acceptance for {client} of action {action} under way"),
    )
    learn = transition(
        "{action.id}.client.{client.client}.learn",
        means=Meaning("{client} learns that its goal of action {action} is accepted", step=Accepted),
    )
    arcs = [arc(told, learn), arc(learn, accepted)]

    message = Acceptance(told, learn)
    heard = Heard(learn)


class A9Accept(StandardRule, phase=Phase.outcomes):
    """The server answers when it accepts the goal."""

    action, client = action_with_client()
    slot = Index(upto=slots(action))
    accept = Made(A2.accept, of=[client, slot])
    message = Made(Acceptance, of=client)

    answers = arc(accept, message.told)


class A9Once(StandardRule, phase=Phase.outcomes):
    """A client with one goal under way has at most one acceptance waiting."""

    client = Node(sym.ActionClientPort, outstanding=1)
    message = Made(Acceptance, of=client)

    bound = Bound(message.told, 1, means=Meaning("no acceptance for {client} under way", rests=True))


class A9Handle(StandardRule, phase=Phase.outcomes):
    """A client can ask to cancel a goal only after it has received the acceptance."""

    client = Node(sym.ActionClientPort)
    bound = Made(A9Once.bound, of=client)
    wish = Made(A3.asks, of=client)

    waits = read(bound.free, wish.move)


class A9First(StandardRule, phase=Phase.outcomes):
    """A client receives the acceptance of a goal before it takes the result."""

    client = Node(sym.ActionClientPort)
    bound = Made(A9Once.bound, of=client)
    answer = Made(A1Result.answer, of=client)

    waits = read(bound.free, answer.move)
