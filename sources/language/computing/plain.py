"""Functions that only calculate: after some calls with unknown numbers, their result is not calculated again.

Robots with geometry call such functions thousands of times, each time with other objects. Nothing that the
facts tell depends on the result, as long as it is unknown.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from dineros.sources.branches import Branch, Called, Do, Leave, Loop, Turns, walk
from dineros.sources.facts import Item
from dineros.sources.language.modules import Module
from dineros.sources.language.values import (
    QUEUE,
    Const,
    Either,
    Frame,
    Function,
    Items,
    Made,
    Object,
    Open,
    Outside,
    OutsideMethod,
    Text,
    Value,
    options,
)

MOST_RESULTS = 12
"""How often the result is calculated."""


class PlainFunctions:
    """Knows the functions of a program that only calculate, and their unknown results.

    Parameters
    ----------
    frames : mapping of str to Frame
        The modules that have run, by their paths: only their code can be called.
    """

    def __init__(self, frames: Mapping[str, Frame]) -> None:
        self._frames = frames
        self._size = 0
        self._names = _Names()
        self._is_possible = False
        self._known: dict[ast.AST, bool] = {}
        self._results: dict[ast.AST, list[Value]] = {}
        self._errors: dict[ast.AST, list[ast.Raise]] = {}
        self._never: set[ast.AST] = set()

    def result(self, function: Function, args: Iterable[Value]) -> Value | None:
        """Return the result of a call if it is unknown anyway; None: the function must be followed."""
        found = self._results.get(function.node)
        if found is None or len(found) < MOST_RESULTS or not self._is_plain(function):
            return None
        last = found[-1]
        if not _is_number(last) or not all(_is_data(each) for value in args for each in options(value)):
            return None
        return replace(last, items=list(last.items)) if isinstance(last, Items) else last

    def errors(self, function: Function) -> list[ast.Raise]:
        """Return the errors that the calls of a function have raised."""
        return self._errors.get(function.node, [])

    def keep(self, function: Function, result: Value, body: list[Item]) -> None:
        """Record a result of a call with what it did; a known result, or an effect, ends the recording."""
        if function.node in self._never or len(self._results.get(function.node, ())) == MOST_RESULTS:
            return
        if function.frame.function is None and _is_number(result) and _is_harmless(body):
            raised = [each for each in walk(body) if isinstance(each, Leave) and each.way == "raises"]
            own = [each for each in ast.walk(function.node) if isinstance(each, ast.Raise)] if raised else []
            if len(raised) <= len(own):
                self._results.setdefault(function.node, []).append(result)
                if own:
                    self._errors[function.node] = own
                return
        self._never.add(function.node)
        self._results.pop(function.node, None)

    def _is_plain(self, function: Function) -> bool:
        """Return whether neither the code of a function nor what it calls can do anything but calculate."""
        if len(self._frames) != self._size:
            self._size = len(self._frames)
            self._names = _Names()
            for frame in self._frames.values():
                self._names.add(_names_in(frame.module))
            self._known = {}
            self._is_possible = not self._names.is_dynamic and all(map(self._is_all_plain, self._operators()))
        return self._is_possible and self._is_definition_plain(function.node, function.frame.module)

    def _operators(self) -> list[str]:
        """Return the methods of the program that Python calls without a name."""
        return [
            each for each in self._names.defined if each.startswith("__") and each not in _NOT_IN_CALCULATIONS
        ]

    def _is_all_plain(self, name: str) -> bool:
        """Return whether all functions of a name only calculate."""
        return all(self._is_definition_plain(node, module) for node, module in self._names.defined[name])

    def _is_definition_plain(self, node: ast.AST, module: Module) -> bool:
        known = self._known
        if node not in known:
            known[node] = True  # also while it is looked at: it may call itself
            if not isinstance(node, ast.FunctionDef) or not self._calculates(node, module):
                order = list(known)
                for each in order[order.index(node) :]:  # these may rest on it
                    if known[each]:
                        del known[each]
                known[node] = False
        return known[node]

    def _calculates(self, function: ast.FunctionDef, module: Module) -> bool:
        if any(
            not isinstance(each, ast.Name) or each.id not in _DECORATORS for each in function.decorator_list
        ):
            return False
        called = {id(each.func) for each in ast.walk(function) if isinstance(each, ast.Call)}
        hints = [
            function.returns,
            *(each.annotation for each in ast.walk(function.args) if hasattr(each, "annotation")),
        ]
        left_out = {id(inner) for each in hints if each is not None for inner in ast.walk(each)}
        own = {each.arg for each in ast.walk(function.args) if isinstance(each, ast.arg)}
        own |= {
            each.id
            for each in ast.walk(function)
            if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
        }
        for each in ast.walk(function):
            if each is function or id(each) in left_out or isinstance(each, ast.Load | ast.Store):
                continue
            if isinstance(each, ast.Raise):
                if not _is_only_a_message(each):
                    return False
                left_out |= {id(inner) for inner in ast.walk(each)}
            elif isinstance(each, ast.Call):
                if not self._is_call_plain(each, own, module):
                    return False
            elif isinstance(each, ast.Attribute):
                if not isinstance(each.ctx, ast.Load):
                    return False
                if id(each) not in called and not self._is_all_plain(each.attr):
                    return False  # a property, or a function as a value
            elif isinstance(each, ast.Name):
                if id(each) not in called and each.id not in own and self._names.defined.get(each.id):
                    return False
            elif isinstance(each, ast.Subscript):
                if not isinstance(each.ctx, ast.Load):
                    return False
            elif not isinstance(each, _CALCULATES):
                return False
        return True

    def _is_call_plain(self, call: ast.Call, own: set[str], module: Module) -> bool:
        names, function = self._names, call.func
        if any(each.arg in (None, "key") for each in call.keywords):
            return False
        if isinstance(function, ast.Name):
            name = function.id
            if name in own or name in names.stored or name in names.classes:
                return False
            if name in names.defined:
                return self._is_all_plain(name)
            library = _imports(module).get(name)
            return name in _BUILT_IN if library is None else library in _NUMERIC
        if not isinstance(function, ast.Attribute):
            return False
        root: ast.expr = function
        while isinstance(root, ast.Attribute):
            root = root.value
        if isinstance(root, ast.Name) and root.id not in own and _imports(module).get(root.id) in _NUMERIC:
            return True
        name = function.attr
        if name in names.stored or name in names.classes:
            return False
        return (
            name in _METHODS
            if name not in names.defined
            else name not in _OF_ROS and self._is_all_plain(name)
        )


@dataclass
class _Names:
    """The names in the modules of a program."""

    defined: defaultdict[str, list[tuple[ast.AST, Module]]] = field(default_factory=lambda: defaultdict(list))
    """Functions and methods by name."""
    classes: set[str] = field(default_factory=set)
    stored: set[str] = field(default_factory=set)
    """Attributes, and variables of modules and classes, that code assigns."""
    is_dynamic: bool = False
    """Whether code may give objects other methods under any name."""

    def add(self, other: _Names) -> None:
        """Add the names of another module."""
        for name, found in other.defined.items():
            self.defined[name] += found
        self.classes |= other.classes
        self.stored |= other.stored
        self.is_dynamic |= other.is_dynamic

    def read(self, module: Module) -> None:
        """Add the names of the code of a module."""
        for node in module.nodes:
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                self.defined[node.name].append((node, module))
            elif isinstance(node, ast.ClassDef):
                self.classes.add(node.name)
                self.is_dynamic |= any(not _is_ordinary(each) for each in node.decorator_list)
                self.is_dynamic |= any(each.arg == "metaclass" for each in node.keywords)
                self._add_variables(node.body)
            elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
                self.stored.add(node.attr)
            elif isinstance(node, ast.Name) and node.id in ("setattr", "exec", "eval", "globals", "vars"):
                self.is_dynamic = True
            elif isinstance(node, ast.Global):
                self.stored.update(node.names)
            if isinstance(node, ast.Attribute) and node.attr in ("__dict__", "__setattr__", "__class__"):
                self.is_dynamic = True
        self._add_variables(module.tree.body)

    def _add_variables(self, body: list[ast.stmt]) -> None:
        for part in body:
            if not isinstance(part, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                for each in ast.walk(part):
                    if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store):
                        self.stored.add(each.id)


def _names_in(module: Module) -> _Names:
    """Return the names in a module, which is read once."""
    known: _Names | None = getattr(module.tree, "names_in", None)
    if known is None:
        known = module.tree.names_in = _Names()  # type: ignore[attr-defined]
        known.read(module)
    return known


def _imports(module: Module) -> dict[str, str]:
    """Return the names that a module imports, with the first part of where they are from."""
    known: dict[str, str] | None = getattr(module.tree, "imported_from", None)
    if known is None:
        known = {}
        for node in module.nodes:
            if isinstance(node, ast.Import):
                for each in node.names:
                    name = each.name.partition(".")[0]
                    known[each.asname or name] = name
            elif isinstance(node, ast.ImportFrom):
                first = "" if node.level else (node.module or "").partition(".")[0]
                known.update((each.asname or each.name, first) for each in node.names)
        module.tree.imported_from = known  # type: ignore[attr-defined]
    return known


def _is_ordinary(decorator: ast.expr) -> bool:
    """Return whether a decorator of a class leaves its methods as they are."""
    named = decorator.func if isinstance(decorator, ast.Call) else decorator
    return getattr(named, "id", getattr(named, "attr", "")) in (
        "dataclass",
        "unique",
        "final",
        "total_ordering",
    )


def _is_only_a_message(node: ast.Raise) -> bool:
    """Return whether what a ``raise`` evaluates is an error with a constant text."""
    error = node.exc
    if isinstance(error, ast.Call) and not error.keywords:
        return isinstance(error.func, ast.Name) and all(isinstance(each, ast.Constant) for each in error.args)
    return error is None or isinstance(error, ast.Name)


def _is_number(value: Value) -> bool:
    """Return whether a value is unknown, and can be nothing but a number or a collection of numbers."""
    if isinstance(value, Either):
        return all(_is_number(each) for each in value.options)
    if isinstance(value, Items):
        return value.kind != QUEUE and all(_is_number(each) for each in value.items)
    if isinstance(value, Made):
        return value.path.partition(".")[0] in _NUMERIC and not value.slots
    return type(value) is Open


def _is_data(value: Value) -> bool:
    """Return whether the use of an argument runs no code of the program."""
    if isinstance(value, Items):
        return all(_is_data(option) for each in value.items for option in options(each))
    if isinstance(value, Made):
        return value.path.partition(".")[0] in _NUMERIC
    if isinstance(value, OutsideMethod):
        return type(value.instance) is Open  # a field of an unknown value
    return isinstance(value, (Const, Object, Outside, Text)) or type(value) is Open


def _is_harmless(body: list[Item]) -> bool:
    """Return whether a body only branches, returns, and raises errors."""
    return all(
        each.effect.do == "raise" if isinstance(each, Do) else isinstance(each, _BRANCHES)
        for each in walk(body)
    )


_BRANCHES = (Branch, Called, Leave, Loop, Turns)
_NUMERIC = frozenset(("math", "cmath", "numpy", "scipy", "shapely", "transforms3d", "tf_transformations"))
"""Libraries that calculate with what they are given."""
_DECORATORS = frozenset(("staticmethod", "classmethod", "property", "override"))
_BUILT_IN = frozenset(
    (
        *("abs", "bool", "divmod", "enumerate", "float", "int", "isinstance", "len", "list", "max", "min"),
        *("pow", "range", "reversed", "round", "sum", "tuple", "zip"),
    )
)
_METHODS = frozenset(
    (
        *("all", "any", "area", "argmax", "argmin", "astype", "bounds", "buffer", "centroid", "contains"),
        *("copy", "cross", "distance", "dot", "flatten", "inverse", "intersection", "intersects", "items"),
        *("keys", "max", "mean", "min", "norm", "reshape", "round", "sum", "tolist", "transpose", "union"),
        *("values", "within"),
    )
)
"""Methods of numbers, matrices, shapes and collections."""
_OF_ROS = frozenset(
    (
        *("acquire", "call", "call_async", "cancel", "get", "join", "publish", "put", "release", "result"),
        *("send_goal", "send_goal_async", "set", "sleep", "spin", "spin_once", "start", "wait"),
    )
)
"""Methods of ports, futures, threads, locks and queues."""
_NOT_IN_CALCULATIONS = frozenset(
    (
        *("__init__", "__new__", "__del__", "__repr__", "__str__", "__format__", "__post_init__"),
        *("__enter__", "__exit__", "__aenter__", "__aexit__", "__call__", "__init_subclass__", "__setitem__"),
        *("__set_name__", "__hash__"),
    )
)
"""Methods that only code calls that functions that calculate do not have."""
_CALCULATES = (
    *(ast.arg, ast.arguments, ast.expr_context, ast.operator, ast.unaryop, ast.boolop, ast.cmpop),
    *(ast.Assign, ast.AugAssign, ast.Break, ast.Continue, ast.Expr, ast.For, ast.If, ast.Pass),
    *(ast.Return, ast.BinOp, ast.BoolOp, ast.Compare, ast.Constant, ast.IfExp, ast.List, ast.ListComp),
    *(ast.Slice, ast.Tuple, ast.UnaryOp, ast.comprehension, ast.keyword),
)
"""The other parts that a function that calculates may have."""
