"""Interprets statements in C++, and the construction of objects."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from dineros.sources.branches import Leave
from dineros.sources.cpp.declarators import Parameter, function_of, is_lost, name_of, used
from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.choices import Choices
from dineros.sources.cpp.following.expressions import named
from dineros.sources.cpp.following.machine import MOST_CALLS, coerced, is_node
from dineros.sources.cpp.following.operators import AT_END, CALLED
from dineros.sources.cpp.following.statics import is_kept
from dineros.sources.cpp.index import ClassInfo
from dineros.sources.cpp.parsing import arguments_of, path_of, text_of
from dineros.sources.cpp.values import (
    NO_VALUE,
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
    Value,
    joined,
    members_of,
    options,
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
_MOST_DELEGATIONS = 8
"""Limit of the constructors of a class that call each other."""
_POINTERS = ("Ptr", "shared_ptr", "unique_ptr")
"""Ends of types of pointers."""
_OWN = ("Broadcaster", "Listener", "Updater", "ImageTransport")
"""Parts of names of classes of libraries that wrap a given node and are not equal to it."""


class Statements(Choices):
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

    def _declare(self, kind: Node | None, declarator: Node, node: Node, frame: Frame) -> None:
        name = name_of(declarator)
        inner = declarator.child_by_field_name("value") if declarator.type == "init_declarator" else None
        if inner is None and declarator.type != "init_declarator":
            inner = node.child_by_field_name("value")  # of ``if (auto helper = helper_)``
        function = function_of(declarator)
        is_auto = kind is not None and kind.type == "placeholder_type_specifier"
        if inner is not None and inner.type == "initializer_list" and _is_array(declarator):
            value = self._aggregates(self.value(inner, frame), kind, node, frame)
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

    # ---------------------------------------------------------------------------------------------- objects

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
        routine = max(fitting, key=lambda each: self._match(each.parameters, args, cls), default=None)
        if routine is None:
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

    def _match(self, parameters: list[Parameter], args: list[Value], cls: ClassInfo) -> int:
        """Return how many arguments are objects of exactly the type of their parameter."""
        frame = Frame(cls.path, cls.full)
        count = 0
        for each, arg in zip(parameters, args, strict=False):
            kind = "" if each.type is None else self.type_text(each.type, frame)
            if isinstance(arg, Obj) and arg.cls is not None:
                count += self.class_of(kind, frame) is arg.cls
            elif isinstance(arg, Made):
                count += kind.partition("<")[0] == arg.path
        return count

    def _aggregate(self, kind: Node | None, value: Value, node: Node, frame: Frame) -> Value:
        """Return the value of a member of an aggregate: lists in braces become objects."""
        if not isinstance(value, Items) or kind is None:
            return coerced(text_of(kind), value)
        inner = arguments_of(kind)
        if inner and path_of(kind).endswith("vector"):
            return self._aggregates(value, inner[0], node, frame)
        return self.declared(kind, value.values, node, frame)

    def _aggregates(self, value: Value, kind: Node | None, node: Node, frame: Frame) -> Value:
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
            if (
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

    def _is_value(self, kind: Node, cls: ClassInfo, name: str, frame: Frame) -> bool:
        """Return whether a member without arguments is an object or a list, and not a pointer."""
        if kind.type not in ("type_identifier", "qualified_identifier", "template_type"):
            return False
        return not any(
            each.endswith(("Ptr", "_ptr")) or "weak" in each
            for each in (path_of(kind), self.type_text(kind, frame))
        )


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


def _is_array(declarator: Node) -> bool:
    """Return whether a variable is declared as an array, as in ``const char * names[] = {...}``."""
    inner = declarator.child_by_field_name("declarator")
    return declarator.type == "array_declarator" or (inner is not None and _is_array(inner))


def _may_copy(cls: ClassInfo) -> bool:
    """Return whether a class has a constructor with one argument, which may be that for copies."""
    return any(len(each.parameters) == 1 for each in cls.methods.get(cls.name, []))
