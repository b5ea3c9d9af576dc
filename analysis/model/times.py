"""Firing intervals, which the engines leave out, and which answers hold all the same.

With times a net has some of its runs only (Merlin's time Petri nets): a transition with a latest time can
force others to wait. So the markings with times are some of those without, and each of them enables the same.
A property of all markings or runs of the net without times holds with times, too; a run without times may be
impossible with times. If no interval has a latest time, nothing is ever forced: each run is possible with
times if it waits long enough.

References
----------
P. Merlin, D. Farber, *Recoverability of communication protocols*, IEEE Trans. Communications 24(9), 1976.
"""

from __future__ import annotations

from dataclasses import dataclass

from dineros.analysis.logic.language.syntax import (
    Equivalent,
    Exists,
    ForAll,
    Formula,
    Implies,
    Not,
)
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.elements import label, pages, transitions
from dineros.metamodel.errors import counted
from dineros.metamodel.files.exact import exact_text, fraction_of

_OF_CHECK = (
    "proofs that something never happens, boundedness and the absence of deadlocks also hold with times; "
    "deadlocks, unbounded places, violated properties and possible firings may not"
)
_ALL_ANSWERS = "no interval has a latest time, so all answers also hold with times"
_OF_COUNTS = (
    "with times there may be fewer markings, arcs and deadlocks, and an unbounded net may be bounded; "
    "bounds hold"
)
_ALL_MARKINGS = "no interval has a latest time, so the markings are those with times"


@dataclass(frozen=True)
class LeftOutTimes:
    """Times of a net that its analysis does not know: firing intervals, or those of nodes and channels."""

    count: int
    """How many transitions have an interval that says something; of other times: how many are declared."""
    example: str
    changes_runs: bool
    """Whether some interval has a latest time; if none has, all answers hold with times."""
    is_of_transitions: bool = True
    """Whether they are firing intervals."""

    def survives(self, is_universal: bool) -> bool:
        """Return whether an answer holds with times; `is_universal` if it is about all runs without them."""
        return is_universal or not self.changes_runs

    @property
    def of_check(self) -> str:
        """Its effect on the findings and proofs of a check."""
        return _OF_CHECK if self.changes_runs else _ALL_ANSWERS

    @property
    def of_counts(self) -> str:
        """Its effect on the figures of a state space."""
        return _OF_COUNTS if self.changes_runs else _ALL_MARKINGS

    def __str__(self) -> str:
        if not self.is_of_transitions:
            return (
                f"the times that the model declares are ignored ({self.count}, such as {self.example};"
                " --time takes them into account)"
            )
        return f"firing intervals are ignored ({counted(self.count, 'transition')}, such as {self.example})"


@dataclass(frozen=True)
class UsedTimes:
    """Firing intervals that an answer takes into account."""

    count: int
    """How many transitions of the net have an interval that says something; 0 if only priorities count."""
    example: str
    unit: str
    """The length of time of which every bound is a multiple."""

    def __str__(self) -> str:
        if not self.count:
            return "priorities are taken into account (no transition has a firing interval)"
        many = f"{counted(self.count, 'transition')}, such as {self.example}, unit {self.unit}"
        return f"firing intervals are taken into account ({many})"

    def to_dict(self) -> dict[str, object]:
        """Return them for JSON."""
        return {"taken_into_account": str(self), "transitions": self.count, "unit": self.unit}


def left_out_times(net: pn.Net) -> LeftOutTimes | None:
    """Return the intervals that are left out; None if the net has no times.

    That is so for a net without intervals, and for a system model whose intervals have no latest time.
    """
    timed = [
        (transition, interval)
        for transition in transitions(net)
        if (interval := transition.interval) is not None and _says_something(interval)
    ]
    bounded = [pair for pair in timed if pair[1].latest is not None]
    if isinstance(net, sym.SystemModel) and not bounded:
        return _declared(net)
    if not timed:
        return None
    transition, interval = (bounded or timed)[0]
    return LeftOutTimes(len(timed), f"{transition.id} {_text(interval)}", bool(bounded))


def _declared(model: sym.SystemModel) -> LeftOutTimes | None:
    """Return the latest times that a model of ROS 2 declares for callbacks, messages and engines."""
    if model.middleware != sym.Middleware.ros2:
        return None
    owners: list[tuple[str, EObject]] = [("", model.times)] if model.times is not None else []
    owners += [(f" of {label(page)}", page) for page in pages(model)]
    for channel in model.channels:
        owners += [(f" of {label(channel)}", each) for each in (channel, *channel.eContents)]
    found = [
        (f"{name}{whose} {_text(interval)}", interval)
        for whose, owner in owners
        for name in ("duration", "latency", "reaction")
        if (interval := getattr(owner, name, None)) is not None and interval.latest is not None
    ]
    return LeftOutTimes(len(found), found[0][0], True, is_of_transitions=False) if found else None


def _says_something(interval: pn.TimeInterval) -> bool:
    return interval.latest is not None or interval.earliest > 0 or bool(interval.earliestExcluded)


def _text(interval: pn.TimeInterval) -> str:
    start = "]" if interval.earliestExcluded else "["
    if interval.latest is None:
        return f"{start}{exact_text(fraction_of(interval.earliest))},w["
    end = "[" if interval.latestExcluded else "]"
    earliest, latest = (exact_text(fraction_of(bound)) for bound in (interval.earliest, interval.latest))
    return f"{start}{earliest},{latest}{end}"


def is_of_all_runs(formula: Formula, value: bool) -> bool:
    """Return whether a verdict on a formula of branching time stays if runs are taken away.

    That is so if the formula holds and quantifies over all paths only, or is violated and quantifies over
    some path only; negations turn one into the other.
    """
    todo, seen = [(formula, value)], set()
    while todo:
        part, is_positive = todo.pop()
        if (part, is_positive) in seen:
            continue
        seen.add((part, is_positive))
        if isinstance(part, (Exists if is_positive else ForAll)):
            return False
        if isinstance(part, Not):
            todo.append((part.operands[0], not is_positive))
        elif isinstance(part, Implies):
            todo += [(part.operands[0], not is_positive), (part.operands[1], is_positive)]
        elif isinstance(part, Equivalent):
            todo += [(operand, sign) for operand in part.operands for sign in (True, False)]
        else:
            todo += [(operand, is_positive) for operand in part.operands]
    return True
