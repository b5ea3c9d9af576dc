"""The end of goals: without a cancel request, before it arrives, after reacting to it or not (rules A4)."""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.records import Finish
from dineros.transformations.language import Expression, Fragment, Meaning, New, image
from dineros.transformations.language.patterns import Index, Made, Node, Pattern
from dineros.transformations.rules.actions.goals import A2, A1Result
from dineros.transformations.rules.actions.outcomes import Exits
from dineros.transformations.rules.actions.slots import A6, A7, A7Ask, A7Cancel, slots
from dineros.transformations.rules.notation import arc, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule


class EndingGoal(Pattern):
    """A goal of a client in a slot whose page has a result for it."""

    def __init__(self) -> None:
        self.action = Node(sym.ActionChannel)
        self.client = Node(sym.ActionClientPort, channel=self.action)
        self._match_wish()
        self.slot = Index(upto=slots(self.action))
        self.exit = Node(pn.Place, of=Exits(self.action.server))
        self.page = Made(A6.page, of=[self.action, self.slot])
        self.output = Node(pn.Place, of=image(self.exit, self.page))
        self.result = Made(A1Result.result, of=[self.client, self.exit])
        self.in_use = Made(A2.in_use, of=[self.client, self.slot])
        self.idle = Made(A7.idle, of=[self.action, self.slot])

    def _match_wish(self) -> None:
        """Match any client."""


class CanceledGoal(EndingGoal):
    """A goal whose client may ask to cancel it."""

    def _match_wish(self) -> None:
        self.wish = Node(pn.Place, of=self.client.cancel)


class End(Fragment):
    """A goal ends.

    Parameters
    ----------
    way : str
        How it ends, as a part of its transition's id.
    state : Expression
        The place for the state of the slot.
    words : str
        Description of the end.
    """

    roles: Mapping[str, type[EObject]] = {"move": pn.Transition}
    move: New

    def __init__(
        self,
        way: str,
        goal: EndingGoal,
        state: Expression,
        *,
        words: str = "the goal of {client} in slot {instance} of action {action} is {outcome}",
        part: str = "end",
    ) -> None:
        super().__init__()
        id = f"{{action.id}}.client.{{client.client}}.{way}.{{exit.id}}[{{slot}}]"
        self.move = transition(id, Meaning(words, step=Finish, part=part))
        self.arcs = [
            *(arc(each, self.move) for each in (goal.output, state, goal.in_use)),
            *(arc(self.move, each) for each in (goal.idle, goal.result)),
        ]


class A4(StandardRule, phase=Phase.outcomes):
    """A goal that is executing succeeds or is aborted."""

    goal = EndingGoal()
    executing = Made(A7.executing, of=[goal.action, goal.slot])

    end = End("finish", goal, executing)

    where = [goal.exit != goal.action.server.canceled]


class A4Late(StandardRule, phase=Phase.outcomes):
    """A goal that is executing also ends if a request to cancel it comes too late."""

    goal = CanceledGoal()
    asked = Made(A7Ask.asked, of=[goal.action, goal.slot])

    end = End(
        "late",
        goal,
        asked,
        words="the goal of {client} in slot {instance} of action {action} is {outcome}: "
        "the request to cancel it comes too late",
        part="too late",
    )

    where = [goal.exit != goal.action.server.canceled]


class A4Cancel(StandardRule, phase=Phase.outcomes):
    """A goal whose server knows of a cancel request may end in any way, once the request is handled."""

    goal = CanceledGoal()
    canceling = Made(A7Cancel.canceling, of=[goal.action, goal.slot])
    bound = Made(A7Cancel.bound, of=[goal.action, goal.slot])

    end = End("heeded", goal, canceling)
    was_noted = read(bound.free, end.move)


class A4Unheeded(StandardRule, phase=Phase.outcomes):
    """A goal ends although its server never reacted to the cancel request; the request is discarded."""

    goal = CanceledGoal()
    noted = Node(pn.Place, of=image(goal.action.server.cancel, goal.page))
    canceling = Made(A7Cancel.canceling, of=[goal.action, goal.slot])

    end = End(
        "unheeded",
        goal,
        canceling,
        words="the goal of {client} in slot {instance} of action {action} is {outcome}: the request to "
        "cancel it was not received",
        part="unheeded",
    )
    goes = arc(noted, end.move)
