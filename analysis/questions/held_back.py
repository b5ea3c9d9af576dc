"""Goals that the rules hold back, and the answers that rest on that.

The rules let a client of an action have `outstanding` goals under way, one by default. `rclpy` and `rclcpp`
have no such bound: a client that asks for another goal sends it. Both agree unless a goal is asked for while
the client has its greatest number under way. If no such marking can be reached, the bound changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import Name
from dineros.analysis.model.subject import Subject
from dineros.analysis.portfolio.asking import find_marking
from dineros.metamodel import sym
from dineros.metamodel.callbacks.waiting import held_back_clients

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link

SHARE = 0.1
"""Part of the time that is left in which such a marking is searched."""
LEAST_SECONDS = 5.0
"""Seconds of that search without a limit of time."""


@dataclass(frozen=True)
class HeldBack:
    """A client of an action whose goals the rules may hold back.

    Attributes
    ----------
    port : sym.ActionClientPort
        The client.
    """

    port: sym.ActionClientPort

    @property
    def words(self) -> str:
        """Name the client and its action."""
        assert self.port.channel is not None
        return f"client {self.port.client} of action {self.port.channel.action}"

    @property
    def assumption(self) -> str:
        """State what the answers assume."""
        return f"{self.words} sends a goal only if its last one is over"


def held_back(subject: Subject, budget: Budget) -> list[HeldBack]:
    """Return the clients of actions whose goals the rules hold back in some reachable marking.

    A client for which that is not decided in time is among them. Firing intervals are left out, which is
    safe: with them, no other marking is reached.

    Parameters
    ----------
    subject : Subject
        The net.
    budget : Budget
        Time and memory; a part of it is spent.
    """
    if not isinstance(subject.model, sym.SystemModel):
        return []
    found = []
    for port in held_back_clients(subject.model):
        share = budget.share(SHARE) if budget.left is not None else budget.at_most(LEAST_SECONDS)
        try:
            answer = find_marking(subject.net, _full(subject, port), NetNames(subject.net), share)
        except BudgetExceededError:
            found.append(HeldBack(port))
            continue
        if answer.status != "unreachable":
            found.append(HeldBack(port))
    return found


def _full(subject: Subject, port: sym.ActionClientPort) -> str:
    """Return the condition that a goal waits while its client has the greatest number under way."""
    (ready,) = (link.target.id for link in subject.links() if port in link.sources and _is_ready(link))
    return f"{Name(str(port.goal.id))} >= 1 and {Name(str(ready))} == 0"


def _is_ready(link: Link) -> bool:
    return link.meaning is not None and link.meaning.part == "ready"
