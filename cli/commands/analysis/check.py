"""``dineros check``: every question with a yes/no answer that can be asked of any model."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    VIOLATED,
    budget_of,
    exploring,
    load_valid,
    memory_option,
)
from dineros.cli.console import summarise
from dineros.cli.options import (
    ModelPath,
    command,
    json_option,
    middleware_option,
    model_argument,
    settings_option,
)
from dineros.cli.orders import cache_option, orders_beside
from dineros.cli.presentation.findings import print_report, say_capacities, write_witnesses
from dineros.cli.quick_start import start_quickly

if TYPE_CHECKING:
    from dineros.metamodel import pn


@command(
    "dineros check sorting.sym.xmi",
    "dineros check sorting.sym.xmi --set RedObjects.tokens=2 --format junit > findings.xml",
    "dineros check sorting.sym.xmi --suggest-capacities",
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
@memory_option
@cache_option
@middleware_option
@settings_option
@json_option
def check(
    model: Path,
    format: str,
    suggest_capacities: bool,
    behaviour: bool,
    witnesses: bool,
    output: Path | None,
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
    from dineros.analysis.questions.check import check as check_model
    from dineros.analysis.witnesses.findings import Report, Unknown

    format = "json" if as_json else format
    if suggest_capacities and format not in ("text", "json"):
        raise click.UsageError(f"capacities are no findings: there is no --format {format} of them")
    if suggest_capacities and output is not None:
        raise click.UsageError("capacities are no findings: -o does not go with --suggest-capacities")
    net = load_valid(model, settings)
    if suggest_capacities:
        return _suggest(net, model, memory, format == "json", witnesses)
    report = Report()
    try:
        with exploring() as progress:
            budget = budget_of(memory, progress=progress)
            check_model(net, budget, report, behaviour, orders_beside(model, no_cache))
    except KeyboardInterrupt:
        report.unknown.append(Unknown("everything else", "interrupted"))
        print_report(report, net, model, format, witnesses)
        raise
    print_report(report, net, model, format, witnesses)
    if output is not None and output.suffix.lower() == ".html":
        from dineros.cli.presentation.check_reports import write_check_report

        write_check_report(report, net, output, model, settings, memory)
        if format == "text":
            summarise(f"{model} -> {output}")
    elif output is not None:
        write_witnesses(report, output, model, settings, say_files=format == "text")
    if any(finding.severity != "note" for finding in report.findings):
        return VIOLATED
    return UNKNOWN if any(unknown.may_be_fault for unknown in report.unknown) else HOLDS


def _suggest(net: pn.Net, model: Path, memory: int | None, as_json: bool, witnesses: bool) -> int:
    from dineros.analysis.questions.capacities import suggest_capacities
    from dineros.metamodel import sym
    from dineros.metamodel.errors import DinerosError, Location

    if not isinstance(net, sym.SystemModel):
        raise DinerosError("has no queues: it is no system model", location=Location(model))
    with exploring() as progress:
        found = suggest_capacities(net, budget_of(memory, progress=progress))
    say_capacities(found, model, as_json, witnesses)
    if all(capacity.needed is not None and capacity.needed <= capacity.limit for capacity in found):
        return HOLDS
    return (
        UNKNOWN if any(capacity.needed is None and not capacity.witness for capacity in found) else VIOLATED
    )
