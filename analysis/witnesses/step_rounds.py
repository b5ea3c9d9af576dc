"""The steps of a run as they are printed: rounds that repeat are listed once.

With times, a round repeats if each of its steps fires later by the same time in every round. Two parts of a
system with different periods have different ones.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from math import nan

import numpy as np

from dineros.analysis.model.subject import FiringTime
from dineros.analysis.witnesses.folding import Block, folded

DIGITS = 9
"""Digits of differences of times that are compared: sums of decimal fractions are not exact."""

LEAST_ROUNDS, MOST_DIFFERENCES = 3, 4
"""Rounds, at least, whose steps fire later by different times, and how many such times, at most."""

Times = Sequence[FiringTime | None]


@dataclass(frozen=True)
class StepRound:
    """Steps that come several times in a row, or one step."""

    first: int
    """Number of the first step; the first one of all is 1."""
    steps: tuple[str, ...]
    """Those of the first round, in words, each with its time if it has one."""
    times: int
    """How often they come in a row."""
    later: str = ""
    """With times: how much later they fire each time, in words."""

    @property
    def last(self) -> int:
        """Number of the last step of the last round."""
        return self.first + len(self.steps) * self.times - 1

    @property
    def heading(self) -> str:
        """The line above repeated steps."""
        what = "the next step" if len(self.steps) == 1 else f"the next {len(self.steps)} steps"
        later = f", {self.later} later each time" if self.later else ""
        return f"{what} {self.times} times{later}, up to step {self.last}:"


def step_rounds(texts: Sequence[str], times: Times = (), before: int = 0) -> list[StepRound]:
    """Return the steps of a run in rounds.

    Parameters
    ----------
    texts : sequence of str
        What the steps are, in words.
    times : sequence of FiringTime or None
        When they fire; empty if the net has no times.
    before : int
        How many steps have been before.

    Examples
    --------
    >>> times = [FiringTime(at, at, at) for at in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)]
    >>> [found] = step_rounds(["tick"] * 6, times)
    >>> found.heading, found.steps
    ('the next step 6 times, 0.1 later each time, up to step 6:', ('tick, at 0.1',))
    """
    times = times or [None] * len(texts)
    shown = [text if at is None else f"{text}, {at}" for text, at in zip(texts, times, strict=True)]
    found = []
    for block in _blocks(texts, times):
        end = block.start + block.length
        steps, later = shown[block.start : end], ""
        if block.times > 1:
            each = [_later(times[at], times[at + block.length]) for at in range(block.start, end)]
            if len(set(each)) == 1:
                later = each[0]
            else:
                steps = [f"{step}, {after} later each time" for step, after in zip(steps, each, strict=True)]
        found.append(StepRound(before + block.start + 1, tuple(steps), block.times, later))
    return found


def _blocks(texts: Sequence[str], times: Times) -> list[Block]:
    """Return the rounds, in each of which steps fire as much later, or a few as much more than others."""
    values = np.array([_numbers(at) for at in times], dtype=np.float64).reshape(len(texts), 3)
    keys, found = _keys(texts, times), []
    for block in folded(texts, values):
        start, length, end = block.start, block.length, block.start + block.length * block.times
        later = (values[start + length : end] - values[start : end - length]).round(DIGITS)
        differences = len(np.unique(later, axis=0))
        if differences <= 1 or (block.times >= LEAST_ROUNDS and differences <= MOST_DIFFERENCES):
            found.append(block)
        else:
            found += [replace(part, start=start + part.start) for part in folded(keys[start:end])]
    return found


def _numbers(time: FiringTime | None) -> tuple[float, float, float]:
    """Return the numbers of a time, without the latest one if it is missing."""
    if time is None:
        return 0.0, 0.0, 0.0
    return time.at, time.earliest, nan if time.latest is None else time.latest


def _keys(texts: Sequence[str], times: Times) -> list[Hashable]:
    """Return, by step, what is equal in steps of which one is the other one, later."""
    keys: list[Hashable] = []
    for number, (text, at) in enumerate(zip(texts, times, strict=True)):
        earlier = times[number - 1] if number else FiringTime(0, 0, 0)
        keys.append((text, None if at is None or earlier is None else _difference(earlier, at)))
    return keys


def _difference(one: FiringTime, other: FiringTime) -> tuple[float | None, ...]:
    """Return how much later a step fires: in the schedule, at the earliest, and at the latest."""
    latest = None if one.latest is None or other.latest is None else other.latest - one.latest
    differences = (other.at - one.at, other.earliest - one.earliest, latest)
    return tuple(None if each is None else round(each, DIGITS) for each in differences)


def _later(one: FiringTime | None, other: FiringTime | None) -> str:
    if one is None or other is None:
        return ""
    at, earliest, latest = _difference(one, other)
    if at == earliest == 0 and latest in (0, None):
        return ""
    text = f"{at:g}"
    if earliest == at and latest in (at, None):
        return text
    most = "" if latest is None else f", the latest {latest:g}"
    return f"{text} (the earliest time {earliest:g}{most})"
