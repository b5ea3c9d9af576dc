"""``dineros check``: decides all yes/no questions that apply to every model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.analysis.answers.stages import Share
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
from dineros.cli.coding import Code, code_options, faults_of_code, model_of_code
from dineros.cli.console import summarise, warn
from dineros.cli.options import (
    flag,
    format_option,
    json_option,
    middleware_option,
    model_argument,
    model_path_option,
    output_option,
    path_option,
    settings_option,
)
from dineros.cli.presentation.evidence import (
    add_confirmation,
    check_certificates,
    confirm_with_times,
    refuse_certificates,
    say_confirmation,
    say_confirmed_questions,
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
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.timed_checks.timed_checked import TimedChecked
    from dineros.analysis.witnesses.findings import Finding, Report
    from dineros.metamodel import pn

ASKED = Share(time=0.8)
"""Share of the time for the questions; the rest is for separating consequences from their causes."""


@search_command(
    "dineros check sorting.sym.xmi",
    "dineros check sorting.sym.xmi --set RedObjects.tokens=2 --format junit > findings.xml",
    "dineros check sorting.sym.xmi --suggest-capacities",
    "dineros check robot.sym.xmi --suggest-callback-groups",
    "dineros check camera.sym.xmi --suggest-start-order",
    "dineros check sorting.sym.xmi -o report.html",
    "dineros check handler.net --time --witnesses",
    "dineros check sorting.sym.xmi --write-baseline known.json",
    "dineros check --source src --launch robot.launch.py --format sarif",
)
@model_argument(required=False)
@code_options()
@path_option(
    "--given FILE.toml", "With --source: facts that the code does not show, as for 'dineros import'."
)
@format_option("the findings")
@flag(
    "--suggest-capacities",
    "Instead of checking: find the smallest capacity of each queue that loses no message.",
)
@flag(
    "--suggest-callback-groups",
    "Instead of checking: find the least change of groups and threads so that no callback waits forever.",
)
@flag(
    "--suggest-start-order",
    "Instead of checking: find a start order of managed nodes in which no message is lost.",
)
@flag("--behaviour", "Decide liveness, reversibility and home markings without a limit of their own.")
@time_option("Take firing intervals into account; each finding has a schedule.")
@flag("--witnesses", "Print the steps that lead to each finding.")
@output_option(
    "Write a report (.html); or the witnesses of the findings to OUT, OUT with .2, .3 ... (JSON Lines)."
)
@model_path_option(
    "--certificate FILE|FOLDER",
    "Write the proofs of answers, for 'dineros certify': in one file (.json), or one file each.",
)
@baseline_options
@confirm_option
@scheduler_option
@cache_option
@middleware_option
@settings_option
@json_option
def check(
    model: Path | None,
    code: Code,
    given: Path | None,
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
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Check a model or code: clauses, overflow of queues, unused and dead parts, boundedness, deadlock.

    With --source FOLDER, the model is built from the code as by 'dineros import', and faults of the code
    itself are also reported; findings name its lines.

    The exit status is 1 if there is a finding (notes, suppressed findings and those of the baseline do not
    count), and 3 if an answer stays unknown that could be more than a note.
    """
    start_quickly(None if code.folders else model)
    from dineros.analysis.checks.check import check as check_model
    from dineros.analysis.consequences.durations import left_to_durations
    from dineros.analysis.consequences.lacks import left_to_lacks
    from dineros.analysis.consequences.lives import left_to_lives
    from dineros.analysis.consequences.unseen import about_seen
    from dineros.analysis.model.assumptions import assumptions, of_source
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
        _refuse_with_time({"--behaviour": behaviour, "--scheduler": scheduler})
    if certificate is not None:
        refuse_certificates(certificate, also_folder=True)
    if model is not None and code.folders:
        code, model = replace(code, arguments=(str(model), *code.arguments)), None
    code.refuse_without_folders()
    run, report = search(), Report()
    net: pn.Net
    of_code: list[Finding] = []
    if code.folders:
        _refuse_with_source(output, certificate)
        made = model_of_code(code, given, settings)
        net, of_code = made.model, made.findings
        model, orders, faults = code.folders[0], None, faults_of_code()
    elif model is None or given is not None:
        raise click.UsageError("name what to check: MODEL, or --source FOLDER; --given requires --source")
    else:
        net, orders, faults = load_valid(model, settings), orders_beside(model, code.no_cache), TIMED_FAULTS
    if suggests:
        return suggest(suggests[0], net, model, format == "json", witnesses)
    acceptance = Acceptance(net, baseline, write_baseline)

    def accepted(report: Report) -> Report:
        found = replace(report, findings=[*report.findings, *of_code])
        if of_code:
            from dineros.observation.findings.contradicting import contradicted

            found = contradicted(found, of_code)
        if of_source(net):  # what the model lacks may do anything
            found = replace(found, proved=[], assumed=[*report.assumed, *report.proved])
        if found.proved or found.assumed:
            found = replace(found, assumes=[*report.assumes, *assumptions(net, with_times=timed)])
        found = left_to_lacks(net, left_to_lives(net, left_to_durations(net, found)))
        return acceptance.apply(about_seen(net, found))

    def so_far(ending: str) -> int:
        rest = replace(report, unknown=[*report.unknown, Unknown("everything else", ending)])
        rest = accepted(rest)
        print_report(rest, net, model, format, witnesses, faults)
        if write_baseline is not None:
            warn(f"{write_baseline} is not written: {ending}")
        return _status(rest)

    run.draft(so_far)
    if format == "text":
        run.follow(Coming(report, accepted))
    confirmation, budget = None, run.budget().begun()
    with_times: TimedChecked | None = None
    told: dict[str, Confirmation] | None = None
    if timed:
        from dineros.analysis.timed_checks.timed_check import ask_timed

        with_times = ask_timed(net, report, ASKED.share(budget), orders)
        if with_times is not None:
            from dineros.analysis.consequences.precautions import about_precautions

            judged = about_precautions(with_times.timed, report, budget)
            report.findings[:], report.unknown[:] = judged.findings, judged.unknown
            report.open_rules = judged.open_rules
    elif scheduler is None:
        check_model(net, ASKED.share(budget), report, behaviour, orders)
    if with_times is not None and confirm:
        told = confirm_with_times(with_times, run.budget())
    elif scheduler is None:
        if confirm and report.space is not None:
            from dineros.analysis.evidence.confirmation import confirm_space

            confirmation = confirm_space(report.space, run.budget())
    else:
        run.stage(f"using the workers of {scheduler}")
        confirmation = check_on_workers(
            net, scheduler, report, at_any_cost=behaviour, memory=run.limits.memory, is_confirmed=confirm
        )
    if confirmation is not None:
        add_confirmation(report, confirmation)
    report.findings[:] = left_to_lives(net, report).findings
    if any(finding.severity != "note" for finding in report.findings):  # a note neither causes nor follows
        from dineros.analysis.consequences.folding import fold_consequences

        again = None
        if report.times is not None:
            from dineros.analysis.consequences.in_time import gone_in_time

            again = gone_in_time
        fold_consequences(net, report, budget, orders, again)
    report = accepted(report)
    with run.answer():
        report = acceptance.write(report)
        show_failures(report)
        print_report(report, net, model, format, witnesses, faults)
        if told is not None:
            say_confirmed_questions(told, format != "text")
        elif confirm:
            say_confirmation(confirmation, format != "text")
    status = _status(report)
    if any(one is not None and one.agrees is False for one in (confirmation, *(told or {}).values())):
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
        count = check_certificates(report, net, settings, certificate, run.budget(), with_times)
        if format == "text":
            summarise(f"certificates: {certificate}: {count}")
    if output is not None and output.suffix.lower() == ".html":
        from dineros.cli.presentation.reports.checks import write_check_report

        write_check_report(report, net, output, model, settings, code.folders)
        if format == "text":
            summarise(f"{model} -> {output}")
    elif output is not None:
        write_witnesses(report, output, model, settings, say_files=format == "text")
    return status


