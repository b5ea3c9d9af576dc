"""``dineros reduce``: a smaller net with the same answer (paper, Alg. 4)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from dineros.cli.analysing import HOLDS, UNKNOWN, load_subject
from dineros.cli.console import say, say_json, summarise, warn
from dineros.cli.models import rules_of
from dineros.cli.options import (
    json_option,
    model_argument,
    output_option,
    settings_option,
    values_option,
    variant_options,
)
from dineros.cli.presentation.answers import say_times, times_fields
from dineros.cli.questions.timed import load_timed_subject, time_option
from dineros.cli.searching import TIME, search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.nets.compiled import CompiledNet
    from dineros.analysis.timed.timed_subject import TimedSubject

PROPERTIES = (
    "state_space_size",
    "markings",
    "kept_places",
    "deadlocks",
    "ltl_without_next",
    "liveness",
    "boundedness",
)


@search_command(
    "dineros reduce sorting.sym.xmi -o small.net",
    "dineros reduce sorting.sym.xmi --signals fully-enabled --preserve deadlocks -o small.pnml",
    "dineros reduce camera.net --time --keep queue -o small.net",
)
@model_argument()
@output_option("The reduced net; its suffix selects the format: .net, .pnml, .xmi.", required=True)
@click.option(
    "--preserve",
    "preserve",
    type=click.Choice(PROPERTIES),
    multiple=True,
    default=["state_space_size"],
    show_default=True,
    help="What the smaller net must preserve; repeatable.",
)
@values_option("--keep ELEMENT", "A place or transition to keep; repeatable.")
@time_option("Keep all times: remove only parts that never affect the behaviour.")
@variant_options
@settings_option
@json_option
def reduce(
    model: Path,
    output: Path,
    preserve: tuple[str, ...],
    keep: tuple[str, ...],
    timed: bool,
    signals: str,
    overflow: str,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Reduce a net by structural rules. Only rules that preserve what --preserve names are applied.

    With --time, the smaller net keeps its firing intervals and priorities. Observed at the remaining places
    and transitions, it has the same runs at the same times: all answers with --time stay the same.

    The exit status is 3 if time ran out: the net as reduced until then is written.
    """
    from dineros.analysis.model.times import left_out_times
    from dineros.analysis.nets.models import to_model
    from dineros.analysis.reductions import reduce as reduce_net
    from dineros.metamodel.files import save

    run = search()

    def not_written(ending: str) -> int:
        warn(f"{output} is not written: {ending}")
        return UNKNOWN

    run.draft(not_written)
    if timed:
        if click.get_current_context().get_parameter_source("preserve") is not ParameterSource.DEFAULT:
            raise click.UsageError(
                "--time cannot be combined with --preserve: all runs and times are preserved"
            )
        timed_subject = load_timed_subject(model, settings, signals, overflow)
        return _reduce_timed(timed_subject, model, output, keep, as_json)
    subject = load_subject(model, settings, signals, overflow)
    net, times = subject.net, left_out_times(subject.model)
    places, transitions = _kept(subject, keep)
    run.stage("reducing the net")
    budget = run.time().begun()
    reduction = reduce_net(
        net, set(preserve), observed_places=places, observed_transitions=transitions, budget=budget
    )
    reason = run.reason(TIME) if budget.is_over else ""
    run.stage(f"writing {output.name}")
    save(to_model(reduction.net, str(subject.model.id)), output)
    steps = [
        {
            "rule": step.rule,
            "elements": [*step.places, *step.transitions],
            "preserves": sorted(map(str, step.preserves)),
        }
        for step in reduction.steps
    ]
    small = reduction.net
    report: dict[str, object] = {
        "model": str(model),
        **rules_of(subject.model),
        "places": [len(net.places), len(small.places)],
        "transitions": [len(net.transitions), len(small.transitions)],
        "steps": steps,
    }
    merged = reduction.merged if "markings" in reduction.preserves else {}
    if "markings" in preserve:
        report["markings"] = {"factor": reduction.marking_factor, "merged": dict(merged)}
    with run.answer():
        if as_json:
            say_json({**report, **times_fields(times, None), "reason": reason})
        else:
            _say_rules([step.rule for step in reduction.steps])
            if "markings" in preserve:
                say(f"a marking stands for {reduction.marking_factor}, times the ways to share the tokens of")
                for place, parts in merged.items():
                    say(f"{parts:4} places: {place}")
            _say_sizes(model, output, net, small, reason)
            say_times(times, "the smaller net has none; --time keeps them")
    return UNKNOWN if reason else HOLDS


def _reduce_timed(
    subject: TimedSubject, model: Path, output: Path, keep: Sequence[str], as_json: bool
) -> int:
    """Reduce a net and keep its times; return the exit status."""
    from dineros.analysis.timed.reductions.reduction import reduce_timed
    from dineros.analysis.tina.timed_models import to_timed_model
    from dineros.metamodel.files import save

    run = search()
    places, transitions = _kept(subject, keep)
    run.stage("reducing the net")
    budget = run.time().begun()
    reduction = reduce_timed(subject.timed, [*places, *transitions], budget)
    reason = run.reason(TIME) if budget.is_over else ""
    run.stage(f"writing {output.name}")
    save(to_timed_model(reduction.net, str(subject.model.id), Fraction(1)), output)
    net, small = reduction.original.untimed, reduction.net.untimed
    with run.answer():
        if as_json:
            say_json(
                {
                    "model": str(model),
                    **rules_of(subject.model),
                    "places": [len(net.places), len(small.places)],
                    "transitions": [len(net.transitions), len(small.transitions)],
                    "steps": [{"rule": one.rule, "elements": [one.removed]} for one in reduction.steps],
                    "times": subject.used_times.to_dict() if subject.timed.has_times else None,
                    "reason": reason,
                }
            )
        else:
            _say_rules([one.rule for one in reduction.steps])
            _say_sizes(model, output, net, small, reason)
    return UNKNOWN if reason else HOLDS


def _say_rules(rules: Sequence[str]) -> None:
    for rule, number in Counter(rules).items():
        say(f"{number:4} x {rule}")


def _say_sizes(model: Path, output: Path, net: CompiledNet, small: CompiledNet, reason: str) -> None:
    if reason:
        say(f"unknown whether the net can be reduced further: {reason}", "magenta")
    summarise(
        f"{model} -> {output}: {len(net.places)} -> {len(small.places)} places, "
        f"{len(net.transitions)} -> {len(small.transitions)} transitions"
    )


def _kept(subject: Subject, names: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the places and the transitions of the net for names of the model."""
    from dineros.analysis.logic.language.errors import FormulaError
    from dineros.metamodel.errors import DinerosError, near_matches

    places: list[str] = []
    transitions: list[str] = []
    for name in names:
        try:
            places += [subject.net.places[index] for index in subject.names.places(name)]
            continue
        except FormulaError:
            pass
        try:
            transitions += [subject.net.transitions[index] for index in subject.names.transitions(name)]
        except FormulaError:
            hint = near_matches(name, [*subject.net.places, *subject.net.transitions])
            raise DinerosError(f"--keep: no place or transition is named {name!r}", hint=hint) from None
    return places, transitions
