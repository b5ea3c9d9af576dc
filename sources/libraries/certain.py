"""Finds the attributes of a program whose assignments are all known and that have few possible values."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache

from dineros.sources.branches import (
    NOTHING,
    OTHER,
    SOME,
    Compared,
    Put,
    conditions,
    variables_set,
    variables_tested,
    walk,
)
from dineros.sources.facts import CallbackFact, Item, NodeFact
from dineros.sources.language.conditions import simple
from dineros.sources.language.machine import Machine
from dineros.sources.language.modules import Module
from dineros.sources.language.values import Class, Const, Object
from dineros.sources.variables import Known, Use, Variable

MOST_VALUES = 8
"""Limit of the values of a variable that a model distinguishes."""
_BASES = ("rclpy.", "abc.", "object", "builtins.object", "typing.", "enum.")
"""Prefixes of the dotted names of bases that set no attribute of a program."""
_TAKEN = frozenset(
    (
        *("_action_client", "_allow_undeclared_parameters", "_callbacks", "_clients", "_clock", "_context"),
        *("_default_callback_group", "_descriptors", "_enabled", "_guards", "_logger", "_logger_service"),
        *("_managed_entities", "_node", "_on_set_parameters_callbacks", "_parameter_event_publisher"),
        *("_parameter_overrides", "_parameter_service", "_parameters", "_post_set_parameters_callbacks"),
        *("_pre_set_parameters_callbacks", "_publishers", "_rate_group", "_services", "_state_machine"),
        *("_status", "_subscriptions", "_time_source", "_timers", "_type_description_service", "_is_ready"),
        *("executor", "handle", "context", "enabled", "service_name"),
    )
)
"""Attributes that rclpy sets on its own objects."""


def find_variables(machine: Machine, outside: Iterable[Item]) -> None:
    """Store with each node of a program its certain variables.

    Parameters
    ----------
    machine : Machine
        The interpreter, at the end of the program.
    outside : iterable of Item
        Effects of the program outside of constructors and callbacks.
    """
    known, is_known = machine.attributes, only_followed(machine)
    loose = variables_set(list(outside))
    loose |= {each for fact in _unused(machine) for each in variables_set(fact.body or [])}
    users = _users(machine)
    for holder, variable in known.all():
        if variable in loose or not is_known(holder, variable.name):
            continue
        nodes = users.get(variable, set())
        first = (
            known.first(variable)
            if known.has_first(variable)
            else simple(machine.look_up(holder.cls, variable.name))
        )
        if len(nodes) == 1 and first is not None:
            variable.first = first
            next(iter(nodes)).variables.append(variable)
    for node in machine.nodes:
        _finish(node)


def only_followed(machine: Machine) -> Callable[[Object, str], bool]:
    """Return whether only code that was followed can set an attribute of an object.

    `machine`: the interpreter, at the end of the program.
    """
    known = machine.attributes
    modules = [machine.modules.all[path] for path in machine.frames if path in machine.modules.all]
    hidden = _Hidden(modules, known.stores)
    if known.is_wild or hidden.is_wild:
        return lambda holder, name: False
    names = known.names | hidden.set_by(known.calls)

    def is_known(holder: Object, name: str) -> bool:
        return (
            name not in names
            and name not in _TAKEN
            and id(holder) in known.single
            and _is_plain(machine, holder, name)
            and not hidden.is_stored(name, holder)
        )

    return is_known


def _unused(machine: Machine) -> Iterator[CallbackFact]:
    """Yield the items that do not belong to a node."""
    return (each.fact for each in machine.callbacks.values() if each.node is None)


def _users(machine: Machine) -> dict[Variable, set[NodeFact]]:
    """Return the nodes whose callbacks set or test a variable."""
    found: dict[Variable, set[NodeFact]] = {}
    for callback in machine.callbacks.values():
        body = callback.fact.body or []
        if callback.node is not None:
            for variable in variables_set(body) | variables_tested(body):
                found.setdefault(variable, set()).add(callback.node)
    return found


def _finish(node: NodeFact) -> None:
    """Find the values of a node's variables; omit those with many values, and those that nothing tests."""
    kept = []
    for variable in node.variables:
        values: dict[Known, None] = {variable.first: None}
        is_any = is_tested = False
        for fact in node.callbacks:
            for item in walk(fact.body or []):
                if isinstance(item, Put) and item.variable is variable:
                    variable.sets.append(Use(fact.name, item.at, item.values))
                    is_any |= item.values is None
                    values |= dict.fromkeys(item.values or ())
            for each in conditions(fact.body or []):
                if isinstance(each, Compared) and each.variable is variable:
                    variable.tests.append(Use(fact.name, each.at))
                    is_tested = True
                    values |= dict.fromkeys([each.value] if each.value is not None and is_any else ())
        if is_any:
            values |= {NOTHING: None, SOME: None, OTHER: None}
            for fact in node.callbacks:
                values |= {
                    each.value: None
                    for each in conditions(fact.body or [])
                    if isinstance(each, Compared) and each.variable is variable and each.value is not None
                }
        variable.values = tuple(values)
        for uses in (variable.sets, variable.tests):
            uses.sort(key=lambda use: (use.at.file, use.at.line))
        if is_tested and 1 < len(values) <= MOST_VALUES:
            kept.append(variable)
    node.variables = kept


