"""Common parts of subcommands that write files: early detection of files that cannot be written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import warn

if TYPE_CHECKING:
    from dineros.metamodel.errors import DinerosError

PICTURES = (".svg", ".png", ".html")
"""Suffixes of pictures; the same as `dineros.views.nets.FORMATS`, which is slow to import."""


def refuse_output(output: Path, formats: Sequence[str], what: str = "to convert to") -> None:
    """Check before long work that a file can be written.

    Parameters
    ----------
    formats : sequence of str
        The suffixes that it may have.
    what : str
        The kind of the formats.

    Raises
    ------
    ModelFileError
        The suffix belongs to no format, the file is a directory, or its folder does not exist.
    """
    from dineros.metamodel.errors import Location, ModelFileError

    if output.suffix.lower() not in formats:
        raise ModelFileError(
            f"{output.suffix!r} is not a format {what}" if output.suffix else "has no suffix",
            location=Location(output),
            hint=f"known are {', '.join(formats)}",
        )
    if output.is_dir():
        raise ModelFileError("is a directory", location=Location(output), hint="name a file")
    if not output.parent.is_dir():
        raise ModelFileError(
            f"cannot be written: there is no folder {str(output.parent)!r}",
            location=Location(output),
            hint="create the folder first",
        )


def write_page(output: Path, page: str, failure: DinerosError | None, pictures: str = "a picture") -> None:
    """Write a page, atomically; a line reports missing pictures, and why they could not be drawn."""
    from dineros.metamodel.files.atomic import write_atomically

    write_atomically(output, page.encode())
    if failure is not None:
        warn(f"{output}: without {pictures}: {failure}")


def refuse_file(folder: Path) -> None:
    """Check that a folder to write to is not a file.

    Raises
    ------
    ModelFileError
        It is.
    """
    from dineros.metamodel.errors import Location, ModelFileError

    if folder.exists() and not folder.is_dir():
        raise ModelFileError("is a file", location=Location(folder), hint="name a folder")
