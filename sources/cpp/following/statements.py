"""Interprets statements and declarations in C++."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from dineros.sources.branches import Leave
from dineros.sources.cpp.declarators import function_of, is_array, is_lost, name_of, used
from dineros.sources.cpp.following.constructing import Constructing
from dineros.sources.cpp.following.expressions import named
from dineros.sources.cpp.following.machine import coerced
from dineros.sources.cpp.following.operators import AT_END
from dineros.sources.cpp.following.statics import is_kept
from dineros.sources.cpp.parsing import path_of, text_of
from dineros.sources.cpp.values import (
    NO_VALUE,
    Const,
    Frame,
    Items,
    Lambda,
    Made,
    Method,
    Obj,
    Open,
    Port,
    Value,
    joined,
    members_of,
)

if TYPE_CHECKING:
    from tree_sitter import Node

_INSIDE = {
    *("compound_statement", "preproc_if", "preproc_ifdef", "preproc_else", "preproc_elif"),
    *("else_clause", "labeled_statement", "ERROR", "case_statement", "translation_unit"),
}
_NOTHING = {
    *("comment", "static_assert_declaration", "class_specifier"),
    *(
        "struct_specifier",
        "preproc_def",
        "preproc_function_def",
        "preproc_call",
        "preproc_include",
        "enum_specifier",
    ),
}


_TEMPLATE = re.compile(r"<.*>", re.DOTALL)
"""Arguments of a template: a list of pointers is a list."""
_SAME = re.compile(r"std::(?:move|ref|cref)\s*\(\s*(\w+)\s*\)")
"""An argument that is a variable."""
_POINTERS = ("Ptr", "shared_ptr", "unique_ptr")
"""Ends of types of pointers."""


class Statements(Constructing):
    """Runs statements."""

    def run_block(self, node: Node | None, frame: Frame) -> None:
        """Run a statement, or those of a block."""
        if node is None or frame.is_done:
            return
        self.count()
        kind = node.type
        if kind in _NOTHING:
            return
        if kind in _INSIDE:
            self._inside(node, frame)
            return
        found = getattr(self, f"_do_{kind}", None)
        if found is not None:
            found(node, frame)
        else:
            self.value(node, frame)

    def _inside(self, node: Node, frame: Frame) -> None:
        if node.type.startswith("preproc"):
            self.directive(node, frame)
            return
        held = len(self.holding)
        value = node.child_by_field_name("value")
        outer, self.scoped = self.scoped, []
        for each in named(node):
            if each != value:
                self.run_block(each, frame)
        inner, self.scoped = self.scoped, outer
        self.destroy(inner, node)
        del self.holding[held:]

    def _do_expression_statement(self, node: Node, frame: Frame) -> None:
        for each in named(node):
            value = self.value(each, frame)
            if isinstance(value, Obj) and self._is_new(each, value, frame):
                self.destroy([value], node)  # no variable holds it

    _do_init_statement = _inside

    def _do_alias_declaration(self, node: Node, frame: Frame) -> None:
        name = node.child_by_field_name("name") or node.child_by_field_name("declarator")
        kind = node.child_by_field_name("type")
        if name is not None and kind is not None:
            frame.types[text_of(name)] = self.type_text(kind, frame)

    _do_type_definition = _do_alias_declaration

    def _do_using_declaration(self, node: Node, frame: Frame) -> None:
        name = used(node)
        if name is not None:
            frame.types[path_of(name).rpartition("::")[2]] = self.type_text(name, frame)

    def _do_return_statement(self, node: Node, frame: Frame) -> None:
        found = named(node)
        value = self.value(found[0], frame) if found else Open("nothing")
        self.block.append(Leave("returns"))
        if self.off > frame.off:  # with the default values, it returns elsewhere
            self._leave(frame)
            return
        frame.result = value if frame.result is None else joined(frame.result, value)
        self._leave(frame)

    def _do_break_statement(self, node: Node, frame: Frame) -> None:
        self.block.append(Leave("breaks"))

    def _do_continue_statement(self, node: Node, frame: Frame) -> None:
        self.block.append(Leave("continues"))

    def _do_goto_statement(self, node: Node, frame: Frame) -> None:
        self.is_lost = True

    def _do_throw_statement(self, node: Node, frame: Frame) -> None:
        self.values(node, frame)
        if self.role not in ("main", "constructor"):
            self.does("throw", text_of(node)[:60], node, frame)
        self.block.append(Leave("raises"))
        self._leave(frame)

    def _leave(self, frame: Frame) -> None:
        if self.cond + self.loops > frame.level:
            frame.has_left = True
        else:
            frame.is_done = True

    # ----------------------------------------------------------------------------------------- declarations

    def _do_declaration(self, node: Node, frame: Frame) -> None:
        kind = node.child_by_field_name("type")
        words = {text_of(each) for each in node.named_children if each.type.endswith("_specifier")}
        words |= {text_of(each) for each in node.named_children if each.type == "type_qualifier"}
        is_static = "static" in words and not words & {"const", "constexpr"}
        for declarator in node.children_by_field_name("declarator"):
            if kind is not None and self._calls_item(kind, declarator, frame):
                continue
            key = declarator.id, *sorted(frame.types.items())
            name = name_of(declarator)
            if is_static and key in self.statics:
                frame.values[name] = self.statics[key]
                continue
            before = self.happened
            self._declare(kind, declarator, node, frame)
            value = frame.values.get(name)
            if is_static and isinstance(value, Const):
                frame.values[name] = Open(name)  # it has the value of the last run
            elif is_static and is_kept(value) and self.happened == before:
                self.statics[key] = frame.values[name]

    def _calls_item(self, kind: Node, declarator: Node, frame: Frame) -> bool:
        """Call an item of a list: the grammar takes ``steps[number](value);`` for a declaration."""
        brackets = declarator.child_by_field_name("declarator")
        if kind.type != "type_identifier" or brackets is None:
            return False
        if brackets.type != "structured_binding_declarator" or declarator.type != "function_declarator":
            return False
        steps = self.lookup(text_of(kind), frame)
        steps = steps if steps is not None else self._identifier(kind, frame)
        called = self.item(steps, [self.value(each, frame) for each in named(brackets)], brackets, frame)
        given = named(declarator.child_by_field_name("parameters"))
        self.invoke(called, [self._as_argument(each, frame) for each in given], declarator, frame)
        return True

    def _declare(self, kind: Node | None, declarator: Node, node: Node, frame: Frame) -> None:
        name = name_of(declarator)
        inner = declarator.child_by_field_name("value") if declarator.type == "init_declarator" else None
        if inner is None and declarator.type != "init_declarator":
            inner = node.child_by_field_name("value")  # of ``if (auto helper = helper_)``
        function = function_of(declarator)
        is_auto = kind is not None and kind.type == "placeholder_type_specifier"
        if inner is not None and inner.type == "initializer_list" and is_array(declarator):
            value = self.aggregates(self.value(inner, frame), kind, node, frame)
        elif inner is not None and inner.type in ("initializer_list", "argument_list") and not is_auto:
            value = self.declared(kind, self.values(inner, frame), declarator, frame)
        elif inner is not None:
            value = coerced(text_of(kind), self.value(inner, frame))
        elif function is not None:  # an apparent function is a variable with arguments
            name = path_of(function.child_by_field_name("declarator"))
            parameters = named(function.child_by_field_name("parameters"))
            args = [self._as_argument(each, frame) for each in parameters]
            value = self.declared(kind, args, declarator, frame)
        else:
            value = self.declared(kind, [], declarator, frame)
            if isinstance(value, Obj) and value.node is None:
                value.is_held = True
        target = declarator.child_by_field_name("declarator")
        if target is not None and target.type == "reference_declarator":
            target = named(target)[-1]
        if target is not None and target.type == "structured_binding_declarator":
            parts = members_of(value)
            for number, each in enumerate(named(target)):
                known = number < len(parts)
                frame.values[text_of(each)] = parts[number] if known else Open(text_of(each))
            return
        frame.values[name] = value
        is_made_here = isinstance(value, Obj) and _is_made_here(kind, declarator, inner)
        if is_made_here or self._is_owned(kind, value, declarator, inner, frame):
            self.scoped.append(value)

    def _is_new(self, node: Node | None, value: Obj, frame: Frame) -> bool:
        """Return whether an expression is a call of the constructor of an object's class."""
        if node is None or node.type not in ("call_expression", "compound_literal_expression"):
            return False
        name = node.child_by_field_name("function") or node.child_by_field_name("type")
        if name is None or name.type not in ("identifier", "qualified_identifier", "template_function"):
            is_type = name is not None and name.type in ("type_identifier", "template_type")
            if not is_type:
                return False
        return value.cls is not None and self.class_of(self.type_text(name, frame), frame) is value.cls

    def _is_owned(
        self, kind: Node | None, value: Value, declarator: Node, made: Node | None, frame: Frame
    ) -> bool:
        """Return whether a variable is the only owner of an object, which ends with the block then.

        It is a new object of ``auto``, a ``unique_ptr``, or runs a function at the end of its block.
        """
        if kind is None or made is None or not isinstance(value, (Obj, Lambda, Made)):
            return False
        if not is_lost(declarator):
            return False
        is_auto = kind.type == "placeholder_type_specifier"
        if isinstance(value, Obj):
            is_unique = path_of(kind).endswith("unique_ptr") or text_of(made).startswith("std::make_unique")
            return is_unique or (is_auto and self._is_new(made, value, frame))
        if isinstance(value, Made):
            return value.path == AT_END
        return path_of(kind).endswith(("unique_ptr", "shared_ptr")) and len(named(made)) == 2

    def _as_argument(self, parameter: Node, frame: Frame) -> Value:
        """Return the value of what looks like a parameter: a name, or a call without arguments."""
        value = self.value(parameter.child_by_field_name("type") or parameter, frame)
        declarator = parameter.child_by_field_name("declarator")
        given = _SAME.fullmatch(text_of(parameter))
        if given is not None:  # ``std::thread t(std::move(task))``
            found = self.lookup(given[1], frame)
            return found if found is not None else value
        if (
            isinstance(value, Method)
            and declarator is not None
            and declarator.type == "abstract_function_declarator"
        ):
            return self.invoke(value, [], parameter, frame)
        return value

    def declared(self, kind: Node | None, args: list[Value], node: Node, frame: Frame) -> Value:
        """Return the value of a declaration with arguments."""
        text = text_of(kind)
        if kind is not None and kind.type == "decltype" and not args:
            like = self.value(next(iter(named(kind)), None), frame)
            return replace(like, values=[], keys={}) if isinstance(like, Items) else NO_VALUE
        if (
            kind is None
            or kind.type in ("primitive_type", "sized_type_specifier")
            or (text.startswith(("std::string", "string")) and "stream" not in text)
        ):
            return coerced(text, args[0]) if args else NO_VALUE
        if args and (path_of(kind).endswith(_POINTERS) or self.type_text(kind, frame).endswith(_POINTERS)):
            if len(args) == 2 and isinstance(args[1], Lambda) and not isinstance(args[0], (Obj, Port)):
                return args[1]  # it runs when the pointer ends
            return args[0]  # also under another name: ``using Client = rclcpp::Client<Ask>::SharedPtr``
        is_declared = node.type.endswith("declarator")
        if text_of(node).startswith("*") if is_declared else "*" in _TEMPLATE.sub("", text):
            return args[0] if args else Const(None)
        return self.make(kind, args, node, frame)


def _is_made_here(kind: Node | None, declarator: Node, value: Node | None) -> bool:
    """Return whether a variable is an object that ends with its block: no pointer, and no reference."""
    text = "" if value is None else text_of(value)
    if kind is None or kind.type == "placeholder_type_specifier":
        return False
    target = (
        declarator.child_by_field_name("declarator") if declarator.type == "init_declarator" else declarator
    )
    is_plain = target is not None and target.type not in ("reference_declarator", "pointer_declarator")
    is_pointer = path_of(kind).endswith(("Ptr", "_ptr"))
    return is_plain and not is_pointer and not text.startswith(("*", "&"))
