"""``dineros import``: builds a system model of an existing system."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import HOLDS, VIOLATED
from dineros.cli.coding import Code, cache_option, code_options, say_taken
from dineros.cli.models import refuse_invalid
from dineros.cli.observing import Source, source_options
from dineros.cli.options import json_option, output_option, path_option, values_option
from dineros.cli.outputs import refuse_output
from dineros.cli.presentation.imports import ImportReport, print_import
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.witnesses.findings import Finding, Report
    from dineros.observation.importing.coded import Coded
    from dineros.observation.systems import ObservedSystem


@search_command(
    "dineros import --graph -o robot.sym.xmi",
    "dineros import --graph --domain 7 --namespace /arm --watch 10 -o arm.sym.xmi",
    "dineros import --bag recording -o robot.sym.xmi",
    "dineros import --source src -o robot.sym.xmi --facts facts.json",
    "dineros import --source src --launch robot.launch.py rviz:=false -o robot.sym.xmi",
    "dineros import --source src --launch robot.launch.py --graph -o robot.sym.xmi",
    "dineros import --interfaces std_msgs -o messages.sym.xmi",
)
@source_options
@code_options()
@cache_option
@values_option(
    "--interfaces PACKAGE", "Import only the messages of an installed package, as token types; repeatable."
)
@path_option(
    "--given FILE.toml",
    "Facts that a graph does not show: depths, groups, threads, timers, actions of callbacks.",
    show_default="OUT with .given.toml",
)
@output_option("The model to write: .xmi or .pnml.", required=True)
@json_option
def import_(
    source: Source,
    code: Code,
    interfaces: tuple[str, ...],
    given: Path | None,
    output: Path,
    as_json: bool,
) -> int:
    """Make a system model of a running graph, a recording or source code, with one node net per node.

    --source reads packages in Python and C++ without running them: ports, groups, executors, and the steps of
    callbacks, with the lines of the code. Code that it cannot follow is left open, and listed. With
    --graph, the model is made of the code, and differences of the running graph are findings.

    Facts that a graph does not show are assumed, marked in the model and listed. A file next to the model
    contains them: it is written if it does not exist, and never overwritten; correct it, and import again. A
    callback without declared actions can do everything that its node can.

    The exit status is 1 if ports do not match or names have two meanings; the model is still written. If
    there is no node or topic it is 2, and nothing is written.
    """
    refuse_output(output, (".xmi", ".pnml"))
    if interfaces:
        if source.graph or source.bag is not None:
            raise click.UsageError("--interfaces cannot be combined with --graph or --bag")
        return _interfaces(interfaces, output, as_json)
    code.refuse_without_folders()
    folders, namespaces, without = code.folders, source.namespaces, source.without
    lacks: tuple[str, ...] = ()
    from dineros.metamodel.files import save
    from dineros.metamodel.files.atomic import write_atomically
    from dineros.metamodel.ros_names import snake_case
    from dineros.observation.findings.mismatches import mismatches
    from dineros.observation.findings.types import unknown_types
    from dineros.observation.importing.building import to_model
    from dineros.observation.importing.given import Given
    from dineros.observation.importing.given_reading import given_beside, read_given
    from dineros.observation.importing.questions import to_be_given
    from dineros.observation.systems import within

    beside = given or given_beside(output)
    said = read_given(beside) if given is not None or beside.exists() else Given()
    if folders:
        code.refuse_beside(source.bag, graph=False)
        if source.domain is not None and not source.graph:
            raise click.UsageError("--domain requires --graph")
        read, found = code.read()
        if source.graph:
            found += _against(read, source)
        seen, said = within(read.system, namespaces, without), read.with_people(said)
        named = within(read.apart, namespaces, without)
        threads = read.lacks_of_threads(said)
        lacks = (*read.lacks, *threads)
        say_taken((*read.taken, *threads))
    else:
        named = seen = source.system(lambda seen: bool(mismatches(seen)))
    kept = within(seen, namespaces)
    faults = code.mismatches(read, named) if folders else mismatches(named)
    findings = [*faults, *unknown_types(seen)]
    if namespaces:
        names = {node.name for node in within(named, namespaces).nodes}
        findings = [finding for finding in findings if names.intersection(finding.elements)]
    if folders:  # code needs no interfaces here; whose lines they are, is in the messages
        findings = [*found, *(each for each in findings if each.rule != "type-unknown")]
    search().stage("making the model")
    imported = to_model(kept, said, snake_case(output.name.split(".")[0]), lacks)
    refuse_invalid(imported.model, output)
    save(imported.model, output)
    is_written = bool(imported.assumed or imported.recorded) and not beside.exists()
    if is_written:
        write_atomically(beside, to_be_given(imported, kept, output).encode())
    report = ImportReport(kept, imported, findings, output, beside, is_written)
    with search().answer():
        print_import(report, as_json)
    return VIOLATED if any(finding.severity == "error" for finding in findings) else HOLDS


def _against(read: Coded, source: Source) -> list[Finding]:
    """Return the differences between a running graph and the code."""
    from dineros.observation.differences.code import differences_of_code

    def compared(seen: ObservedSystem) -> Report:
        return differences_of_code(read.apart, seen, source.namespaces, source.without)

    return compared(source.system(lambda seen: bool(compared(seen).findings))).findings


def _interfaces(packages: tuple[str, ...], output: Path, as_json: bool) -> int:
    from dineros.cli.console import say_json, summarise
    from dineros.metamodel.errors import counted
    from dineros.metamodel.files import save
    from dineros.metamodel.ros_names import snake_case
    from dineros.observation.importing.interfaces import token_types_of

    model, left_out = token_types_of(packages, snake_case(output.name.split(".")[0]))
    refuse_invalid(model, output)
    save(model, output)
    names = [str(each.ros) for each in (model.tokenType, *model.otherTokenTypes) if each is not None]
    if as_json:
        say_json({"model": str(output), "types": names, "left_out": left_out})
        return HOLDS
    from dineros.cli.console import warn

    for line in left_out:
        warn(f"left out: {line}")
    summarise(f"{', '.join(packages)} -> {output}: {counted(len(names), 'token type')}")
    return HOLDS
