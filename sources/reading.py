"""From folders of source code to facts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from dineros.sources.facts import Facts, is_open
from dineros.sources.folders import open_folder
from dineros.sources.language.modules import Modules
from dineros.sources.launch.description import Started, full
from dineros.sources.launch.reading import LaunchFiles
from dineros.sources.libraries.idioms import known_idioms, read_idioms
from dineros.sources.packages import packages_of
from dineros.sources.programs import Reading, read_programs


def read_source(root: Path, tables: Sequence[Path] = ()) -> Facts:
    """Return what the Python packages of a folder say; nothing in it is executed or imported.

    Parameters
    ----------
    root : Path
        The folder.
    tables : sequence of Path
        Tables of library idioms, beside those that are known.

    Raises
    ------
    DinerosError
        There is no such folder, it has too many files, or a table cannot be read.
    """
    idioms = dict(known_idioms())
    for table in tables:
        idioms |= read_idioms(table)
    folder = open_folder(root)
    packages = packages_of(folder)
    modules = Modules(folder, [package.path for package in packages])
    files = LaunchFiles(folder, packages, modules, idioms)
    launch = []
    shown: list[tuple[dict[str, Any], Started]] = []
    given: dict[str, list[dict[str, Any]]] = {}
    for path in files.all():
        arguments, started = files.read(path, {}, follows=False)
        entries = [each.to_json() for each in started]
        shown += zip(entries, started, strict=True)
        launch.append({"file": path, "arguments": arguments, "nodes": entries})
        for each in started:
            if each.executable and not is_open(each.executable):
                name = each.to_json().get("name", f"/{each.executable}")
                found = files.parameters(each, str(name))
                given.setdefault(f"{each.package}/{each.executable}", []).append(found)
    facts = read_programs(
        Reading(folder, packages, idioms, {k: _agreed(v) for k, v in given.items()}), modules
    )
    names = {node.program: node.name for node in facts.nodes if not is_open(node.name)}
    for entry, each in shown:
        name = names.get(f"{each.package}/{each.executable}")
        if "name" not in entry and each.kind != "include" and name is not None:
            entry["name"] = full(name, each.namespace)
    facts.launch = launch
    return facts


def _agreed(found: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the values on which all launch files agree."""
    return {
        key: value for key, value in found[0].items() if all(each.get(key) == value for each in found[1:])
    }
