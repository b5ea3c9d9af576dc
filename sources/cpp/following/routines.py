"""Interprets routines of the folder: parameters, bodies and results, and which routines can be skipped."""

from __future__ import annotations

import re
from contextlib import nullcontext
from typing import TYPE_CHECKING

from dineros.sources.branches import Called
from dineros.sources.cpp.declarators import declared, is_pointer
from dineros.sources.cpp.entries import Routine
from dineros.sources.cpp.following.assigning import Assigning
from dineros.sources.cpp.following.expressions import named
from dineros.sources.cpp.following.machine import MOST_CALLS, MOST_STEPS, coerced
from dineros.sources.cpp.parsing import arguments_of, path_of, text_of
from dineros.sources.cpp.values import Const, Either, Frame, Items, Made, Obj, Open, Seconds, Value, options

if TYPE_CHECKING:
    from tree_sitter import Node

_SUSPENDS = re.compile(r"\bco_(?:await|yield|return)\b")
_LARGE = MOST_STEPS // 4
"""Steps after which only routines that may use ROS are followed."""
_MOST_OBJECTS = 200
"""Limit of the objects whose members a skipped routine may change."""

_POINTERS = ("SharedPtr", "ConstSharedPtr", "UniquePtr", "ConstUniquePtr", "ConstPtr")
"""Names that classes of ROS give to pointers to their objects."""
_WHOLE = (
    "int",
    "int32_t",
    "int64_t",
    "long",
    "uint32_t",
    "uint64_t",
    "size_t",
    "unsigned",
    "int16_t",
    "uint8_t",
)
_OF_CONSTANTS: dict[str, list[tuple[str, ...]]] = {
    "bool": [("bool",), _WHOLE, ("double", "float")],
    "int": [("int", "int32_t"), _WHOLE, ("double", "float"), ("bool",)],
    "float": [("double",), ("float",), _WHOLE],
    "str": [("string", "string_view", "char*")],
}
"""By the type of a constant: the types of parameters that fit, the best first."""


