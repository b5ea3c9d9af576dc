"""Looks up and assigns variables: of functions, of functions around them, of modules, and built in."""

from __future__ import annotations

import ast
from collections import Counter
from functools import lru_cache

from dineros.sources.language.computing.gathering import Collections
from dineros.sources.language.modules import Module
from dineros.sources.language.values import (
    Const,
    Frame,
    Function,
    Holder,
    Open,
    Outside,
    Value,
    join,
)

_STARRED = {
    "rclpy.callback_groups": ("MutuallyExclusiveCallbackGroup", "ReentrantCallbackGroup"),
    "rclpy.executors": ("SingleThreadedExecutor", "MultiThreadedExecutor", "ExternalShutdownException"),
    "rclpy.node": ("Node",),
    "rclpy.action": ("ActionClient", "ActionServer", "CancelResponse", "GoalResponse"),
    "rclpy.qos": (
        *("QoSProfile", "QoSHistoryPolicy", "QoSReliabilityPolicy", "QoSDurabilityPolicy"),
        *("HistoryPolicy", "ReliabilityPolicy", "DurabilityPolicy", "qos_profile_sensor_data"),
    ),
}
"""Names that ``from module import *`` brings, of modules that code imports so next to others."""


class Names(Collections):
    """The part of the interpreter that knows variables."""

    def _value_of_Name(self, node: ast.Name, frame: Frame) -> Value:  # noqa: N802
        return self.variable(node.id, frame) or Open(node.id)

    def variable(self, name: str, frame: Frame) -> Value | None:
        """Return a variable: of the function, of enclosing functions, of the module, or built in."""
        here: Frame | None = frame
        is_global = name in frame.globals
        while here is not None:
            holder = here.holder
            if holder is not None:
                found = self.read_slot(holder, name) if name in holder.slots else None
                if found is not None:
                    return self._as_assigned(found, holder, name, frame)
            elif name in here.names and not is_global and not _is_hidden(here, frame):
                return here.names[name]
            here = here.outer
        if name in _BUILT_IN:
            return Outside(f"builtins.{name}")
        stars = self.stars.get(frame.module.path, ())
        for star in stars:
            if name in _STARRED.get(star, ()):
                return Outside(f"{star}.{name}")
        if len(stars) == 1 and name[:1].isupper():  # ``from geometry_msgs.msg import *``
            return Outside(f"{stars[0]}.{name}")
        if stars and name[:1].isupper() and all(each.endswith((".msg", ".srv", ".action")) for each in stars):
            return join(Outside(f"{each}.{name}", is_star=True) for each in stars)
        return None

    @staticmethod
    def _as_assigned(value: Value, holder: Holder, name: str, frame: Frame) -> Value:
        """Return a variable of a module to the code of this module: a constant as it was assigned."""
        if not isinstance(value, Const) or value.origin != "variable":
            return value
        is_one = name in _assigned_once(frame.module) and len(holder.slots[name].values) == 1
        return Const(value.value, enum=value.enum) if is_one else value

    def assign_variable(self, name: str, value: Value, frame: Frame) -> None:
        """Assign a value to a variable."""
        here: Frame | None = frame
        if name in frame.globals or name in frame.nonlocals:
            while here is not None and here.holder is None:
                is_enclosing = here is not frame and name in frame.nonlocals
                if is_enclosing and name in here.names and not _is_hidden(here, frame):
                    here.names[name] = join([here.names[name], value])
                    self._changes_variable(name, here)
                    return
                here = here.outer
        if here is None:
            return
        holder = here.holder
        if holder is not None:
            self.write_slot(holder, name, value)
            if frame is not here:
                self._changes_variable(name, here)
            return
        if (
            isinstance(value, Const)
            and not value.origin
            and here.function is not None
            and name in shared(here.function)
        ):
            value = Const(value.value, "variable")
        here.names[name] = value

    def _changes_variable(self, name: str, frame: Frame) -> None:
        """Record that a callback changes a variable of a module, or of a function around it."""
        if self.activity.fact.kind not in ("constructor", "module"):
            self.attributes.changed.append((shared_name(name, frame), self.activity.fact))

    def _value_of_NamedExpr(self, node: ast.NamedExpr, frame: Frame) -> Value:  # noqa: N802
        value = self.evaluate(node.value, frame)
        self.assign_variable(node.target.id, value, frame)
        return value


def shared_name(name: str, frame: Frame) -> str:
    """Return the name of a variable that functions share, with the function that has it."""
    return name if frame.function is None else f"{name} of {frame.function.name}"


def shared(function: Function) -> frozenset[str]:
    """Return the variables of a function that functions inside it change."""
    found: frozenset[str] | None = getattr(function.node, "shared_names", None)
    if found is None:
        inner = [each.names for each in ast.walk(function.node) if isinstance(each, ast.Nonlocal)]
        found = frozenset(name for names in inner for name in names)
        function.node.shared_names = found  # type: ignore[union-attr]
    return found


_BUILT_IN = frozenset(
    (
        *("abs", "all", "any", "bool", "bytes", "callable", "classmethod", "delattr", "dict", "dir"),
        *("divmod", "enumerate", "eval", "exec", "exit", "filter", "float", "format", "frozenset"),
        *("getattr", "globals", "hasattr", "hash", "id", "input", "int", "isinstance", "issubclass"),
        *("iter", "len", "list", "locals", "map", "max", "min", "next", "object", "open", "print"),
        *("property", "quit", "range", "repr", "reversed", "round", "set", "setattr", "sorted"),
        *("staticmethod", "str", "sum", "super", "tuple", "type", "vars", "zip"),
        *("Exception", "IOError", "KeyError", "KeyboardInterrupt", "NotImplementedError", "OSError"),
        *("RuntimeError", "StopIteration", "TimeoutError", "TypeError", "ValueError"),
    )
)


@lru_cache(maxsize=4096)
def _assigned_once(module: Module) -> frozenset[str]:
    """Return the variables of a module that only one statement assigns, in no branch."""
    names = (each for each in module.nodes if isinstance(each, ast.Name))
    stores = Counter(each.id for each in names if not isinstance(each.ctx, ast.Load))
    changed = {name for each in module.nodes if isinstance(each, ast.Global) for name in each.names}
    assigned = (each for each in module.tree.body if isinstance(each, (ast.Assign, ast.AnnAssign)))
    found = {
        target.id
        for statement in assigned
        for target in ast.walk(statement)
        if isinstance(target, ast.Name) and isinstance(target.ctx, ast.Store)
    }
    return frozenset(name for name in found - changed if stores[name] == 1)


def _is_hidden(outer: Frame, frame: Frame) -> bool:
    """Return whether an outer scope is the body of a class, whose names its methods do not see."""
    return outer is not frame and frame.function is not None and hasattr(outer, "cls")
