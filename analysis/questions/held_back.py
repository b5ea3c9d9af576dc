"""Goals that wait for a slot in the analysis but not in `rclpy`, and the answers that depend on this.

A server of `rclpy` or `rclcpp` accepts each goal. In the analysis, an action executes at most as many goals
at once as it has slots. Both agree if the action states its number of goals, if its clients wait, or if each
thread of its server has a slot. Otherwise the number of slots is an assumption, unless no reachable marking
has a waiting goal while all slots are busy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.stages import Share
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import Name
from dineros.analysis.model.subject import Subject
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.under_way import Slots, free_slots, goal_counts

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link

SHARE = Share(time=0.1, seconds_if_unlimited=5.0)
"""Share of the remaining time for the search for such a marking."""


@dataclass(frozen=True)
class HeldBack:
    """An action whose goals may wait because of its number of slots."""

    slots: Slots

    @property
    def words(self) -> str:
        """Return the name of the action."""
        return f"action {self.slots.action.action}"

    @property
    def assumption(self) -> str:
        """Return the assumption of the answers."""
        number = self.slots.number
        return f"{self.words} works on at most {number} goal{'s' if number > 1 else ''} at once"


def held_back(subject: Subject, budget: Budget) -> list[HeldBack]:
    """Return the actions with a reachable marking in which a goal waits because all slots are busy.

    Actions for which this is not decided in time are included. Firing intervals are ignored, which is safe:
    they only exclude markings.

    Parameters
    ----------
    budget : Budget
        Time and memory; a share of it is used.
    """
    model = subject.model
    if not isinstance(model, sym.SystemModel):
        return []
    found = []
    for slots in free_slots(model, goal_counts(model)):
        if slots.is_enough:
            continue
        from dineros.analysis.portfolio.asking import find_marking

        share = SHARE.share(budget)
        try:
            answer = find_marking(subject.net, _full(subject, slots), NetNames(subject.net), share)
        except BudgetExceededError:
            found.append(HeldBack(slots))
            continue
        if answer.status != "unreachable":
            found.append(HeldBack(slots))
    return found


def _full(subject: Subject, slots: Slots) -> str:
    """Return the condition that a goal waits while all slots are busy."""
    places = [
        link for link in subject.links() if slots.action in link.sources and isinstance(link.target, pn.Place)
    ]
    load = next(link for link in places if _is(link, "load", "goal"))
    idle = [link for link in places if _is(link, "idle slot")]
    busy = " and ".join(f"{Name(str(link.target.id))} == 0" for link in idle)
    return f"{Name(str(load.target.id))} >= 1 and {busy}"


def _is(link: Link, part: str, queue: str | None = None) -> bool:
    return link.meaning is not None and (link.meaning.part, link.meaning.queue) == (part, queue)
