"""Assigns values to variables, attributes and elements; ports and groups get their names from them."""

from __future__ import annotations

import ast

from dineros.sources.language.attributes import changed_name
from dineros.sources.language.computing.gathering import put
from dineros.sources.language.conditions import Conditions
from dineros.sources.language.modules import text_of_code
from dineros.sources.language.values import (
    QUEUE,
    Bound,
    Class,
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
                    setter = self.look_up(holder.cls, f"{target.attr}.setter")
                    if isinstance(setter, Function):
                        self.call(Bound(setter, holder), [value], {}, target, frame)
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
                if isinstance(holder, Holder):
                    self.write_slot(holder, target.attr, value)
                elif isinstance(holder, Class):
                    before = holder.names.get(target.attr)
                    holder.names[target.attr] = join([before, value]) if before is not None else value
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
                    put(each, key, value)
                elif isinstance(each, Items):
                    each.items.append(value)
                    each.is_open = True
        elif isinstance(target, (ast.Tuple, ast.List)):
            self._unpack(target.elts, value, frame)
        elif isinstance(target, ast.Starred):
            self.assign(target.value, Items([value], is_open=True), frame)

    def changes_attribute(self, target: ast.expr) -> None:
        """Record that the code changes an attribute, or the container that it holds."""
        name = changed_name(target)
        if name is not None and self.activity.fact.kind != "constructor":
            self.attributes.changed.append((name, self.activity.fact))

    def _unpack(self, targets: list[ast.expr], value: Value, frame: Frame) -> None:
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