class Routines(Assigning):
    """Runs routines."""

    def _body(self, body: Node | None, frame: Frame, called: Node, site: Node | None = None) -> Value:
        key = (called.id, id(frame.this))
        if len(self.calls) >= MOST_CALLS or any(each[:2] == key for each in self.calls):
            self.is_lost = True
            return Open("a call within itself")
        if called.id not in self.followed and _SUSPENDS.search(text_of(body)):
            self.unread.append(
                f"{self.place(called, frame)}: a coroutine, which is followed like a function: "
                "when it continues is unknown"
            )
        self.followed.add(called.id)
        # Each call of a routine makes ports and objects of its own.
        self.calls.append(key if site is None else (*key, site.id))
        self.frames.append(frame)
        held, frame.level, frame.off = len(self.holding), self.cond + self.loops, self.off
        frame.routine = called
        outer, self.block = self.block, []
        try:
            self.run_block(body, frame)
        finally:
            inner, self.block = self.block, outer
            if inner:
                self.block.append(Called(inner))
            self.calls.pop()
            self.frames.pop()
            del self.holding[held:]
        return frame.result or Open("a result")

    def run(
        self, routines: list[Routine], args: list[Value], this: Obj | None, node: Node, types: list[str]
    ) -> Value:
        """Call a routine; of several, the one with the matching number of arguments."""
        found = [each for each in routines if each.body is not None]
        if not found:
            return Open(text_of(node)[:60])
        fitting = [each for each in found if len(each.parameters) == len(args)]
        fitting = fitting or [each for each in found if any(one.is_pack for one in each.parameters)]
        fitting = fitting or [each for each in found if len(each.parameters) > len(args)] or found
        if len(fitting) > 1:
            fitting = self._of_objects(self._of_types(fitting, args, node), args)
        results = []
        for each in fitting[:4]:
            frame = self.frame_of(each, self._converted(each, args, node), this, types)
            self.sites.append((each.name, node, self.frames[-1] if self.frames else None, frame))
            try:
                with self.perhaps() if len(fitting) > 1 else nullcontext():
                    results.append(self._followed(each, frame, node))
                    self._give_back(each, args, frame, node)
            finally:
                self.sites.pop()
        return results[0] if len(results) == 1 else Either(tuple(results))

    def _converted(self, routine: Routine, args: list[Value], node: Node) -> list[Value]:
        """Return arguments as the parameters get them: classes may be made of objects of other classes."""
        given = named(node.child_by_field_name("arguments")) if node.type == "call_expression" else []
        if len(given) != len(args) or not any(isinstance(each, Obj) and each.cls for each in args):
            return args
        frame = Frame(routine.path, routine.cls.full if routine.cls is not None else routine.space)
        return [
            value if number >= len(routine.parameters) else self._as_class(kind, value, given[number], frame)
            for number, value in enumerate(args)
            for kind in [self.type_of_parameter(routine, number) if number < len(routine.parameters) else ""]
        ]

    def _as_class(self, kind: str, value: Value, node: Node, frame: Frame) -> Value:
        """Return a new object of a class if a constructor makes it of this object; else the object itself."""
        if not isinstance(value, Obj) or value.cls is None or not kind or kind.endswith("*"):
            return value
        cls = self.class_of(kind, frame)
        own = self.bases(value.cls)
        if cls is None or cls in own:
            return value
        for each in cls.methods.get(cls.name, []):
            if len(each.parameters) != 1 or each.body is None:
                continue
            taken = self.type_of_parameter(each, 0)
            if not taken or self.class_of(taken.removesuffix("*"), Frame(each.path, cls.full)) in own:
                return self.construct(cls, [value], [], node, frame)
        return value

    def _of_objects(self, routines: list[Routine], args: list[Value]) -> list[Routine]:
        """Return the overloads with parameters of the classes of the objects; without any, all of them."""
        for number, value in enumerate(args):
            cls = value.cls if isinstance(value, Obj) else None
            exact = []
            for each in routines if cls is not None else ():
                if number < len(each.parameters):
                    kind = self.type_of_parameter(each, number).removesuffix("*")
                    exact += [each] if self.class_of(kind, Frame(each.path, each.space)) is cls else []
            routines = exact or routines
        return routines

    def _of_types(self, routines: list[Routine], args: list[Value], node: Node) -> list[Routine]:
        """Return the overloads whose parameters have exactly the types of the arguments, as far as known.

        If none has, all of them are possible.
        """
        function = node.child_by_field_name("function") if node.type == "call_expression" else None
        given = named(node.child_by_field_name("arguments")) if function is not None else []
        names = {each.name for each in routines}
        last = path_of(function).replace("->", "::").replace(".", "::").rpartition("::")[2]
        if not self.frames or len(given) != len(args) or names != {last}:
            return routines
        for number, (each, value) in enumerate(zip(given, args, strict=True)):
            for kinds in self._types_of(each, value):
                exact = [
                    one
                    for one in routines
                    if number < len(one.parameters) and _is_among(self.type_of_parameter(one, number), kinds)
                ]
                if exact:
                    routines = exact
                    break
        return routines

    def type_of_parameter(self, routine: Routine, number: int) -> str:
        """Return the type of a parameter; empty: it depends on a template."""
        kind = routine.parameters[number].type
        space = routine.cls.full if routine.cls is not None else routine.space
        is_known = kind is not None and path_of(kind) not in routine.templates
        return self._spelled(kind, Frame(routine.path, space, None, routine.cls)) if is_known else ""

    def _types_of(self, node: Node, value: Value) -> list[tuple[str, ...]]:
        """Return the types that an argument may have, those that fit best first."""
        if isinstance(value, Const) and value.value is not None:
            return _OF_CONSTANTS[type(value.value).__name__]
        if isinstance(value, Obj) and value.cls is not None:
            return [(value.cls.full, f"{value.cls.full}*")]
        if node.type == "call_expression" and text_of(node).startswith("std::move("):
            node = named(node.child_by_field_name("arguments"))[0]
        sign = text_of(node)[:1] if node.type == "pointer_expression" else ""
        inner = node.child_by_field_name("argument") if sign else node
        frame = self.frames[-1]
        kind: Node | None = None
        if inner is not None and inner.type == "identifier":
            kind = self.kind_of(inner, frame)
        elif inner is not None and inner.type in ("call_expression", "compound_literal_expression"):
            kind = inner.child_by_field_name("function") or inner.child_by_field_name("type")
            kind = kind if isinstance(value, Made) and value.path == self.type_text(kind, frame) else None
        found = self._spelled(kind, frame) if kind is not None else ""
        if not found:
            return []
        return [(found.removesuffix("*") if sign == "*" else f"{found}*" if sign == "&" else found,)]

    def kind_of(self, node: Node | None, frame: Frame) -> Node | None:
        """Return the type with which a variable or a member is declared; None: not known."""
        if node is None or node.type not in ("identifier", "field_expression"):
            return None
        if node.type == "identifier":
            made = declared(text_of(node), node)
            if made is not None:
                return made.child_by_field_name("type")
            holders: tuple[Value, ...] = () if frame.this is None else (frame.this,)
        else:
            holders = options(self.value(node.child_by_field_name("argument"), frame))
            node = node.child_by_field_name("field")
        kinds = [each.cls for each in holders if isinstance(each, Obj) and each.cls is not None]
        fields = (each.fields.get(text_of(node)) for cls in kinds for each in self.bases(cls))
        return next((each[0] for each in fields if each is not None), None)

    def _spelled(self, kind: Node | None, frame: Frame) -> str:
        """Return a type with a star for a pointer of any kind; empty: it is deduced."""
        name = self.type_text(kind, frame)
        scope, _, last = name.rpartition("::")
        inner = arguments_of(kind)
        if last in ("shared_ptr", "unique_ptr") and inner:
            return f"{self.type_text(inner[0], frame)}*"
        if last in _POINTERS and scope:
            return f"{scope}*"
        if inner or last == "auto":
            return ""
        return f"{name}*" if kind is not None and is_pointer(kind.parent) else name

    def frame_of(self, routine: Routine, args: list[Value], this: Obj | None, types: list[str]) -> Frame:
        """Return the variables with which a routine begins."""
        space = routine.cls.full if routine.cls is not None else routine.space
        frame = Frame(routine.path, space, this, routine.cls)
        frame.types = dict(zip(routine.templates, types, strict=False))
        declared = routine.cls.defaults.get(routine.name, []) if routine.cls is not None else []
        same = next((each for each in declared if len(each) == len(routine.parameters)), [])
        for number_, each in enumerate(routine.parameters):
            if each.is_pack:
                frame.values[each.name] = Items(args[number_:])
                continue
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

    def _followed(self, routine: Routine, frame: Frame, node: Node) -> Value:
        """Return the result of a routine; in a long program, those that do nothing are skipped."""
        is_followed = self.steps < _LARGE or self.reach.does_matter(routine)
        if is_followed and not self.is_idle(routine.node):
            with self.observed(routine.node):
                return self._body(routine.body, frame, routine.node, node)
        words = self.reach.words(routine)
        sets = frozenset(self.writes[routine.node.id]) if is_followed else words
        held = [frame.this, *frame.values.values()]
        _open_members(
            [each for value in held for each in options(value) if isinstance(each, Obj)], words, sets
        )
        for each in routine.parameters:
            if each.is_out:
                frame.values[each.name] = Open(each.name)
        return Open(text_of(node)[:60])

    def _give_back(self, routine: Routine, args: list[Value], frame: Frame, node: Node) -> None:
        """Copy the values of reference parameters to the variables of the caller."""
        given = named(node.child_by_field_name("arguments")) if node.type == "call_expression" else []
        if len(given) != len(args) or not self.frames:
            return
        for each, left, before in zip(routine.parameters, given, args, strict=False):
            value = frame.values.get(each.name)
            # The value that `frame_of` has made of the argument is not new.
            if each.is_out and value is not None and value != coerced(text_of(each.type), before):
                if left.type == "subscript_expression":  # an item of a list; which one may be unknown
                    held = self.value(left.child_by_field_name("argument"), self.frames[-1])
                    if isinstance(held, Items):
                        held.is_open = True
                else:
                    self.assign(left, value, self.frames[-1])


def _is_among(kind: str, kinds: tuple[str, ...]) -> bool:
    """Return whether a type is one of several; their namespaces may be left out."""
    return bool(kind) and any(
        kind == each or kind.endswith(f"::{each}") or each.endswith(f"::{kind}") for each in kinds
    )


def _open_members(objects: list[Obj], words: frozenset[str], sets: frozenset[str]) -> None:
    """Forget lists that a routine names, and values of members that it may set."""
    seen: set[int] = set()
    while objects and len(seen) < _MOST_OBJECTS:
        each = objects.pop()
        if id(each) in seen:
            continue
        seen.add(id(each))
        for name, value in each.fields.items():
            objects += [one for one in options(value) if isinstance(one, Obj)]
            plain = all(isinstance(one, (Const, Seconds)) and one != Const(None) for one in options(value))
            if (plain and name in sets) or (isinstance(value, Items) and name in words):
                each.fields[name] = Open(name)
