"""Parses the modules of a folder, and resolves imports to them."""

from __future__ import annotations

import ast
import hashlib
import math
import re
import sys
import warnings
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.reading import read_bytes
from dineros.sources.folders import MOST_BYTES, SourceFolder

MOST_DEPTH = 400
"""Limit of the nesting of an expression or a statement."""

LARGE = 1 << 64
"""Whole numbers from here on, and infinite ones, count as unknown: no message of ROS holds them."""

_MAY_BE_LARGE = re.compile(rb"[0-9A-Fa-f_]{16}|[eE]\+?[0-9_]{3}")


class Module:
    """A file of the program."""

    def __init__(self, path: str, tree: ast.Module, nodes: list[ast.AST]) -> None:
        self.path = path
        """Relative to the folder."""
        self.tree = tree
        """Its syntax tree."""
        self.nodes = nodes
        """All nodes of the tree, in the order of ``ast.walk``: several searches go through them."""

    @property
    def stem(self) -> str:
        """Its name without folders."""
        return PurePosixPath(self.path).stem


@dataclass(eq=False)
class Noted:
    """What code used while it ran."""

    asked: set[str] = field(default_factory=set)
    """Paths of the modules that it asked for."""
    reached: set[tuple[str, int]] = field(default_factory=set)
    """Path and line of the calls that create entities and that it reached."""


