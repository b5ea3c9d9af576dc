"""Interprets the containers of the standard library, and weak references."""

from __future__ import annotations

import ast

from dineros.sources.language.computing.gathering import put
from dineros.sources.language.machine import Machine
from dineros.sources.language.values import (
    NONE,
    Frame,
    Items,
    Made,
    Mapping,
    Object,
    Open,
    Value,
    join,
    options,
)

_DICTIONARIES = frozenset(
    (
        *("collections.OrderedDict", "collections.Counter", "collections.UserDict", "builtins.dict"),
        *("weakref.WeakValueDictionary", "weakref.WeakKeyDictionary", "types.MappingProxyType"),
    )
)
_REFERENCES = ("weakref.ref", "weakref.WeakMethod")


class Collected:
    """Containers and references.

    `machine`: the interpreter that makes them.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine

    def call(self, path: str, made: Made, node: ast.AST, frame: Frame) -> Value | None:
        """Call a class or function by its dotted name; None: another one."""
        args, keys = made.args, made.keys
        if path in _DICTIONARIES:
            return self._dictionary(args, keys)
        if path == "builtins.dict.fromkeys" and args:
            found = Mapping()
            turns, is_exact = self.machine.turns(args[0])
            for each in turns:
                put(found, each, args[1] if len(args) > 1 else NONE)
            found.is_open = not is_exact
            return found
        if path == "collections.defaultdict":
            found = self._dictionary(args[1:], keys)
            found.is_open = True
            found.factory = args[0] if args else None
            return found
        if path == "collections.ChainMap":
            found = Mapping()
            for each in reversed(args):
                inner = self._dictionary([each], {})
                found.rest += [*(found.items[key] for key in inner.items if key in found.items), *inner.rest]
                found.items |= inner.items
                found.is_open |= inner.is_open
            return found
        if path in ("collections.deque", "weakref.WeakSet", "collections.UserList"):
            turns, is_exact = self.machine.turns(args[0]) if args else ([], True)
            return Items(list(turns), not is_exact)
        if path.startswith("heapq.") and args and isinstance(args[0], Items):
            return self._heap(path.rpartition(".")[2], args[0], args[1:])
        if path == "types.SimpleNamespace":
            for name, value in keys.items():
                self.machine.write_slot(made, name, value)
            return made
        if path == "weakref.proxy" and args:
            return args[0]
        if path in _REFERENCES and args:
            return made
        if path in ("dataclasses.asdict", "dataclasses.astuple") and args:
            fields = {
                name: self.machine.read_slot(each, name) or Open(name)
                for each in options(args[0])
                if isinstance(each, Object)
                for name in each.slots
            }
            return Mapping(fields) if path.endswith("dict") else Items(list(fields.values()), kind="tuple")
        if path in ("dataclasses.replace", "copy.replace", "attr.evolve") and args:
            return self.replaced(args[0], keys)
        return None

    def call_made(self, made: Made, node: ast.AST, frame: Frame) -> Value | None:
        """Call a reference; None: something else."""
        if made.path in _REFERENCES and made.args:
            return made.args[0]
        if made.path == "weakref.finalize" and len(made.args) > 1:
            return self.machine.call(made.args[1], made.args[2:], made.keys, node, frame)
        return None

    def method(self, value: Value, name: str, args: list[Value], keys: dict[str, Value]) -> Value | None:
        """Call a method of a named tuple or of a variable of ``contextvars``; None: of something else."""
        if name == "_replace" and isinstance(value, (Object, Made)):
            return self.replaced(value, keys)
        if not isinstance(value, Made) or value.path != "contextvars.ContextVar":
            return None
        if name == "set" and args:
            self.machine.write_slot(value, "value", args[0])
        return self.machine.read_slot(value, "value") or Open("value") if name == "get" else NONE

    def replaced(self, value: Value, keys: dict[str, Value]) -> Value:
        """Return a copy of an object with other values of some attributes."""
        if not isinstance(value, (Object, Made)):
            return Open("replaced")
        found: Object | Made = (
            Object(value.cls, value.at)
            if isinstance(value, Object)
            else Made(value.path, value.args, value.keys, value.at)
        )
        for name in {**value.slots, **keys}:
            given = keys[name] if name in keys else self.machine.read_slot(value, name)
            if given is not None:
                self.machine.write_slot(found, name, given)
        return found

    def _dictionary(self, args: list[Value], keys: dict[str, Value]) -> Mapping:
        found = Mapping()
        for given in args[:1]:
            for each in options(given):
                if isinstance(each, Mapping):
                    found.items |= each.items
                    found.rest += each.rest
                    found.is_open |= each.is_open
                elif isinstance(each, Items):
                    for pair in each.items:
                        if isinstance(pair, Items) and len(pair.items) == 2:
                            put(found, *pair.items)
                        else:
                            found.is_open = True
                    found.is_open |= each.is_open
                else:
                    found.is_open = True
        found.items |= keys
        return found

    def _heap(self, name: str, heap: Items, args: list[Value]) -> Value:
        element = join(heap.items) if heap.items else Open("element")
        if name in ("heappush", "heappushpop", "heapreplace") and args:
            heap.items.append(args[0])
            heap.is_open = True
            del heap.items[64:]
            element = join(heap.items)
        if name in ("nlargest", "nsmallest", "merge"):
            return Items(list(heap.items), is_open=True)
        return NONE if name in ("heappush", "heapify") else element
