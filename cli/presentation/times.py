"""What is said of firing intervals that an analysis leaves out, as text and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.cli.console import say

if TYPE_CHECKING:
    from dineros.analysis.model.times import LeftOutTimes

HOLDS = "this answer holds with times, too"
NEED_NOT_HOLD = "with times this answer need not hold: the run may be impossible"


def say_times(times: LeftOutTimes | None, text: str) -> None:
    """Print that times are left out, and what that means; nothing for a net without."""
    if times is not None:
        say(f"note: {times}; {text}")


def answer_and_times(times: LeftOutTimes, is_universal: bool) -> str:
    """Return whether an answer holds with times, in words."""
    return HOLDS if times.survives(is_universal) else NEED_NOT_HOLD


def times_fields(times: LeftOutTimes | None, is_universal: bool | None) -> dict[str, object]:
    """Return for JSON that times are left out, and whether the answer holds with them; nothing for others."""
    if times is None:
        return {}
    holds = None if is_universal is None else times.survives(is_universal)
    return {"times": {"left_out": str(times), "transitions": times.count, "holds_with_times": holds}}
