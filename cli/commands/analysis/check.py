"""``dineros check``: every question with a yes/no answer that can be asked of any model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    VIOLATED,
    cache_option,
    confirm_option,
    load_valid,
    orders_beside,
    scheduler_option,
)
from dineros.cli.console import summarise, warn
from dineros.cli.options import (
    ModelPath,
    format_option,
    json_option,
    middleware_option,
    model_argument,
    output_option,
    settings_option,
)
from dineros.cli.presentation.evidence import (
    add_confirmation,
    check_certificates,
    refuse_certificates,
    say_confirmation,
)
from dineros.cli.presentation.findings import Coming, print_report, show_failures, write_witnesses
from dineros.cli.presentation.scheduling import check_on_workers
from dineros.cli.questions.accepting import Acceptance, baseline_options
from dineros.cli.questions.suggesting import suggest
from dineros.cli.questions.timed import time_option
from dineros.cli.quick_start import start_quickly
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.witnesses.findings import Report


@search_command(
    "dineros check sorting.sym.xmi",
    "dineros check sorting.sym.xmi --set RedObjects.tokens=2 --format junit > findings.xml",
    "dineros check sorting.sym.xmi --suggest-capacities",
    "dineros check robot.sym.xmi --suggest-callback-groups",
    "dineros check camera.sym.xmi --suggest-start-order",
    "dineros check sorting.sym.xmi -o report.html",
    "dineros check handler.net --time --witnesses",
    "dineros check sorting.sym.xmi --write-baseline known.json",
)
@model_argument()
@format_option("the findings")
@click.option(
    "--suggest-capacities",
    is_flag=True,
    help="Instead: the smallest capacity of each queue that loses no message.",
)
@click.option(
    "--suggest-callback-groups",
    is_flag=True,
    help="Instead: the smallest change of groups and threads after which no callback waits forever.",
)
@click.option(
    "--suggest-start-order",
    is_flag=True,
    help="Instead: a start order of managed nodes in which no message is lost.",
)
@click.option(
    "--behaviour",
    is_flag=True,
    help="Decide liveness, reversibility and home markings, however long it takes.",
)
@time_option("Take firing intervals into account; each finding has a schedule.")
@click.option("--witnesses", is_flag=True, help="Print how each finding comes about, step by step.")
@output_option(
    "Write a report (.html); or the witnesses of the findings to OUT, OUT with .2, .3 ... (JSON Lines)."
)
@click.option(
    "--certificate",
    type=ModelPath(),
    metavar="FILE|FOLDER",
    help="Write the proofs of answers by structure or induction: in one file (.json), or one file each.",
)
@baseline_options
@confirm_option
@scheduler_option
@cache_option
@middleware_option
@settings_option
@json_option
def check(
    model: Path,
    format: str,
    suggest_capacities: bool,
    suggest_callback_groups: bool,
    suggest_start_order: bool,
    behaviour: bool,
    timed: bool,
    witnesses: bool,
    output: Path | None,
    certificate: Path | None,
    baseline: Path | None,
    write_baseline: Path | None,
    confirm: bool,
    scheduler: str | None,
    no_cache: bool,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Check a model: clauses, overflow of queues, unused and dead parts, boundedness, deadlock.

    The exit status is 1 if there is a finding (notes, suppressed findings and those of the baseline do not
    count), and 3 if an answer stays unknown that could be more than a note.
    """
    start_quickly()
    from dineros.analysis.checks.check import check as check_model
    from dineros.analysis.timed_checks.faults import TIMED_FAULTS
    from dineros.analysis.witnesses.findings import Report, Unknown

    format = "json" if as_json else format
    asked = {
        "--suggest-capacities": suggest_capacities,
        "--suggest-callback-groups": suggest_callback_groups,
        "--suggest-start-order": suggest_start_order,
    }
    suggests = [option for option, is_asked in asked.items() if is_asked]
    if suggests:
        written: dict[str, object] = {"-o": output, "--certificate": certificate, "--scheduler": scheduler}
        written |= {"--baseline": baseline, "--write-baseline": write_baseline}
        written |= {"--time": timed or None}
        _refuse_beside(suggests, format, [option for option, value in written.items() if value is not None])
    if timed:
        _refuse_with_time(
            {
                "--behaviour": behaviour,
                "--confirm": confirm,
                "--scheduler": scheduler,
                "--certificate": certificate,
            }
        )
    if certificate is not None:
        refuse_certificates(certificate, also_folder=True)
    net = load_valid(model, settings)
    if suggests:
        return suggest(suggests[0], net, model, format == "json", witnesses)
    acceptance = Acceptance(net, baseline, write_baseline)
    run, report = search(), Report()

    def so_far(ending: str) -> int:
        rest = replace(report, unknown=[*report.unknown, Unknown("everything else", ending)])
        rest = acceptance.apply(rest)
        print_report(rest, net, model, format, witnesses, TIMED_FAULTS)
        if write_baseline is not None:
            warn(f"{write_baseline} is not written: {ending}")
        return _status(rest)

    run.draft(so_far)
    if format == "text":
        run.follow(Coming(report, acceptance.apply))
    confirmation, budget = None, run.budget().begun()
    if timed:
        from dineros.analysis.timed_checks.timed_check import check_timed

        check_timed(net, budget, report, orders_beside(model, no_cache))
    elif scheduler is None:
        check_model(net, budget, report, behaviour, orders_beside(model, no_cache))
        if confirm and report.space is not None:
            from dineros.analysis.evidence.confirmation import confirm_space

            confirmation = confirm_space(report.space, run.budget())
    else:
        run.stage(f"asking the workers of {scheduler}")
        confirmation = check_on_workers(
            net, scheduler, report, at_any_cost=behaviour, memory=run.limits.memory, is_confirmed=confirm
        )
    if confirmation is not None:
        add_confirmation(report, confirmation)
    if report.times is None and report.findings:
        from dineros.analysis.consequences.folding import fold_consequences

        fold_consequences(net, report, budget, orders_beside(model, no_cache))
    report = acceptance.apply(report)
    with run.answer():
        report = acceptance.write(report)
        show_failures(report)
        print_report(report, net, model, format, witnesses, TIMED_FAULTS)
        if confirm:
            say_confirmation(confirmation, format != "text")
    status = _status(report)
    if confirmation is not None and confirmation.agrees is False:
        status = UNKNOWN

    def not_written(ending: str, file: Path | None = output) -> int:
        warn(f"{file} is not written: {ending}")
        return status or UNKNOWN

    if output is not None:
        run.draft(not_written)
        run.stage(f"writing {output.name}")
    if certificate is not None:
        run.draft(lambda ending: not_written(ending, certificate))
        run.stage("looking for proofs")
        count = check_certificates(report, net, settings, certificate, run.budget())
        if format == "text":
            summarise(f"certificates: {certificate}: {count}")
    if output is not None and output.suffix.lower() == ".html":
        from dineros.cli.presentation.check_reports import write_check_report

        write_check_report(report, net, output, model, settings)
        if format == "text":
            summarise(f"{model} -> {output}")
    elif output is not None:
        write_witnesses(report, output, model, settings, say_files=format == "text")
    return status


def _refuse_beside(options: Sequence[str], format: str, others: Sequence[str]) -> None:
    """Refuse what does not go with a suggestion."""
    if len(options) > 1:
        raise click.UsageError(f"{options[0]} does not go with {options[1]}")
    what = "capacities" if options[0] == "--suggest-capacities" else "changes"
    if format not in ("text", "json"):
        raise click.UsageError(f"{what} are not findings: there is no --format {format} of them")
    if "--scheduler" in others:
        raise click.UsageError(f"--scheduler does not go with {options[0]}")
    if others:
        raise click.UsageError(f"{what} are not findings: {others[0]} does not go with {options[0]}")


def _refuse_with_time(options: Mapping[str, object]) -> None:
    """Refuse what does not go with times."""
    for option, value in options.items():
        if value:
            raise click.UsageError(f"--time does not go with {option}")


def _status(report: Report) -> int:
    if any(finding.severity != "note" for finding in report.findings):
        return VIOLATED
    return UNKNOWN if any(unknown.may_be_fault for unknown in report.unknown) else HOLDS
