"""How goals end: in time, too late to be canceled, heeding the request to cancel or not (rules A4)."""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.records import Finish
from dineros.transformations.language.creation import Fragment, New, image
from dineros.transformations.language.expressions import Expression
from dineros.transformations.language.meaning import Meaning
from dineros.transformations.language.patterns import Index, Made, Node
from dineros.transformations.rules.actions.goals import A2, A1Result
from dineros.transformations.rules.actions.outcomes import Exits
from dineros.transformations.rules.actions.slots import A6, A7, A7Ask, A7Cancel, slots
from dineros.transformations.rules.notation import arc, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule


class End(Fragment):
    """A goal is over.

    Parameters
    ----------
    id : str
        Of its transition; may hold placeholders.
    exit : Expression
        The place of the result at the server.
    state, in_use : Expression
        Places of how far the slot is, and of whose goal it has.
    idle, result : Expression
        Places of the slot's idleness, and of the result for the client.
    words : str
        How the goal ends.
    """

    roles: Mapping[str, type[EObject]] = {"move": pn.Transition}
    move: New

    def __init__(
        self,
        id: str,
        *,
        exit: Expression,
        state: Expression,
        in_use: Expression,
        idle: Expression,
        result: Expression,
        words: str = "the goal of {client} in slot {instance} of action {action} is {outcome}",
        part: str = "end",
    ) -> None:
        super().__init__()
        self.move = transition(id, Meaning(words, step=Finish, part=part))
        self.arcs = [
            *(arc(each, self.move) for each in (exit, state, in_use)),
            *(arc(self.move, each) for each in (idle, result)),
        ]


class A4(StandardRule, phase=Phase.outcomes):
    """A goal that is executing succeeds or is aborted."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action)
    slot = Index(upto=slots(action))
    exit = Node(pn.Place, of=Exits(action.server))
    page = Made(A6.page, of=[action, slot])
    output = Node(pn.Place, of=image(exit, page))
    result = Made(A1Result.result, of=[client, exit])
    in_use = Made(A2.in_use, of=[client, slot])
    idle = Made(A7.idle, of=[action, slot])
    executing = Made(A7.executing, of=[action, slot])

    end = End(
        "{action.id}.client.{client.client}.finish.{exit.id}[{slot}]",
        exit=output,
        state=executing,
        in_use=in_use,
        idle=idle,
        result=result,
    )

    where = [exit != action.server.canceled]


class A4Late(StandardRule, phase=Phase.outcomes):
    """So does one that is to be canceled, where the request comes too late."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action)
    wish = Node(pn.Place, of=client.cancel)
    slot = Index(upto=slots(action))
    exit = Node(pn.Place, of=Exits(action.server))
    page = Made(A6.page, of=[action, slot])
    output = Node(pn.Place, of=image(exit, page))
    result = Made(A1Result.result, of=[client, exit])
    in_use = Made(A2.in_use, of=[client, slot])
    idle = Made(A7.idle, of=[action, slot])
    asked = Made(A7Ask.asked, of=[action, slot])

    end = End(
        "{action.id}.client.{client.client}.late.{exit.id}[{slot}]",
        exit=output,
        state=asked,
        in_use=in_use,
        idle=idle,
        result=result,
        words="the goal of {client} in slot {instance} of action {action} is {outcome}: "
        "the request to cancel it comes too late",
        part="too late",
    )

    where = [exit != action.server.canceled]


class A4Cancel(StandardRule, phase=Phase.outcomes):
    """One whose server knows of the request ends in any way, once the request has been taken note of."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action)
    wish = Node(pn.Place, of=client.cancel)
    slot = Index(upto=slots(action))
    exit = Node(pn.Place, of=Exits(action.server))
    page = Made(A6.page, of=[action, slot])
    output = Node(pn.Place, of=image(exit, page))
    result = Made(A1Result.result, of=[client, exit])
    in_use = Made(A2.in_use, of=[client, slot])
    idle = Made(A7.idle, of=[action, slot])
    canceling = Made(A7Cancel.canceling, of=[action, slot])
    bound = Made(A7Cancel.bound, of=[action, slot])

    end = End(
        "{action.id}.client.{client.client}.heeded.{exit.id}[{slot}]",
        exit=output,
        state=canceling,
        in_use=in_use,
        idle=idle,
        result=result,
    )
    was_noted = read(bound.free, end.move)


class A4Unheeded(StandardRule, phase=Phase.outcomes):
    """Or without that; then the request goes with its goal."""

    action = Node(sym.ActionChannel)
    client = Node(sym.ActionClientPort, channel=action)
    wish = Node(pn.Place, of=client.cancel)
    slot = Index(upto=slots(action))
    exit = Node(pn.Place, of=Exits(action.server))
    page = Made(A6.page, of=[action, slot])
    output = Node(pn.Place, of=image(exit, page))
    noted = Node(pn.Place, of=image(action.server.cancel, page))
    result = Made(A1Result.result, of=[client, exit])
    in_use = Made(A2.in_use, of=[client, slot])
    idle = Made(A7.idle, of=[action, slot])
    canceling = Made(A7Cancel.canceling, of=[action, slot])

    end = End(
        "{action.id}.client.{client.client}.unheeded.{exit.id}[{slot}]",
        exit=output,
        state=canceling,
        in_use=in_use,
        idle=idle,
        result=result,
        words="the goal of {client} in slot {instance} of action {action} is {outcome}: "
        "nothing there took note of the request to cancel it",
        part="unheeded",
    )
    goes = arc(noted, end.move)
