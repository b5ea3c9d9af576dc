"""Imports of modules inside and outside of the folder."""

from __future__ import annotations

import ast
import sys

from dineros.sources.language.expressions import Expressions
from dineros.sources.language.machine import FALLS
from dineros.sources.language.modules import Module
from dineros.sources.language.values import Frame, ModuleValue, Open, Outside, Value

_LIBRARIES = ("rclpy", "launch", "launch_ros", "numpy", "math")
_INTERFACES = ("_msgs", "_msg", "_interfaces", "_srvs", "_actions")
"""Suffixes of the modules of interfaces."""


class Imports(Expressions):
    """The part of the interpreter that runs imports."""

    # ------------------------------------------------------------------------------------------------ imports

    def _run_Import(self, node: ast.Import, frame: Frame) -> set[str]:  # noqa: N802
        for alias in node.names:
            if alias.asname:
                self.assign_variable(alias.asname, self._module(alias.name, frame.module), frame)
            else:
                top = alias.name.partition(".")[0]
                self.assign_variable(top, self._module(top, frame.module, alias.name), frame)
        return {FALLS}

    def _module(self, name: str, by: Module, whole: str = "") -> Value:
        path = self.modules.find(name, by)
        module = self.modules.module(path) if path else None
        if module is not None:
            self.module_frame(module)
            return ModuleValue(module)
        return Outside(name)

    def imported(self, name: str, frame: Frame) -> Value | None:
        """Return a module of the folder by its dotted name; None: it is not in the folder."""
        found = self._module(name, frame.module)
        return found if isinstance(found, ModuleValue) else None

    def _run_ImportFrom(self, node: ast.ImportFrom, frame: Frame) -> set[str]:  # noqa: N802
        name = node.module or ""
        if node.level:
            path = self.modules.relative(frame.module, node.level, name)
        else:
            path = self.modules.find(name, frame.module)
        module = self.modules.module(path) if path else None
        for alias in node.names:
            if alias.name == "*":
                self._star(module, frame)
                if module is None and not node.level:
                    self._outside_star(name, node, frame)
                continue
            found: Value | None = None
            if module is not None:
                found = self.member(module, alias.name)
            elif not node.level:
                inner = self.modules.find(f"{name}.{alias.name}", frame.module)
                inner_module = self.modules.module(inner) if inner else None
                found = ModuleValue(inner_module) if inner_module else None
            else:
                inner = self.modules.relative(frame.module, node.level, f"{name}.{alias.name}".strip("."))
                inner_module = self.modules.module(inner) if inner else None
                found = ModuleValue(inner_module) if inner_module else None
            if isinstance(found, ModuleValue):
                self.module_frame(found.module)
            if found is None:
                start = "." * node.level + name
                found = Outside(f"{start}.{alias.name}") if module is None else Open(alias.name)
            self.assign_variable(alias.asname or alias.name, found, frame)
        return {FALLS}

    def _outside_star(self, name: str, node: ast.ImportFrom, frame: Frame) -> None:
        """Record that all names of a module outside of the folder are imported."""
        stars = self.stars.setdefault(frame.module.path, [])
        top = name.partition(".")[0]
        if name not in stars and top not in sys.stdlib_module_names:
            stars.append(name)
        if not (top in sys.stdlib_module_names or top in _LIBRARIES or top.endswith(_INTERFACES)):
            self.modules.unread(
                f"{frame.module.path}:{node.lineno}: takes all names of {name}, which is not in the folder"
            )

    def _star(self, module: Module | None, frame: Frame) -> None:
        holder = self.module_frame(module).holder if module is not None else None
        if holder is not None:
            for name in list(holder.slots):
                value = self.read_slot(holder, name)
                if value is not None and not name.startswith("_"):
                    self.assign_variable(name, value, frame)
