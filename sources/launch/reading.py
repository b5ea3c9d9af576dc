"""Reads the launch files of a folder: Python by the interpreter of programs, XML, and YAML."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from dineros.sources.facts import CallbackFact
from dineros.sources.folders import SourceFolder
from dineros.sources.language.activities import Activity
from dineros.sources.language.calls import Interpreter
from dineros.sources.language.machine import TooLong
from dineros.sources.language.modules import Modules
from dineros.sources.language.values import Const, Frame, Function, Items, Made, Open, Text, Value
from dineros.sources.language.values import Mapping as Table
from dineros.sources.launch.description import Walker
from dineros.sources.launch.markup import actions_of_xml, actions_of_yaml
from dineros.sources.launch.parameters import parameters_for
from dineros.sources.launch.started import Started
from dineros.sources.launch.substitutions import Scope
from dineros.sources.launch.yaml_text import UnreadableError, parts_of
from dineros.sources.libraries.idioms import Idiom
from dineros.sources.libraries.library import RosLibrary
from dineros.sources.packages import Package
from dineros.sources.places import Place

MOST_INCLUDES = 1000
"""Limit of the files that a launch file includes, with repetitions."""


@dataclass(frozen=True)
class _CalledAt(Place):
    """A line of a launch file that a call reaches, with the line of that call in the launch description."""

    site: Place


class _LaunchInterpreter(Interpreter):
    """Runs a launch file; records from which lines its functions are called."""

    def place(self, node: ast.AST, frame: Frame) -> Place:
        """Return the place of a part of the code."""
        at = super().place(node, frame)
        calls = [each for each in self.trail if isinstance(each, tuple) and len(each) == 3]
        return _CalledAt(at.file, at.line, Place(calls[1][0], calls[1][1])) if len(calls) > 1 else at


class LaunchFiles:
    """Reads launch files of a folder.

    `idioms`: the table of library idioms.
    """

    def __init__(
        self, folder: SourceFolder, packages: list[Package], modules: Modules, idioms: Mapping[str, Idiom]
    ) -> None:
        self._folder, self._packages, self._modules, self._idioms = folder, packages, modules, idioms
        self._machines: dict[str, Interpreter] = {}
        self._scopes: list[tuple[Walker, Scope]] = []
        self._includes = 0

    def all(self) -> list[str]:
        """Return the paths of all launch files."""
        return [path for path in self._folder.files if self._is_launch(path)]

    def _is_launch(self, path: str) -> bool:
        name = PurePosixPath(path).name
        if name.endswith(
            (".launch.xml", ".launch.yaml", ".launch.yml", "_launch.xml", "_launch.yaml", "_launch.yml")
        ):
            return True
        if not name.endswith(".py") or "launch" not in path:
            return False
        module = self._modules.module(path)
        return module is not None and any(
            isinstance(node, ast.FunctionDef) and node.name == "generate_launch_description"
            for node in module.tree.body
        )

    def read(
        self, path: str, given: Mapping[str, str], *, follows: bool
    ) -> tuple[dict[str, str], list[Started]]:
        """Return the arguments of a launch file, and the nodes that it starts.

        Parameters
        ----------
        path : str
            The file.
        given : mapping of str to str
            Values of arguments.
        follows : bool
            Whether files that it includes are followed.
        """
        walker = Walker(given, self._included, self._call)
        walker.follows = follows
        walker.including = [path]
        self._includes = 0
        scope = Scope(file=path)
        self._scopes = [(walker, scope)]
        for action in self._actions(path, scope) or ():
            walker.walk(action, scope)
        _tell_apart(walker.found)
        return walker.arguments, walker.found

    def _included(self, text: str, scope: Scope) -> list[Value] | None:
        path = self.path(text, scope.file)
        if path is None:
            return None
        walker = self._scopes[0][0]
        if path in walker.including:
            self._folder.unread.append(f"{path}: it includes itself, and is not read again")
            return None
        self._includes += 1
        if self._includes > MOST_INCLUDES:
            self._folder.unread.append(f"{path}: ignored: more than {MOST_INCLUDES} includes")
            return None
        scope.file = path
        self._scopes[0] = (self._scopes[0][0], scope)
        return self._actions(path, scope)

    def path(self, text: str, beside: str = "") -> str | None:
        """Return the path in the folder for a text of a launch file; None: it does not exist."""
        for package in self._packages:
            text = text.replace(f"$(find {package.name})", package.path)
        base = PurePosixPath(beside).parent
        for candidate in (text, (base / text).as_posix()):
            parts: list[str] = []
            for part in candidate.split("/"):
                if part == "..":
                    parts[-1:] = []
                elif part not in ("", "."):
                    parts.append(part)
            found = "/".join(parts)
            if found in self._folder.files:
                return found
        return None

    def named(self, text: str) -> str | None:
        """Return the launch file for a path of the user.

        It is a path in the folder, a path from the current folder, as shells complete it, or the end of
        exactly one path.
        """
        ends = [path for path in self.all() if path.endswith(f"/{text}")]
        return self.path(text) or self._from_here(text) or (ends[0] if len(ends) == 1 else None)

    def _from_here(self, text: str) -> str | None:
        try:
            path = Path(text).resolve().relative_to(self._folder.root.resolve()).as_posix()
        except (OSError, ValueError, RuntimeError):  # outside of the folder, or not a path
            return None
        return path if path in self._folder.files else None

    def _actions(self, path: str, scope: Scope) -> list[Value] | None:
        try:
            if path.endswith(".py"):
                return self._python(path, scope)
            text = self._folder.read(path)
            if text is None:
                return None
            return actions_of_xml(text, path) if path.endswith(".xml") else actions_of_yaml(text, path)
        except UnreadableError as error:
            self._folder.unread.append(f"{path}: {error}")
            return None

    def _machine(self, path: str) -> Interpreter:
        machine = _LaunchInterpreter(self._modules, path)
        library = RosLibrary(machine, self._idioms)
        library.substitute = self._substitute
        library.standard.load = self._load
        machine.library = library
        return machine

    def _python(self, path: str, scope: Scope) -> list[Value] | None:
        module = self._modules.module(path)
        if module is None:
            return None
        machine = self._machines[path] = self._machine(path)
        try:
            with machine.doing(Activity(CallbackFact("launch", "main", Place(path, 1)))):
                frame = machine.module_frame(module)
                function = machine.variable("generate_launch_description", frame)
                if isinstance(function, Function):
                    return [machine.call(function, [], {}, function.node, frame)]
        except (TooLong, RecursionError):
            self._folder.unread.append(f"{path}: the launch file is too large to be read completely")
        return None

    def _call(self, function: Value, args: list[Value], keys: dict[str, Value], scope: Scope) -> Value:
        machine = self._machines.get(scope.file)
        node = ast.Pass(lineno=1, col_offset=0)
        frame = getattr(function, "frame", None)
        if frame is None or machine is None:
            return Open("function")
        try:
            with machine.doing(Activity(CallbackFact("launch", "main", Place(scope.file, 1)))):
                self._scopes[0] = (self._scopes[0][0], scope)
                return machine.call(function, args, keys, node, frame)
        except (TooLong, RecursionError):
            return Open("function")

    def _substitute(self, value: Value) -> Value:
        """Return the value of a substitution while an ``OpaqueFunction`` runs."""
        walker, scope = self._scopes[0]
        text = walker.text(value, scope)
        return Const(text, "parameter of the launch file") if "{" not in text else Text(text)

    def _load(self, text: str) -> Value | None:
        """Return the values of a file in YAML."""
        path = self.path(text)
        content = self._folder.read(path) if path is not None else None
        if content is None:
            return None
        try:
            return _value(parts_of(content).plain())
        except UnreadableError as error:
            self._folder.unread.append(f"{path}: {error}")
            return None

    def parameters(self, started: Started, name: str) -> dict[str, Any]:
        """Return the parameters with which a node is started, by its name; files are read."""
        found: dict[str, Any] = {}
        for each in started.parameters:
            if isinstance(each, dict):
                found |= {
                    key: value for key, value in each.items() if not (isinstance(value, str) and "{" in value)
                }
                continue
            path = self.path(each, started.file)
            text = self._folder.read(path) if path is not None else None
            if text is not None:
                try:
                    found |= parameters_for(text, name)
                except UnreadableError as error:
                    self._folder.unread.append(f"{path}: {error}")
        return found


def _tell_apart(started: list[Started]) -> None:
    """Give nodes that one function creates repeatedly the lines of its calls."""
    sites: dict[str, set[Place]] = {}
    for each in started:
        if isinstance(each.at, _CalledAt):
            sites.setdefault(str(each.at), set()).add(each.at.site)
    for each in started:
        if isinstance(each.at, _CalledAt):
            is_shared = len(sites[str(each.at)]) > 1
            each.at = each.at.site if is_shared else Place(each.at.file, each.at.line)


def _value(plain: Any) -> Value:
    """Convert a value of YAML to a value of a program, which users can set."""
    if isinstance(plain, dict):
        return Table({key: _value(each) for key, each in plain.items()})
    if isinstance(plain, list):
        return Items([_value(each) for each in plain])
    return Const(plain, "parameter of a file")


__all__ = ["LaunchFiles", "Made"]
