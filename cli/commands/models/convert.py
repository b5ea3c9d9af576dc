"""``dineros convert``: a model in another file format, or as a picture."""

from __future__ import annotations

from pathlib import Path

from dineros.cli.console import note, summarise, warn, working
from dineros.cli.models import load_named, refuse_settings_that_break, violations_of
from dineros.cli.options import model_argument, output_option, settings_option, value_option
from dineros.cli.outputs import PICTURES, refuse_output
from dineros.cli.supervising import reading_command


@reading_command(
    "dineros convert sorting.sym.xmi -o sorting.pnml",
    "dineros convert sorting.sym.xmi -o two_red.sym.xmi --set RedObjects.tokens=2",
    "dineros convert sorting.sym.xmi -o sorting.svg",
)
@model_argument()
@output_option(
    "The file to write; its suffix gives the format: .xmi, .sym, .pnml, .net, .xml, .cts; "
    "pictures are .svg, .png, .html.",
    required=True,
)
@value_option(
    "--properties FILE.xml",
    "Store the formulas of a property file of the Model Checking Contest in the model.",
)
@settings_option
def convert(model: Path, output: Path, properties: str | None, settings: tuple[str, ...]) -> int:
    """Write a model in another format: XMI, PNML, TINA (.net), Romeo (.xml, .cts), or as a picture.

    A model that violates constraints is still converted, with a warning. OUT is written atomically. 'dineros
    view' has more options for pictures.
    """
    from dineros.metamodel import files

    refuse_output(output, (*files.SUFFIXES, *PICTURES))
    net = load_named(model, settings)
    if properties is not None:
        from dineros.cli.questions.property_files import take_in

        note(f"properties taken from {properties}: {take_in(net, properties, model)}")
    violations = violations_of(net)
    if settings:
        refuse_settings_that_break(violations, model)
    with working(f"Writing {output}"):
        if output.suffix.lower() in PICTURES:
            from dineros.views.nets import collapse_if_large, save_picture, view_of

            save_picture(collapse_if_large(view_of(net)), output)
        else:
            files.save(net, output)
    note(f"wrote {output}")
    errors = sum(violation.severity == "error" for violation in violations)
    if errors:
        warn(f"{model}: warning: the model has errors: {errors} ('dineros validate' lists them)")
    summarise(f"{model} -> {output}")
    return 0
