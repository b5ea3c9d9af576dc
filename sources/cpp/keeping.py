"""A cache of the facts of C++ programs between runs: unchanged programs are not followed again.

Following a program is most of the work. What it says depends on what it looked up in the index of the folder,
and on nothing else: an entry of the cache has all these names, each with the files and lines that define it
and the hashes of the files. It counts only if each name still means the same. An entry also depends on the
code of this reader, the tables of idioms and the values of parameters: these are in its key.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dineros.sources.cpp.index import Asked, Index
from dineros.sources.cpp.reaching.reached import Reached
from dineros.sources.facts import NodeFact
from dineros.sources.keeping.graphs import from_plain, to_plain
from dineros.sources.keeping.store import NOT_READABLE, Store, digest_of, reader_digest


@dataclass(eq=False)
class Followed:
    """The result of following a program."""

    nodes: list[NodeFact]
    """The nodes that it creates."""
    unread: list[str] = field(default_factory=list)
    """Parts that could not be read, a line each."""
    reached: Reached = field(default_factory=Reached)
    """What it reached."""
    steps: int = 0
    """How many expressions and statements were followed."""


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
        self._store = Store(folder)

    def load(self, program: Mapping[str, Any]) -> Followed | None:
        """Return the cached facts of a program; None: not cached, or an input has changed."""
        entry = self._store.load(self._name(program))
        try:
            if entry is None or entry["key"] != self._key(program) or not self._is_valid(entry):
                return None
            classes = {self._class_id(each) for each in entry["classes"]}
            calls = {(str(path), int(line)) for path, line in entry["calls"]}
            unread = [str(each) for each in entry["unread"]]
            return Followed(from_plain(entry["facts"]), unread, Reached(classes, calls), int(entry["steps"]))
        except NOT_READABLE:
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
        named = {id(cls): [cls.full, cls.path, cls.node.start_byte] for cls in self._index.all_classes()}
        with suppress(ValueError, KeyError):
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
            self._store.save(self._name(program), entry)

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
            self._meanings[table, name] = digest_of(self._index.meaning(table, name))
        return self._meanings[table, name]

    def _all(self) -> str:
        return digest_of(sorted(self._index.digests.items()))

    def _key(self, program: Mapping[str, Any]) -> str:
        return digest_of([self._context, program])

    def _name(self, program: Mapping[str, Any]) -> str:
        """Return the file of an entry: a changed program replaces its old entry."""
        names = ("name", "path", "cls", "given", "launched")
        return f"cpp-{digest_of([self._context[1], *(program[each] for each in names)])}.json"
