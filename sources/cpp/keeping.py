"""A cache of the facts of C++ programs between runs: unchanged programs are not followed again.

Following a program is most of the work. What it says depends on what it looked up in the index of the folder,
and on nothing else: an entry of the cache has all these names, each with the files and lines that define it
and the hashes of the files. It counts only if each name still means the same. An entry also depends on the
code of this reader, the tables of idioms and the values of parameters: these are in its key.

Entries are JSON. One that is damaged, or not of this form, is ignored; nothing of it is executed.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from sys import version as python
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.json_text import decode_json
from dineros.sources.cpp.following.reached import Reached
from dineros.sources.cpp.index import Asked, Index
from dineros.sources.facts import NodeFact
from dineros.sources.keeping.facts import from_plain, to_plain

MOST_BYTES = 1 << 24
"""Bytes of an entry."""
MOST_ENTRIES = 2000
"""Entries of a cache; beyond that, the oldest are removed."""

_READER = Path(__file__).resolve().parents[1]
_WRITABLE_BY_OTHERS = stat.S_IWGRP | stat.S_IWOTH


@dataclass(eq=False)
class Followed:
    """The result of following a program.

    Attributes
    ----------
    nodes : list of NodeFact
        The nodes that it creates.
    unread : list of str
        Parts that could not be read, a line each.
    reached : Reached
        What it reached.
    steps : int
        How many expressions and statements were followed.
    """

    nodes: list[NodeFact]
    unread: list[str] = field(default_factory=list)
    reached: Reached = field(default_factory=Reached)
    steps: int = 0


class Keeper:
    """The cache of programs of one folder.

    Parameters
    ----------
    folder : Path
        The folder of the entries; created if missing. A folder that other users may change is not used.
    index : Index
        Of the source code.
    context : sequence of str
        Inputs of all programs: the folder of source code, and the idioms.
    """

    def __init__(self, folder: Path, index: Index, context: Sequence[str]) -> None:
        self._index = index
        self._context = [reader_digest(), *context]
        self._meanings: dict[tuple[str, str], str] = {}
        self._folder = folder if _is_own(folder) else None

    def load(self, program: Mapping[str, Any]) -> Followed | None:
        """Return the cached facts of a program; None: not cached, or an input has changed."""
        if self._folder is None:
            return None
        try:
            content = read_bytes(self._folder / self._name(program), MOST_BYTES, follow_links=False)
            digest, _, text = content.partition(b"\n")
            if hashlib.sha256(text).hexdigest().encode() != digest:
                return None
            entry = decode_json(text)
            if entry["key"] != self._key(program) or not self._is_valid(entry):
                return None
            classes = {self._class_id(each) for each in entry["classes"]}
            calls = {(str(path), int(line)) for path, line in entry["calls"]}
            unread = [str(each) for each in entry["unread"]]
            return Followed(from_plain(entry["facts"]), unread, Reached(classes, calls), int(entry["steps"]))
        except (DinerosError, KeyError, TypeError, ValueError, IndexError, AttributeError, RecursionError):
            return None

    def save(self, program: Mapping[str, Any], followed: Followed, asked: Asked, is_of_all: bool) -> None:
        """Store the facts of a program.

        Parameters
        ----------
        program : mapping
            Its key, as for `load`.
        followed : Followed
            Its facts.
        asked : Asked
            Its look-ups in the index.
        is_of_all : bool
            Whether it depends on all files.
        """
        if self._folder is None:
            return
        named = {id(cls): [cls.full, cls.path, cls.node.start_byte] for cls in self._index.all_classes()}
        with suppress(TypeError, ValueError, KeyError, RecursionError, DinerosError, OSError):
            entry = {
                "key": self._key(program),
                "all": self._all() if is_of_all else "",
                "names": [[table, name, self._meaning(table, name)] for table, name in sorted(asked.names)],
                "interfaces": [[*asked_for, found] for asked_for, found in sorted(asked.interfaces.items())],
                "classes": [named[each] for each in followed.reached.classes],
                "calls": sorted([path, line] for path, line in followed.reached.calls),
                "unread": followed.unread,
                "steps": followed.steps,
                "facts": to_plain(followed.nodes),
            }
            text = json.dumps(entry, allow_nan=False).encode()
            if len(text) < MOST_BYTES // 2 and json.loads(text) == entry:
                content = hashlib.sha256(text).hexdigest().encode() + b"\n" + text
                write_atomically(self._folder / self._name(program), content, synchronise=False)

    def _is_valid(self, entry: Mapping[str, Any]) -> bool:
        return (
            entry["all"] in ("", self._all())
            and all(self._meaning(table, name) == then for table, name, then in entry["names"])
            and all(
                self._index.find_interface(name, path) == then for name, path, then in entry["interfaces"]
            )
        )

    def _class_id(self, named: list[Any]) -> int:
        full, path, start = named
        found = self._index.classes[full.rpartition("::")[2]]
        return next(
            id(cls) for cls in found if [cls.full, cls.path, cls.node.start_byte] == [full, path, start]
        )

    def _meaning(self, table: str, name: str) -> str:
        if (table, name) not in self._meanings:
            self._meanings[table, name] = _digest(self._index.meaning(table, name))
        return self._meanings[table, name]

    def _all(self) -> str:
        return _digest(sorted(self._index.digests.items()))

    def _key(self, program: Mapping[str, Any]) -> str:
        return _digest([self._context, program])

    def _name(self, program: Mapping[str, Any]) -> str:
        """Return the file of an entry: a changed program replaces its old entry."""
        return f"cpp-{_digest([self._context[1], program['name'], program['path'], program['cls']])}.json"


def tidy(folder: Path) -> None:
    """Remove the oldest entries of a cache that has too many."""
    with suppress(OSError):
        entries = [(each.stat().st_mtime, each) for each in folder.glob("cpp-*.json")]
        for _, each in sorted(entries)[: max(0, len(entries) - MOST_ENTRIES)]:
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


def _digest(value: object) -> str:
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
