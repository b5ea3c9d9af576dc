"""Answers to the question whether a goal is reached."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Answer:
    """How a goal is reached.

    Attributes
    ----------
    status : {"reachable", "unreachable", "unknown"}
    trace : tuple of int or None
        Transitions from the initial marking to the goal, replayed by the plain firing rule; where a
        transition is to be enabled, that transition comes last.
    states : int or None
        Markings visited; None where the search stopped at the goal.
    reason : str
        Why the answer is unknown.
    """

    status: Literal["reachable", "unreachable", "unknown"]
    trace: tuple[int, ...] | None = None
    states: int | None = None
    reason: str = ""
