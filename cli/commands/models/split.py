"""``dineros split``: a system model as one run-time model per node net."""

from __future__ import annotations

from pathlib import Path

from dineros.cli.console import note, working
from dineros.cli.models import load_valid_system
from dineros.cli.options import ANY_PATH, json_option, model_argument, output_option, settings_option
from dineros.cli.outputs import refuse_file
from dineros.cli.presentation.workspaces import say_parts
from dineros.cli.supervising import reading_command


@reading_command("dineros split sorting.sym.xmi -o nodes", "dineros split sorting.sym.xmi -o nodes --json")
@model_argument()
@output_option("The folder to write.", metavar="DIR", required=True, type=ANY_PATH)
@settings_option
@json_option
def split(model: Path, output: Path, settings: tuple[str, ...], as_json: bool) -> int:
    """Split a system model into one run-time model per node net: DIR/NODE.rtm.xmi.

    Channels are removed; their ports are kept as information on the places. DIR is created if it does not
    exist; other files in it are not changed.
    """
    from dineros.metamodel import files
    from dineros.metamodel.files.whole_folders import whole_folder
    from dineros.metamodel.files.xmi import xmi_bytes
    from dineros.transformations.flattening.split import file_names
    from dineros.transformations.flattening.split import split as split_model

    system = load_valid_system(model, settings)
    with working(f"Splitting {model}"):
        parts = split_model(system)
    written = {output / name: part for name, part in zip(file_names(parts), parts, strict=True)}
    for path, part in written.items():
        xmi_bytes(part, path)  # before the first file is written, each must be one that can be
    refuse_file(output)
    with whole_folder(output) as folder:
        for path, part in written.items():
            files.save(part, folder / path.name)
    for path in written:
        note(f"wrote {path}")
    say_parts(model, written, as_json)
    return 0
