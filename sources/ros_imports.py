"""Finds out whether a program can use ROS, by the modules that it imports directly or indirectly."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from dineros.sources.language.modules import Module, Modules

_DYNAMIC = frozenset(("__import__", "exec", "eval", "importlib", "runpy", "pkgutil"))
"""Names with which a module may import others that its text does not name."""
_HARMLESS = frozenset(("importlib.util.find_spec", "importlib.metadata", "importlib.resources"))
"""Parts of ``importlib`` that run no other module."""
_ALWAYS = frozenset(("rclpy", "rospy"))


class RosImports:
    """Distinguishes programs that can use ROS from others, which need not be followed.

    Parameters
    ----------
    modules : Modules
        The modules of the folder.
    paths : iterable of str
        Dotted names of other classes and functions that use ROS: the table of idioms.
    """

    def __init__(self, modules: Modules, paths: Iterable[str]) -> None:
        self._modules = modules
        self._libraries = _ALWAYS | {each.partition(".")[0] for each in paths}
        self._known: dict[str, tuple[bool, frozenset[str]]] = {}

    def can_use_ros(self, module: Module) -> bool:
        """Return whether a module, or one that it imports, imports a library of ROS, or is not known."""
        seen, todo = {module.path}, [module]
        while todo:
            each = todo.pop()
            has_ros, inner = self._imports(each)
            if has_ros:
                return True
            for path in inner - seen:
                seen.add(path)
                found = self._modules.module(path)
                if found is None:
                    return True
                todo.append(found)
        return False

    def _imports(self, module: Module) -> tuple[bool, frozenset[str]]:
        """Return whether a module may use ROS itself, and the modules of the folder that it imports."""
        if module.path not in self._known:
            inner: set[str] = set()
            has_ros = False
            for node in module.nodes:
                has_ros |= getattr(node, "id", None) in _DYNAMIC
                for name, level in _named(node):
                    first = name.partition(".")[0]
                    has_ros |= not level and (first in self._libraries or first in _DYNAMIC)
                    path = (
                        self._modules.relative(module, level, name)
                        if level
                        else self._modules.find(name, module)
                    )
                    if path is not None:
                        inner.add(path)
            self._known[module.path] = has_ros, frozenset(inner)
        return self._known[module.path]


def _named(node: ast.AST) -> Iterator[tuple[str, int]]:
    """Yield the dotted names that a statement may import, with the level of a relative import."""
    if isinstance(node, ast.Import):
        for each in node.names:
            parts = each.name.split(".")
            yield from ((".".join(parts[:count]), 0) for count in range(1, len(parts) + 1))
    elif isinstance(node, ast.ImportFrom):
        named = {f"{node.module}.{each.name}" for each in node.names}
        if not node.level and (node.module in _HARMLESS or named <= _HARMLESS):
            return
        parts = (node.module or "").split(".") if node.module else []
        yield from ((".".join(parts[:count]), node.level) for count in range(len(parts) + 1))
        for each in node.names:
            yield ".".join([*parts, each.name]), node.level
