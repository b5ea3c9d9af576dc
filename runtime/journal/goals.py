"""The goals of a node's actions, rebuilt from its records."""

from __future__ import annotations

from typing import Any, cast

from dineros.metamodel.records import (
    Accept,
    Accepted,
    Cancel,
    Canceling,
    Checkpoint,
    Data,
    Feedback,
    Finish,
    Goal,
    Hear,
    Outcome,
    Reject,
    TooLate,
)
from dineros.runtime.journal.saved import GoalResult, GoalState, PendingGoal, SlotGoal

FEEDBACK_DEPTH = 10
"""How much feedback of a goal is kept where no checkpoint says so."""

KEPT_RESULTS = 64
"""Results of an action that are kept, at most, for clients that ask for them later."""


class Goals:
    """What the records so far leave the goals of a node in.

    Attributes
    ----------
    pending : dict
        ``CHANNEL/CLIENT`` -> goal -> what its client knows.
    slots : dict
        Entry place -> the goal that the slot works on.
    results : dict
        Channel -> goal -> its outcome.
    """

    def __init__(self) -> None:
        self.pending: dict[str, dict[str, PendingGoal]] = {}
        self.slots: dict[str, SlotGoal] = {}
        self.results: dict[str, dict[str, GoalResult]] = {}

    def begin(self, record: Checkpoint) -> None:
        """Take over what a checkpoint says."""
        self.pending = {
            key: {goal["message"]: dict(goal) for goal in goals}  # type: ignore[misc]
            for key, goals in record.goals.items()
        }
        self.slots = cast("Any", {entry: dict(slot) for entry, slot in record.slots.items()})
        self.results = cast("Any", {channel: dict(kept) for channel, kept in record.results.items()})

    def save(self) -> GoalState:
        """Return them."""
        return {
            "goals": {key: list(goals.values()) for key, goals in self.pending.items() if goals},
            "slots": {entry: slot.copy() for entry, slot in self.slots.items()},
            "results": {channel: dict(kept) for channel, kept in self.results.items() if kept},
        }

    # What a client does.

    def sent(self, record: Goal, data: Data) -> None:
        """A goal is sent."""
        goal = PendingGoal(
            message=record.message or "", data=data, accepted=False, canceled=False, heard=0, attempts=1
        )
        self._pending(record)[goal["message"]] = goal

    def failed(self, key: str, message: str, attempt: int) -> None:
        """A goal is not answered, and is sent again."""
        if (goal := self.pending.get(key, {}).get(message)) is not None:
            goal["attempts"] = attempt + 1

    def told(self, record: Accepted | Cancel | TooLate) -> None:
        """A client learns that a goal is accepted or not canceled, or asks to cancel it."""
        goal = self._pending(record).get(record.message or "")
        if goal is None:
            return
        if isinstance(record, Accepted):
            goal["accepted"] = True
        else:
            goal["canceled"] = isinstance(record, Cancel)

    def heard(self, record: Hear) -> None:
        """Feedback comes."""
        goal = self._pending(record).get(record.message or "")
        if goal is not None and record.number:
            goal["heard"] = record.number

    def over(self, record: Reject | Outcome) -> None:
        """A goal has ended, for its client."""
        self._pending(record).pop(record.message or "", None)

    def _pending(self, record: Any) -> dict[str, PendingGoal]:
        return self.pending.setdefault(f"{record.channel}/{record.client}", {})

    # What a server does.

    def accepted(self, record: Accept) -> None:
        """A slot begins to work on a goal."""
        self.slots[record.place or ""] = SlotGoal(
            message=record.message or "",
            data=record.data,
            canceling=False,
            sent=0,
            feedback=[],
            depth=FEEDBACK_DEPTH,
        )

    def _slot(self, message: str | None) -> tuple[str, SlotGoal] | None:
        return next(((at, slot) for at, slot in self.slots.items() if slot["message"] == message), None)

    def canceling(self, record: Canceling) -> None:
        """A goal is to be canceled."""
        if (known := self._slot(record.message)) is not None:
            known[1]["canceling"] = True

    def gave(self, record: Feedback, data: Data) -> None:
        """Feedback on a goal is sent."""
        if (known := self._slot(record.message)) is not None:
            slot = known[1]
            slot["sent"] = record.number
            slot["feedback"] = [*slot["feedback"], [record.number, data]][-slot["depth"] :]

    def finished(self, record: Finish, data: Data) -> bool:
        """Note that a goal ends; False: no slot works on it."""
        known = self._slot(record.message)
        if known is None:
            return False
        del self.slots[known[0]]
        kept = self.results.setdefault(record.channel, {})
        kept[record.message or ""] = {"outcome": record.outcome, "data": data}
        while len(kept) > KEPT_RESULTS:
            del kept[next(iter(kept))]
        return True
