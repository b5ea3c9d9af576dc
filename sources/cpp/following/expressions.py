"""Evaluates expressions in C++; calls are in `calls`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.sources.cpp.declarators import is_array
from dineros.sources.cpp.durations import UNITS
from dineros.sources.cpp.following.machine import MOST_CALLS, coerced
from dineros.sources.cpp.following.operators import Operators
from dineros.sources.cpp.following.statics import global_lock
from dineros.sources.cpp.operations import binary, number, text_literal
from dineros.sources.cpp.parsing import arguments_of, path_of, text_of
from dineros.sources.cpp.quality import RMW_PROFILE, of_rmw
from dineros.sources.cpp.values import (
    NO_VALUE,
    PAIRS,
    Const,
    Either,
    Frame,
    Items,
    Lambda,
    Made,
    Method,
    Obj,
    Open,
    Port,
    Seconds,
    Value,
    one_of,
    options,
    shown,
    value_of,
)

if TYPE_CHECKING:
    from tree_sitter import Node

    from dineros.sources.cpp.entries import ClassInfo


_PLAIN = ("bool", "char", "int", "long", "float", "double", "unsigned")
"""Types without a namespace."""
_ARGUMENTS = {"argument_list", "initializer_list", "field_initializer_list"}


def named(node: Node | None) -> list[Node]:
    """Return the parts of a node except comments; of a condition among arguments, its first branch."""
    found: list[Node] = []
    for each in node.named_children if node is not None else ():
        if each.type.startswith("preproc_if") and node is not None and node.type in _ARGUMENTS:
            name = each.child_by_field_name("name") or each.child_by_field_name("condition")
            found += [
                inner
                for inner in each.named_children
                if inner != name and inner.type not in ("comment", "preproc_else", "preproc_elif")
            ]
        elif each.type != "comment":
            found.append(each)
    return found


class Expressions(Operators):
    """Evaluates expressions."""

    def run_block(self, node: Node | None, frame: Frame) -> None:
        """Run statements."""
        raise NotImplementedError

    def value(self, node: Node | None, frame: Frame) -> Value:
        """Return the value of an expression."""
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
        """Return the values of arguments."""
        found: list[Value] = []
        for each in named(node):
            value = self.value(each, frame)
            is_pack = each.type == "parameter_pack_expansion" and isinstance(value, Items)
            found += value.values if is_pack else [value]  # type: ignore[attr-defined]
        return found

    def _parameter_pack_expansion(self, node: Node, frame: Frame) -> Value:
        return self.value(node.child_by_field_name("pattern"), frame)

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
        if path == "std::is_same_v":
            return self._are_same(node, frame)
        if frame.this is not None and path.count("::") == 1:
            found = frame.this.fields.get(path.rpartition("::")[2])
            kinds = self.bases(frame.this.cls) if frame.this.cls is not None else []
            if found is not None and path.partition("::")[0] in [each.name for each in kinds]:
                return found
        scope, _, last = path.rpartition("::")
        around: Frame | None = frame
        while around is not None:  # a parameter of a template, or an alias
            kind = around.types.get(scope) or (
                around.this.types.get(scope) if around.this is not None else None
            )
            if kind:
                return self._outer(f"{kind}::{last}", frame)
            around = around.outer
        return self._outer(path, frame)

    def _outer(self, path: str, frame: Frame) -> Value:
        given = self._template_value(path, frame)
        if given is not None:
            return given
        shared = global_lock(path, frame, self)
        if shared is not None:
            return shared
        space = frame.cls.full if frame.cls else frame.space
        constant = self.index.find_constant(path, frame.path, space)
        if constant is not None and len(self.calls) < MOST_CALLS:
            self.calls.append((0, 0))
            try:
                if constant.node.type == "preproc_arg":
                    text = text_of(constant.node).strip()
                    return Const(text[1:-1]) if text[:1] == text[-1:] == '"' else number(text)
                inside = Frame(constant.path, constant.full.rpartition("::")[0])
                found = self.braced(constant.node, inside) or self.value(constant.node, inside)
                found = self._table(constant.node, found, inside)
                is_profile = isinstance(found, Items) and _declared_type(constant.node).endswith(RMW_PROFILE)
                return Made(RMW_PROFILE, fields=of_rmw(found.values)) if is_profile else found  # type: ignore[attr-defined]
            finally:
                self.calls.pop()
        if frame.cls is not None and "::" not in path:
            routines = self.methods(frame.cls, path)
            if routines:
                return Method(routines, path, frame.this)
        functions = self.index.find_functions(path, frame.path)
        if functions and all(each.path == functions[0].path for each in functions):
            return Method(functions, path)
        owner = self.class_of(path.rpartition("::")[0], frame) if "::" in path else None
        if owner is not None and (routines := self.methods(owner, path.rpartition("::")[2])):
            return Method(routines, path.rpartition("::")[2])
        is_preset = path.startswith("rmw_qos_profile_")
        return Made(path) if "::" in path or is_preset else Open(path)

    def _table(self, node: Node, value: Value, frame: Frame) -> Value:
        """Return the value of a constant; the items of a list in braces are objects of their class."""
        declaration = node
        while declaration.parent is not None and declaration.parent.type.endswith("declarator"):
            declaration = declaration.parent
        declarator = declaration.child_by_field_name("declarator") if declaration is not node else None
        holder = declaration.parent
        declarator = declarator or (None if holder is None else holder.child_by_field_name("declarator"))
        kind = None if holder is None else holder.child_by_field_name("type")
        if not isinstance(value, Items) or kind is None or declarator is None or value.is_map:
            return value
        if is_array(declarator):
            return self.aggregates(value, kind, node, frame)
        return self.declared(kind, [value], node, frame) if arguments_of(kind) else value

    def _are_same(self, node: Node, frame: Frame) -> Value:
        """Return whether two types are one, if both are known."""
        given = [self.template_text(each, frame) for each in arguments_of(node)]
        are_known = all(
            "::" in each or each in _PLAIN or self.class_of(each, frame) is not None for each in given
        )
        return Const(given[0] == given[1]) if are_known and len(given) == 2 else Open(text_of(node)[:60])

    def _template_value(self, name: str, frame: Frame) -> Value | None:
        """Return the value of a parameter of a template that is a number or a method; None: no such one."""
        around: Frame | None = frame
        text = None
        while around is not None and text is None:
            own = around.this.types if around.this is not None else {}
            text = around.types.get(name) or own.get(name)
            around = around.outer
        if text is None:
            return None
        if text in ("true", "false"):
            return Const(text == "true")
        if text[:1].isdigit():
            return number(text)
        scope, _, last = text.lstrip("&").rpartition("::")
        cls = self.class_of(scope, frame) if scope and text.startswith("&") else None
        routines = self.methods(cls, last) if cls is not None else []
        return Method(routines, last) if routines else None

    def _field_expression(self, node: Node, frame: Frame) -> Value:
        on = self.held_by(node, self.value(node.child_by_field_name("argument"), frame))
        name = path_of(node.child_by_field_name("field")).rpartition("::")[2]
        found: list[Value] = []
        for each in options(on):
            if isinstance(each, (Obj, Made)) and name in each.fields:
                found.append(each.fields[name])
            elif name in ("first", "second"):
                found.append(_of_pair(each, name) or Open(text_of(node)[:60]))
            else:
                found.append(Open(text_of(node)[:60]))
        return one_of(found)

    def construct(self, cls: ClassInfo, args: list[Value], types: list[str], node: Node, frame: Frame) -> Obj:
        """Return a new object of a class of the folder."""
        raise NotImplementedError

    def _subscript_expression(self, node: Node, frame: Frame) -> Value:
        on = self.value(node.child_by_field_name("argument"), frame)
        return self.item(on, self.values(node.child_by_field_name("indices"), frame), node, frame)

    def item(self, on: Value, indices: list[Value], node: Node, frame: Frame) -> Value:
        """Return the item of a list or map."""
        index = indices[0] if indices else None
        of_class = self.operated(on, "[]", indices, node)
        if of_class is not None:
            return of_class
        if isinstance(on, Items):
            if on.is_map and on.kind is not None and not on.values:  # the map makes the item
                on.values.append(self.construct(on.kind, [], [], node, frame))
            if (
                isinstance(index, Const)
                and not on.is_map
                and isinstance(index.value, int)
                and 0 <= index.value < len(on.values)
            ):
                return on.values[index.value]
            others = (Open(text_of(node)[:60]),) if on.is_open or not on.values else ()
            held = [value_of(each) for each in on.values] if on.is_map else on.values
            found = tuple(each for each in held if each not in others) + others
            return found[0] if len(found) == 1 else Either(found)
        return Open(text_of(node)[:60])

    # ------------------------------------------------------------------------------------------- operators

    def _comma_expression(self, node: Node, frame: Frame) -> Value:
        found = self.values(node, frame)
        return found[-1] if found else Open(",")

    def _parenthesized_expression(self, node: Node, frame: Frame) -> Value:
        found = self.values(node, frame)
        return found[-1] if found else Open("()")

    def _pointer_expression(self, node: Node, frame: Frame) -> Value:
        inner = node.child_by_field_name("argument")
        if text_of(node).startswith("&") and inner is not None and inner.type == "qualified_identifier":
            path = path_of(inner)
            scope, _, name = path.rpartition("::")
            cls = self.class_of(scope, frame) if "::" in scope else None
            cls = cls or self.class_of(self.type_text(inner.child_by_field_name("scope"), frame), frame)
            cls = cls or self.class_of(scope, frame) or (frame.cls if scope in frame.types else None)
            ours = frame.this.cls if frame.this is not None else None
            if cls is not None and ours is not None and cls in self.bases(ours):
                cls = ours  # which may override it
            routines = self.methods(cls, name) if cls is not None else []
            return Method(routines, name) if routines else self.value(inner, frame)
        value = self.value(inner, frame)
        return (self.operated(value, "*", [], node) if text_of(node).startswith("*") else None) or value

    def _unary_expression(self, node: Node, frame: Frame) -> Value:
        value = self.value(node.child_by_field_name("argument"), frame)
        sign = text_of(node.child_by_field_name("operator"))
        of_class = self.operated(value, sign, [], node)
        if of_class is not None:
            return of_class
        value = self.tested(value, node) if sign == "!" else value
        if isinstance(value, Const):
            if sign == "!":
                return Const(not value.value) if not isinstance(value.value, str) else Open("!")
            if sign == "-" and isinstance(value.value, (int, float)):
                return Const(-value.value)
        if isinstance(value, Seconds) and sign == "-":
            return Seconds(-value.value)
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
        right = self.value(node.child_by_field_name("right"), frame)
        of_class = self.operated(left, sign, [right], node)
        if of_class is not None:
            return of_class
        if sign == ">>" and right is NO_VALUE:  # a stream gives the variable a value
            self.assign(node.child_by_field_name("right"), Open(text_of(node)[:60]), frame)
        if sign == "<<" and isinstance(left, Made) and left.path.endswith("stringstream"):
            before = left.fields.get("text", left.args[0] if left.args else Const(""))
            added = Const(shown(right)) if isinstance(right, Const) else right
            self.set_member(left, "text", binary("+", before, added))
            return left
        return binary(sign, left, right)

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

    def assign(self, left: Node | None, value: Value, frame: Frame) -> None:
        """Assign a value to the left side of ``=``."""
        raise NotImplementedError

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


def _declared_type(value: Node) -> str:
    """Return the type of the declaration of a constant with a value."""
    declarator = value.parent
    declaration = declarator.parent if declarator is not None else None
    return "" if declaration is None else path_of(declaration.child_by_field_name("type"))


def _of_pair(value: Value, name: str) -> Value | None:
    """Return a part of a pair; a map of this reader holds pairs, or its values only. None: not known."""
    parts = value.values if isinstance(value, Items) else value.args if isinstance(value, Made) else []
    is_pair = isinstance(value, Items) or (isinstance(value, Made) and value.path.endswith(PAIRS))
    if is_pair and len(parts) == 2:
        return parts[0 if name == "first" else 1]
    return value if name == "second" and isinstance(value, (Obj, Port)) else None
