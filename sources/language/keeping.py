"""A cache of the facts of Python programs between runs: unchanged programs are not interpreted again.

What a program does depends on the modules that it asks for. Apart from these, it depends only on the paths of
all files, which resolve imports. An entry has the hashes of these modules. It also depends on the code of
this reader, the tables of idioms and the values of parameters: these are in its key.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from dineros.sources.facts import NodeFact
from dineros.sources.folders import SourceFolder
from dineros.sources.keeping.graphs import from_plain, to_plain
from dineros.sources.keeping.store import NOT_READABLE, Store, digest_of, reader_digest
from dineros.sources.language.modules import Modules

Program = Mapping[str, Any]
"""What identifies a program, such as its ``path``, with the values that it gets; JSON."""


class ProgramKeeper:
    """The cache of Python programs of one folder.

    Parameters
    ----------
    cache : Path
        The folder of the entries.
    folder : SourceFolder
        The folder of source code.
    context : sequence of str
        Other inputs of all programs: packages and idioms.
    """

    def __init__(self, cache: Path, folder: SourceFolder, modules: Modules, context: Sequence[str]) -> None:
        self._store = Store(cache)
        self._folder, self._modules = folder, modules
        self._root = str(folder.root.resolve())
        self._context = digest_of([reader_digest(), self._root, folder.scripts, *context])

    def nodes(self, program: Program, run: Callable[[], list[NodeFact]]) -> list[NodeFact]:
        """Return the nodes of a program: from the cache, or else from running it.

        The folder gets its lines about unread code, and the modules get the calls that it reaches.
        """
        found = self._load(program)
        if found is None:
            modules, unread = self._modules, len(self._folder.unread)
            with modules.noted() as noted:
                found = run()
            self._save(program, found, noted.asked, noted.reached, self._folder.unread[unread:])
        return found

    def _load(self, program: Program) -> list[NodeFact] | None:
        entry = self._store.load(self._name(program))
        try:
            if entry is None or entry["key"] != self._key(program):
                return None
            if any(self._modules.digest(path) != digest for path, digest in entry["modules"]):
                return None
            nodes = from_plain(entry["facts"])
            reached = {(str(path), int(line)) for path, line in entry["reached"]}
            unread = [str(line) for line in entry["unread"]]
        except NOT_READABLE:
            return None
        for path, _ in entry["modules"]:
            self._modules.module(path)
        self._modules.reached |= reached
        self._folder.unread += unread
        return nodes

    def _save(
        self,
        program: Program,
        nodes: list[NodeFact],
        asked: set[str],
        reached: set[tuple[str, int]],
        unread: list[str],
    ) -> None:
        with suppress(ValueError):
            entry = {
                "key": self._key(program),
                "modules": [[path, self._modules.digest(path)] for path in sorted({program["path"], *asked})],
                "reached": sorted([path, line] for path, line in reached),
                "unread": unread,
                "facts": to_plain(nodes),
            }
            self._store.save(self._name(program), entry)

    def _key(self, program: Program) -> str:
        return digest_of([self._context, program])

    def _name(self, program: Program) -> str:
        """Return the file of an entry: a changed program replaces its old entry."""
        return f"python-{digest_of([self._root, program])}.json"
