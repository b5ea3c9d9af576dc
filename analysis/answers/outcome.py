"""The outcome of any question, by any engine."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.analysis.answers.evidence import Evidence

FiredAt = tuple[float, float, float | None]
"""When a transition fires: in the schedule that is shown, and its earliest and latest time."""


@dataclass(frozen=True)
class Outcome:
    """The answer to a question.

    Attributes
    ----------
    status : str
        ``unknown``, or the answer: ``reachable`` or ``unreachable`` for a goal, ``holds`` or ``violated`` for
        a formula, ``conforms`` or ``violated`` for the traces of a run.
    trace : tuple of int or None
        Transitions from the initial marking that show the answer, replayed by the firing rule; None: no
        trace.
    loop : tuple of int
        Transitions fired repeatedly after the trace. Empty if a finite path shows the answer, or if the run
        ends in a deadlock.
    ends_at_fault : bool
        Whether every continuation of the trace violates the formula. Then `loop` is empty.
    states : int or None
        Number of states stored to find the answer; None if it is not meaningful.
    seconds : float
        Wall-clock time.
    reason : str
        Why the answer is unknown, what the trace shows, or why a possible trace is missing.
    question : str
        The undecided question, in a report of many questions.
    hint : str
        How to decide it, if that is known.
    may_be_fault : bool
        Whether an unknown answer may hide an error or a warning, or was requested; else it could only be a
        note.
    elements : tuple of str
        Ids of the elements that an undecided question is about, in a report of many questions.
    rule : str
        Id of the rule that an undecided question in a report may break, where there is one.
    by : str
        The method that answered, as text: ``state equation``, ``explicit search`` ...
    times : tuple of FiredAt
        Times of the trace, if only some of its schedules show the answer; empty if all do.
    evidence : Evidence or None
        The evidence, if no state space was used.
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
    elements: tuple[str, ...] = ()
    rule: str = ""

    @classmethod
    def left_open(cls, question: str, reason: str, hint: str = "", may_be_fault: bool = True) -> Outcome:
        """Return the outcome of an undecided question in a report."""
        return cls("unknown", question=question, reason=reason, hint=hint, may_be_fault=may_be_fault)

    @property
    def stem(self) -> tuple[int, ...]:
        """The trace, as the part of a run before its loop; empty without a trace."""
        return self.trace or ()

    def __str__(self) -> str:
        return f"{self.question}: {self.reason}{f' ({self.hint})' if self.hint else ''}"
