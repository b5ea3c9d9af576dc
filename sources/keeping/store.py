"""The files of a cache of facts, an entry for each program.

Entries are JSON. One that is damaged, or not of the expected form, is ignored; nothing of it is executed.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from sys import version as python
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.json_text import decode_json

MOST_BYTES = 1 << 24
"""Bytes of an entry."""
MOST_ENTRIES = 2000
"""Entries of a cache; beyond that, the oldest are removed."""

NOT_READABLE = (
    *(DinerosError, KeyError, TypeError, ValueError, IndexError, AttributeError, RecursionError),
    *(StopIteration, OverflowError),
)
"""Errors while an entry is read that is damaged, or was made by another program."""

_READER = Path(__file__).resolve().parents[1]
_WRITABLE_BY_OTHERS = stat.S_IWGRP | stat.S_IWOTH


class Store:
    """The entries of a cache.

    `folder`: their folder; created if missing. A folder that other users may change is not used.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder if _is_own(folder) else None

    def load(self, name: str) -> Any:
        """Return the entry of a file; None: there is none, or it is damaged."""
        if self._folder is None:
            return None
        try:
            content = read_bytes(self._folder / name, MOST_BYTES, follow_links=False)
            digest, _, text = content.partition(b"\n")
            is_whole = hashlib.sha256(text).hexdigest().encode() == digest
            return decode_json(text) if is_whole else None
        except NOT_READABLE:
            return None

    def save(self, name: str, entry: dict[str, Any]) -> None:
        """Write an entry, unless JSON cannot represent it, or it is too large."""
        if self._folder is None:
            return
        with suppress(TypeError, ValueError, RecursionError, DinerosError, OSError):
            text = json.dumps(entry, allow_nan=False).encode()
            if len(text) < MOST_BYTES // 2 and json.loads(text) == entry:
                content = hashlib.sha256(text).hexdigest().encode() + b"\n" + text
                write_atomically(self._folder / name, content, follow_links=False, synchronise=False)


def tidy(folder: Path) -> None:
    """Remove the oldest entries of a cache that has too many."""
    with suppress(OSError):
        found = [each for kind in ("cpp", "python") for each in folder.glob(f"{kind}-*.json")]
        entries = sorted((each.stat().st_mtime, each) for each in found)
        for _, each in entries[: max(0, len(entries) - MOST_ENTRIES)]:
            each.unlink(missing_ok=True)


@cache
def reader_digest() -> str:
    """Return a hash of all code and tables of this reader and of its dependencies."""
    found = hashlib.sha256()
    for path in sorted([*_READER.rglob("*.py"), *_READER.rglob("*.toml")]):
        found.update(path.relative_to(_READER).as_posix().encode() + b"\0")
        found.update(hashlib.sha256(read_bytes(path)).digest())
    for package in ("dineros", "tree-sitter", "tree-sitter-cpp"):
        with suppress(PackageNotFoundError):
            found.update(f"{package} {version(package)}".encode())
    found.update(python.encode())
    return found.hexdigest()


def digest_of(value: object) -> str:
    """Return a hash of a value."""
    return hashlib.sha256(json.dumps(value, sort_keys=True, default=repr).encode()).hexdigest()


def _is_own(folder: Path) -> bool:
    """Return whether a folder exists, belongs to the user, and is not writable for others."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = folder.lstat()
    except (OSError, ValueError):
        return False
    is_own = not hasattr(os, "getuid") or found.st_uid == os.getuid()
    return stat.S_ISDIR(found.st_mode) and is_own and not found.st_mode & _WRITABLE_BY_OTHERS
