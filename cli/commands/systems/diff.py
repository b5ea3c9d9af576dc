"""``dineros diff``: compares a model with a running or recorded system."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import HOLDS, VIOLATED
from dineros.cli.coding import Code, cache_option, code_options, say_taken
from dineros.cli.models import load_valid_system
from dineros.cli.observing import Source, source_options
from dineros.cli.options import format_option, json_option, model_argument, settings_option
from dineros.cli.presentation.findings import print_report
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.witnesses.findings import Report
    from dineros.observation.systems import ObservedSystem


@search_command(
    "dineros diff robot.sym.xmi --graph",
    "dineros diff robot.sym.xmi --graph --domain 7 --namespace /arm",
    "dineros diff seen.sym.xmi --bag recording --format junit",
    "dineros diff coded.sym.xmi --source src --launch robot.launch.py",
)
@model_argument()
@source_options
@code_options()
@cache_option
@format_option("the differences")
@settings_option
@json_option
def diff(
    model: Path,
    source: Source,
    code: Code,
    format: str,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Compare a model with a running graph, a recording or source code: nodes, ports, types, QoS.

    For source code, ports with an open name or type are omitted, and listed.
    For a recording, only topics are compared, because it does not contain nodes. A node that disappeared
    while the graph was watched counts as missing. The exit status is 1 if something differs; notes do not
    count.
    """
    from dineros.analysis.witnesses.findings import worst_first
    from dineros.observation.differences.comparing import FAULTS, differences

    code.refuse_without_folders()
    system = load_valid_system(model, settings)

    def compared(seen: ObservedSystem) -> Report:
        return differences(system, seen, source.namespaces, source.without)

    if code.folders:
        code.refuse_beside(source.bag, source.graph or source.domain is not None)
        read, _ = code.read()
        say_taken(read.taken)
        report = compared(read.system)
    else:
        report = compared(source.system(lambda seen: bool(compared(seen).findings)))
    report.findings = worst_first(report.findings)
    with search().answer():
        print_report(
            report,
            system,
            model,
            "json" if as_json else format,
            witnesses=False,
            faults=FAULTS,
            command="diff",
        )
    return VIOLATED if any(finding.severity != "note" for finding in report.findings) else HOLDS
