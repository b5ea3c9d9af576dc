"""Calls in C++: of routines of the folder, of lambdas, of libraries; and how routines begin."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

from dineros.sources.cpp.declarators import function_of, parameters_of
from dineros.sources.cpp.entries import ClassInfo
from dineros.sources.cpp.following.endings.polling import CHANGES, value_in_words
from dineros.sources.cpp.following.expressions import named
from dineros.sources.cpp.following.machine import coerced
from dineros.sources.cpp.following.routines import Routines
from dineros.sources.cpp.parsing import arguments_of, path_of, text_of
from dineros.sources.cpp.quality import RMW_PROFILE, of_rmw
from dineros.sources.cpp.tables.boost import standard
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
    Value,
    node_in,
    one_of,
    options,
)

if TYPE_CHECKING:
    from tree_sitter import Node


_HARMLESS = {
    *(
        "ParamListener",
        "CreateTimerROS",
        "shared_from_this",
        "Buffer",
        "Clock",
        "TimeSource",
        "make_pair",
    ),
    *("declare_parameter_if_not_declared", "declare_parameter", "get_logger", "weak_ptr", "Bond", "Rate"),
    *("TRACEPOINT", "TRACETOOLS_TRACEPOINT", "DO_TRACEPOINT"),
    *("setCreateTimerInterface", "TransportHints", "setMouseCallback"),
    *("emplace", "emplace_back", "push_back", "insert", "swap", "get_child", "set_parameter", "what"),
    "assert",
    *(
        "RequiredInterfaces",
        "NodeInterfaces",
        "ClassLoader",
        "get_parameter",
        "add_node",
        "remove_node",
        "static_cast",
        "dynamic_cast",
    ),
}
"""Functions and classes of libraries that receive a node and create no ports that a model represents."""
_HARMLESS_SPACES = (
    "std::",
    "rclcpp::",
    "rclcpp_",
    "rcl_",
    "RCLCPP_",
    "builtin",
    "tf2::",
    "RCUTILS_",
    "fmt::",
)


SLOTS = "slots"
"""Member of a signal of Boost: the functions that its call calls."""
TASK = "std::packaged_task"
"""The class of tasks whose end others wait for."""
CONTAINERS = {
    f"{space}{name}"
    for space in ("std::", "")
    for name in (
        "vector",
        "list",
        "array",
        "map",
        "unordered_map",
        "deque",
        "set",
        "multimap",
        "forward_list",
        *("queue", "priority_queue", "stack", "unordered_set", "multiset", "unordered_multimap"),
    )
}
"""Classes of the standard library that hold items."""


class Call:
    """A call in the code: the callee, its object and its arguments."""

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
    """Interprets calls of libraries."""

    def call(self, call: Call) -> Value | None:
        """Return the result of a call of a library; None: an unknown call."""

    def make_node(self, this: Obj, kind: str, args: list[Value], node: Node, frame: Frame) -> None:
        """Make an object a node."""

    def read_callback(self, target: Value, kind: str, node: Node, frame: Frame) -> None:
        """Read a callback without a port."""


class Calls(Routines):
    """Evaluates calls."""

    library: Library

    def event(self, node: Node, target: Value, frame: Frame) -> None:
        """Read the callback of an event of a port."""
        self.library.read_callback(target, "event", node, frame)

    def _new_expression(self, node: Node, frame: Frame) -> Value:
        args = self.values(node.child_by_field_name("arguments"), frame)
        return self.make(node.child_by_field_name("type"), args, node, frame)

    def _delete_expression(self, node: Node, frame: Frame) -> Value:
        for each in named(node):
            self.let_go(options(self.value(each, frame)), node)
        return Const(None)

    def _compound_literal_expression(self, node: Node, frame: Frame) -> Value:
        args = self.values(node.child_by_field_name("value"), frame)
        return self.make(node.child_by_field_name("type"), args, node, frame)

    def make(self, kind: Node | None, args: list[Value], node: Node, frame: Frame) -> Value:
        """Return an object of a type."""
        name = self.type_text(kind, frame)
        if name in CONTAINERS:
            return self._container(kind, args, frame)
        cls = self.class_of(name, frame)
        if cls is not None:
            types = [self.template_text(each, frame) for each in arguments_of(kind)]
            return self.construct(cls, args, types, node, frame)
        call = Call(node, frame, name, args, name=kind)
        found = self.library.call(call)
        if found is None:
            self.escapes(call)
        if found is None:
            fields = of_rmw(args) if name.endswith(RMW_PROFILE) else {}
            found = Made(name, args, fields, node=kind if kind is not None else node)
        return found

    def _container(self, kind: Node | None, args: list[Value], frame: Frame) -> Items:
        """Return a list of the standard library; of a map, the class of its values counts."""
        inner = self.templated(kind, frame)
        is_map = self.type_text(kind, frame).endswith("map") and len(inner) > 1
        first = args[0] if len(args) == 1 else None
        is_pair = is_map and isinstance(first, Items) and _is_pair(first)  # of ``map{{key, value}}``
        cls = None if is_map or not inner else self.class_of(self.type_text(inner[0], frame), frame)
        is_item = cls is not None and isinstance(first, Items) and not first.of and _is_aggregate(first)
        made = first if isinstance(first, Items) and not is_pair and not is_item else Items(args)
        if inner and made.kind is None:
            made.is_map = is_map
            number = 1 if is_map else 0
            made.of = self.type_text(inner[number], frame)
            made.kind = self.class_of(made.of, frame)
            if not is_map and any(isinstance(each, Items) for each in made.values):
                made.values = _items(self.aggregates(made, inner[0], inner[0], frame))
            for each in made.values if is_map and made.kind is not None else ():
                if isinstance(each, Items) and len(each.values) == 2:
                    value = Items(each.values[1:])
                    each.values[1:] = _items(self.aggregates(value, inner[1], inner[1], frame))
        return made

    def _call_expression(self, node: Node, frame: Frame) -> Value:
        function = node.child_by_field_name("function")
        inner = node.child_by_field_name("arguments")
        assert function is not None
        if function.type == "field_expression":
            left = function.child_by_field_name("argument")
            on = self.held_by(function, self.value(left, frame))
            field = function.child_by_field_name("field")
            args = self.values(inner, frame)
            held = [each for each in options(on) if isinstance(each, (Lambda, Method))]
            if held and text_of(field) == "second":  # lists of this reader have the values of a map only
                return self.invoke(one_of(held), args, node, frame)
            if text_of(field) in ("first", "second") and not isinstance(on, Obj):
                return self.invoke(self.value(function, frame), args, node, frame)
            if text_of(field) in CHANGES:
                value = CHANGES[text_of(field)] or value_in_words(args[0] if args else None)
                self.note_change(path_of(left).rpartition("->")[2], value)
            if text_of(field) == "reset" and len(args) == 1 and self._is_pointer(function, on):
                self.assign(left, args[0], frame)
                return Open("reset")
            if text_of(field) == "reset" and not args and self._is_pointer(function, on):
                self.let_go(options(on), node, self.kind_of(left, frame))
            several = options(on)
            found = []
            for each in several:
                with self.perhaps() if len(several) > 1 else nullcontext():  # it is one of them
                    found.append(self._on(Call(node, frame, path_of(field), args, each, field)))
            return one_of(found)
        args = self.values(inner, frame)
        if function.type in ("identifier", "template_function", "qualified_identifier"):
            return self._plain(Call(node, frame, path_of(function), args, name=function))
        if function.type in ("primitive_type", "sized_type_specifier") and len(args) == 1:  # int(rate * 1000)
            return coerced(text_of(function), args[0])
        called = self._by_pointer(function, frame) or self.value(function, frame)
        return self.invoke(called, args, node, frame)

    def _by_pointer(self, function: Node, frame: Frame) -> Value | None:
        """Return the method that ``(this->*state_)`` calls; None: another expression.

        The grammar does not know this operator.
        """
        sign = next((each for each in function.named_children if each.type == "ERROR"), None)
        if sign is None or text_of(sign) not in ("this->*", "(this->*"):
            return None
        found = options(self.value(function.named_children[-1], frame))
        bound = tuple(replace(each, this=frame.this) if isinstance(each, Method) else each for each in found)
        return bound[0] if len(bound) == 1 else Either(bound)

    def _is_pointer(self, function: Node, on: Value) -> bool:
        """Return whether a method belongs to a smart pointer itself, and not to the object that it holds."""
        kinds = [each.cls for each in options(on) if isinstance(each, Obj) and each.cls is not None]
        return text_of(function.child_by_field_name("operator")) == "." and not any(
            self.methods(each, "reset") for each in kinds
        )

    def _on(self, call: Call) -> Value:
        """Call a method of an object."""
        on = call.on
        if isinstance(on, Obj):
            routines = self.methods_of(on, call.last)
            if routines:
                return self.run(routines, call.args, on, call.node, self._types(call))
            held = [each for each in options(on.fields.get(call.last)) if isinstance(each, (Lambda, Method))]
            if held:
                return self.invoke(one_of(held), call.args, call.node, call.frame)
        found = self.library.call(call)
        if found is None:
            self.escapes(call)
        return found if found is not None else Open(text_of(call.node)[:60])

    def _plain(self, call: Call) -> Value:
        """Call a function, a method of this object, a lambda or a constructor."""
        frame, path = call.frame, call.path
        variable = self.lookup(path, frame) if "::" not in path else None
        if variable is not None:
            return self.invoke(variable, call.args, call.node, frame)
        if path in ("shared_from_this", "weak_from_this") and frame.this is not None:
            return frame.this
        if frame.this is not None and frame.cls is not None:
            scope = path.rpartition("::")[0]
            owner = (
                self.class_of(self.type_text(call.named.child_by_field_name("scope"), frame), frame)
                if (scope and call.named is not None)
                else frame.this.cls or frame.cls
            )
            if owner is not None and (not scope or owner in self.bases(frame.this.cls or frame.cls)):
                is_own = owner is (frame.this.cls or frame.cls)
                routines = self.methods_of(frame.this, call.last) if is_own else []
                routines = routines or self.methods(owner, call.last)
                if routines and call.last != owner.name:
                    return self.run(routines, call.args, frame.this, call.node, self._types(call))
        if call.named is not None and call.named.type != "identifier":
            call.path = standard(self._resolved(call.named, frame))
        elif call.named is not None and "chrono" in (kind := self.type_text(call.named, frame)):
            call.path = kind
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
        self.escapes(call)
        return Made(call.path, call.args, node=call.node)

    def _resolved(self, node: Node, frame: Frame) -> str:
        if node.type == "qualified_identifier":
            scope = node.child_by_field_name("scope")
            rest = path_of(node).removeprefix(path_of(scope)).removeprefix("::")
            return f"{self.type_text(scope, frame)}::{rest}" if scope is not None else rest
        return path_of(node)

    def _types(self, call: Call) -> list[str]:
        return [self.template_text(each, call.frame) for each in arguments_of(call.named)]

    def escapes(self, call: Call) -> None:
        """Record that unknown code receives a node, so that it may use its ports in any way."""
        self.forget(call)
        self._hand_over(call)
        nodes = [each for each in map(node_in, call.args) if each is not None]
        if not nodes or call.last in _HARMLESS or call.path.startswith(_HARMLESS_SPACES):
            return
        self.fact.is_open = True
        for each in nodes:
            if each.node is not None:
                each.node.is_lent = True
        place, name = self.place(call.node, call.frame), call.path
        self.unread.append(
            f"{place}: {name} receives the node, but its code is not in the folder, so its ports are unknown"
        )

    def _hand_over(self, call: Call) -> None:
        """Read the callables that unknown code receives: it may call them at any time, as drivers do."""
        if call.last in _HARMLESS or call.path.startswith(_HARMLESS_SPACES):
            return
        nodes = call.nodes if len(call.nodes) == len(call.args) else [call.node] * len(call.args)
        for node, value in zip(nodes, call.args, strict=True):
            for found in options(value):
                is_bare = isinstance(found, Method) and not found.args
                each = self._with_object(found, call.args) if is_bare else found  # type: ignore[arg-type]
                is_lambda = isinstance(each, Lambda) and self.reach.does_code_matter(each.node)
                routines = each.routines if isinstance(each, Method) and (each.this or each.args) else []
                if is_lambda or any(self.reach.does_matter(one) for one in routines):
                    self.library.read_callback(each, "event", node, call.frame)
                    if self.role not in ("main", "constructor"):
                        self.unread.append(
                            f"{self.place(node, call.frame)}: {call.path} receives a function, but its code "
                            "is not in the folder, so when it calls it is unknown; any time is assumed"
                        )

    def _with_object(self, method: Method, args: list[Value]) -> Method:
        """Return a method or function with the object that unknown code receives besides it.

        C libraries give the object back as a ``void *`` argument.
        """
        objects = [each for value in args for each in options(value) if isinstance(each, Obj) and each.cls]
        fitting = (each for each in objects for one in method.routines if one.cls in self._of(each))
        this = method.this or next(fitting, None)
        given: list[Value] = []
        for routine in method.routines[:1]:
            for number, each in enumerate(routine.parameters):
                if text_of(each.type) == "void" and objects:
                    before = routine.parameters[len(given) : number]
                    given += [*(Open(one.name) for one in before), objects[0]]
        return replace(method, this=this, args=given)

    def _of(self, value: Obj) -> list[ClassInfo]:
        return self.bases(value.cls) if value.cls is not None else []

    def forget(self, call: Call) -> None:
        """Record that a call that cannot be followed may set variables without a value."""
        for node, value in zip(call.nodes, call.args, strict=False):
            if value is NO_VALUE:
                self.assign(node, Open(text_of(call.node)[:60]), call.frame)

    def invoke(self, called: Value, args: list[Value], node: Node, frame: Frame) -> Value:
        """Call a value."""
        found: list[Value] = []
        several = [one for each in options(called) for one in self._callables(each, args)]
        for each in several:
            with self.perhaps() if len(several) > 1 else nullcontext():
                if isinstance(each, Lambda):
                    found.append(self._run_lambda(each, args, node))
                elif isinstance(each, Method):
                    this, given = _with_this(each, [*each.args, *args])
                    found.append(self.run(each.routines, given, this, node, []))
                elif isinstance(each, Made) and each.path == TASK:
                    found.append(self.library.call(Call(node, frame, "operator()", args, each)) or each)
                else:
                    found.append(Open(text_of(node)[:60]))
        return one_of(found)

    def _callables(self, called: Value, args: list[Value]) -> list[Value]:
        """Return what a call may run: of an object with several functions, those for its argument."""
        found = list(options(self.functor(called)))
        slots = called.fields.get(SLOTS) if isinstance(called, Made) else None
        if isinstance(slots, Items):
            return [one for each in slots.values for one in options(each)]
        if isinstance(called, Items):  # a pack of functions: ``(f(), ...)``
            return called.values
        if isinstance(called, Obj) and len(found) > 1 and args and isinstance(args[0], Obj):
            cls = args[0].cls
            exact = [each for each in found if isinstance(each, Lambda) and self._first_class(each) is cls]
            found = [*exact] or found
        return found

    def _first_class(self, called: Lambda) -> ClassInfo | None:
        """Return the class of the first parameter of a lambda; None: it has another type."""
        declarator = called.node.child_by_field_name("declarator")
        parameters = parameters_of(function_of(declarator) or declarator) if declarator is not None else []
        kind = parameters[0].type if parameters else None
        return None if kind is None else self.class_of(self.type_text(kind, called.frame), called.frame)

    def _run_lambda(self, each: Lambda, args: list[Value], node: Node) -> Value:
        declarator = each.node.child_by_field_name("declarator")
        parameters = parameters_of(function_of(declarator) or declarator) if declarator is not None else []
        frame = Frame(each.frame.path, each.frame.space, each.frame.this, each.frame.cls, outer=each.frame)
        frame.values = {p.name: args[n] if n < len(args) else Open(p.name) for n, p in enumerate(parameters)}
        return self._body(each.node.child_by_field_name("body"), frame, each.node)


def _is_aggregate(value: Items) -> bool:
    """Return whether a list in braces is that of one object, and not of several."""
    return bool(value.values) and not any(isinstance(each, (Items, Obj)) for each in value.values)


def _items(value: Value) -> list[Value]:
    return value.values if isinstance(value, Items) else []


def _is_pair(value: Items) -> bool:
    return len(value.values) == 2 and not isinstance(value.values[0], Items)


def _with_this(method: Method, args: list[Value]) -> tuple[Obj | None, list[Value]]:
    """Return the object and the arguments of a call; ``std::invoke`` gives both as arguments."""
    routine = next((each for each in method.routines if each.body is not None), None)
    first = args[0] if args else None
    is_method = method.this is None and routine is not None and routine.cls is not None
    if is_method and isinstance(first, Obj) and len(args) == len(routine.parameters) + 1:  # type: ignore[union-attr]
        return first, args[1:]
    return method.this, args
