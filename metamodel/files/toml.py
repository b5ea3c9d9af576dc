"""TOML of unknown origin: read within limits, with errors that name file and line."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from dineros.metamodel.errors import DinerosError, Location

MOST_PARTS = 64
"""Parts of a key with dots between them: the time to read one grows with the square of their number."""

_PLACE = re.compile(r" \(at line (\d+), column (\d+)\)$")

_NO_KEY = re.compile(r"""[^\w.\-"' \t]+""")
"""What separates keys with dots: anything else than words, quotes and blanks."""


def decode_toml(content: bytes, path: Path) -> dict[str, Any]:
    """Return the table that a file of TOML holds.

    Parameters
    ----------
    content : bytes
        All of the file.
    path : Path
        The file, for errors.

    Raises
    ------
    DinerosError
        It is not TOML, no UTF-8, nested too deep, or has numbers or keys that are too long.
    """
    try:
        text = content.decode()
    except UnicodeDecodeError as error:
        raise DinerosError("is not written in UTF-8", location=Location(path)) from error
    line = _line_of_deep_key(text)
    if line is not None:
        message = f"a key of more than {MOST_PARTS} parts with dots between them"
        raise DinerosError(message, location=Location(path, line))
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = _PLACE.search(str(error))
        location = Location(path, int(found[1]), int(found[2])) if found else Location(path)
        said = _PLACE.sub("", str(error))
    except RecursionError:
        location, said = Location(path), "nested too deep"
    except ValueError:  # Python limits the digits of a number
        location, said = (
            Location(path),
            "a value cannot be read, for example a number with thousands of digits",
        )
    raise DinerosError(f"is not TOML: {said}", location=location, hint="see https://toml.io")


def _line_of_deep_key(text: str) -> int | None:
    for number, line in enumerate(text.split("\n"), start=1):
        if line.count(".") > MOST_PARTS and any(each.count(".") > MOST_PARTS for each in _NO_KEY.split(line)):
            return number
    return None
