"""Slots of an action server: a copy of its page for each, and the state of its goal (rules A6 and A7).

A goal in a slot is executing or canceling. It is also known whether a cancel request for it is under way, so
that a request never affects another goal than its own (ROS 2, design of actions, goal states).
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language import Copy, Expression, Index, Made, Meaning, Node, Pattern, image
from dineros.transformations.language.functions import count, either, enclosing
from dineros.transformations.rules.notation import Bound, place
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.services import copied_client


def slots(action: Node) -> Expression:
    """Return the number of goals that a server executes at a time: by default one per client."""
    return either(action.instances, count(action.clients))


def asking(action: Node) -> Expression:
    """Return whether a client of an action may ask to cancel a goal."""
    return count(action.clients.cancel) > 0


class Slot(Pattern):
    """A slot of an action.

    `upto`: number of the last slot that matches; by default, all slots match.
    """

    def __init__(self, upto: Expression | int | None = None) -> None:
        self.action = Node(sym.ActionChannel)
        self.slot = Index(upto=slots(self.action) if upto is None else upto)


class A6(StandardRule, phase=Phase.instances):
    """A copy of the server's page for each slot; what it reaches by references outside is shared."""

    action = Node(sym.ActionChannel)
    server = Node(sym.ActionServerPort, channel=action)
    slot = Index(upto=slots(action))

    page = Copy(
        server.page,
        into=server.page.page.objects,
        named=pn.Element,
        id="{action.id}[{slot}].{original.id}",
    )


class A6Client(StandardRule, phase=Phase.instances):
    """A client of a service of its own for each slot whose page a client is on."""

    action = Node(sym.ActionChannel)
    server = Node(sym.ActionServerPort, channel=action)
    slot = Index(upto=slots(action))
    page = Made(A6.page, of=[action, slot])
    called = Node(sym.ServiceChannel)
    original = Node(sym.ClientPort, channel=called)
    around = Node(pn.Page, of=enclosing(original.request, pn.Page))

    client = copied_client("{action.id}[{slot}]", called, original, page)

    where = [around == server.page]


class SlotPage(Slot):
    """A slot of an action, with its copy of the server's page."""

    def __init__(self, upto: Expression | int | None = None) -> None:
        super().__init__(upto)
        self.page = Made(A6.page, of=[self.action, self.slot])


class SlotCallback(SlotPage):
    """A slot whose copy of the page is a callback page."""

    def __init__(self, upto: Expression | int | None = None) -> None:
        super().__init__(upto)
        self.callback = Node(sym.CallbackPage, of=self.page)


class A7(StandardRule, phase=Phase.goals):
    """Whether a slot works on a goal."""

    served = Slot()

    idle = place(
        "{action.id}[{slot}].idle",
        tokens=1,
        means=Meaning("slot {instance} of action {action} is idle", part="idle slot", rests=True),
    )
    executing = place(
        "{action.id}[{slot}].executing",
        means=Meaning("slot {instance} of action {action} is executing a goal", part="executing"),
    )


class A7Ask(StandardRule, phase=Phase.goals):
    """Whether a request to cancel the goal of a slot is under way, if a client may ask."""

    served = Slot()

    asked = place(
        "{action.id}[{slot}].asked",
        means=Meaning(
            "request to cancel the goal in slot {instance} of action {action} under way", part="asked"
        ),
    )

    where = [asking(served.action)]


class A7Cancel(StandardRule, phase=Phase.goals):
    """Whether the goal of a slot is to be canceled, if the server allows that; the server learns it once."""

    served = SlotPage()
    noted = Node(pn.Place, of=image(served.action.server.cancel, served.page))

    canceling = place(
        "{action.id}[{slot}].canceling",
        means=Meaning("the goal in slot {instance} of action {action} is to be canceled", part="canceling"),
    )
    bound = Bound(
        noted,
        1,
        means=Meaning("no request to cancel is pending in slot {instance} of action {action}", rests=True),
    )

    where = [asking(served.action)]
