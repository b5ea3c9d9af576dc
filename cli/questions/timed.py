"""Questions about nets with their times, by `--time`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import HOLDS, UNKNOWN, load_valid, variant_fields
from dineros.cli.console import say_figures, say_json
from dineros.cli.models import errors_of
from dineros.cli.options import Adds, flag
from dineros.cli.presentation.answers import assumes_field, say_assumes
from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.analysis.answers.budget import Budget
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.timed.classes import Kind
    from dineros.analysis.timed.nets import TimedNet
    from dineros.analysis.timed.state_space import TimedStateSpace
    from dineros.analysis.timed.timed_subject import TimedSubject


def time_option(help: str) -> Adds:
    """Add `--time`, passed as `timed`."""
    return flag("--time", help, into="timed")


def load_timed_subject(path: Path, settings: Sequence[str], signals: str, overflow: str) -> TimedSubject:
    """Read a model, reject an invalid one, flatten a system model, and compile it with its times."""
    from dineros.analysis.timed.timed_subject import timed_subject_of

    model = load_valid(path, settings)
    search().stage("flattening")
    with errors_of(path):
        return timed_subject_of(model, signals, overflow)  # type: ignore[arg-type]


def quickest_way(subject: Subject, kind: str, goal: str) -> tuple[Outcome, dict[str, object]]:
    """Find the quickest firing sequence to a marking or a firing, and its time for JSON."""
    from dineros.analysis.timed.durations.quickest import quickest_firing, quickest_marking
    from dineros.analysis.timed.timed_subject import TimedSubject

    assert isinstance(subject, TimedSubject), "it goes with --time"
    find = quickest_firing if kind == "enabled" else quickest_marking
    run = search()
    found = find(subject.timed, goal, subject.names, run.budget())
    reason = str(found) or run.reason(found.outcome.reason)
    return replace(found.outcome, reason=reason), found.to_dict()


def count_with_time(
    model: Path,
    settings: Sequence[str],
    signals: str,
    overflow: str,
    construction: Kind | None,
    engine: str,
    confirm: bool,
    as_json: bool,
) -> int:
    """Count a timed state space and print it, by the options of `statespace`; return the exit status."""
    from dineros.analysis.model.assumptions import of_source
    from dineros.analysis.timed.state_space import unfinished_timed

    run = search()
    subject = load_timed_subject(model, settings, signals, overflow)
    net = subject.timed
    kind: Kind = construction or ("S" if net.has_priorities else "W")
    engine = "classes" if engine == "auto" else engine
    about, assumes = variant_fields(subject, model, signals, overflow), of_source(subject.model)
    confirmed: dict[str, object] = {}

    def tell(space: TimedStateSpace) -> int:
        figures = {**about, **space.to_dict(), **confirmed}
        if as_json:
            say_json({**figures, **assumes_field(assumes)})
        else:
            say_figures(figures)
            say_assumes(assumes)
        return HOLDS if space.complete else UNKNOWN

    def so_far(ending: str) -> int:
        seen = run.last.count if run.last is not None and run.last.unit == "states" else None
        return tell(unfinished_timed(net, kind, engine, seen, ending, run.limits.spent))

    run.draft(so_far)
    budget = run.budget()
    space = _counted(net, kind, engine, budget)
    if confirm and space.complete:
        run.stage("confirming the counts")
        space, said = _confirmed(space, net, kind, engine, budget)
        confirmed.update(said)
    with run.answer():
        return tell(replace(space, reason=run.reason(space.reason)))


def _confirmed(
    space: TimedStateSpace, net: TimedNet, kind: Kind, engine: str, budget: Budget
) -> tuple[TimedStateSpace, dict[str, object]]:
    """Count again by the other engine; return the figures, and the text of the comparison."""
    from dineros.metamodel.errors import DinerosError

    other = "integer" if engine == "classes" else "classes"
    try:
        again = _counted(net, kind, other, budget)
    except DinerosError as error:
        return space, {"confirmed_by": None, "agrees": None, "not_confirmed": str(error.message)}
    differing = _differing(space, again)
    agrees = not differing if again.complete else None
    if agrees is False:
        name, ours, theirs = differing[0]
        why = f"{engine} counts {ours} {name}, {other} {theirs}: one of the engines is wrong"
        space = replace(space, complete=False, reason=why)
    return space, {"confirmed_by": other, "agrees": agrees}


def _counted(net: TimedNet, kind: Kind, engine: str, budget: Budget) -> TimedStateSpace:
    if engine == "tina":
        from dineros.analysis.tina import count_classes

        return count_classes(net, kind, budget)
    from dineros.analysis.timed.state_space import timed_state_space

    return timed_state_space(net, kind, engine, budget)  # type: ignore[arg-type]


def _differing(space: TimedStateSpace, again: TimedStateSpace) -> list[tuple[str, int, int]]:
    """Return the figures on which the engines disagree."""
    figures = space.to_dict(), again.to_dict()
    pairs = [
        (name, *(each[name] for each in figures)) for name in ("markings", "classes", "edges", "deadlocks")
    ]
    return [each for each in pairs if None not in each and each[1] != each[2]]