def _is_plain(machine: Machine, holder: Object, name: str) -> bool:
    """Return whether an attribute of an object only has values that the program assigns."""
    special = ("__setattr__", "__getattribute__", "__getattr__", "__delattr__")
    if any(machine.look_up(holder.cls, each) is not None for each in special):
        return False
    found = machine.look_up(holder.cls, name)
    if found is not None and not isinstance(found, Const):
        return False
    return holder.cls.is_complete() and all(path.startswith(_BASES) for path in holder.cls.outside())


class _Hidden:
    """Assignments to attributes in code that was not followed.

    Parameters
    ----------
    modules : iterable of Module
        Modules that the program imports.
    stores : set of (str, int, int)
        The assignments that were followed.
    """

    def __init__(self, modules: Iterable[Module], stores: set[tuple[str, int, int]]) -> None:
        self._found: dict[str, list[ast.ClassDef | None]] = {}
        self._functions: dict[str, list[ast.AST]] = {}
        self.is_wild = False
        for module in modules:
            assigned = _assigned(module)
            self.is_wild |= assigned.is_wild
            for name, functions in assigned.functions.items():
                self._functions.setdefault(name, []).extend(functions)
            for name, at, cls in assigned.attributes:
                if at is None or (module.path, *at) not in stores:
                    self._found.setdefault(name, []).append(cls)

    def is_stored(self, name: str, holder: Object) -> bool:
        """Return whether code that was not followed may set an attribute of an object."""
        own = [each.node for each in holder.cls.order() if isinstance(each, Class)]
        return any(cls is None or cls in own for cls in self._found.get(name, ()))

    def set_by(self, functions: Iterable[str]) -> set[str]:
        """Return the attributes that functions of some names set, and those that they call."""
        todo, seen, found = list(functions), set[str](), set[str]()
        while todo:
            name = todo.pop()
            if name in seen:
                continue
            seen.add(name)
            for function in self._functions.get(name, ()):
                for each in ast.walk(function):
                    if isinstance(each, ast.Attribute):
                        if not isinstance(each.ctx, ast.Load):
                            found.add(each.attr)
                        todo.append(each.attr)
                    elif isinstance(each, ast.Name):
                        todo.append(each.id)
        return found


@lru_cache(maxsize=1024)
def _assigned(module: Module) -> _Assigned:
    """Read a module; several programs import it."""
    found = _Assigned()
    found.read(module.tree, None, "")
    return found


@dataclass(eq=False)
class _Assigned:
    """What the code of a module assigns and calls, whether it is followed or not."""

    attributes: list[tuple[str, tuple[int, int] | None, ast.ClassDef | None]] = field(default_factory=list)
    """Name, line and column of each assignment to an attribute, and the class if it is one of ``self``;
    without a location: it is deleted, or set by name.
    """
    functions: dict[str, list[ast.AST]] = field(default_factory=dict)
    """The functions of each name."""
    is_wild: bool = False
    """Whether it may assign any attribute."""

    def read(self, tree: ast.AST, cls: ast.ClassDef | None, own: str) -> None:
        """Read a tree; `own` is the name by which a method calls its object."""
        for node in ast.iter_child_nodes(tree):
            inner, named = cls, own
            if isinstance(node, ast.ClassDef):
                inner = node
            elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                self.functions.setdefault(node.name, []).append(node)
                if isinstance(tree, ast.ClassDef):
                    named = node.args.args[0].arg if node.args.args else ""
            elif isinstance(node, ast.Attribute):
                self._attribute(node, cls, own)
            elif isinstance(node, ast.Call):
                self._call(node)
            self.read(node, inner, named)

    def _attribute(self, node: ast.Attribute, cls: ast.ClassDef | None, own: str) -> None:
        self.is_wild |= node.attr in ("__dict__", "__class__") and not isinstance(node.ctx, ast.Load)
        self.is_wild |= node.attr == "__dict__"
        if not isinstance(node.ctx, ast.Load):
            is_own = isinstance(node.value, ast.Name) and bool(own) and node.value.id == own
            at = None if isinstance(node.ctx, ast.Del) else (node.lineno, node.col_offset)
            self.attributes.append((node.attr, at, cls if is_own else None))

    def _call(self, node: ast.Call) -> None:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in ("exec", "eval", "vars", "__setattr__", "__delattr__", "__import__", "import_module"):
            self.is_wild = True
        if name in ("setattr", "delattr"):
            text = node.args[1] if len(node.args) > 1 else None
            if isinstance(text, ast.Constant):
                self.attributes.append((str(text.value), None, None))
            else:
                self.is_wild = True
