"""Developers' modules: their handlers, the token fields they name, and appending stubs.

They are parsed to syntax trees and never run. Their existing text is never changed.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from dineros.metamodel.errors import DinerosError, Location

DECORATOR = "on"
"""Name of the decorator that makes a function the handler of a transition."""

_INSTANCE = re.compile(r"(?P<service>.+)\[(?P<number>\d+)\]\.(?P<transition>.+)")


class DeveloperFileError(DinerosError):
    """A developer's file is not valid Python."""


class Instance(NamedTuple):
    """A transition of one server instance, such as ``Pick[2].TPick``."""

    service: str
    number: int
    transition: str


def instance_of(name: str) -> Instance | None:
    """Return the parts of the name of one instance's transition; None: another kind of name."""
    found = _INSTANCE.fullmatch(name)
    return Instance(found["service"], int(found["number"]), found["transition"]) if found else None


@dataclass(frozen=True)
class Handler:
    """A handler in a developer's module."""

    transition: str
    """The name for which it is registered, such as ``TPick`` or ``Pick[2].TPick``."""
    function: str
    """Name of the function."""
    line: int
    end: int
    """`line`, `end`: first line, decorators included, and last line."""

    @property
    def model_transition(self) -> str:
        """The transition in the model, without the server instance."""
        instance = instance_of(self.transition)
        return instance.transition if instance else self.transition


@dataclass(frozen=True)
class Module:
    """A developer's module."""

    path: Path
    """The file."""
    content: bytes
    text: str
    """Its text, with line feeds as line ends."""
    tree: ast.Module
    """Its syntax tree."""
    encoding: str
    newline: str
    """`encoding`, `newline`: its encoding and its line ends."""


def read_module(path: Path, content: bytes) -> Module:
    """Parse a developer's module with this content.

    Raises
    ------
    DeveloperFileError
        It is not Python, or has an unknown encoding; with the line.
    """
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(content).readline)
        text = content.decode(encoding)
        newline = "\r\n" if text.count("\r\n") > text.count("\n") / 2 else "\n"
        text = text.replace("\r\n", "\n")
        return Module(path, content, text, ast.parse(text), encoding, newline)
    except SyntaxError as error:
        raise DeveloperFileError(
            f"is not Python: {error.msg}", location=Location(path, error.lineno), hint="fix it first"
        ) from error
    except ValueError as error:
        raise DeveloperFileError(f"cannot be read: {error}", location=Location(path)) from error


def handlers(module: Module) -> list[Handler]:
    """Return the handlers of a module: functions, classes and lambdas registered for a transition by name."""
    found = []
    for node in ast.walk(module.tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            for decorator in node.decorator_list:
                for transition in _registered(decorator):
                    end = node.end_lineno or node.lineno
                    found.append(Handler(transition, node.name, decorator.lineno, end))
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):  # on("T")(function)
            for transition in _registered(node.value.func):
                found.append(Handler(transition, "", node.lineno, node.end_lineno or node.lineno))
    return sorted(found, key=lambda handler: handler.line)


def _registered(call: ast.expr) -> Iterable[str]:
    if not isinstance(call, ast.Call):
        return
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", None)
    if name != DECORATOR or not call.args:
        return
    argument = call.args[0]
    if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
        yield argument.value


def texts(module: Module, wanted: Iterable[str]) -> list[tuple[str, int]]:
    """Return the places where words occur as text constants or keywords: the word and its line."""
    words = set(wanted)
    found = set()
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in words:
            found.add((node.lineno, node.value))
        elif isinstance(node, ast.keyword) and node.arg in words:
            found.add((node.value.lineno, node.arg))
    return [(word, line) for line, word in sorted(found)]


def names(module: Module) -> set[str]:
    """Return the names that a module binds at its top level."""
    bound: set[str] = set()
    for node in module.tree.body:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            bound.add(node.name)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            bound.update(alias.asname or alias.name.partition(".")[0] for alias in node.names)
        else:
            bound.update(
                each.id
                for each in ast.walk(node)
                if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
            )
    return bound


def module_name(module: Module, package: str, name: str) -> str | None:
    """Return the name under which a module imports its neighbour: ``from . import name [as ...]``."""
    for node in module.tree.body:
        if isinstance(node, ast.ImportFrom):
            is_own = (node.level == 1 and node.module is None) or (node.level == 0 and node.module == package)
            for alias in node.names:
                if is_own and alias.name == name:
                    return alias.asname or alias.name
    return None


def append(module: Module, parts: Sequence[str]) -> bytes:
    """Return a module's bytes with text appended; the existing text is unchanged.

    `parts`: top-level statements, each ending with a line feed; two blank lines are inserted before each.

    Raises
    ------
    DeveloperFileError
        The result is not Python, or the text cannot be written in the module's encoding.
    """
    text = "" if module.text.endswith("\n") or not module.text else "\n"
    text += "".join(f"\n\n{part}" for part in parts)
    try:
        added = text.replace("\n", module.newline).encode(module.encoding.removesuffix("-sig"))
    except UnicodeEncodeError as error:
        raise DeveloperFileError(
            f"is written in {module.encoding}, which cannot encode the new stubs: {error}",
            location=Location(module.path),
            hint="write it in UTF-8",
        ) from error
    content = module.content + added
    read_module(module.path, content)
    return content
