"""Methods that C++ calls without a name: operators and destructors; constants in braces."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from typing import TYPE_CHECKING

from dineros.sources.branches import Leave
from dineros.sources.cpp.entries import ClassInfo, Routine
from dineros.sources.cpp.following.machine import Machine
from dineros.sources.cpp.parsing import path_of, text_of
from dineros.sources.cpp.values import Either, Frame, Made, Method, Obj, Open, Value, options

if TYPE_CHECKING:
    from tree_sitter import Node

AT_END = "a function at the end of a block"
"""Path of an object that runs its argument when its block ends."""
CALLED = "operator()"
"""The member of an object whose class extends lambdas, for all of them."""
_BRACED = ("std::string", "string", "std::chrono::", "rclcpp::QoS", "rclcpp::Duration")
"""Types of constants in braces."""


_OWNERS = ("unique_ptr", "optional", "UniquePtr")
_SHARED = ("shared_ptr", "SharedPtr")
"""Ends of names of pointers that own their object, alone or together with others."""


class Operators(Machine):
    """Calls operators and destructors of classes of the folder."""

    def braced(self, node: Node, frame: Frame) -> Value | None:
        """Return a constant that is written in braces or parentheses; None: another one, or of a class."""
        declarator = node.parent
        declaration = declarator.parent if declarator is not None else None
        kind = declaration.child_by_field_name("type") if declaration is not None else None
        if node.type not in ("initializer_list", "argument_list") or kind is None or declarator is None:
            return None
        is_plain = kind.type in ("primitive_type", "sized_type_specifier")
        inner = declarator.child_by_field_name("declarator")
        if (inner is not None and inner.type == "array_declarator") or not (
            is_plain or text_of(kind).startswith(_BRACED)
        ):
            return None
        return self.declared(kind, self.values(node, frame), node, frame)

    def values(self, node: Node | None, frame: Frame) -> list[Value]:
        """Return the values of arguments."""
        raise NotImplementedError

    def declared(self, kind: Node | None, args: list[Value], node: Node, frame: Frame) -> Value:
        """Return the value of a declaration with arguments."""
        raise NotImplementedError

    def aggregates(self, value: Value, kind: Node | None, node: Node, frame: Frame) -> Value:
        """Return a list of objects: those in braces are made."""
        raise NotImplementedError

    def operated(self, on: Value, sign: str, args: list[Value], node: Node) -> Value | None:
        """Call an operator that a class of the folder has; None: no class has it."""
        able = [
            (each, routines)
            for each in options(on)
            if isinstance(each, Obj) and each.cls and (routines := self.methods(each.cls, f"operator{sign}"))
        ]
        found: list[Value] = []
        for each, routines in able:
            with self.perhaps() if len(options(on)) > 1 else nullcontext():
                found.append(self.run(routines, args, each, node, []))
        if not able:
            found = self._operated_outside(options(on), sign, args, node)
        return None if not found else found[0] if len(found) == 1 else Either(tuple(found))

    def _operated_outside(
        self, several: Sequence[Value], sign: str, args: list[Value], node: Node
    ) -> list[Value]:
        """Call an operator that is a function of the folder, for each object; return the results."""
        found: list[Value] = []
        for each in several:
            if not isinstance(each, Obj) or each.cls is None or not self.frames:
                continue
            own = self.bases(each.cls)
            routines = []
            for one in self.index.find_functions(f"operator{sign}", self.frames[-1].path):
                if len(one.parameters) == len(args) + 1:
                    frame = Frame(one.path, one.space)
                    if self.class_of(self.type_text(one.parameters[0].type, frame), frame) in own:
                        routines.append(one)
            if routines:
                with self.perhaps() if len(several) > 1 else nullcontext():
                    found.append(self.run(routines, [each, *args], None, node, []))
        return found

    def tested(self, value: Value, node: Node) -> Value:
        """Return a value as a truth value: what ``operator bool`` of a class returns."""
        return self.operated(value, " bool", [], node) or value

    def held_by(self, access: Node, on: Value) -> Value:
        """Return the object whose member ``->`` accesses: what the operator of a class returns."""
        if text_of(access.child_by_field_name("operator")) != "->":
            return on
        return self.operated(on, "->", [], access) or on

    def run(
        self, routines: list[Routine], args: list[Value], this: Obj | None, node: Node, types: list[str]
    ) -> Value:
        """Run a routine of the folder."""
        raise NotImplementedError

    def methods(self, cls: ClassInfo, name: str) -> list[Routine]:
        """Return the methods of a name that a class has or inherits."""
        for each in self.bases(cls):
            if name in each.methods:
                return each.methods[name]
        return []

    def invoke(self, called: Value, args: list[Value], node: Node, frame: Frame) -> Value:
        """Call a value."""
        raise NotImplementedError

    def methods_of(self, this: Obj, name: str) -> list[Routine]:
        """Return the methods of a name that an object has, also by bases that a template's argument names."""
        if this.cls is None:
            return []
        found = self.methods(this.cls, name)
        return found or next((one for each in this.policies if (one := self.methods(each, name))), [])

    def functor(self, value: Value) -> Value:
        """Return the method that a call of an object calls; other values as they are."""
        if isinstance(value, Obj) and value.cls is not None:
            routines = self.methods(value.cls, "operator()")
            return Method(routines, "operator()", value) if routines else value.fields.get(CALLED, value)
        return value

    def let_go(self, objects: Sequence[Value], node: Node, kind: Node | None = None) -> None:
        """Run the destructors of what a pointer holds; of a shared pointer, others may hold it, too."""
        path = path_of(kind)
        if kind is not None and not path.endswith((*_OWNERS, *_SHARED)):
            return
        held = [each for each in objects if isinstance(each, Obj)]
        for each in held:
            with self.perhaps() if len(held) > 1 or path.endswith(_SHARED) else nullcontext():
                self.destroy([each], node)

    def destroy(self, objects: Sequence[Value], node: Node) -> None:
        """Run the destructors of a block's objects, the last one first; a ``return`` comes after them."""
        for each in reversed(objects):
            cls = each.cls if isinstance(each, Obj) and each.node is None else None
            routines = self.methods(cls, f"~{cls.name}") if cls is not None else []
            if not routines and isinstance(each, Obj):
                continue
            outer, self.block = self.block, []
            try:
                if isinstance(each, Obj):
                    self.run(routines, [], each, node, [])
                else:
                    called = each.args[0] if isinstance(each, Made) else each
                    self.invoke(called, [Open("the object")], node, self.frames[-1])
            finally:
                done, self.block = self.block, outer
            at = len(outer) - 1 if outer and isinstance(outer[-1], Leave) else len(outer)
            outer[at:at] = done
