"""``dineros flatten``: flattens a system model to one plain net, with trace links."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dineros.cli.console import note, say_json, summarise, working
from dineros.cli.models import load_valid_system, rules_of, say_rules
from dineros.cli.options import (
    json_option,
    model_argument,
    output_option,
    rules_option,
    settings_option,
    value_option,
    variant_options,
)
from dineros.cli.outputs import refuse_output
from dineros.cli.presentation.explanations import explained, say_explanation
from dineros.cli.rule_files import load_rules
from dineros.cli.supervising import reading_command

if TYPE_CHECKING:
    from dineros.transformations.flattening.flatten import Flattened
    from dineros.transformations.rules.phases import OverflowVariant, SignalVariant


@reading_command(
    "dineros flatten sorting.sym.xmi -o sorting.pnm",
    "dineros flatten sorting.sym.xmi -o sorting.net --signals none --overflow inhibitor",
    "dineros flatten sorting.sym.xmi --explain LeftCellObjects",
)
@model_argument()
@output_option("The file to write: .pnm or .xmi, .pnml, .net.")
@rules_option("Apply the list RULES of this Python file after the standard rules.")
@variant_options
@settings_option
@value_option(
    "--explain ELEMENT", "Show which rule made an element from which elements, and what was made from it."
)
@json_option
def flatten(
    model: Path,
    output: Path | None,
    signals: SignalVariant,
    overflow: OverflowVariant,
    rule_file: Path | None,
    settings: tuple[str, ...],
    explain: str | None,
    as_json: bool,
) -> int:
    """Flatten a system model into one plain Petri net.

    The place invariants that the rules guarantee are checked on the net. A trace model is written next to
    OUT: for sorting.pnm it is sorting.trace.xmi.
    """
    from dineros.transformations.flattening import flatten as flattening
    from dineros.transformations.pictures.explaining import explain as explain_element

    if output is None and explain is None:
        raise click.MissingParameter(param_hint="'-o' or '--explain'", param_type="option")
    if output is not None:
        _refuse_output(model, output)
    own = load_rules(rule_file)
    system = load_valid_system(model, settings)
    say_rules(system, model)
    with working(f"Flattening {model}"):
        result = flattening.flatten(system, signals, overflow, own)
    report = {**_counts(model, result, signals, overflow), **rules_of(system)}
    explanation = None if explain is None else explain_element(explain, system, result.trace)
    if output is not None:
        report |= _write(result, model, output, changed=bool(settings))
    if explanation is not None and explain is not None:
        report["explained"] = explained(explanation, explain)
    if as_json:
        say_json(report)
        return 0
    if explanation is not None and explain is not None:
        say_explanation(explanation, explain)
    if output is not None:
        counts = ", ".join(f"{report[what]} {what}" for what in ("places", "transitions", "arcs"))
        summarise(f"{model} -> {output}: {counts}; {report['invariants']} place invariants hold")
    return 0


def _refuse_output(model: Path, output: Path) -> None:
    """Reject a file of the wrong kind before long work."""
    from dineros.metamodel.errors import Location, ModelFileError
    from dineros.metamodel.files import SUFFIXES
    from dineros.metamodel.files.reading import resolved
    from dineros.transformations.flattening.trace_files import trace_path

    refuse_output(output, SUFFIXES, "of nets")
    if resolved(model) in (resolved(output), resolved(trace_path(output))):
        raise ModelFileError(
            "is the system model itself", location=Location(output), hint="name another file"
        )


def _counts(model: Path, result: Flattened, signals: str, overflow: str) -> dict[str, Any]:
    from dineros.metamodel.elements import arcs, places, transitions

    net = result.net
    return {
        "model": str(model),
        "signals": signals,
        "overflow": overflow,
        "places": len(places(net)),
        "transitions": len(transitions(net)),
        "arcs": len(list(arcs(net))),
        "invariants": len(net.certificate),
    }


def _write(result: Flattened, model: Path, output: Path, changed: bool) -> dict[str, str]:
    from dineros.metamodel import files
    from dineros.transformations.flattening.trace_files import save_trace

    with working(f"Writing {output}"):
        files.save(result.net, output)
        note(f"wrote {output}")
        trace = save_trace(result.trace, model, output, changed=changed)
        note(f"wrote {trace}")
    return {"output": str(output), "trace": str(trace)}
