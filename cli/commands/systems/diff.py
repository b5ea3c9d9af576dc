"""``dineros diff``: a model against a system that runs or was recorded."""

from __future__ import annotations

from pathlib import Path

import click

from dineros.cli.analysing import HOLDS, VIOLATED
from dineros.cli.models import load_system, refuse_invalid
from dineros.cli.observing import source_of, source_options
from dineros.cli.options import command, json_option, model_argument, settings_option
from dineros.cli.presentation.findings import print_report


@command(
    "dineros diff robot.sym.xmi --graph",
    "dineros diff robot.sym.xmi --graph --domain 7 --namespace /arm",
    "dineros diff robot.sym.xmi --bag recording --format junit",
)
@model_argument()
@source_options
@click.option(
    "--format",
    "format",
    type=click.Choice(["text", "json", "sarif", "junit"]),
    default="text",
    show_default=True,
    help="How to print the differences; CI shows SARIF and JUnit.",
)
@settings_option
@json_option
def diff(
    model: Path,
    graph: bool,
    bag: Path | None,
    domain: int | None,
    namespaces: tuple[str, ...],
    without: tuple[str, ...],
    seconds: float,
    format: str,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Compare a model with a running graph or a recording: nodes, ports, types, quality of service.

    Of a recording, topics only are compared: it does not tell its nodes. A node that went while it was
    watched counts as missing. The exit status is 1 where something differs; a note does not count.
    """
    from dineros.observation.differences.comparing import FAULTS, differences

    source = source_of(graph, bag, domain, namespaces, without, seconds)
    system = load_system(model, settings)
    refuse_invalid(system, model)
    report = differences(system, source.system(), namespaces, without)
    print_report(report, system, model, "json" if as_json else format, witnesses=False, faults=FAULTS)
    return VIOLATED if any(finding.severity != "note" for finding in report.findings) else HOLDS
