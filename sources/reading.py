"""From folders of source code to facts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dineros.sources.facts import Facts
from dineros.sources.folders import open_folder
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
    return read_programs(Reading(folder, packages_of(folder), idioms))
