"""Expressions in C++, and calls of routines of the folder."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

from dineros.sources.cpp.index import ClassInfo, Routine, function_of, parameters_of
from dineros.sources.cpp.machine import MOST_CALLS, UNITS, Machine, coerced
from dineros.sources.cpp.operations import binary, number, text_literal
from dineros.sources.cpp.parsing import arguments_of, path_of, text_of
from dineros.sources.cpp.values import (
    Const,
    Either,
    Frame,
    Items,
    Lambda,
    Made,
    Method,
    Obj,
    Open,
    Seconds,
    Value,
    options,
)

if TYPE_CHECKING:
    from tree_sitter import Node


class Call:
    """A call as it stands in the code: what is called, on what, with what."""

    def __init__(
        self,
        node: Node,
        frame: Frame,
        path: str,
        args: list[Value],
        on: Value | None = None,
        name: Node | None = None,
    ) -> None:
        self.node, self.frame, self.path, self.args, self.on, self.named = node, frame, path, args, on, name
        self.last = path.rpartition("::")[2]
        inner = node.child_by_field_name("arguments") or node.child_by_field_name("value")
        self.nodes = named(inner)


class Library(Protocol):
    """What libraries do."""

    def call(self, call: Call) -> Value | None:
        """Return what a call of a library returns; None: it is none that is known."""

    def make_node(self, this: Obj, kind: str, args: list[Value], node: Node, frame: Frame) -> None:
        """Make an object a node."""


def named(node: Node | None) -> list[Node]:
    """Return the parts of a node that are no comments."""
    return [] if node is None else [each for each in node.named_children if each.type != "comment"]


class Expressions(Machine):
    """Evaluates expressions."""

    library: Library

    def run_block(self, node: Node | None, frame: Frame) -> None:
        """Run statements."""
        raise NotImplementedError

    def value(self, node: Node | None, frame: Frame) -> Value:
        """Return what an expression is."""
        self.count()
        if node is None:
            return Open("nothing")
        found = getattr(self, f"_{node.type}", None)
        if found is not None:
            result = found(node, frame)
            assert isinstance(result, Value)
            return result
        for child in named(node):
            if child.type not in ("type_descriptor", "template_argument_list"):
                self.value(child, frame)
        return Open(text_of(node)[:60])

    def values(self, node: Node | None, frame: Frame) -> list[Value]:
        """Return what arguments are."""
        return [self.value(each, frame) for each in named(node)]

    # -------------------------------------------------------------------------------------------- literals

    def _number_literal(self, node: Node, frame: Frame) -> Value:
        return number(text_of(node))

    def _string_literal(self, node: Node, frame: Frame) -> Value:
        return Const(text_literal(node))

    _raw_string_literal = _string_literal

    def _concatenated_string(self, node: Node, frame: Frame) -> Value:
        found: Value = Const("")
        for each in named(node):
            found = binary("+", found, self.value(each, frame))
        return found

    def _user_defined_literal(self, node: Node, frame: Frame) -> Value:
        inner, suffix = node.named_children[0], text_of(node.named_children[-1])
        value = self.value(inner, frame)
        if suffix in UNITS and isinstance(value, Const) and isinstance(value.value, (int, float)):
            return Seconds(value.value * UNITS[suffix])
        return value if isinstance(value, Const) and isinstance(value.value, str) else Open(text_of(node))

    def _true(self, node: Node, frame: Frame) -> Value:
        return Const(True)

    def _false(self, node: Node, frame: Frame) -> Value:
        return Const(False)

    def _null(self, node: Node, frame: Frame) -> Value:
        return Const(None)

    _nullptr = _null

    def _this(self, node: Node, frame: Frame) -> Value:
        return frame.this if frame.this is not None else Open("this")

    # ------------------------------------------------------------------------------------------------ names

    def _identifier(self, node: Node, frame: Frame) -> Value:
        name = text_of(node)
        found = self.lookup(name, frame)
        if found is not None:
            return found
        return self._outer(name, frame)

    _field_identifier = _type_identifier = _identifier

    def _qualified_identifier(self, node: Node, frame: Frame) -> Value:
        path = path_of(node)
        if frame.this is not None and path.count("::") == 1:
            found = frame.this.fields.get(path.rpartition("::")[2])
            if found is not None:
                return found
        return self._outer(path, frame)

    def _outer(self, path: str, frame: Frame) -> Value:
        space = frame.cls.full if frame.cls else frame.space
        constant = self.index.find_constant(path, frame.path, space)
        if constant is not None and len(self.calls) < MOST_CALLS:
            self.calls.append((0, 0))
            try:
                if constant.node.type == "preproc_arg":
                    text = text_of(constant.node).strip()
                    return Const(text[1:-1]) if text[:1] == text[-1:] == '"' else number(text)
                return self.value(constant.node, Frame(constant.path, constant.full.rpartition("::")[0]))
            finally:
                self.calls.pop()
        if frame.cls is not None and "::" not in path:
            routines = self.methods(frame.cls, path)
            if routines:
                return Method(routines, path, frame.this)
        functions = self.index.find_functions(path, frame.path)
        if functions and all(each.path == functions[0].path for each in functions):
            return Method(functions, path)
        return Made(path) if "::" in path else Open(path)

    def methods(self, cls: ClassInfo, name: str) -> list[Routine]:
        """Return the methods of a name that a class has or inherits."""
        for each in self.bases(cls):
            if name in each.methods:
                return each.methods[name]
        return []

    def _field_expression(self, node: Node, frame: Frame) -> Value:
        on = self.value(node.child_by_field_name("argument"), frame)
        name = path_of(node.child_by_field_name("field")).rpartition("::")[2]
        found: list[Value] = []
        for each in options(on):
            if isinstance(each, (Obj, Made)) and name in each.fields:
                found.append(each.fields[name])
            else:
                found.append(Open(text_of(node)[:60]))
        return found[0] if len(found) == 1 else Either(tuple(found))

    def _subscript_expression(self, node: Node, frame: Frame) -> Value:
        on = self.value(node.child_by_field_name("argument"), frame)
        indices = self.values(node.child_by_field_name("indices"), frame)
        index = indices[0] if indices else None
        if isinstance(on, Items):
            if (
                isinstance(index, Const)
                and isinstance(index.value, int)
                and 0 <= index.value < len(on.values)
            ):
                return on.values[index.value]
            return Either(tuple(on.values)) if on.values and not on.is_open else Open(text_of(node)[:60])
        return Open(text_of(node)[:60])

    # ------------------------------------------------------------------------------------------- operators

    def _parenthesized_expression(self, node: Node, frame: Frame) -> Value:
        found = self.values(node, frame)
        return found[-1] if found else Open("()")

    def _pointer_expression(self, node: Node, frame: Frame) -> Value:
        inner = node.child_by_field_name("argument")
        if text_of(node).startswith("&") and inner is not None and inner.type == "qualified_identifier":
            path = path_of(inner)
            scope, _, name = path.rpartition("::")
            cls = self.class_of(self.type_text(inner.child_by_field_name("scope"), frame), frame)
            cls = cls or self.class_of(scope, frame) or (frame.cls if scope in frame.types else None)
            routines = self.methods(cls, name) if cls is not None else []
            return Method(routines, name) if routines else self.value(inner, frame)
        return self.value(inner, frame)

    def _unary_expression(self, node: Node, frame: Frame) -> Value:
        value = self.value(node.child_by_field_name("argument"), frame)
        sign = text_of(node.child_by_field_name("operator"))
        if isinstance(value, Const):
            if sign == "!":
                return Const(not value.value) if not isinstance(value.value, str) else Open("!")
            if sign == "-" and isinstance(value.value, (int, float)):
                return Const(-value.value)
        return Open(text_of(node)[:60])

    def _binary_expression(self, node: Node, frame: Frame) -> Value:
        sign = text_of(node.child_by_field_name("operator"))
        left = self.value(node.child_by_field_name("left"), frame)
        if sign in ("&&", "||"):
            if isinstance(left, Const) and bool(left.value) == (sign == "||"):
                return Const(bool(left.value))
            with self.perhaps():
                right = self.value(node.child_by_field_name("right"), frame)
            return (
                Const(bool(right.value))
                if isinstance(left, Const) and isinstance(right, Const)
                else Open(sign)
            )
        return binary(sign, left, self.value(node.child_by_field_name("right"), frame))

    def _conditional_expression(self, node: Node, frame: Frame) -> Value:
        asked = self.value(node.child_by_field_name("condition"), frame)
        with self.perhaps():
            yes = self.value(node.child_by_field_name("consequence"), frame)
            no = self.value(node.child_by_field_name("alternative"), frame)
        if isinstance(asked, Const):
            return yes if asked.value else no
        return yes if yes == no else Either((*options(yes), *options(no)))

    def _cast_expression(self, node: Node, frame: Frame) -> Value:
        value = self.value(node.child_by_field_name("value"), frame)
        return coerced(self.type_text(node.child_by_field_name("type"), frame), value)

    def _update_expression(self, node: Node, frame: Frame) -> Value:
        inner = node.child_by_field_name("argument")
        self.assign(inner, Open(text_of(node)), frame)
        return Open(text_of(node)[:60])

    def _assignment_expression(self, node: Node, frame: Frame) -> Value:
        left = node.child_by_field_name("left")
        value = self.value(node.child_by_field_name("right"), frame)
        sign = text_of(node.child_by_field_name("operator"))
        if sign != "=":
            value = (
                binary(sign[:-1], self.value(left, frame), value)
                if not self.loops
                else Open(text_of(node)[:60])
            )
        self.assign(left, value, frame)
        return value

    def assign(self, left: Node | None, value: Value, frame: Frame) -> None:
        """Give what stands left of ``=`` a value."""
        if left is None:
            return
        if left.type == "identifier":
            self.store(text_of(left), value, frame)
        elif left.type == "field_expression":
            name = path_of(left.child_by_field_name("field"))
            for each in options(self.value(left.child_by_field_name("argument"), frame)):
                if isinstance(each, Obj):
                    self.store_field(each, name, value)
                elif isinstance(each, Made):
                    each.fields[name] = self.mixed(each.fields.get(name), value)
        elif left.type == "subscript_expression":
            on = self.value(left.child_by_field_name("argument"), frame)
            if isinstance(on, Items):
                on.values.append(value)
                on.is_open = on.is_open or isinstance(value, Open)
        elif left.type in ("pointer_expression", "parenthesized_expression"):
            self.assign(left.child_by_field_name("argument") or next(iter(named(left)), None), value, frame)

    def _initializer_list(self, node: Node, frame: Frame) -> Value:
        return Items(self.values(node, frame))

    def _initializer_pair(self, node: Node, frame: Frame) -> Value:
        name = text_of(node.child_by_field_name("designator")).lstrip(".")
        return Made(f".{name}", [self.value(node.child_by_field_name("value"), frame)])

    def _lambda_expression(self, node: Node, frame: Frame) -> Value:
        captures = node.child_by_field_name("captures")
        inner = Frame(frame.path, frame.space, frame.this, frame.cls, outer=frame)
        for each in named(captures):
            if each.type == "lambda_capture_initializer":
                inner.values[text_of(each.child_by_field_name("left"))] = self.value(
                    each.child_by_field_name("right"), frame
                )
        return Lambda(node, inner)

    # ------------------------------------------------------------------------------------------------ calls

    def _new_expression(self, node: Node, frame: Frame) -> Value:
        args = self.values(node.child_by_field_name("arguments"), frame)
        return self.make(node.child_by_field_name("type"), args, node, frame)

    def _compound_literal_expression(self, node: Node, frame: Frame) -> Value:
        args = self.values(node.child_by_field_name("value"), frame)
        return self.make(node.child_by_field_name("type"), args, node, frame)

    def make(self, kind: Node | None, args: list[Value], node: Node, frame: Frame) -> Value:
        """Return an object of a type."""
        name = self.type_text(kind, frame)
        cls = self.class_of(name, frame)
        if cls is not None:
            types = [self.template_text(each, frame) for each in arguments_of(kind)]
            return self.construct(cls, args, types, node, frame)
        found = self.library.call(Call(node, frame, name, args, name=kind))
        return found if found is not None else Made(name, args, node=node)

    def _call_expression(self, node: Node, frame: Frame) -> Value:
        function = node.child_by_field_name("function")
        inner = node.child_by_field_name("arguments")
        assert function is not None
        if function.type == "field_expression":
            on = self.value(function.child_by_field_name("argument"), frame)
            field = function.child_by_field_name("field")
            args = self.values(inner, frame)
            found = [self._on(Call(node, frame, path_of(field), args, each, field)) for each in options(on)]
            return found[0] if len(found) == 1 else Either(tuple(found))
        args = self.values(inner, frame)
        if function.type in ("identifier", "template_function", "qualified_identifier"):
            return self._plain(Call(node, frame, path_of(function), args, name=function))
        called = self.value(function, frame)
        return self.invoke(called, args, node, frame)

    def _on(self, call: Call) -> Value:
        """Call a method of an object."""
        on = call.on
        if isinstance(on, Obj):
            routines = self.methods(on.cls, call.last) if on.cls is not None else []
            if routines:
                return self.run(routines, call.args, on, call.node, self._types(call))
            if isinstance(on.fields.get(call.last), (Lambda, Method)):
                return self.invoke(on.fields[call.last], call.args, call.node, call.frame)
        found = self.library.call(call)
        return found if found is not None else Open(text_of(call.node)[:60])

    def _plain(self, call: Call) -> Value:
        """Call a function, a method of this object, a lambda or a constructor."""
        frame, path = call.frame, call.path
        variable = self.lookup(path, frame) if "::" not in path else None
        if variable is not None:
            return self.invoke(variable, call.args, call.node, frame)
        if frame.this is not None and frame.cls is not None:
            scope = path.rpartition("::")[0]
            owner = (
                self.class_of(self.type_text(call.named.child_by_field_name("scope"), frame), frame)
                if (scope and call.named is not None)
                else frame.this.cls or frame.cls
            )
            if owner is not None and (not scope or owner in self.bases(frame.this.cls or frame.cls)):
                routines = self.methods(owner, call.last)
                if routines and call.last != owner.name:
                    return self.run(routines, call.args, frame.this, call.node, self._types(call))
        if call.named is not None and call.named.type != "identifier":
            call.path = self._resolved(call.named, frame)
        found = self.library.call(call)
        if found is not None:
            return found
        scope = call.path.rpartition("::")[0]
        cls = self.class_of(self.type_text(call.named, frame), frame) or None
        if cls is not None:
            types = [self.template_text(each, frame) for each in arguments_of(call.named)]
            return self.construct(cls, call.args, types, call.node, frame)
        owner = self.class_of(scope, frame) if scope else None
        if owner is not None and self.methods(owner, call.last):
            return self.run(self.methods(owner, call.last), call.args, None, call.node, self._types(call))
        functions = self.index.find_functions(path, frame.path)
        if functions and len({each.path for each in functions}) == 1:
            return self.run(functions, call.args, None, call.node, self._types(call))
        self.escapes(call.args)
        return Made(call.path, call.args, node=call.node)

    def _resolved(self, node: Node, frame: Frame) -> str:
        if node.type == "qualified_identifier":
            scope = node.child_by_field_name("scope")
            rest = path_of(node).removeprefix(path_of(scope)).removeprefix("::")
            return f"{self.type_text(scope, frame)}::{rest}" if scope is not None else rest
        return path_of(node)

    def _types(self, call: Call) -> list[str]:
        return [self.template_text(each, call.frame) for each in arguments_of(call.named)]

    def escapes(self, args: Sequence[Value]) -> None:
        """Note that code that cannot be followed gets a node: it may do anything with its ports."""
        if any(isinstance(each, Obj) and each.node is not None for each in args):
            self.fact.is_open = True

    def invoke(self, called: Value, args: list[Value], node: Node, frame: Frame) -> Value:
        """Call what a value is."""
        found: list[Value] = []
        for each in options(called):
            if isinstance(each, Lambda):
                found.append(self._run_lambda(each, args, node))
            elif isinstance(each, Method):
                found.append(self.run(each.routines, [*each.args, *args], each.this, node, []))
            else:
                found.append(Open(text_of(node)[:60]))
        return found[0] if len(found) == 1 else Either(tuple(found))

    def _run_lambda(self, each: Lambda, args: list[Value], node: Node) -> Value:
        declarator = each.node.child_by_field_name("declarator")
        parameters = parameters_of(function_of(declarator) or declarator) if declarator is not None else []
        frame = Frame(each.frame.path, each.frame.space, each.frame.this, each.frame.cls, outer=each.frame)
        frame.values = {p.name: args[n] if n < len(args) else Open(p.name) for n, p in enumerate(parameters)}
        return self._body(each.node.child_by_field_name("body"), frame, each.node)

    def _body(self, body: Node | None, frame: Frame, called: Node) -> Value:
        key = (called.id, id(frame.this))
        if len(self.calls) >= MOST_CALLS or self.calls.count(key) > 0:
            return Open("a call within itself")
        self.calls.append(key)
        self.frames.append(frame)
        held, frame.level = len(self.holding), self.cond + self.loops
        try:
            self.run_block(body, frame)
        finally:
            self.calls.pop()
            self.frames.pop()
            del self.holding[held:]
        return frame.result or Open("a result")

    def run(
        self, routines: list[Routine], args: list[Value], this: Obj | None, node: Node, types: list[str]
    ) -> Value:
        """Call a routine; the one of several that takes so many arguments."""
        found = [each for each in routines if each.body is not None]
        if not found:
            return Open(text_of(node)[:60])
        fitting = [each for each in found if len(each.parameters) == len(args)]
        fitting = fitting or [each for each in found if len(each.parameters) > len(args)] or found
        results = []
        for each in fitting[:4]:
            if len(fitting) > 1:
                with self.perhaps():
                    results.append(self._body(each.body, self.frame_of(each, args, this, types), each.node))
            else:
                results.append(self._body(each.body, self.frame_of(each, args, this, types), each.node))
        return results[0] if len(results) == 1 else Either(tuple(results))

    def frame_of(self, routine: Routine, args: list[Value], this: Obj | None, types: list[str]) -> Frame:
        """Return the variables with which a routine begins."""
        space = routine.cls.full if routine.cls is not None else routine.space
        frame = Frame(routine.path, space, this, routine.cls)
        frame.types = dict(zip(routine.templates, types, strict=False))
        declared = routine.cls.defaults.get(routine.name, []) if routine.cls is not None else []
        same = next((each for each in declared if len(each) == len(routine.parameters)), [])
        for number_, each in enumerate(routine.parameters):
            if number_ < len(args):
                value = coerced(text_of(each.type), args[number_])
            else:
                default = each.default or (same[number_].default if number_ < len(same) else None)
                value = self.value(default, frame) if default is not None else Open(each.name)
            if each.name:
                frame.values[each.name] = value
            if each.type is not None and number_ < len(args):
                text = path_of(each.type)
                if text in routine.templates and isinstance(args[number_], Obj):
                    cls = args[number_].cls  # type: ignore[attr-defined]
                    if cls is not None:
                        frame.types.setdefault(text, cls.full)
        return frame

    def construct(self, cls: ClassInfo, args: list[Value], types: list[str], node: Node, frame: Frame) -> Obj:
        """Return a new object of a class of the folder."""
        raise NotImplementedError
