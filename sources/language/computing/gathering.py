"""Lists, dictionaries and comprehensions."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from dineros.sources.language.computing.operations import Operations, short
from dineros.sources.language.values import (
    Bound,
    Class,
    Const,
    Either,
    Frame,
    Function,
    Items,
    LateItems,
    Made,
    Mapping,
    Object,
    Open,
    Outside,
    Value,
    constant,
    is_none,
    join,
    key_of,
    of_key,
    options,
)

OF_ROS2 = {"ROS_VERSION": "2", "ROS_PYTHON_VERSION": "3"}
"""Variables of the environment that each set-up of ROS 2 sets, and their values."""
MOST_TURNS = 64
"""Limit of the iterations of a loop that are followed one by one."""


class Collections(Operations):
    """The part of the interpreter that evaluates collections."""

    # -------------------------------------------------------------------------------------------- collections

    def _items(self, nodes: list[ast.expr], frame: Frame, kind: str) -> Items:
        found: list[Value] = []
        is_open = False
        for each in nodes:
            if isinstance(each, ast.Starred):
                values, is_exact = self.turns(self.drawn(self.evaluate(each.value, frame), each.value, frame))
                found += values
                is_open |= not is_exact
            else:
                found.append(self.evaluate(each, frame))
        return Items(found, is_open, kind)

    def _value_of_List(self, node: ast.List, frame: Frame) -> Value:  # noqa: N802
        return self._items(node.elts, frame, "list")

    def _value_of_Tuple(self, node: ast.Tuple, frame: Frame) -> Value:  # noqa: N802
        return self._items(node.elts, frame, "tuple")

    def _value_of_Set(self, node: ast.Set, frame: Frame) -> Value:  # noqa: N802
        found = self._items(node.elts, frame, "set")
        for each in found.items:
            self.hashed(each, node, frame)
        return found

    def _value_of_Dict(self, node: ast.Dict, frame: Frame) -> Value:  # noqa: N802
        found = Mapping()
        for key, each in zip(node.keys, node.values, strict=True):
            value = self.evaluate(each, frame)
            if key is None:
                if isinstance(value, Mapping):
                    found.items |= value.items
                    found.rest += value.rest
                    found.is_open |= value.is_open
                else:
                    found.is_open = True
                continue
            known = self.evaluate(key, frame)
            self.hashed(known, key, frame)
            put(found, known, value)
        return found

    def hashed(self, key: Value, node: ast.AST, frame: Frame) -> None:
        """Call the method that gives the hash of an object, which a set or a dictionary asks for."""
        if isinstance(key, (Object, Either)):
            self.special(key, "__hash__", [], node, frame)

    def _value_of_Subscript(self, node: ast.Subscript, frame: Frame) -> Value:  # noqa: N802
        value = self.evaluate(node.value, frame)
        if isinstance(node.slice, ast.Slice):
            of_class = self.special(value, "__getitem__", [Open(short(node.slice))], node, frame)
            if of_class is not None:
                return of_class
            return self._sliced(value, node.slice, short(node), frame)
        key = self.evaluate(node.slice, frame)
        of_class = self.special(value, "__getitem__", [key], node, frame)
        if of_class is None and isinstance(value, (Object, Either)):
            with self.perhaps():
                of_class = self.special(value, "__missing__", [key], node, frame)
        if of_class is not None:
            return of_class
        if isinstance(value, Mapping):
            self.hashed(key, node, frame)
        if isinstance(value, Class):
            if value.is_enum() and isinstance(key, Const) and isinstance(key.value, str):
                return self.attribute(value, key.value, short(node), node, frame)
            of_type = self.look_up(value, "__class_getitem__")
            if isinstance(of_type, Function):
                return self.call(Bound(of_type, value), [key], {}, node, frame)
            return value  # ``Box[int]``
        if isinstance(value, Mapping) and value.factory is not None and is_missing(value, key):
            put(value, key, self.call(value.factory, [], {}, node, frame))
        found = [self.element(each, key, short(node)) for each in options(value) if not is_none(each)]
        return join(found) if found else Open(short(node))

    def _sliced(self, value: Value, node: ast.Slice, text: str, frame: Frame) -> Value:
        """Return a part of a list or a string."""
        ends = (node.lower, node.upper, node.step)
        known = [Const(None) if each is None else self.evaluate(each, frame) for each in ends]
        if not all(isinstance(each, Const) and isinstance(each.value, int | None) for each in known):
            return Open(text)
        part = slice(*(constant(each) for each in known))
        try:
            if isinstance(value, Items) and not value.is_open:
                return Items(value.items[part], kind=value.kind)
            if isinstance(value, Const) and isinstance(value.value, str):
                origins = (each.origin for each in (value, *known) if isinstance(each, Const))
                return Const(value.value[part], next(filter(None, origins), ""))
        except ValueError:  # a step of zero
            pass
        return Open(text)

    def element(self, value: Value, key: Value, text: str) -> Value:
        """Return an element of a collection."""
        if isinstance(value, Mapping):
            if (known := key_of(key)) is not None and known in value.items:
                return join([value.items[known], *value.rest]) if value.rest else value.items[known]
            if not isinstance(key, Const) or key.origin or value.rest:
                found = [*value.items.values(), *value.rest]
                return join([*found, Open(text)] if value.is_open else found) if found else Open(text)
            return Open(text)
        if isinstance(value, Items):
            if isinstance(key, Const) and isinstance(key.value, int) and not value.is_open:
                return (
                    value.items[key.value]
                    if -len(value.items) <= key.value < len(value.items)
                    else Open(text)
                )
            return join(value.items) if value.items else Open(text)
        if isinstance(value, Const) and isinstance(value.value, str) and isinstance(key, Const):
            try:
                return Const(value.value[key.value], value.origin)
            except (TypeError, IndexError):
                return Open(text)
        if isinstance(value, Outside):
            return (
                self.library.attribute(value, "__getitem__") or value
                if "[" not in text
                else _subscripted(value, key, text)
            )
        return Open(text)

    def turns(self, value: Value) -> tuple[list[Value], bool]:
        """Return the items of a loop over a value, and whether they are known exactly."""
        if isinstance(value, Items):
            return list(value.items), not value.is_open and len(value.items) <= MOST_TURNS
        if isinstance(value, Mapping):
            return [of_key(key) for key in value.items], not value.is_open and not value.rest
        if isinstance(value, Class) and value.is_enum():
            return members_of(value), True
        if isinstance(value, Either):
            found = [self.turns(each)[0] for each in value.options]
            return [each for values in found for each in values], False
        return [], False

    def _comprehension(self, node: Any, frame: Frame, make: Callable[[Frame], None]) -> bool:
        """Follow the loops of a comprehension; return whether all iterations are known."""
        inner = Frame(frame.module, {}, frame, function=frame.function, instance=frame.instance)
        is_exact = True

        def go(index: int) -> None:
            nonlocal is_exact
            if index == len(node.generators):
                make(inner)
                return
            generator = node.generators[index]
            here = frame if index == 0 else inner
            value = self.drawn(self.evaluate(generator.iter, here), generator.iter, here)
            values, exact = self.turns(value)
            is_exact &= exact
            if not exact:
                with self.perhaps(is_loop=True):
                    self.assign(
                        generator.target, join(values) if values else Open(short(generator.target)), inner
                    )
                    for test in generator.ifs:
                        self.evaluate(test, inner)
                    go(index + 1)
                return
            for turn, each in enumerate(values):
                with self.each(turn):
                    self.assign(generator.target, each, inner)
                    verdicts = [self.decide(test, inner) for test in generator.ifs]
                    if any(verdict is False and not origin for verdict, origin in verdicts):
                        continue
                    if all(verdict and not origin for verdict, origin in verdicts):
                        go(index + 1)
                    else:
                        is_exact = False
                        with self.perhaps():
                            go(index + 1)

        go(0)
        return is_exact

    def _value_of_ListComp(self, node: ast.ListComp, frame: Frame) -> Value:  # noqa: N802
        found: list[Value] = []
        is_exact = self._comprehension(
            node, frame, lambda inner: found.append(self.evaluate(node.elt, inner))
        )
        return Items(found, not is_exact)

    _value_of_SetComp = _value_of_ListComp  # noqa: N815

    def _value_of_GeneratorExp(self, node: ast.GeneratorExp, frame: Frame) -> Value:  # noqa: N802
        return LateItems(node, frame)

    def drawn_late(self, value: LateItems) -> Items:
        """Return what a generator expression gives, which runs now."""
        found: list[Value] = []
        is_exact = self._comprehension(
            value.node, value.frame, lambda inner: found.append(self.evaluate(value.node.elt, inner))
        )
        return Items(found, not is_exact)

    def _value_of_DictComp(self, node: ast.DictComp, frame: Frame) -> Value:  # noqa: N802
        found = Mapping()

        def make(inner: Frame) -> None:
            put(found, self.evaluate(node.key, inner), self.evaluate(node.value, inner))

        found.is_open = not self._comprehension(node, frame, make)
        return found

    def assign(self, target: ast.expr, value: Value, frame: Frame) -> None:
        """Assign a value to a target."""
        raise NotImplementedError


def members_of(cls: Class) -> list[Value]:
    """Return the members of an enumeration."""
    values = (each for name, each in cls.names.items() if not name.startswith("_"))
    found: list[Value] = []
    for each in values:
        if isinstance(each, Const):
            found.append(Const(each.value, each.origin, cls))
        elif isinstance(each, Made):
            each.enum = cls
            found.append(each)
        elif isinstance(each, Object) and each.cls is cls:
            found.append(each)
    return found


def is_missing(mapping: Mapping, key: Value) -> bool:
    """Return whether a dictionary has no value for a key, as far as known."""
    known = key_of(key)
    return not mapping.rest if known is None else known not in mapping.items


def put(mapping: Mapping, key: Value, value: Value) -> None:
    """Put a value into a dictionary, under a key that may be unknown."""
    if (known := key_of(key)) is not None:
        mapping.items[known] = value
    else:
        mapping.rest.append(value)


def _subscripted(value: Outside, key: Value, _text: str) -> Value:
    """Return a type with parameters as the type; an element of something unknown is unknown."""
    if value.path.startswith("os.environ"):
        name = str(key.value) if isinstance(key, Const) else "?"
        return Const(OF_ROS2[name]) if name in OF_ROS2 else Open(f"environment {name}")
    return Open(_text) if isinstance(key, Const) else value
