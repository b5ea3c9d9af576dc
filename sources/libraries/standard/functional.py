"""Interprets ``functools``, ``operator``, ``itertools``, and what else calls its arguments at once."""

from __future__ import annotations

import ast

from dineros.sources.language.machine import Machine
from dineros.sources.language.values import (
    Bound,
    Const,
    Frame,
    Function,
    Items,
    Made,
    Object,
    Open,
    Outside,
    OutsideMethod,
    Partial,
    Value,
    constant,
    is_none,
    join,
    options,
    text_of,
)

_CACHES = ("functools.lru_cache", "functools.cache")
_CALL_AT_ONCE = frozenset(
    (
        "bisect",
        "cProfile",
        "csv",
        "heapq",
        "json",
        "math",
        "numpy",
        "os",
        "pandas",
        "random",
        "re",
        "scipy",
        "sched",
        "shutil",
        "statistics",
        "timeit",
        "xml",
    )
)
"""Modules whose functions call the functions that they get before they return."""
_GET = ("operator.methodcaller", "operator.attrgetter", "operator.itemgetter")
_MOST_FOLDED = 8
"""Limit of the elements of a list that ``reduce`` goes through one by one."""


def calls_at_once(path: str) -> bool:
    """Return whether a function of the standard library calls its arguments before it returns."""
    return path.partition(".")[0] in _CALL_AT_ONCE


class Functional:
    """Functions that call functions.

    `machine`: the interpreter that calls them.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine

    def call(self, path: str, made: Made, node: ast.AST, frame: Frame) -> Value | None:
        """Call a function by its dotted name; None: another function."""
        args = made.args
        if path == "functools.reduce" and len(args) > 1:
            return self._reduce(args, node, frame)
        if path in _CACHES and args and _is_code(args[0]):
            return args[0]
        if path in ("functools.cmp_to_key", "enum.member", "enum.nonmember") and args:
            return args[0]
        if path in (*_GET, *_CACHES):
            return made
        if path.startswith("itertools."):
            return self._iterate(path.rpartition(".")[2], made, node, frame)
        if path == "inspect.getmembers" and args:
            return self._members(args[0], node, frame)
        if path == "operator.call" and args:
            return self.machine.call(args[0], args[1:], made.keys, node, frame)
        if calls_at_once(path):
            self.call_each(args, made.keys, node, frame)
        return None

    def call_made(self, made: Made, args: list[Value], node: ast.AST, frame: Frame) -> Value | None:
        """Call what one of these functions has returned; None: something else."""
        if made.path in _CACHES and args:
            return args[0]
        if made.path not in _GET or not args:
            return None
        found = []
        for holder in options(args[0]):
            if made.path == "operator.methodcaller":
                method = self._attribute(holder, text_of(made.argument(0)), node, frame)
                found.append(self.machine.call(method, made.args[1:], made.keys, node, frame))
            elif made.path == "operator.itemgetter":
                found += [self.machine.element(holder, each, "an item") for each in made.args]
            else:
                found += [self._attribute(holder, text_of(each), node, frame) for each in made.args]
        return join(found) if len(made.args) == 1 or made.path == _GET[0] else Items(found, kind="tuple")

    def call_each(self, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame) -> None:
        """Call the functions among arguments any number of times."""
        for each in (*args, *keys.values()):
            if any(_is_code(option) for option in options(each)):
                with self.machine.perhaps(is_loop=True):
                    self.machine.call(each, [], {}, node, frame)

    def _attribute(self, holder: Value, path: str, node: ast.AST, frame: Frame) -> Value:
        found = holder
        for name in path.split("."):
            found = self.machine.attribute(found, name, path, node, frame)
        return found

    def _reduce(self, args: list[Value], node: ast.AST, frame: Frame) -> Value:
        turns, is_exact = self.machine.turns(self.machine.drawn(args[1], node, frame))
        if is_exact and len(turns) <= _MOST_FOLDED:
            rest = [*args[2:3], *turns]
            found = rest[0] if rest else Open("reduce")
            for index, each in enumerate(rest[1:]):
                with self.machine.each(index, is_loop=False):
                    found = self.machine.call(args[0], [found, each], {}, node, frame)
            return found
        element = join(turns) if turns else Open("element")
        with self.machine.perhaps(is_loop=True):
            found = self.machine.call(
                args[0], [args[2] if len(args) > 2 else element, element], {}, node, frame
            )
        return join([*args[2:3], found])

    def _iterate(self, name: str, made: Made, node: ast.AST, frame: Frame) -> Value:
        """Call a function of ``itertools``: what it goes through is known, but not how often."""
        args = list(made.args)
        function: Value | None = None
        if name in ("takewhile", "dropwhile", "filterfalse", "starmap"):
            function = args.pop(0) if args else None
        elif name in ("accumulate", "groupby"):
            function = made.argument(1, "func", "key")
            args = args[:1]
        elif name in ("islice", "cycle", "tee", "pairwise", "batched"):
            args = args[:1]
        elif name in ("count", "repeat"):
            return Items(args[:1], is_open=True)
        turns = [self.machine.turns(self.machine.drawn(each, node, frame)) for each in args]
        values = [each for found, _ in turns for each in found]
        if name == "chain":
            return Items(values, not all(is_exact for _, is_exact in turns))
        if name == "from_iterable":
            inner = [each for value in values for each in self.machine.turns(value)[0]]
            return Items(inner, is_open=True)
        if name in ("product", "zip_longest"):
            columns = [join(found) if found else Open("element") for found, _ in turns]
            return Items([Items(columns, kind="tuple")], is_open=True)
        element = join(values) if values else Open("element")
        if function is not None and not is_none(function):
            given = element.items if name == "starmap" and isinstance(element, Items) else [element]
            given = [*given, element] if name == "accumulate" else list(given)
            with self.machine.perhaps(is_loop=True):
                found = self.machine.call(function, given, {}, node, frame)
            if name in ("starmap", "accumulate"):
                return Items([found], is_open=True)
            if name == "groupby":
                return Items([Items([found, Items(values, is_open=True)], kind="tuple")], is_open=True)
        if name in ("permutations", "combinations", "pairwise", "batched", "tee"):
            return Items([Items(values, is_open=True)], is_open=True)
        return Items(values, is_open=True)

    def _members(self, holder: Value, node: ast.AST, frame: Frame) -> Value:
        if not isinstance(holder, Object):
            return Items([], is_open=True)
        pairs = [
            Items([Const(name), self.machine.attribute(holder, name, name, node, frame)], kind="tuple")
            for name in names_of(holder)
        ]
        return Items(list(pairs), is_open=True)


def names_of(holder: Object) -> list[str]:
    """Return the names of the attributes and methods of an object, without those of Python."""
    every = [*holder.slots, *(name for cls in holder.cls.inside for name in cls.names)]
    return [each for each in dict.fromkeys(every) if not each.startswith("__") and each.isidentifier()]


def _is_code(value: Value) -> bool:
    is_method = isinstance(value, OutsideMethod) and isinstance(constant(value.instance), str)
    is_outside = isinstance(value, Outside)
    return not is_method and not is_outside and isinstance(value, (Bound, Function, Partial))
