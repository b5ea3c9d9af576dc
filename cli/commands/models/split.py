"""``dineros split``: a system model as one run-time model per node net."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from dineros.cli.console import note, say, say_json, summarise, working
from dineros.cli.models import load_valid_system
from dineros.cli.options import command, json_option, model_argument, settings_option
from dineros.metamodel.errors import counted


@command("dineros split sorting.sym.xmi -o nodes", "dineros split sorting.sym.xmi -o nodes --json")
@model_argument()
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="DIR",
    required=True,
    help="The folder to write.",
)
@settings_option
@json_option
def split(model: Path, output: Path, settings: tuple[str, ...], as_json: bool) -> int:
    """Split a system model into one run-time model per node net: DIR/NODE.rtm.xmi.

    Channels are gone; their ports stay as information on the places. DIR is made where it is not there; other
    files in it are left alone.
    """
    from dineros.metamodel import files, rtm
    from dineros.metamodel.elements import places, transitions
    from dineros.transformations.flattening.split import split as split_model

    system = load_valid_system(model, settings)
    with working(f"Splitting {model}"):
        parts = split_model(system)
    _make(output)
    names = file_names([part.node.id for part in parts])
    rows: list[dict[str, Any]] = []
    for part, name in zip(parts, names, strict=True):
        path = output / name
        files.save(part, path)
        note(f"wrote {path}")
        held = [place for place in places(part) if isinstance(place, rtm.Place)]
        rows.append(
            {
                "node": part.node.id,
                "file": str(path),
                "places": len(held),
                "transitions": len(transitions(part)),
                "ports": sum(len(place.ports) for place in held),
                "signals": len(part.node.signals),
            }
        )
    if as_json:
        say_json({"model": str(model), "nodes": rows})
        return 0
    for row in rows:
        counts = ", ".join(
            counted(row[f"{what}s"], what) for what in ("place", "transition", "port", "signal")
        )
        say(f"{row['node']} -> {row['file']}: {counts}")
    summarise(f"{model}: {counted(len(rows), 'node net')}")
    return 0


def file_names(ids: list[str]) -> list[str]:
    """Return a file name for each node net: its id, without what a file name cannot hold."""
    names: list[str] = []
    for id in ids:
        stem = re.sub(r"[^\w.+-]", "_", id).lstrip(".") or "_"
        name, number = f"{stem}.rtm.xmi", 1
        while name in names:
            number += 1
            name = f"{stem}~{number}.rtm.xmi"
        names.append(name)
    return names


def _make(folder: Path) -> None:
    from dineros.metamodel.errors import Location, ModelFileError

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise ModelFileError("is a file", location=Location(folder), hint="name a folder") from error
    except OSError as error:
        raise ModelFileError(f"cannot be made: {error.strerror}", location=Location(folder)) from error
