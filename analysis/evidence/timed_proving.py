"""Creates certificates of answers about nets with times: all state classes, or a schedule.

The classes are read from the tables of the search; `timed_checker` checks them independently.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.evidence.certificate import TIMED_FORMAT
from dineros.analysis.evidence.proving import Asked, Certificate
from dineros.analysis.evidence.timed_checker import timed_goal, timed_refutation
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.nets import UNBOUNDED, TimedNet
from dineros.analysis.timed.schedules import schedule
from dineros.analysis.timed.timed_subject import TimedSubject
from dineros.metamodel.errors import DinerosError

Class = dict[str, Any]
"""A state class in the format of certificates: a marking, and the firing times of its transitions."""


def timed_certificate(asked: Asked, answer: Outcome, budget: Budget = UNLIMITED) -> Certificate | None:
    """Return the certificate of an answer about a net with times, after checking it.

    Parameters
    ----------
    asked
        The question; its subject has times.
    budget
        Budget for creating and checking the classes.

    Returns
    -------
    Certificate or None
        None if the answer is about more than one moment of a run, or depends on priorities.

    Raises
    ------
    BudgetExceededError
        A limit was exceeded before the certificate was checked.
    """
    subject, budget = asked.subject, budget.begun()
    assert isinstance(subject, TimedSubject)
    try:
        _, is_shown = timed_goal(asked.kind, asked.text, answer.status)
    except DinerosError:  # the question is invalid; the engine that answers reports it
        return None
    net = subject.timed
    classes = [] if is_shown else list(classes_of(net, budget))
    steps = _schedule(net, [*answer.stem, *answer.loop]) if is_shown else []
    certificate = timed_form(asked, answer.status, classes, steps)
    return None if timed_refutation(certificate, subject, budget) else certificate


def timed_form(
    asked: Asked, status: str, classes: Sequence[Class], steps: Sequence[Mapping[str, str]] = ()
) -> Certificate:
    """Return a certificate with these classes, or this schedule; it is not checked here."""
    return asked.certificate(TIMED_FORMAT, status, classes=list(classes), schedule=list(steps))


def _schedule(net: TimedNet, trace: Sequence[int]) -> list[dict[str, str]]:
    names = net.untimed.transitions
    return [{"fires": names[one.transition], "at": str(one.at)} for one in schedule(net, trace)]


def classes_of(net: TimedNet, budget: Budget) -> Iterator[Class]:
    """Yield the maximal linear classes of a net without its priorities, in the format of certificates.

    Raises
    ------
    BudgetExceededError
        A limit was exceeded, or tokens grow without bound.
    """
    without = replace(net, above=tuple(() for _ in net.above)) if net.has_priorities else net
    explored = explore_timed(without, budget)
    if not explored.is_complete:
        raise BudgetExceededError(explored.reason)
    search = explored.search
    places, names, markings = net.untimed.places, net.untimed.transitions, explored.markings
    for number in np.flatnonzero(search.kept() == np.arange(search.classes)).tolist():
        budget.check_time()
        row = int(search.marking_of[number])
        enabled, matrix = search.domain(number)
        of = [names[t] for t in enabled]
        yield {
            "marking": {places[p]: int(markings[row, p]) for p in np.flatnonzero(markings[row]).tolist()},
            "times": dict(_intervals(net, of, matrix)),
            "differences": list(_differences(net, of, matrix)),
        }


def _intervals(net: TimedNet, names: Sequence[str], matrix: Int64Array) -> Iterator[tuple[str, str]]:
    """Yield the firing interval of each transition."""
    for at, name in enumerate(names, 1):
        low, is_open_below = _bound(net, matrix[0, at])
        left = "]" if is_open_below else "["
        if matrix[at, 0] >= UNBOUNDED:
            yield name, f"{left}{-low},w["
        else:
            high, is_open_above = _bound(net, matrix[at, 0])
            yield name, f"{left}{-low},{high}{'[' if is_open_above else ']'}"


def _differences(net: TimedNet, names: Sequence[str], matrix: Int64Array) -> Iterator[dict[str, object]]:
    """Yield the bounds of differences that are not implied by the intervals."""
    for i, first in enumerate(names, 1):
        for j, second in enumerate(names, 1):
            if i == j or matrix[i, j] >= UNBOUNDED:
                continue
            most, is_strict = _bound(net, matrix[i, j])
            follows = matrix[i, 0] < UNBOUNDED and matrix[i, j] == _sum(matrix[i, 0], matrix[0, j])
            if not follows:
                yield {"first": first, "second": second, "most": str(most), "strict": is_strict}


def _sum(one: int, other: int) -> int:
    """Add two stored bounds."""
    return int(one) + int(other) - ((int(one) | int(other)) & 1)


def _bound(net: TimedNet, stored: int) -> tuple[Fraction, bool]:
    """Return a bound that is stored as twice a number of units, plus 1 if it is allowed."""
    return (int(stored) >> 1) * net.unit, not int(stored) & 1
