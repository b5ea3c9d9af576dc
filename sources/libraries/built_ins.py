"""Interprets the built-in functions of Python, as far as it matters."""

from __future__ import annotations

import ast
import re

from dineros.sources.language.computing.constants import call_built_in
from dineros.sources.language.machine import Machine
from dineros.sources.language.values import (
    NONE,
    Const,
    Frame,
    Holder,
    Items,
    Made,
    Mapping,
    Object,
    Open,
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
        found = call_built_in(name, args, name)
        if found is not None:
            return found
        if name in ("list", "tuple", "set", "sorted", "reversed", "iter"):
            if first is None:
                return Items([], kind=name)
            values, is_exact = self.machine.turns(first)
            values = list(reversed(values)) if name == "reversed" else list(values)
            return Items(values, not is_exact or name == "sorted")
        if name == "dict":
            found_items = Mapping(dict(keys))
            if isinstance(first, Mapping):
                found_items = Mapping({**first.items, **keys}, list(first.rest), first.is_open)
            elif first is not None:
                found_items.is_open = True
            return found_items
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
            return self.machine.attribute(
                args[0], str(args[1].value), f"getattr({args[1].value})", node, frame
            )
        if name == "getattr" and len(args) > 1:
            return self._any_attribute(args, node, frame)
        if name == "setattr" and len(args) > 2 and isinstance(args[1], Const):
            for each in options(args[0]):
                if isinstance(each, Holder):
                    self.machine.write_slot(each, str(args[1].value), args[2])
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
                        for each in _names(holder)
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


_SPECIAL = ("len", "str", "repr", "next", "bool", "int", "float", "hash", "abs")
"""Functions that call a method of the class."""


def _names(holder: Object) -> list[str]:
    """Return the names of the attributes and methods of an object, without those of Python."""
    every = [*holder.slots, *(name for cls in holder.cls.inside for name in cls.names)]
    return [each for each in dict.fromkeys(every) if not each.startswith("__")]
