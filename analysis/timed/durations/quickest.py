"""The quickest way to a marking or a firing: the least total time that any run takes.

The least time is a multiple of the unit of time, or comes as near to one as wanted if an open bound keeps it
from being one: the bounds of a firing sequence are differences in whole units. So a few questions decide it:
can the goal be reached before a moment? An observer stops the net at that moment. Each way that is found has
its own least time (`schedules`), which bounds the answer from above.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.timed.durations.watched import GATE, Watched, Watcher, watched
from dineros.analysis.timed.goals import find_timed, find_timed_firing
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.schedules import schedule


@dataclass(frozen=True)
class Quickest:
    """The answer.

    Attributes
    ----------
    outcome : Outcome
        ``reachable`` with a way, ``unreachable`` or ``unknown``.
    time : Fraction or None
        No way takes less time; None without a way.
    is_attained : bool
        Whether the way takes just so long. If not, open bounds keep ways from it, and come as near as wanted.
    is_least : bool
        Whether it is proved that no way is quicker.
    """

    outcome: Outcome
    time: Fraction | None = None
    is_attained: bool = True
    is_least: bool = True

    def __str__(self) -> str:
        if self.time is None:
            return ""
        if not self.is_least:
            return (
                f"this firing sequence takes {self.time}; "
                f"it is unknown whether another is quicker: {self.outcome.reason}"
            )
        if self.is_attained:
            return f"the quickest firing sequence takes {self.time}"
        return f"every firing sequence takes more than {self.time}, and some take arbitrarily little more"

    def to_dict(self) -> dict[str, object]:
        """Return it for JSON."""
        time = None if self.time is None else str(self.time)
        return {"time": time, "attained": self.is_attained, "least": self.is_least}


Ask = Callable[[TimedNet, TimedNet | None, Budget], Outcome]
"""Finds a firing sequence in a net, which may have a second observer."""


def quickest_marking(
    net: TimedNet, condition: str, names: Names | None = None, budget: Budget = UNLIMITED
) -> Quickest:
    """Find the quickest way to a marking; see `find_timed`."""
    named = names or NetNames(net.untimed)
    return _quickest(
        net, lambda asked, observed, share: find_timed(asked, condition, named, share, observed), budget
    )


def quickest_firing(
    net: TimedNet, transition: str, names: Names | None = None, budget: Budget = UNLIMITED
) -> Quickest:
    """Find the quickest way that ends with the firing of a transition; see `find_timed_firing`."""
    named = names or NetNames(net.untimed)
    return _quickest(net, lambda asked, _, share: find_timed_firing(asked, transition, named, share), budget)


def _quickest(net: TimedNet, ask: Ask, budget: Budget) -> Quickest:
    budget = budget.begun()
    best = ask(net, None, budget)
    if best.trace is None:
        return Quickest(best)
    time, is_attained = least_time(net, best.trace)
    unit, states = net.unit, best.states or 0
    least = Fraction(0)
    while (time, not is_attained) > (least, False):
        # No way is quicker than `least`, which is a multiple of the unit.
        middle = least + (time - least) / unit // 2 * unit
        is_last = time == least
        moment = least if is_last else middle + unit / 2 if middle < time else least + unit / 2
        stopped = _stopped_after(net, moment)
        found = ask(stopped.net, net, budget)
        states = max(states, found.states or 0)
        if found.status == "unknown":
            return Quickest(replace(best, states=states, reason=found.reason), time, is_attained, False)
        if found.trace is not None:
            trace = stopped.trace_of(found.trace)
            better, attains = least_time(net, trace)
            assert (better, not attains) < (time, not is_attained), "it is before the moment"
            best, time, is_attained = replace(best, trace=trace), better, attains
        elif is_last:
            break
        else:
            least = (moment // unit + 1) * unit
    return Quickest(replace(best, states=states, seconds=budget.spent), time, is_attained)


def least_time(net: TimedNet, trace: tuple[int, ...]) -> tuple[Fraction, bool]:
    """Return the least time that a firing sequence takes, and whether it can take just so long."""
    if not trace:
        return Fraction(0), True
    last = schedule(net, trace)[-1]
    return last.earliest, last.at == last.earliest


def _stopped_after(net: TimedNet, moment: Fraction) -> Watched:
    """Return a net that stops at a moment, after what happens at that moment or before it."""
    return watched(net, {}, [Watcher("stop", Interval(moment, moment), takes=(GATE,))])
