"""The goals of a node's actions, rebuilt from its records."""

from __future__ import annotations

from typing import Any, cast

from dineros.metamodel.records import Checkpoint, Data
from dineros.runtime.journal.saved import GoalResult, GoalState, PendingGoal, SlotGoal

FEEDBACK_DEPTH = 10
"""Number of feedback messages kept for a goal if no checkpoint gives it."""

KEPT_RESULTS = 64
"""Maximum number of results of an action kept for clients that ask for them later."""


class Goals:
    """The state of a node's goals after the records so far.

    Attributes
    ----------
    pending : dict
        ``CHANNEL/CLIENT`` -> goal -> the state that its client knows.
    slots : dict
        Entry place -> the goal that the slot executes.
    results : dict
        Channel -> goal -> its outcome.
    """

    def __init__(self) -> None:
        self.pending: dict[str, dict[str, PendingGoal]] = {}
        self.slots: dict[str, SlotGoal] = {}
        self.results: dict[str, dict[str, GoalResult]] = {}

    def begin(self, record: Checkpoint) -> None:
        """Take over the goals of a checkpoint."""
        self.pending = {
            key: {goal["message"]: dict(goal) for goal in goals}  # type: ignore[misc]
            for key, goals in record.goals.items()
        }
        self.slots = cast("Any", {entry: dict(slot) for entry, slot in record.slots.items()})
        self.results = cast("Any", {channel: dict(kept) for channel, kept in record.results.items()})

    def save(self) -> GoalState:
        """Return the state of the goals."""
        return {
            "goals": {key: list(goals.values()) for key, goals in self.pending.items() if goals},
            "slots": {entry: slot.copy() for entry, slot in self.slots.items()},
            "results": {channel: dict(kept) for channel, kept in self.results.items() if kept},
        }

    def happen(self, record: Any, data: Data) -> bool:
        """Apply a step of a goal, as its kind declares it; False: a goal ends that no slot executes.

        Parameters
        ----------
        record : GoalStep or TooLate
            The step.
        data : dict
            Data of the token that leaves its place, if one does.
        """
        id, key = record.message or "", f"{record.channel}/{record.client}"
        goal = self.pending.get(key, {}).get(id)
        entry = next((entry for entry, slot in self.slots.items() if slot["message"] == record.message), None)
        slot = None if entry is None else self.slots[entry]
        match record.declared.goal:
            case "is sent":
                self.pending.setdefault(key, {})[id] = PendingGoal(
                    message=id, data=data, accepted=False, canceled=False, heard=0, attempts=1
                )
            case "is known to be accepted" if goal is not None:
                goal["accepted"] = True
            case ("is asked to cancel" | "is not canceled") as change if goal is not None:
                goal["canceled"] = change == "is asked to cancel"
            case "has its feedback heard" if goal is not None and record.number:
                goal["heard"] = record.number
            case "is known to be rejected" | "is known to have ended":
                self.pending.get(key, {}).pop(id, None)
            case "is accepted":
                self.slots[record.place or ""] = SlotGoal(
                    message=id, data=record.data, canceling=False, sent=0, feedback=[], depth=FEEDBACK_DEPTH
                )
            case "is to be canceled" if slot is not None:
                slot["canceling"] = True
            case "gives feedback" if slot is not None:
                slot["sent"] = record.number
                slot["feedback"] = [*slot["feedback"], [record.number, data]][-slot["depth"] :]
            case "ends":
                return self._end(record, entry, data)
        return True

    def _end(self, record: Any, entry: str | None, data: Data) -> bool:
        if entry is None:
            return False
        del self.slots[entry]
        kept = self.results.setdefault(record.channel, {})
        kept[record.message or ""] = {"outcome": record.outcome, "data": data}
        while len(kept) > KEPT_RESULTS:
            del kept[next(iter(kept))]
        return True

    def failed(self, key: str, message: str, attempt: int) -> None:
        """Count an attempt of a goal that was not answered and is sent again."""
        if (goal := self.pending.get(key, {}).get(message)) is not None:
            goal["attempts"] = attempt + 1
