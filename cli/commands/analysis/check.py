"""``dineros check``: every question with a yes/no answer that can be asked of any model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    VIOLATED,
    budget_options,
    load_valid,
)
from dineros.cli.console import summarise, warn
from dineros.cli.options import ModelPath, json_option, middleware_option, model_argument, settings_option
from dineros.cli.orders import cache_option, orders_beside
from dineros.cli.presentation.evidence import (
    check_certificates,
    confirm_option,
    confirmed_report,
    refuse_certificates,
    report_confirmed,
    say_confirmation,
)
from dineros.cli.presentation.findings import print_report, write_witnesses
from dineros.cli.presentation.scheduling import check_on_workers, scheduler_option
from dineros.cli.presentation.suggestions import say_callback_groups, say_capacities, say_start_order
from dineros.cli.quick_start import start_quickly
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.witnesses.findings import Report
    from dineros.metamodel import pn


@search_command(
    "dineros check sorting.sym.xmi",
    "dineros check sorting.sym.xmi --set RedObjects.tokens=2 --format junit > findings.xml",
    "dineros check sorting.sym.xmi --suggest-capacities",
    "dineros check robot.sym.xmi --suggest-callback-groups",
    "dineros check camera.sym.xmi --suggest-start-order",
    "dineros check sorting.sym.xmi -o report.html",
)
@model_argument()
@click.option(
    "--format",
    "format",
    type=click.Choice(["text", "json", "sarif", "junit"]),
    default="text",
    show_default=True,
    help="How to print the findings; CI shows SARIF and JUnit.",
)
@click.option(
    "--suggest-capacities",
    is_flag=True,
    help="Instead, for each queue, the smallest capacity that loses no message.",
)
@click.option(
    "--suggest-callback-groups",
    is_flag=True,
    help="Instead, the smallest change of groups and threads after which no callback waits for ever.",
)
@click.option(
    "--suggest-start-order",
    is_flag=True,
    help="Instead, an order of bringing managed nodes up in which no message is lost.",
)
@click.option(
    "--behaviour",
    is_flag=True,
    help="Decide liveness, reversibility and home markings, however long it takes.",
)
@click.option("--witnesses", is_flag=True, help="Print how each finding comes about, step by step.")
@click.option(
    "-o",
    "--output",
    type=ModelPath(),
    metavar="OUT",
    help="Write a report (.html); or how the findings come about to OUT, OUT with .2, .3 ... (JSON Lines).",
)
@click.option(
    "--certificate",
    type=ModelPath(),
    metavar="FILE|FOLDER",
    help="Write what answers rest on that structure or induction prove: of all (.json), or one file each.",
)
@confirm_option
@scheduler_option
@budget_options
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
    witnesses: bool,
    output: Path | None,
    certificate: Path | None,
    confirm: bool,
    scheduler: str | None,
    timeout: float | None,
    memory: int | None,
    no_cache: bool,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Check a model: clauses, overflow of queues, unused and dead parts, boundedness, deadlock.

    Exit status 1 when something is found (a note does not count), 3 when something stays unknown (what could
    be a note at worst does not count).
    """
    start_quickly()
    from dineros.analysis.checks.check import check as check_model
    from dineros.analysis.witnesses.findings import Report, Unknown

    format = "json" if as_json else format
    asked = {
        "--suggest-capacities": suggest_capacities,
        "--suggest-callback-groups": suggest_callback_groups,
        "--suggest-start-order": suggest_start_order,
    }
    suggests = [option for option, is_asked in asked.items() if is_asked]
    if suggests:
        written = "-o" if output is not None else "--certificate" if certificate is not None else None
        _refuse_beside(suggests, format, written)
    if scheduler is not None and suggests:
        raise click.UsageError(f"--scheduler does not go with {suggests[0]}")
    if certificate is not None:
        refuse_certificates(certificate, also_folder=True)
    net = load_valid(model, settings)
    if suggest_callback_groups:
        return _suggest_groups(net, model, format == "json", witnesses)
    if suggest_start_order:
        return _suggest_order(net, model, format == "json", witnesses)
    if suggest_capacities:
        return _suggest(net, model, format == "json", witnesses)
    run, report = search(), Report()

    def so_far(ending: str) -> int:
        rest = Report(report.findings, report.proved, [*report.unknown, Unknown("everything else", ending)])
        print_report(rest, net, model, format, witnesses)
        return _status(rest)

    run.draft(so_far)
    if scheduler is None:
        check_model(net, run.budget(), report, behaviour, orders_beside(model, no_cache))
        confirmation = confirmed_report(report, run.budget()) if confirm else None
    else:
        run.stage(f"asking the workers of {scheduler}")
        said = check_on_workers(
            net, scheduler, report, at_any_cost=behaviour, memory=memory, is_confirmed=confirm
        )
        confirmation = report_confirmed(report, said)
    with run.answer():
        print_report(report, net, model, format, witnesses)
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


