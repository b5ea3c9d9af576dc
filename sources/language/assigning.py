"""Assigns values to variables, attributes and elements; ports and groups get their names from them."""

from __future__ import annotations

import ast
from typing import TypeGuard

from dineros.sources.language.attributes import changed_name
from dineros.sources.language.computing.gathering import put
from dineros.sources.language.conditions import Conditions
from dineros.sources.language.expressions import PROPERTY
from dineros.sources.language.modules import text_of_code
from dineros.sources.language.values import (
    QUEUE,
    Bound,
    Class,
    Const,
    Either,
    Frame,
    Function,
    Holder,
    Items,
    Made,
    Mapping,
    ModuleValue,
    Object,
    Open,
    Outside,
    Partial,
    Port,
    Value,
    is_none,
    join,
    key_of,
    options,
)


class Assignments(Conditions):
    """The part of the interpreter that handles assignments."""

    def assign(self, target: ast.expr, value: Value, frame: Frame, expr: ast.expr | None = None) -> None:
        """Assign the value of an expression to a target; ports and groups get their names."""
        self.changes_attribute(target)
        if isinstance(target, ast.Name):
            self._name(value, target.id)
            self.assign_variable(target.id, value, frame)
        elif isinstance(target, ast.Attribute):
            self._name(value, text_of_code(target))
            self.attributes.stores.add((frame.module.path, target.lineno, target.col_offset))
            holders = options(self.evaluate(target.value, frame))
            self.gives(target, expr, frame)
            for holder in holders:
                if isinstance(holder, Object):
                    if self._set_by_code(holder, target.attr, value, target, frame):
                        continue
                    is_one = len(holders) == 1
                    self.put(holder, target.attr, value, expr, target, frame, is_certain=is_one)
                elif isinstance(holder, Outside) and holder.path.startswith("rclpy.qos"):
                    at = self.place(target, frame)
                    preset = self.presets.setdefault(holder.path, Made(holder.path, [], {}, at))
                    self.write_slot(preset, target.attr, value)
                elif not isinstance(holder, (Made, Port, ModuleValue)) and not is_none(holder):
                    self.attributes.names.add(target.attr)
                    self.escape(value)
                elif isinstance(holder, Made) and isinstance(value, (Bound, Function, Partial)):
                    self.escape(value)  # ``client.on_message = self.on_message``
                if isinstance(holder, Function):
                    holder.attributes[target.attr] = join([holder.attributes.get(target.attr), value])
                if isinstance(holder, Holder):
                    self.write_slot(holder, target.attr, value)
                elif isinstance(holder, Class):
                    self._set_in_class(holder, target.attr, value)
                elif isinstance(holder, ModuleValue):
                    outer = self.module_frame(holder.module).holder
                    if outer is not None:
                        self.write_slot(outer, target.attr, value)
        elif isinstance(target, ast.Subscript):
            self._name(value, f"{text_of_code(target.value)}[...]")
            key = self.evaluate(target.slice, frame)
            held = self.evaluate(target.value, frame)
            self.special(held, "__setitem__", [key, value], target, frame)
            for each in options(held):
                if isinstance(each, Mapping):
                    self.hashed(key, target, frame)
                    put(each, key, value)
                    if each.holder is not None and isinstance(known := key_of(key), str):
                        self.set_attribute(each.holder, known, value, target, frame)
                elif isinstance(each, Items):
                    each.items.append(value)
                    each.is_open = True
        elif isinstance(target, (ast.Tuple, ast.List)):
            self._unpack(target.elts, self.drawn(value, target, frame), frame)
        elif isinstance(target, ast.Starred):
            self.assign(target.value, Items([value], is_open=True), frame)

    def _set_by_code(self, holder: Object, name: str, value: Value, node: ast.AST, frame: Frame) -> bool:
        """Let the class set an attribute: a property, a descriptor, ``__setattr__``; False: it does not."""
        setter = self.look_up(holder.cls, f"{name}.setter")
        if isinstance(setter, Function):
            self.call(Bound(setter, holder), [value], {}, node, frame)
            return True
        for each in options(self.look_up(holder.cls, name)):
            of_property = each.argument(1, "fset") if _is_property_call(each) else None
            if of_property is not None:
                self.call(of_property, [holder, value], {}, node, frame)
                return True
            if isinstance(each, Object) and isinstance(self.look_up(each.cls, "__set__"), Function):
                self.special(each, "__set__", [holder, value], node, frame)
                return True
        own = self.look_up(holder.cls, "__setattr__")
        if isinstance(own, Function):
            self.call(Bound(own, holder), [Const(name), value], {}, node, frame)
            return True
        return False

    def set_attribute(self, holder: Value, name: str, value: Value, node: ast.AST, frame: Frame) -> None:
        """Set an attribute, as ``setattr`` does."""
        if isinstance(holder, Object) and self._set_by_code(holder, name, value, node, frame):
            return
        if isinstance(holder, Holder):
            self.write_slot(holder, name, value)
        elif isinstance(holder, Class):
            self._set_in_class(holder, name, value)

    def _set_in_class(self, cls: Class, name: str, value: Value) -> None:
        """Set an attribute of a class: for certain if the program does it once, before callbacks run."""
        before = cls.names.get(name)
        activity = self.activity
        is_certain = not (activity.conditional or self.run or self.attributes.has_begun)
        cls.names[name] = value if is_certain or before is None else join([before, value])

    def delete_attribute(self, value: Value, name: str, node: ast.AST, frame: Frame) -> None:
        """Let the class of an object delete an attribute."""
        for holder in options(value):
            if not isinstance(holder, Object):
                continue
            deleter = self.look_up(holder.cls, f"{name}.deleter")
            if isinstance(deleter, Function):
                self.call(Bound(deleter, holder), [], {}, node, frame)
            for each in options(self.look_up(holder.cls, name)):
                of_property = each.argument(2, "fdel") if _is_property_call(each) else None
                if of_property is not None:
                    self.call(of_property, [holder], {}, node, frame)
                self.special(each, "__delete__", [holder], node, frame)
            self.special(holder, "__delattr__", [Const(name)], node, frame)

    def changes_attribute(self, target: ast.expr) -> None:
        """Record that the code changes an attribute, or the container that it holds."""
        name = changed_name(target)
        if name is not None and self.activity.fact.kind != "constructor":
            self.attributes.changed.append((name, self.activity.fact))

    def _unpack(self, targets: list[ast.expr], value: Value, frame: Frame) -> None:
        value = join(_fields_of(each) for each in options(value))
        for index, each in enumerate(targets):
            found = []
            for option in options(value):
                if isinstance(option, Items) and not option.is_open and len(option.items) == len(targets):
                    found.append(option.items[index])
                elif isinstance(option, Items) and option.items:
                    found += option.items
                else:
                    found.append(Open(text_of_code(each)))
            self.assign(each, join(found), frame)

    def _name(self, value: Value, name: str) -> None:
        if isinstance(value, Made) and not value.name:
            value.name = name
            if value.entity is not None:
                value.entity.port = name
        elif isinstance(value, Object) and not value.name:
            value.name = name
            if value.made is not None and value.made.entity is not None:
                value.made.entity.port = name
        elif isinstance(value, Items) and value.kind == QUEUE:
            value.name = value.name or name
        elif hasattr(value, "entity") and value.entity is not None:
            if value.entity.port == "(no variable)":
                value.entity.port = name
        elif isinstance(value, Either):
            for each in value.options:
                if isinstance(each, Port):
                    self._name(each, name)
        elif isinstance(value, Items):
            for each in value.items[:50]:
                if not isinstance(each, Items):
                    self._name(each, name)


def _is_property_call(value: Value) -> TypeGuard[Made]:
    return isinstance(value, Made) and value.path == PROPERTY


def _fields_of(value: Value) -> Value:
    """Return the fields of a named tuple as a tuple, and another value as it is."""
    is_tuple = isinstance(value, Object) and "typing.NamedTuple" in value.cls.outside()
    if is_tuple or (isinstance(value, Made) and value.path == "a named tuple"):
        return Items([each.current for each in value.slots.values()], kind="tuple")  # type: ignore[attr-defined]
    return value