class Modules:
    """All modules of a folder.

    Parameters
    ----------
    folder : SourceFolder
        The folder; files that cannot be parsed are listed in its `unread`.
    packages : iterable of str
        Folders of packages, from which imports may begin.
    """

    def __init__(self, folder: SourceFolder, packages: Iterable[str]) -> None:
        self.all: dict[str, Module] = {}
        self.reached: set[tuple[str, int]] = set()
        """Path and line of the calls that create entities and that a program reached."""
        self._folder = folder
        self._asked: set[str] = set()
        self._digests: dict[str, str] = {}
        files = set(folder.scripts)
        self._with_init = {
            PurePosixPath(path).parent.as_posix() for path in files if path.endswith("__init__.py")
        }
        self._named: dict[str, list[str]] = defaultdict(list)
        roots = {".", *packages}
        for path in sorted(files):
            for name in self._names(path, roots):
                self._named[name].append(path)

    def unread(self, line: str) -> None:
        """Report an ignored part."""
        self._folder.unread.append(line)

    @contextmanager
    def noted(self) -> Iterator[Noted]:
        """Note what the code that runs meanwhile uses."""
        before, noted = (self._asked, self.reached), Noted()
        self._asked, self.reached = noted.asked, noted.reached
        try:
            yield noted
        finally:
            self._asked, self.reached = before
            self._asked |= noted.asked
            self.reached |= noted.reached

    def digest(self, path: str) -> str:
        """Return a hash of the content of a module; empty: it cannot be read."""
        if path not in self._digests:
            try:
                content = read_bytes(self._folder.root / path, MOST_BYTES)
                self._digests[path] = hashlib.sha256(content).hexdigest()
            except ModelFileError:
                self._digests[path] = ""
        return self._digests[path]

    def module(self, path: str) -> Module | None:
        """Return a module by its path; None: it cannot be read."""
        self._asked.add(path)
        if path not in self.all:
            found = self._parse(path)
            if found is None:
                return None
            self.all[path] = Module(path, *found)
        return self.all[path]

    def find(self, name: str, by: Module) -> str | None:
        """Return the path of the module that an absolute name imports; None: outside of the folder.

        If several files have the same name, the one nearest to the importing file is used, then the one in
        the outermost folder.
        """
        if name.partition(".")[0] in sys.stdlib_module_names:
            return None
        beside = PurePosixPath(by.path).parent
        found = [path for path in self._named.get(name, ()) if path != by.path]
        if not found:
            return None
        return min(
            found,
            key=lambda path: (-_shared(beside.parts, PurePosixPath(path).parts), path.count("/"), path),
        )

    def is_package(self, name: str) -> bool:
        """Return whether a dotted name is a prefix of the name of a module of the folder."""
        return any(each.startswith(f"{name}.") for each in self._named)

    def relative(self, by: Module, level: int, name: str) -> str | None:
        """Return the path of a relative import."""
        place = PurePosixPath(by.path).parent
        for _ in range(level - 1):
            place = place.parent
        inner = (place / name.replace(".", "/")).as_posix() if name else place.as_posix()
        for path in (f"{inner}.py", f"{inner}/__init__.py" if inner != "." else "__init__.py"):
            if path in self._folder.scripts:
                return path
        return None

    def _names(self, path: str, roots: set[str]) -> set[str]:
        """Return the dotted names by which a file can be imported."""
        if not path.endswith(".py"):
            return set()
        pure = PurePosixPath(path)
        parts = pure.parts[:-1] if pure.name == "__init__.py" else (*pure.parts[:-1], pure.stem)
        if not parts:
            return set()
        found = set()
        place = pure.parent
        while place.as_posix() in self._with_init and place.as_posix() != ".":
            place = place.parent
        starts = {
            place.as_posix(),
            pure.parent.as_posix() if pure.name != "__init__.py" else place.as_posix(),
        }
        for root in roots:
            base = PurePosixPath(root)
            starts |= {
                base.as_posix(),
                (base / "src").as_posix(),
                base.parent.as_posix(),
                (base / base.name).as_posix(),
            }
        for start in starts:
            base = PurePosixPath(start)
            if start == ".":
                found.add(".".join(parts))
            elif parts[: len(base.parts)] == base.parts and len(parts) > len(base.parts):
                found.add(".".join(parts[len(base.parts) :]))
        return found

    def _parse(self, path: str) -> tuple[ast.Module, list[ast.AST]] | None:
        """Return the tree of a file with all its nodes; None: it cannot be read."""
        content = self._folder.content(path)
        if content is None:
            return None
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of invalid escapes: not ours
                tree = ast.parse(content)  # knows marks of the encoding
            nodes = _nodes_of(tree)
        except SyntaxError as error:
            nodes = []
            if "too many nested" not in str(error.msg):
                line = f" in line {error.lineno}" if error.lineno else ""
                version = f"Python {sys.version_info[0]}.{sys.version_info[1]}"
                self._folder.unread.append(f"{path}: {version} cannot parse it{line}: {error.msg}")
                return None
        except ValueError as error:
            self._folder.unread.append(f"{path}: Python cannot parse it: {error}")
            return None
        except (RecursionError, MemoryError):
            nodes = []
        if not nodes:
            self._folder.unread.append(f"{path}: its code is nested more than {MOST_DEPTH} levels deep")
            return None
        if _MAY_BE_LARGE.search(content):
            tree = _WithoutLargeNumbers().visit(tree)
            nodes = list(ast.walk(tree))
        return tree, nodes


class _WithoutLargeNumbers(ast.NodeTransformer):
    """Replaces numbers that no floating-point number, and no decimal text of Python, can hold by a name."""

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        value = node.value
        is_large = type(value) is int and abs(value) >= LARGE
        if is_large or (isinstance(value, (float, complex)) and math.isinf(abs(value))):
            return ast.copy_location(ast.Name("a large number", ast.Load()), node)
        return node


def text_of_code(node: ast.AST) -> str:
    """Return the text of an expression; it is made once, as loops and calls ask for it again."""
    known: str | None = getattr(node, "text_of_code", None)
    if known is None:
        known = node.text_of_code = ast.unparse(node)  # type: ignore[attr-defined]
    return known


def _nodes_of(tree: ast.AST) -> list[ast.AST]:
    """Return all nodes of a tree, level by level; none, if it is nested too deeply to be followed."""
    found: list[ast.AST] = []
    level: list[ast.AST] = [tree]
    for _ in range(MOST_DEPTH):
        found += level
        level = [child for node in level for child in ast.iter_child_nodes(node)]
        if not level:
            return found
    return []


def _shared(one: tuple[str, ...], other: tuple[str, ...]) -> int:
    count = 0
    for left, right in zip(one, other, strict=False):
        if left != right:
            break
        count += 1
    return count
