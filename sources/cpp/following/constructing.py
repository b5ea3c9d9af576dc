"""Interprets the construction of objects in C++: base classes, members, aggregates."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.sources.cpp.entries import ClassInfo, Routine
from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.choices import Choices
from dineros.sources.cpp.following.expressions import named
from dineros.sources.cpp.following.fitting import fits
from dineros.sources.cpp.following.machine import MOST_CALLS, coerced, is_node
from dineros.sources.cpp.following.operators import CALLED
from dineros.sources.cpp.parsing import arguments_of, path_of, text_of
from dineros.sources.cpp.values import (
    Either,
    Frame,
    Items,
    Lambda,
    Made,
    Obj,
    Value,
    joined,
    options,
)

if TYPE_CHECKING:
    from tree_sitter import Node

_MOST_DELEGATIONS = 8
"""Limit of the constructors of a class that call each other."""
_OWN = ("Broadcaster", "Listener", "Updater", "ImageTransport")
"""Parts of names of classes of libraries that wrap a given node and are not equal to it."""


class Constructing(Choices):
    """Makes objects of the classes of the folder."""

    def construct(self, cls: ClassInfo, args: list[Value], types: list[str], node: Node, frame: Frame) -> Obj:
        """Return a new object of a class of the folder."""
        this = Obj(
            cls,
            types=dict(zip(cls.templates, types, strict=False)),
            made_at=hash((node.id, *self.turns)),
            made_by=hash((node.id, *self.calls, *self.turns)),
        )
        key = (id(cls), node.id, tuple(self.calls), tuple(self.turns))
        before = self.made.get(key)
        if len(args) == 1 and isinstance(args[0], Obj) and args[0].cls is cls and not _may_copy(cls):
            return args[0]  # a copy
        self.made[key] = this
        if self.is_idle(cls.node):
            return this
        if len(self.calls) < MOST_CALLS and self.calls.count((cls.node.id, 0)) < 2:
            self.calls.append((cls.node.id, node.id))
            self.calls.append((cls.node.id, 0))
            try:
                with self.observed(cls.node):
                    self._construct(cls, this, args, node, frame)
            finally:
                del self.calls[-2:]
        # Read again, it is the same object: its members keep the values that callbacks assigned.
        for name, value in before.fields.items() if before is not None else ():
            this.fields[name] = joined(this.fields.get(name), value)
        return this

    def _construct(self, cls: ClassInfo, this: Obj, args: list[Value], node: Node, caller: Frame) -> None:
        found = [each for each in cls.methods.get(cls.name, []) if each.body is not None]
        fitting = [each for each in found if len(each.parameters) == len(args)]
        fitting = fitting or [each for each in found if len(each.parameters) > len(args)] or found
        marks = [self._match(each, args) for each in fitting]
        fitting = [each for each, mark in zip(fitting, marks, strict=True) if mark == max(marks)]
        if not fitting:
            if any(len(each) >= len(args) > 0 for each in cls.defaults.get(cls.name, [])):
                self.escapes(Call(node, caller, cls.full, args))  # its constructor is missing
            frame = Frame(cls.path, cls.full, this, cls)
            self._bases(cls, this, {}, args, node, frame)
            self._members(cls, this, {}, frame)
            lambdas = tuple(each for each in args if isinstance(each, Lambda))
            if cls.bases and lambdas:  # a template extends all of them: ``overloaded{...}``
                this.fields[CALLED] = Either(lambdas)
            if not cls.bases:  # an aggregate: its members in order, or by name
                for order, item in zip(cls.fields, args, strict=False):
                    is_named = isinstance(item, Made) and item.path.startswith(".")
                    name = item.path[1:] if is_named else order  # type: ignore[attr-defined]
                    value = item.args[0] if is_named else item  # type: ignore[attr-defined]
                    this.fields[name] = self._aggregate(
                        cls.fields.get(name, (None, None))[0], value, node, frame
                    )
            return
        self._begin(cls, this, fitting[0], args, node)
        if this.node is None:
            for other in fitting[1:_MOST_DELEGATIONS]:  # it may also be this one
                with self.perhaps():
                    self._begin(cls, this, other, args, node)

    def _begin(self, cls: ClassInfo, this: Obj, routine: Routine, args: list[Value], node: Node) -> None:
        """Run one constructor."""
        self.followed.add(routine.node.id)
        frame = self.frame_of(routine, args, this, [])
        inits: dict[str, Node | None] = {}
        own = None
        for each in routine.node.named_children:
            if each.type == "field_initializer_list":
                for init in named(each):
                    parts = named(init)
                    if parts:
                        name, given_nodes = path_of(parts[0]), parts[-1] if len(parts) > 1 else None
                        inits[name.rpartition("::")[2]] = given_nodes
                        if f"::{cls.full}".endswith(
                            f"::{name}"
                        ):  # a base may also have the name of the class
                            own = given_nodes
        self.frames.append(frame)
        frame.level = self.cond + self.loops
        try:
            if own is not None:  # another constructor does the work
                given = self.values(own, frame)
                if self.calls.count((cls.node.id, 0)) < _MOST_DELEGATIONS:
                    self.calls.append((cls.node.id, 0))
                    try:
                        self._construct(cls, this, given, node, frame)
                    finally:
                        self.calls.pop()
            else:
                self._bases(cls, this, inits, [], routine.node, frame)
                self._members(cls, this, inits, frame)
            self.run_block(routine.body, frame)
        finally:
            self.frames.pop()

    def _match(self, routine: Routine, args: list[Value]) -> int:
        """Return how well arguments fit the parameters of a constructor."""
        mark = 0
        for number, value in enumerate(args[: len(routine.parameters)]):
            arg = value
            kind = self.type_of_parameter(routine, number)
            kinds = self.bases(arg.cls) if isinstance(arg, Obj) and arg.cls is not None else []
            if isinstance(arg, Made) and routine.cls is not None:  # its class may have another name here
                arg = Made(self.type_text_of(arg.path, Frame(routine.path, routine.cls.full)))
            mark += fits(kind, arg, [each.full for each in kinds])
        return mark

    def _aggregate(self, kind: Node | None, value: Value, node: Node, frame: Frame) -> Value:
        """Return the value of a member of an aggregate: lists in braces become objects."""
        if not isinstance(value, Items) or kind is None:
            return coerced(text_of(kind), value)
        inner = arguments_of(kind)
        if inner and path_of(kind).endswith("vector"):
            return self.aggregates(value, inner[0], node, frame)
        return self.declared(kind, value.values, node, frame)

    def aggregates(self, value: Value, kind: Node | None, node: Node, frame: Frame) -> Value:
        """Return a list of objects: those in braces are made, each one an object of its own."""
        cls = self.class_of(self.type_text(kind, frame), frame) if kind is not None else None
        if cls is None or not isinstance(value, Items):
            return value
        made: list[Value] = []
        for turn, each in enumerate(value.values):
            self.turns.append(turn)
            is_list = isinstance(each, Items)
            made.append(self.construct(cls, each.values, [], node, frame) if is_list else each)  # type: ignore[attr-defined]
            self.turns.pop()
        return Items(made, value.is_open, cls)

    def _bases(
        self,
        cls: ClassInfo,
        this: Obj,
        inits: dict[str, Node | None],
        args: list[Value],
        node: Node,
        frame: Frame,
    ) -> None:
        for base in cls.bases:
            name = self.type_text(base, frame)
            last = path_of(base).rpartition("::")[2]
            written = next((each for each in inits if self._names_base(each, cls, last, name)), None)
            given = args if written is None else self.values(inits[written], frame)
            inner = self.class_of(name, frame)
            if is_node(name):
                self.library.make_node(this, name, given, node, frame)
            elif inner is not None and inner is not cls and len(self.calls) < MOST_CALLS:
                if path_of(base) in cls.templates:
                    this.policies.append(inner)
                self.calls.append((inner.node.id, 1))
                types = [self.template_text(each, frame) for each in arguments_of(base)]
                this.types |= dict(zip(inner.templates, types, strict=False))
                try:
                    self._construct(inner, this, given, node, frame)
                finally:
                    self.calls.pop()
            elif inner is None and name not in cls.templates:
                call = Call(node, frame, name, given)
                if self.library.call(call) is None:
                    self.escapes(call)
                if not name.startswith("std::"):
                    self.extending.append(this)

    def _names_base(self, init: str, cls: ClassInfo, last: str, name: str) -> bool:
        """Return whether an initialiser is that of a base class, by its name, its type, or an alias."""
        if init in (last, name.rpartition("::")[2]):
            return True
        alias = None if init in cls.fields else self.index.find_alias(init, cls.path, cls.full)
        return alias is not None and path_of(alias).rpartition("::")[2] == last

    def _members(self, cls: ClassInfo, this: Obj, inits: dict[str, Node | None], frame: Frame) -> None:
        for name, (kind, default) in cls.fields.items():
            inner = inits.get(name)
            if name in inits:
                args = self.values(inner, frame)
                where = inner if inner is not None else cls.node
            elif default is not None:
                is_list = default.type in ("initializer_list", "argument_list")
                args = self.values(default, frame) if is_list else [self.value(default, frame)]
                where = default
            elif kind is not None:
                args, where = [], kind
            else:
                continue
            if kind is None:
                continue
            text = path_of(kind)
            if name in cls.arrays:
                given = args if inner is not None or default is not None else self._field_of(kind, frame)
                this.fields[name] = self.aggregates(Items(given), kind, where, frame)
            elif (
                default is not None
                and name not in inits
                and default.type not in ("initializer_list", "argument_list")
            ):
                this.fields[name] = coerced(text_of(kind), args[0])
            elif name in cls.pointers:  # no object is made
                if args:
                    this.fields[name] = args[0]
            elif args or self._is_value(kind, cls, name, frame):
                this.fields[name] = self._field(kind, text, args, where, frame)

    def _field(self, kind: Node, text: str, args: list[Value], where: Node, frame: Frame) -> Value:
        if len(args) == 1 and text in frame.types | dict.fromkeys(frame.cls.templates if frame.cls else ()):
            return args[0]  # its type is a parameter of a template
        is_plain = len(args) == 1 and any(isinstance(each, (Obj, Made)) for each in options(args[0]))
        if is_plain and isinstance(args[0], Obj) and not arguments_of(kind):
            cls = self.class_of(self.type_text(kind, frame), frame)
            if cls is None and not any(each in text for each in _OWN):
                return args[0]
            if cls is not None and args[0].cls is not None and cls in self.bases(args[0].cls):
                return args[0]
        return self.declared(kind, args, where, frame)

    def _field_of(self, kind: Node, frame: Frame) -> list[Value]:
        """Return an item of an array of objects of the folder, which stands for all of them."""
        cls = self.class_of(self.type_text(kind, frame), frame)
        return [] if cls is None else [self.construct(cls, [], [], kind, frame)]

    def _is_value(self, kind: Node, cls: ClassInfo, name: str, frame: Frame) -> bool:
        """Return whether a member without arguments is an object or a list, and not a pointer."""
        if kind.type not in ("type_identifier", "qualified_identifier", "template_type"):
            return False
        return not any(
            each.endswith(("Ptr", "_ptr")) or "weak" in each
            for each in (path_of(kind), self.type_text(kind, frame))
        )


def _may_copy(cls: ClassInfo) -> bool:
    """Return whether a class has a constructor with one argument, which may be that for copies."""
    return any(len(each.parameters) == 1 for each in cls.methods.get(cls.name, []))