def _refuse_beside(options: Sequence[str], format: str, others: Sequence[str]) -> None:
    """Reject options that cannot be combined with a suggestion."""
    if len(options) > 1:
        raise click.UsageError(f"{options[0]} cannot be combined with {options[1]}")
    what = "capacities" if options[0] == "--suggest-capacities" else "changes"
    if format not in ("text", "json"):
        raise click.UsageError(f"{what} are not findings: they cannot be printed with --format {format}")
    if "--scheduler" in others:
        raise click.UsageError(f"--scheduler cannot be combined with {options[0]}")
    if others:
        raise click.UsageError(f"{what} are not findings: {others[0]} cannot be combined with {options[0]}")


def _refuse_with_time(options: Mapping[str, object]) -> None:
    """Reject options that cannot be combined with times."""
    for option, value in options.items():
        if value:
            raise click.UsageError(f"--time cannot be combined with {option}")


def _refuse_with_source(output: Path | None, certificate: Path | None) -> None:
    """Reject files that name a model file, if there is none."""
    if certificate is not None or (output is not None and output.suffix.lower() != ".html"):
        option = "-o" if certificate is None else "--certificate"
        hint = "import the model with 'dineros import --source', then check it"
        raise click.UsageError(f"with --source, {option} writes a report (.html) only: {hint}")


def _status(report: Report) -> int:
    if any(finding.severity != "note" for finding in report.findings):
        return VIOLATED
    return UNKNOWN if any(unknown.may_be_fault for unknown in report.unknown) else HOLDS
