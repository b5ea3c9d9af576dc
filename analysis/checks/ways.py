"""Runs that show a finding: one that ends with a firing, and one in which goals overtake each other."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Sequence
from typing import TypeAlias

from dineros.analysis.checks.question import OUT_OF_MEMORY, Checked
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.witnesses.witness import Witness, witness_of_firing

TOO_LONG = "the run that leads to it is too long to be shown"

MOST = 50_000
"""Markings among which a run is searched in which goals overtake each other."""


def can_fire(checked: Checked, transitions: Sequence[str]) -> bool | None:
    """Return whether one of some transitions can fire; None: unknown."""
    known, index = checked.firings, checked.subject.transition_index
    if known is None:
        return any(checked.space.enabled(each) for each in transitions)
    numbers = [index[each] for each in transitions]
    if not known.traces.keys().isdisjoint(numbers) or not known.possible.isdisjoint(numbers):
        return True
    return False if known.dead.issuperset(numbers) else None


def firing_witness(checked: Checked, transitions: Sequence[str]) -> Witness | None:
    """Return a sequence that ends with one of some transitions, which can fire; a shortest one if it is near.

    A farther goal is searched for if the state equation estimates that it is near; if that search gives up,
    the state space gives the way. None stands for memory that runs out, or for a sequence with times that is
    too long to be shown.
    """
    if not checked.is_shown:
        return Witness(())
    # Most models need no search.
    from dineros.analysis.portfolio.asking import find_firing
    from dineros.analysis.portfolio.plans import WITNESS

    subject, known = checked.subject, checked.firings
    numbers = [subject.transition_index[each] for each in transitions]
    if known is None:
        number = next(each for each in numbers if checked.space.enabled(subject.net.transitions[each]))
    elif not known.traces.keys().isdisjoint(numbers):
        return witness_of_firing(subject, known.way_to(numbers), checked.rounds_tried)
    elif subject.is_timed:
        return None  # a sequence of the net without its times may have no schedule
    else:
        number = next(each for each in numbers if each in known.possible)
    trace = find_firing(subject.net, number, checked.budget, WITNESS).trace
    if trace is None:
        checked.budget.check_time()
        return None
    return witness_of_firing(subject, trace, checked.rounds_tried)


def why_unseen(checked: Checked) -> str:
    """Return why a finding has no firing sequence as witness; see `firing_witness`."""
    return TOO_LONG if checked.subject.is_timed else OUT_OF_MEMORY


_Here: TypeAlias = tuple[tuple[int, ...], bool]
"""A marking, and whether the second goal has been accepted since the first one was."""


def overtaking(
    net: CompiledNet, first: int, accepts: int, ends: Collection[int]
) -> tuple[tuple[int, ...] | None, bool]:
    """Return a shortest run in which the goal accepted later is over first, and whether all were examined.

    Slots are alike, so that it does not matter which of them has the earlier goal.

    Parameters
    ----------
    first : int
        The place that says that one of two slots works for a client.
    accepts : int
        The transition by which the other one accepts a goal of the same client.
    ends : collection of int
        The transitions by which that goal ends.
    """
    from dineros.analysis.nets.witness import moves

    start: _Here = (tuple(net.initial.tolist()), False)
    before: dict[_Here, tuple[_Here, int] | None] = {start: None}
    queue = deque([start])
    while queue:
        here = queue.popleft()
        marking, is_second = here
        for transition, after in moves(net, marking):
            if is_second and transition in ends:
                way = [transition]
                while (step := before[here]) is not None:
                    here, taken = step
                    way.append(taken)
                return tuple(way[::-1]), True
            goes_on = after[first] > 0 and (is_second or transition == accepts)
            if (after, goes_on) not in before:
                if len(before) == MOST:
                    return None, False
                before[after, goes_on] = here, transition
                queue.append((after, goes_on))
    return None, True
