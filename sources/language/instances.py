"""Makes classes of the program, with what their bases and metaclasses do, and instances of them."""

from __future__ import annotations

import ast

from dineros.sources.facts import CallbackFact
from dineros.sources.language.activities import Activity
from dineros.sources.language.computing.gathering import members_of
from dineros.sources.language.expressions import as_member
from dineros.sources.language.machine import FALLS
from dineros.sources.language.running.statements import Statements
from dineros.sources.language.values import (
    Bound,
    Class,
    Const,
    Frame,
    Function,
    Items,
    Made,
    Mapping,
    Object,
    Open,
    Outside,
    Value,
    join,
    key_of,
    options,
)
from dineros.sources.places import Place


class Instances(Statements):
    """The part of the interpreter that makes classes and instances."""

    # ------------------------------------------------------------------------------------------------ classes

    def _run_ClassDef(self, node: ast.ClassDef, frame: Frame) -> set[str]:  # noqa: N802
        bases = [self.evaluate(each, frame) for each in node.bases]
        keys = {each.arg or "": self.evaluate(each.value, frame) for each in node.keywords}
        cls = Class(node, frame, [b for base in bases for b in options(base)])
        inner = Frame(frame.module, {}, frame)
        inner.cls = cls  # type: ignore[attr-defined]
        with self.doing(Activity(self.activity.fact, self.activity.node)):
            self.execute(node.body, inner)
        cls.names = inner.names
        self._begin_class(cls, keys, node, frame)
        self.assign_variable(node.name, self.decorated(cls, node, frame), frame)
        return {FALLS}

    def _begin_class(self, cls: Class, keys: dict[str, Value], node: ast.AST, frame: Frame) -> None:
        """Tell the bases, the descriptors and the metaclass of a new class."""
        given = keys.pop("metaclass", None)
        metas = [given, *(each.meta for each in cls.inside)]
        cls.meta = next((each for each in metas if isinstance(each, Class)), None)
        for base in cls.bases:
            if isinstance(base, Class):
                base.subclasses.append(cls)
        if cls.is_enum() and isinstance(self.look_up(cls, "__init__"), Function):
            self._begin_members(cls, node, frame)
        for name, value in list(cls.names.items()):
            self.special(value, "__set_name__", [cls, Const(name)], node, frame)
        if cls.meta is not None:
            args: list[Value] = [
                Const(cls.node.name),
                Items(list(cls.bases), kind="tuple"),
                Mapping(dict(cls.names)),
            ]
            self.new_classes.append(cls)
            for method, first in (("__new__", cls.meta), ("__init__", cls)):
                function = self.look_up(cls.meta, method)
                if isinstance(function, Function):
                    self.call(function, [first, *args], dict(keys), node, frame)
            self.new_classes.pop()
        told = self.look_up(cls, "__init_subclass__", cls)
        if isinstance(told, Function):
            self.call(Bound(told, cls), [], keys, node, frame)

    def _begin_members(self, cls: Class, node: ast.AST, frame: Frame) -> None:
        """Make the members of an enumeration whose constructor takes their values."""
        for name, value in list(cls.names.items()):
            if name.startswith("_") or isinstance(value, (Class, Function)):
                continue
            member = Object(cls, self.place(node, frame))
            for part in ("value", "_value_"):
                self.write_slot(member, part, value)
            for part in ("name", "_name_"):
                self.write_slot(member, part, Const(name))
            args = list(value.items) if isinstance(value, Items) and value.kind == "tuple" else [value]
            cls.names[name] = self._begin(member, args, {}, node, frame)

    def new_class(self, args: list[Value], node: ast.AST, frame: Frame) -> Value:
        """Return the class of a call ``type(name, bases, names)``."""
        if isinstance(args[0], Class) and self.new_classes:
            return self.new_classes[-1]
        name, bases, names = args[-3:]
        text = str(name.value) if isinstance(name, Const) else "?"
        where = ast.Pass(lineno=getattr(node, "lineno", 1), col_offset=0)
        written = ast.ClassDef(text, [], [], [where], [], lineno=where.lineno, col_offset=0)
        found = Class(written, frame, list(bases.items) if isinstance(bases, Items) else [Open("bases")])
        if isinstance(names, Mapping):
            found.names = {key: each for key, each in names.items.items() if isinstance(key, str)}
        self._begin_class(found, {}, node, frame)
        return found

    # ---------------------------------------------------------------------------------------------- instances

    def instance(
        self, cls: Class, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value:
        """Make an instance of a class of the program, with its own code or the one of its metaclass."""
        meta = self.look_up(cls.meta, "__call__") if cls.meta is not None else None
        if isinstance(meta, Function) and all(each.node is not meta.node for each in self.calls):
            return self.call(Bound(meta, cls), args, keys, node, frame)
        if cls.is_enum():
            return self._member(cls, args)
        new = self.look_up(cls, "__new__")
        if not isinstance(new, Function):
            return self._begin(Object(cls, self.place(node, frame)), args, keys, node, frame)
        made = self.call(new, [cls, *args], dict(keys), node, frame)
        for found in options(made):
            if isinstance(found, Object) and cls in found.cls.inside and found not in self.begun:
                self.begun.add(found)
                self._begin(found, args, keys, node, frame)
        return made

    def _member(self, cls: Class, args: list[Value]) -> Value:
        """Return the member of an enumeration with a value."""
        missing = self.look_up(cls, "_missing_")
        if isinstance(missing, Function):
            with self.perhaps():
                self.call(Bound(missing, cls), list(args), {}, missing.node, missing.frame)
        if args and isinstance(args[0], Const):
            return as_member(args[0], cls)
        has_code = any(isinstance(each, Function) for each in cls.names.values())
        return join(members_of(cls)) if has_code else args[0] if args else Open(cls.node.name)

    def _begin(
        self, found: Object, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value:
        """Run the constructor of a new object."""
        cls = found.cls
        found.run = self.run
        known = options(self.look_up(cls, "__init__"))
        begin = next((each for each in reversed(known) if isinstance(each, Function)), None)
        outside = cls.outside()
        if begin is not None:
            at = Place(begin.frame.module.path, begin.node.lineno)
            activity = Activity(CallbackFact("__init__", "constructor", at))
            outer = self.activity
            activity.conditional, activity.disabled = outer.conditional, outer.disabled
            activity.loops = outer.loops
            if outer.fact.kind in ("main", "constructor") and not (outer.loops or outer.disabled):
                self.attributes.single.add(id(found))
            with self.doing(activity):
                self.call(Bound(begin, found), args, keys, node, frame)
            outer.block += activity.block
            outer.is_lost |= activity.is_lost
            self._adopt(activity.fact, found)
            return found
        names = _fields(cls)
        for name, value in cls.names.items():
            if name in names:
                self.write_slot(found, name, value)
        for name, value in [*zip(_positional(cls, names), args, strict=False), *keys.items()]:
            self.write_slot(found, name, value)
        self._begin_fields(found, names, node, frame)
        for path in outside:
            self.library.construct(found, path, args, keys, node, frame)
        return found

    def _begin_fields(self, found: Object, names: dict[str, str], node: ast.AST, frame: Frame) -> None:
        """Make the default values of a dataclass, and run what follows after that."""
        for name in names:
            slot = found.slots.get(name)
            made = slot.current if slot is not None else None
            if isinstance(made, Made) and made.path == "dataclasses.field":
                factory = made.argument(-1, "default_factory")
                default = made.argument(-1, "default")
                value = self.call(factory, [], {}, node, frame) if factory is not None else default
                found.slots.pop(name)
                if value is not None:
                    self.write_slot(found, name, value)
        after = self.look_up(found.cls, "__post_init__")
        if isinstance(after, Function):
            only = [name for name, kind in names.items() if "InitVar" in kind]
            args = [self.read_slot(found, name) or Open(name) for name in only]
            self.call(Bound(after, found), args, {}, node, frame)

    def named_tuple(
        self, made: Made, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value:
        """Make an instance of a class of ``collections.namedtuple``."""
        given = made.argument(1, "field_names")
        text = given.value if isinstance(given, Const) else None
        names = text.replace(",", " ").split() if isinstance(text, str) else []
        if isinstance(given, Items):
            names = [str(each.value) for each in given.items if isinstance(each, Const)]
        found = Made(NAMED_TUPLE, args, keys, self.place(node, frame))
        for name, value in [*zip(names, args, strict=False), *keys.items()]:
            self.write_slot(found, name, value)
        return found

    def _adopt(self, fact: CallbackFact, found: Object) -> None:
        """Record the constructor of a node as one of its callbacks; others belong to their caller."""
        node = found.node
        if node is None:
            value = next(
                (s.current for s in found.slots.values() if getattr(s.current, "fact", None) is not None),
                None,
            )
            node = getattr(value, "fact", None)
        if not fact.effects:
            return
        if node is not None and hasattr(node, "callbacks") and fact.kind == "constructor":
            if not any(each.at == fact.at and each.kind == fact.kind for each in node.callbacks):
                node.callbacks.append(fact)
        else:
            for effect in fact.effects:
                if effect not in self.activity.fact.effects:
                    self.activity.fact.effects.append(effect)

    # ------------------------------------------------------------------------------- what Python itself knows

    def of_object(
        self, name: str, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value | None:
        """Call a method of ``object`` or ``type`` itself, with its instance; None: one that does nothing."""
        first, key = args[0] if args else None, key_of(args[1]) if len(args) > 1 else None
        if name == "__new__" and isinstance(first, Class):
            if len(args) == 4 and isinstance(args[3], Mapping):
                return self.new_class(args, node, frame)
            return Object(first, self.place(node, frame))
        if name == "__call__" and isinstance(first, Class):
            return self.instance(first, args[1:], keys, node, frame)
        if name == "__setattr__" and isinstance(first, Object) and len(args) > 2:
            if isinstance(key, str):
                self.attributes.names.add(key)
                self.write_slot(first, key, args[2])
            else:
                self.activity.fact.is_open = True
            return Const(None)
        if name == "__getattribute__" and isinstance(first, Object) and isinstance(key, str):
            return self.plain_attribute(first, key, key, node, frame)
        return None


NAMED_TUPLE = "a named tuple"
"""Path of an instance of a class of ``collections.namedtuple``."""


def _fields(cls: Class) -> dict[str, str]:
    """Return the fields of a dataclass or a named tuple, with their types."""
    return {
        each.target.id: ast.unparse(each.annotation)
        for base in reversed(cls.inside)
        for each in base.node.body
        if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)
    }


def _positional(cls: Class, names: dict[str, str]) -> list[str]:
    """Return the fields of a dataclass that its constructor takes by their places."""
    others: set[str] = set()
    for base in cls.inside:
        is_late = any("kw_only=True" in ast.unparse(each) for each in base.node.decorator_list)
        for each in base.node.body:
            if not isinstance(each, ast.AnnAssign) or not isinstance(each.target, ast.Name):
                continue
            value = "" if each.value is None else ast.unparse(each.value)
            is_late |= ast.unparse(each.annotation).endswith("KW_ONLY")
            if is_late or "kw_only=True" in value or "init=False" in value:
                others.add(each.target.id)
    return [each for each in names if each not in others]


def is_base_of_all(value: Value) -> bool:
    """Return whether a value is ``object`` or ``type``."""
    return isinstance(value, Outside) and value.path in ("builtins.object", "builtins.type")
