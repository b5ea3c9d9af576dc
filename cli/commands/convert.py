"""``dineros convert``: a model in another file format."""

from __future__ import annotations

from pathlib import Path

from dineros.cli.console import note, summarise, warn, working
from dineros.cli.models import load, refuse_settings_that_break, violations_of
from dineros.cli.options import command, model_argument, output_option, settings_option


@command(
    "dineros convert sorting.sym.xmi -o sorting.pnml",
    "dineros convert sorting.sym.xmi -o two_red.sym.xmi --set RedObjects.tokens=2",
)
@model_argument()
@output_option("The file to write; its suffix tells the format: .xmi, .sym, .pnml or .net.")
@settings_option
def convert(model: Path, output: Path, settings: tuple[str, ...]) -> int:
    """Write a model in another format: XMI (.xmi), PNML (.pnml) or TINA (.net).

    A model that violates constraints is converted all the same, with a warning. OUT is written as a whole or
    not at all.
    """
    from dineros.metamodel import files

    _refuse_output(output)
    net = load(model, settings)
    violations = violations_of(net)
    if settings:
        refuse_settings_that_break(violations, model)
    with working(f"Writing {output}"):
        files.save(net, output)
    note(f"wrote {output}")
    errors = sum(violation.severity == "error" for violation in violations)
    if errors:
        warn(f"{model}: warning: the model has errors: {errors} ('dineros validate' lists them)")
    summarise(f"{model} -> {output}")
    return 0


def _refuse_output(output: Path) -> None:
    """Find out before long work, not after it, that a file cannot be written."""
    from dineros.metamodel.errors import Location, ModelFileError
    from dineros.metamodel.files import SUFFIXES

    if output.suffix.lower() not in SUFFIXES:
        raise ModelFileError(
            f"{output.suffix!r} is no format to convert to" if output.suffix else "has no suffix",
            location=Location(output),
            hint=f"known are {', '.join(SUFFIXES)}",
        )
    if output.is_dir():
        raise ModelFileError("is a directory", location=Location(output), hint="name a file")
    if not output.parent.is_dir():
        raise ModelFileError(
            f"cannot be written: there is no folder {str(output.parent)!r}",
            location=Location(output),
            hint="make the folder first",
        )
