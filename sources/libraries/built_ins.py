"""Interprets the built-in functions of Python, as far as it matters."""

from __future__ import annotations

import ast
import re

from dineros.sources.language.computing.constants import call_built_in
from dineros.sources.language.machine import Machine
from dineros.sources.language.values import (
    NONE,
    Bound,
    Class,
    Const,
    Frame,
    Function,
    Items,
    Made,
    Mapping,
    Object,
    Open,
    OutsideMethod,
    Partial,
    SomeFunction,
    Text,
    Value,
    constant,
    hole,
    is_none,
    join,
    options,
)
from dineros.sources.libraries.doing import Keys
from dineros.sources.libraries.standard.functional import names_of


class BuiltIns:
    """The functions of Python itself.

    `machine`: the interpreter that calls them.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine

    def call(self, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame) -> Value:
        """Call a function by its name."""
        first = args[0] if args else None
        if first is not None and name in _SPECIAL:
            of_class = self.machine.special(first, f"__{name}__", [], node, frame)
            if of_class is not None:
                return of_class
        self._call_keys(name, args, keys, node, frame)
        if name in ("sorted", "min", "max") and "key" not in keys:
            self._compare(args, node, frame)
        found = call_built_in(name, args, name)
        if found is not None:
            return found
        if name == "iter" and len(args) == 2:
            with self.machine.perhaps(is_loop=True):
                return Items([self.machine.call(args[0], [], {}, node, frame)], is_open=True)
        if name == "callable" and isinstance(first, (Function, Bound, Partial, Class, Const)):
            return Const(not isinstance(first, Const), first.origin if isinstance(first, Const) else "")
        if name in ("list", "tuple", "set", "sorted", "reversed", "iter"):
            if first is None:
                return Items([], kind=name)
            values, is_exact = self.machine.turns(first)
            values = list(reversed(values)) if name == "reversed" else list(values)
            if name == "set":
                for each in values:
                    self.machine.hashed(each, node, frame)
            kind = name if name == "set" else "list"
            return Items(values, not is_exact or name == "sorted", kind)
        if name == "enumerate" and first is not None:
            values, is_exact = self.machine.turns(first)
            return Items([Items([Const(i), v], kind="tuple") for i, v in enumerate(values)], not is_exact)
        if name == "zip" and args:
            turns = [self.machine.turns(each) for each in args]
            pairs: list[Value] = [
                Items(list(each), kind="tuple") for each in zip(*(t[0] for t in turns), strict=False)
            ]
            return Items(pairs, not all(t[1] for t in turns))
        if name == "range":
            numbers = [constant(each) for each in args]
            if numbers and all(isinstance(n, int) for n in numbers):
                try:
                    turns_of = range(*numbers)[:65]
                except (TypeError, ValueError):
                    return Open("range")
                return Items([Const(n) for n in turns_of], len(turns_of) > 64)
            return Items([], is_open=True)
        if name == "len" and isinstance(first, Items) and not first.is_open:
            return Const(len(first.items), "" if self._is_fixed(first, node) else "variable")
        if name == "getattr" and len(args) > 1 and isinstance(args[1], Const):
            wanted = str(args[1].value)
            value = self.machine.attribute(args[0], wanted, f"getattr({wanted})", node, frame)
            is_lost = len(args) > 2 and isinstance(value, OutsideMethod)
            return join([args[2], value]) if is_lost else value
        if name == "type" and len(args) == 1:
            return join(_type_of(each) for each in options(first))
        if name == "type" and len(args) == 3:
            return self.machine.new_class(args, node, frame)
        if name == "vars" and first is not None:
            if isinstance(first, Class):
                return Mapping(dict(first.names))
            return self.machine.attribute(first, "__dict__", "vars()", node, frame)
        if name == "dir" and isinstance(first, Object):
            return Items([Const(each) for each in names_of(first)], is_open=True)
        if name in ("globals", "locals"):
            holder = frame
            while name == "globals" and holder.outer is not None:
                holder = holder.outer
            slots = holder.holder.slots if holder.holder is not None else {}
            return Mapping({**{key: each.any() for key, each in slots.items()}, **holder.names})
        if name in ("eval", "exec"):
            return self._run_text(first, node, frame)
        if name in ("staticmethod", "classmethod", "property"):
            return Made(f"builtins.{name}", args, keys, self.machine.place(node, frame))
        if name == "getattr" and len(args) > 1:
            return self._any_attribute(args, node, frame)
        if name == "setattr" and len(args) > 2 and isinstance(args[1], Const):
            for each in options(args[0]):
                self.machine.set_attribute(each, str(args[1].value), args[2], node, frame)
            return NONE
        if name == "setattr":
            self.machine.activity.fact.is_open = True
            return NONE
        if name == "open":
            return Made("builtins.open", args, keys, self.machine.place(node, frame))
        if name == "input":
            self.machine.effect("input", "terminal", node, frame)
        if name == "map" and len(args) > 1:
            values, is_exact = self.machine.turns(args[1])
            with self.machine.perhaps(is_loop=True):
                return Items(
                    [self.machine.call(args[0], [each], {}, node, frame) for each in values], not is_exact
                )
        if name == "str" and first is not None:
            return Text(hole(first)) if isinstance(first, Text) else Open(hole(first)[1:-1])
        if name in ("int", "float") and isinstance(first, Open):
            return Open(first.text)
        if name == "next" and first is not None:
            values, _ = self.machine.turns(first)
            return join(values) if values else Open("next")
        return Open(name)

    def _run_text(self, text: Value | None, node: ast.AST, frame: Frame) -> Value:
        """Run code that is a text; unknown text may do anything."""
        try:
            code = ast.parse(text.value) if isinstance(text, Const) and isinstance(text.value, str) else None
        except (SyntaxError, ValueError, RecursionError):
            code = None
        if code is None:
            self.machine.activity.fact.is_open = True
            return Open("eval()")
        for each in ast.walk(code):
            if hasattr(each, "lineno"):
                each.lineno = getattr(node, "lineno", 1)
        if len(code.body) == 1 and isinstance(code.body[0], ast.Expr):
            return self.machine.evaluate(code.body[0].value, frame)
        self.machine.execute(code.body, frame)
        return NONE

    def _compare(self, args: list[Value], node: ast.AST, frame: Frame) -> None:
        """Call the methods that compare the objects in lists."""
        for each in args[:1] if len(args) == 1 else args:
            for value in (each, *self.machine.turns(each)[0]):
                with self.machine.perhaps(is_loop=True):
                    for method in ("__lt__", "__gt__"):
                        self.machine.special(value, method, [Open("other")], node, frame)

    def _call_keys(self, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame) -> None:
        """Call the function that a built-in function gets for each element: a key, or a test."""
        function = keys.get("key") if name in ("sorted", "min", "max") else None
        if name == "filter" and len(args) == 2:
            function = args[0]
        if function is None or is_none(function) or not args:
            return
        values, _ = self.machine.turns(args[-1])
        with self.machine.perhaps(is_loop=True):
            self.machine.call(function, [join(values) if values else Open("element")], {}, node, frame)

    def _any_attribute(self, args: list[Value], node: ast.AST, frame: Frame) -> Value:
        """Return the possible attributes of an object whose names are partly known."""
        found = list(args[2:3])
        for holder in options(args[0]):
            for name in options(args[1]):
                if isinstance(name, Const):
                    text = f"getattr({name.value})"
                    found.append(self.machine.attribute(holder, str(name.value), text, node, frame))
                elif not isinstance(holder, Object):
                    found.append(Open("getattr"))
                elif isinstance(name, Text):
                    fits = re.compile(".*".join(map(re.escape, re.split(r"{[^{}]*}", name.text))))
                    found += [
                        self.machine.attribute(holder, each, f"getattr({each})", node, frame)
                        for each in names_of(holder)
                        if fits.fullmatch(each)
                    ]
                else:
                    found.append(SomeFunction("getattr"))
        return join(found) if found else Open("getattr")

    def _is_fixed(self, value: Items, node: ast.AST) -> bool:
        """Return whether a collection has the same length in each run: nothing else has changed it yet."""
        if value.kind == "tuple" or (isinstance(node, ast.Call) and isinstance(node.args[0], ast.List)):
            return True
        is_first = self.machine.activity.fact.kind in ("main", "module") and not self.machine.run
        return is_first and not self.machine.attributes.has_begun


def _type_of(value: Value) -> Value:
    if isinstance(value, Object):
        return value.cls
    return value.meta if isinstance(value, Class) and value.meta is not None else Open("type()")


_SPECIAL = (
    *("len", "str", "repr", "next", "bool", "int", "float", "hash", "abs"),
    *("round", "reversed", "format", "divmod", "bytes", "complex"),
)
"""Functions that call a method of the class."""