def _refuse_beside(options: Sequence[str], format: str, written: str | None) -> None:
    if len(options) > 1:
        raise click.UsageError(f"{options[0]} does not go with {options[1]}")
    what = "capacities" if options[0] == "--suggest-capacities" else "changes"
    if format not in ("text", "json"):
        raise click.UsageError(f"{what} are no findings: there is no --format {format} of them")
    if written is not None:
        raise click.UsageError(f"{what} are no findings: {written} does not go with {options[0]}")


def _status(report: Report) -> int:
    if any(finding.severity != "note" for finding in report.findings):
        return VIOLATED
    return UNKNOWN if any(unknown.may_be_fault for unknown in report.unknown) else HOLDS


def _suggest_groups(net: pn.Net, model: Path, as_json: bool, witnesses: bool) -> int:
    from dineros.analysis.suggestions.callback_groups import Suggestion, suggest_callback_groups
    from dineros.metamodel import sym
    from dineros.metamodel.callbacks.groups import runs_callbacks
    from dineros.metamodel.elements import node_nets
    from dineros.metamodel.errors import DinerosError, Location

    if not isinstance(net, sym.SystemModel):
        raise DinerosError("has no callbacks: it is no system model", location=Location(model))
    if net.middleware != sym.Middleware.ros2 or not any(map(runs_callbacks, node_nets(net))):
        raise DinerosError(
            "no node net runs callbacks under the rules of ros2",
            location=Location(model),
            hint="set execution=callbacks for node nets that are written by hand, and middleware=ros2",
        )
    run, suggestion = search(), Suggestion()

    def so_far(ending: str) -> int:
        suggestion.reason = ending
        say_callback_groups(suggestion, net, model, as_json, witnesses)
        return UNKNOWN

    run.draft(so_far)
    suggest_callback_groups(net, run.budget(), suggestion)
    with run.answer():
        say_callback_groups(suggestion, net, model, as_json, witnesses)
    if suggestion.is_found and not suggestion.changes:
        return HOLDS
    return VIOLATED if suggestion.is_found or suggestion.is_proved else UNKNOWN


def _suggest_order(net: pn.Net, model: Path, as_json: bool, witnesses: bool) -> int:
    from dineros.analysis.suggestions.start_orders import StartOrder, suggest_start_order
    from dineros.metamodel import sym
    from dineros.metamodel.errors import DinerosError, Location
    from dineros.metamodel.lifecycles.start_order import managed_nodes

    if (
        not isinstance(net, sym.SystemModel)
        or net.middleware != sym.Middleware.ros2
        or not managed_nodes(net)
    ):
        raise DinerosError(
            "no node net has a lifecycle under the rules of ros2",
            location=Location(model),
            hint="set NODE.lifecycle.pauses=false for a node that is to be managed, and middleware=ros2",
        )
    run, found = search(), StartOrder()

    def so_far(ending: str) -> int:
        found.reason = ending
        say_start_order(found, net, model, as_json, witnesses)
        return UNKNOWN

    run.draft(so_far)
    suggest_start_order(net, run.budget(), found)
    with run.answer():
        say_start_order(found, net, model, as_json, witnesses)
    if found.is_found and not found.order:
        return HOLDS
    return VIOLATED if found.is_found or found.is_proved else UNKNOWN


def _suggest(net: pn.Net, model: Path, as_json: bool, witnesses: bool) -> int:
    from dineros.analysis.suggestions.capacities import Capacity, suggest_capacities
    from dineros.metamodel import sym
    from dineros.metamodel.errors import DinerosError, Location

    if not isinstance(net, sym.SystemModel):
        raise DinerosError("has no queues: it is no system model", location=Location(model))
    run = search()
    found: list[Capacity] = []

    def so_far(ending: str) -> int:
        say_capacities(found, model, as_json, witnesses, ending)
        return UNKNOWN

    run.draft(so_far)
    suggest_capacities(net, run.budget(), found)
    with run.answer():
        say_capacities(found, model, as_json, witnesses)
    if all(capacity.needed is not None and capacity.needed <= capacity.limit for capacity in found):
        return HOLDS
    is_open = any(capacity.needed is None and not capacity.grows for capacity in found)
    return UNKNOWN if is_open else VIOLATED
