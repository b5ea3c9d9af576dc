"""What is answered, whatever was asked and whoever answers."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.analysis.answers.evidence import Evidence

FiredAt = tuple[float, float, float | None]
"""When a transition fires: in the schedule that is shown, and at the earliest and at the latest."""


@dataclass(frozen=True)
class Outcome:
    """The answer to a question.

    Attributes
    ----------
    status : str
        ``unknown``, or what answers the question: ``reachable`` or ``unreachable`` for a goal, ``holds`` or
        ``violated`` for a formula, ``conforms`` or ``violated`` for the traces of a run.
    trace : tuple of int or None
        Transitions from the initial marking on that show it, replayed by the plain firing rule; None without.
    loop : tuple of int
        Transitions fired again and again after these. Empty when what shows it is a finite path, and when the
        run ends in a deadlock, where it stays forever.
    ends_at_fault : bool
        Whether the trace violates the formula whatever follows it; then there is no loop.
    states : int or None
        States stored to find the answer; None where they say nothing.
    seconds : float
        Wall-clock time.
    reason : str
        Why the answer is unknown, what the trace shows, or why there is none though there could be.
    question : str
        What is not known, in a report of many questions.
    hint : str
        What decides it, where that is known.
    may_be_fault : bool
        Whether an unknown answer might be an error or a warning, or was asked for; else it might be a note at
        worst.
    by : str
        Who answered, in words: ``state equation``, ``explicit search`` ...
    times : tuple of FiredAt
        Of the trace, where only some of its schedules show the answer; empty where all do.
    evidence : Evidence or None
        What the answer rests on, where no state space was looked at.
    """

    status: str
    trace: tuple[int, ...] | None = None
    loop: tuple[int, ...] = ()
    states: int | None = None
    seconds: float = 0.0
    reason: str = ""
    question: str = ""
    hint: str = ""
    may_be_fault: bool = True
    by: str = ""
    evidence: Evidence | None = None
    ends_at_fault: bool = False
    times: tuple[FiredAt, ...] = ()

    @classmethod
    def left_open(cls, question: str, reason: str, hint: str = "", may_be_fault: bool = True) -> Outcome:
        """Return a question of a report that was not decided."""
        return cls("unknown", question=question, reason=reason, hint=hint, may_be_fault=may_be_fault)

    @property
    def stem(self) -> tuple[int, ...]:
        """The trace, as the part of a run before its loop; empty without one."""
        return self.trace or ()

    def __str__(self) -> str:
        return f"{self.question}: {self.reason}{f' ({self.hint})' if self.hint else ''}"
