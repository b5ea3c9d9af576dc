"""Stored properties that random runs decide: a condition that one of them meets can be met.

A run shows that ``G b`` does not hold if ``b`` is false at one of its moments, and that ``EF b`` holds if it
is true. That needs no state classes. Properties that assume fairness are not asked, as it is not looked at.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.graphs.predicates import Flags, Int64Array, MarkingMatrix, combination, holds
from dineros.analysis.logic.language.atoms import BoundAtoms, NoneEnabled, SomeFired
from dineros.analysis.logic.language.syntax import (
    QUANTIFIERS,
    TEMPORAL,
    Atom,
    Deadlock,
    Exists,
    Finally,
    ForAll,
    Formula,
    Globally,
    Not,
)
from dineros.analysis.requirements.stored import Asked
from dineros.analysis.timed.exploring import Trace
from dineros.analysis.timed.timed_subject import TimedSubject

BY_RUNS = "random runs"

_STEPS = 1_000
"""Markings that are looked at together."""


def shown_by_runs(asked: Asked, runs: Iterable[Trace]) -> Outcome | None:
    """Return the answer for a property that some runs of its net show; None if they show none.

    Parameters
    ----------
    asked : Asked
        About a net with times.
    runs : iterable of Trace
        Firing sequences of that net that have a schedule.
    """
    found = _met(asked.reading.formula)
    if found is None or asked.weak or asked.strong or not isinstance(asked.subject, TimedSubject):
        return None
    condition, status = found
    shortest: Trace | None = None
    for run in runs:
        most = len(run) if shortest is None else len(shortest) - 1
        shortest = _beginning(asked.subject, condition, run[: max(0, most)]) or shortest
    if shortest is None:
        return None
    return asked.verdict(Outcome(status, shortest, ends_at_fault=status == "violated", by=BY_RUNS))


def _met(formula: Formula) -> tuple[Formula, str] | None:
    """Return what a run has to meet, and the answer then; None if one moment of a run decides nothing."""
    match formula:
        case Globally(condition):
            found: tuple[Formula, str] = Not(condition), "violated"
        case ForAll(Globally(condition)):
            found = Not(condition), "violated"
        case Exists(Finally(condition)):
            found = condition, "holds"
        case _:
            return None
    parts = found[0].subformulas()
    return None if any(isinstance(part, (*TEMPORAL, *QUANTIFIERS)) for part in parts) else found


def _beginning(subject: TimedSubject, condition: Formula, run: Trace) -> Trace | None:
    """Return the beginning of a run that ends with the first moment at which a condition holds."""
    net = subject.net
    atoms = BoundAtoms(net, condition, subject.names).conditions
    has_fired = any(isinstance(each, SomeFired) for each in atoms.values())
    marking = net.initial.astype(np.int64)
    for first in range(0, len(run) + 1, _STEPS):
        part = run[first : first + _STEPS]
        changes = np.zeros((len(part) + 1, len(marking)), dtype=np.int64)
        changes[0] = marking
        for number, transition in enumerate(part, 1):
            for place, change in net.delta[transition].items():
                changes[number, place] = change
        rows = np.cumsum(changes, axis=0)
        marking = rows[-1]
        matrix, fired = MarkingMatrix(net, rows), np.array([*part, -1])

        def evaluate(atom: Atom, matrix: MarkingMatrix = matrix, fired: Int64Array = fired) -> Flags:
            asked = NoneEnabled() if isinstance(atom, Deadlock) else atoms[atom]
            if isinstance(asked, SomeFired):
                return np.isin(fired, sorted(asked.transitions))
            return holds(matrix, asked)

        is_met = np.flatnonzero(combination(condition, evaluate, len(rows)))
        if has_fired:
            is_met = is_met[is_met < len(part)]  # what fires after the last marking is not in the run
        if len(is_met):
            return run[: first + int(is_met[0]) + has_fired]
    return None
