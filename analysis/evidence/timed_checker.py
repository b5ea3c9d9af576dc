"""Checks certificates about nets with times. No analysis engine is used: plain Python, exact fractions.

The checker consists of this module, `dineros.analysis.timed.plain_classes`, and the readers of models and
formulas. There are two kinds of certificates:

* ``classes`` prove that a condition is never fulfilled. A class is a set of states: a marking with bounds on
the
  firing times of its transitions. One class contains the initial states, the states after each firing in a
  class are contained in a class, and no class fulfils the condition. So no run does (by induction over its
  firings). Priorities are ignored, which only adds runs.
* a ``schedule`` proves that a condition is fulfilled: it is replayed with a clock for each enabled
transition.

References
----------
B. Berthomieu, M. Diaz, *Modeling and verification of time dependent systems using time Petri nets*, IEEE TSE
17(3), 1991 (state classes).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.evidence.checker import excluded
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import (
    TEMPORAL,
    Deadlock,
    Exists,
    Fired,
    ForAll,
    Formula,
    Name,
)
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.plain_classes import (
    AT_MOST_0,
    Bound,
    PlainClass,
    enabled_in,
    normal_form,
    tighter,
)
from dineros.analysis.timed.timed_subject import TimedSubject
from dineros.metamodel.errors import DinerosError

_NUMBER = r"-?[0-9]{1,40}(?:/[1-9][0-9]{0,39})?"
_INTERVAL = re.compile(rf"([\[\]])({_NUMBER}),(w|{_NUMBER})([\[\]])")
_TIME = re.compile(_NUMBER)

_OPPOSITE = {"holds": "violated", "violated": "holds"}


class _RefutedError(Exception):
    """The certificate does not prove its answer."""


def timed_goal(kind: str, text: str, answer: str) -> tuple[Formula, bool]:
    """Return the condition of an answer, and whether a run shows it; otherwise no run fulfils it.

    Parameters
    ----------
    kind, text, answer
        The question, as in certificates, and its answer.

    Raises
    ------
    DinerosError
        The formula is invalid, or the answer is about more than one moment of a run.
    """
    match kind, answer:
        case "enabled", ("reachable" | "unreachable"):
            return Fired(Name(text)), answer == "reachable"
        case "marking", ("reachable" | "unreachable"):
            goal, is_shown = excluded(kind, text, "unreachable"), answer == "reachable"
        case "ltl", "violated":
            goal, is_shown = excluded(kind, text, "holds"), True
        case ("ltl", "holds") | ("ctl", "holds" | "violated"):
            try:
                goal, is_shown = excluded(kind, text, answer), False
            except DinerosError:
                if kind == "ltl":
                    raise
                goal, is_shown = excluded(kind, text, _OPPOSITE[answer]), True
        case _:
            raise DinerosError(f"certificates with times do not support the answer '{answer}' to {kind}")
    if any(isinstance(part, (*TEMPORAL, ForAll, Exists)) for part in goal.subformulas()):
        raise DinerosError(
            f"certificates with times do not support properties of several moments of a run: {text}"
        )
    return goal, is_shown


def timed_refutation(
    certificate: Mapping[str, Any], subject: TimedSubject, budget: Budget = UNLIMITED
) -> str:
    """Return what is wrong with a certificate about a net with times; empty if it proves its answer.

    Parameters
    ----------
    certificate : mapping
        Result of `dineros.analysis.evidence.certificate.read_certificate`.
    subject : TimedSubject
        The net of the model, changed and flattened as the certificate states.

    Raises
    ------
    DinerosError
        The question is not valid for the net.
    BudgetExceededError
        The time ran out.
    """
    asked = certificate["question"]
    goal, is_shown = timed_goal(asked["kind"], asked["text"], certificate["answer"])
    net, atoms = subject.timed, BoundAtoms(subject.timed.untimed, goal, subject.names)
    if Deadlock() in atoms.conditions and net.has_priorities:
        return "with priorities, a marking does not determine whether the net has ended"

    def is_met(marking: Sequence[int], fired: int | None) -> bool:
        return holds_on_lasso(goal, [], [Step(tuple(marking), fired)], atoms.is_true)

    try:
        if is_shown:
            steps = list(_run(net, _steps(net, certificate["schedule"])))
            if not any(is_met(*step) for step in steps):
                return "the schedule does not reach the goal"
        else:
            _check_classes(net, [*_classes(net, certificate["classes"])], is_met, budget)
    except _RefutedError as wrong:
        return str(wrong)
    return ""


def _check_classes(net: TimedNet, classes: Sequence[PlainClass], is_met: Any, budget: Budget) -> None:
    """Check that the classes contain all states, and that none fulfils the condition."""
    alike: dict[tuple[int, ...], list[PlainClass]] = {}
    for one in classes:
        alike.setdefault(one.marking, []).append(one)

    def is_held(one: PlainClass) -> bool:
        return any(one.is_within(other) for other in alike.get(one.marking, ()))

    if not is_held(PlainClass.initial(net)):
        raise _RefutedError("no class holds the initial states")
    for number, one in enumerate(classes, 1):
        budget.check_time()
        firing: list[int | None] = [None]
        for t in one.enabled:
            after = one.after(net, t)
            if after is None:
                continue
            firing.append(t)
            if not is_held(after):
                name = net.untimed.transitions[t]
                raise _RefutedError(f"class {number}: firing {name} leads to states that no class holds")
        if any(is_met(one.marking, t) for t in firing):
            raise _RefutedError(f"class {number} reaches the goal")


def _classes(net: TimedNet, found: Sequence[Mapping[str, Any]]) -> Iterator[PlainClass]:
    """Read classes and bring their matrices into normal form."""
    for number, one in enumerate(found, 1):
        where = f"class {number}"
        marking = [0] * len(net.untimed.places)
        for name, tokens in one["marking"].items():
            marking[_index(net.untimed.places, name, where)] = tokens
        if min(marking, default=0) < 0:
            raise _RefutedError(f"{where} has a negative number of tokens")
        enabled = enabled_in(net, marking)
        names = tuple(net.untimed.transitions[t] for t in enabled)
        size = range(len(enabled) + 1)
        rows: list[list[Bound]] = [
            [AT_MOST_0 if j in (i, *(() if i else size)) else None for j in size] for i in size
        ]
        for name, text in one["times"].items():
            at = _index(names, name, where) + 1
            rows[0][at], rows[at][0] = _interval(text, where)
        for each in one["differences"]:
            first, second = (_index(names, each[end], where) + 1 for end in ("first", "second"))
            bound = _number(each["most"], where), each["strict"]
            rows[first][second] = tighter(rows[first][second], bound)
        matrix = normal_form(rows)
        if matrix is None:
            raise _RefutedError(f"{where} holds no state")
        yield PlainClass(tuple(marking), enabled, tuple(map(tuple, matrix)))


def _interval(text: str, where: str) -> tuple[Bound, Bound]:
    """Read the firing time of a transition: the bound of 0 - x, and that of x."""
    found = _INTERVAL.fullmatch(text)
    if found is None:
        raise _RefutedError(f"{where}: {text!r} is not an interval")
    left, earliest, latest, right = found.groups()
    upper = None if latest == "w" else (Fraction(latest), right == "[")
    return (-Fraction(earliest), left == "]"), upper


def _number(text: str, where: str) -> Fraction:
    if _TIME.fullmatch(text) is None:
        raise _RefutedError(f"{where}: {text!r} is not a time")
    return Fraction(text)


def _index(names: Sequence[str], name: str, where: str) -> int:
    if name not in names:
        raise _RefutedError(f"{where} names {name!r}, which does not exist or is not enabled")
    return names.index(name)


def _steps(net: TimedNet, schedule: Sequence[Mapping[str, str]]) -> Iterator[tuple[int, Fraction]]:
    for number, one in enumerate(schedule, 1):
        where = f"firing {number}"
        yield _index(net.untimed.transitions, one["fires"], where), _number(one["at"], where)


def _run(
    net: TimedNet, schedule: Iterator[tuple[int, Fraction]]
) -> Iterator[tuple[tuple[int, ...], int | None]]:
    """Replay a schedule; yield each marking with the transition fired there, and the last marking."""
    marking = tuple(net.untimed.initial.tolist())
    clocks, now = dict.fromkeys(enabled_in(net, marking), Fraction(0)), Fraction(0)
    for number, (fired, at) in enumerate(schedule, 1):
        name = net.untimed.transitions[fired]
        where = f"firing {number} of {name} at {at}"
        yield marking, fired
        if at < now:
            raise _RefutedError(f"{where} comes before the firing before it")
        clocks, now = {t: clock + at - now for t, clock in clocks.items()}, at
        if fired not in clocks:
            raise _RefutedError(f"{where}: it is not enabled")
        late = next((t for t, clock in clocks.items() if _is_late(net, t, clock)), None)
        if late is not None:
            raise _RefutedError(f"{where}: {net.untimed.transitions[late]} has to fire before")
        if not _is_ripe(net, fired, clocks[fired]):
            raise _RefutedError(f"{where} is too early")
        higher = next((t for t in net.above[fired] if t in clocks and _is_ripe(net, t, clocks[t])), None)
        if higher is not None:
            raise _RefutedError(f"{where}: {net.untimed.transitions[higher]} has priority")
        between, after = list(marking), list(marking)
        for place, weight in net.take.row(fired):
            between[place] -= weight
            after[place] -= weight
        for place, weight in net.put.row(fired):
            after[place] += weight
        marking, kept = tuple(after), {*enabled_in(net, between)} - {fired}
        clocks = {t: clocks[t] if t in kept and t in clocks else Fraction(0) for t in enabled_in(net, after)}
    yield marking, None


def _is_late(net: TimedNet, transition: int, clock: Fraction) -> bool:
    """Whether a transition had to fire before its clock reached this value."""
    interval = net.intervals[transition]
    latest = interval.latest
    return latest is not None and (clock > latest or (clock == latest and interval.is_open_above))


def _is_ripe(net: TimedNet, transition: int, clock: Fraction) -> bool:
    """Whether a transition can fire at this value of its clock."""
    interval = net.intervals[transition]
    return clock > interval.earliest or (clock == interval.earliest and not interval.is_open_below)
