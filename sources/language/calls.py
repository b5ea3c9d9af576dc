"""Calls of functions, methods and classes of the program; modules run when they are first used."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass, replace

from dineros.sources.branches import Called
from dineros.sources.facts import Item
from dineros.sources.language.computing.operations import short
from dineros.sources.language.computing.plain import PlainFunctions
from dineros.sources.language.instances import Instances
from dineros.sources.language.machine import MOST_CALLS, MOST_SIMILAR
from dineros.sources.language.modules import Module, Modules
from dineros.sources.language.values import (
    Bound,
    Class,
    Const,
    Either,
    Frame,
    Function,
    Generator,
    Holder,
    Items,
    LateItems,
    Made,
    Mapping,
    Object,
    Open,
    Outside,
    OutsideMethod,
    Partial,
    SomeFunction,
    SuperOf,
    Value,
    is_none,
    join,
    options,
)
from dineros.sources.places import Place


@dataclass
class _Invocation:
    """A call of a function of the program."""

    function: Function
    args: list[Value]
    keys: dict[str, Value]
    node: ast.AST
    frame: Frame
    instance: Value | None = None
    """The object whose method it is."""


class Interpreter(Instances):
    """An interpreter of one program over values that are partly known.

    Parameters
    ----------
    modules : Modules
        The folder's modules.
    program : str
        The program that is run, in words.
    """

    def __init__(self, modules: Modules, program: str) -> None:
        super().__init__(modules, program)
        self.plain = PlainFunctions(self.frames)

    def call(
        self, function: Value, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value:
        """Call a value; return its possible results."""
        self.step()
        if isinstance(function, Either):
            able = [each for each in function.options if not is_none(each)]
            if len(able) == 1:
                return self.call(able[0], args, keys, node, frame)
            found = []
            for each in able:
                with self.perhaps():
                    found.append(self.call(each, list(args), dict(keys), node, frame))
            return join(found)
        if isinstance(function, Function):
            return self._function(_Invocation(function, args, keys, node, frame))
        if isinstance(function, Bound):
            of_instance = [function.instance, *args]
            return self._function(
                _Invocation(function.function, of_instance, keys, node, frame, function.instance)
            )
        if isinstance(function, Partial):
            return self.call(
                function.function, [*function.args, *args], {**function.keys, **keys}, node, frame
            )
        if isinstance(function, Class):
            return self.instance(function, args, keys, node, frame)
        if isinstance(function, Outside):
            owner, _, name = function.path.rpartition(".")
            if owner in ("builtins.object", "builtins.type"):
                of_all = self.of_object(name, args, keys, node, frame)
                if of_all is not None:
                    return of_all
            return self.library.call(function.path, args, keys, node, frame)
        if isinstance(function, OutsideMethod):
            return self._method(function, args, keys, node, frame)
        if isinstance(function, Object):
            inner = self.look_up(function.cls, "__call__")
            if isinstance(inner, Function):
                return self._function(_Invocation(inner, [function, *args], keys, node, frame, function))
        if isinstance(function, Made) and function.path == "collections.namedtuple":
            return self.named_tuple(function, args, keys, node, frame)
        if isinstance(function, Made):
            made = self.library.call_made(function, args, node, frame)
            if made is not None:
                return made
        self._hand_over(args, keys)
        self.attributes.may_call(function)
        if isinstance(function, SomeFunction):
            self.activity.fact.is_open = True
        return Open(short(node))

    def _method(
        self, function: OutsideMethod, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value:
        instance = function.instance
        if function.name in CHANGES and isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            self.changes_attribute(node.func.value)
        if isinstance(instance, SuperOf):
            first = [] if function.name == "__new__" else [instance.instance]
            of_all = self.of_object(function.name, [*first, *args], keys, node, frame)
            if of_all is not None:
                return of_all
            if not isinstance(instance.instance, Object):
                return Open(function.text)
            if function.name == "__init__":
                for path in instance.instance.cls.outside():
                    self.library.construct(instance.instance, path, args, keys, node, frame)
                return Const(None)
            function = OutsideMethod(instance.instance, function.name, function.text)
        if (
            isinstance(instance, Class)
            and function.name == "__init__"
            and args
            and isinstance(args[0], Object)
        ):
            for path in instance.outside():
                self.library.construct(args[0], path, args[1:], keys, node, frame)
            return Const(None)
        if isinstance(instance, Class) and function.name == "__subclasses__":
            return Items(list(instance.subclasses))
        if isinstance(instance, Object) and _is_unknown(function, instance):
            self.activity.fact.is_open = True  # the reader has lost it
        return self.library.call_method(function, args, keys, node, frame)

    def _hand_over(self, args: list[Value], keys: dict[str, Value]) -> None:
        """Mark lists that unknown code receives as open, because it may change them."""
        for each in [*args, *keys.values()]:
            if isinstance(each, Items) and each.kind != "tuple":
                each.is_open = True
            self.escape(each)

    def _function(self, call: _Invocation) -> Value:
        function, node, frame = call.function, call.node, call.frame
        if isinstance(function.node, ast.AsyncFunctionDef) and node is self.unused:
            self.effect("forgets", function.name, node, frame)
            return Open(short(node))
        if function.registered:
            return self._one_of(call)
        if _is_generator(function) and not function.decorators:
            return Generator(function, call.args, call.keys, call.instance)
        if not function.around:
            return self._body(call)
        for each in function.around:
            self.library.enter(each, "", node, frame)
        found = self._body(call)
        for each in reversed(function.around):
            self.library.leave(each, node, frame)
        return found

    def _one_of(self, call: _Invocation) -> Value:
        """Call a function of ``functools.singledispatch``: the one for the type of the argument."""
        found = []
        for each in [replace(call.function, registered=[]), *call.function.registered]:
            with self.perhaps():
                if isinstance(each, Function):
                    again = replace(call, function=each, args=list(call.args), keys=dict(call.keys))
                    found.append(self._function(again))
        return join(found)

    def drawn(self, value: Value, node: ast.AST, frame: Frame) -> Value:
        """Return what a value gives one after the other: a generator runs now."""
        iterated = self.special(value, "__iter__", [], node, frame)
        following_name = "__next__"
        if iterated is None:
            iterated = self.special(value, "__aiter__", [], node, frame)
            following_name = "__anext__"
        if iterated is not None:
            with self.perhaps(is_loop=True):
                following = self.special(iterated, following_name, [], node, frame)
            if following is not None:
                return Items([following], is_open=True)
            value = join(Open("elements") if isinstance(each, Object) else each for each in options(iterated))
        if isinstance(value, (Object, Either)):
            with self.perhaps(is_loop=True):
                element = self.special(value, "__getitem__", [Open("index")], node, frame)
            if element is not None:
                return Items([element], is_open=True)
        if isinstance(value, LateItems):
            return self.drawn_late(value)
        if not any(isinstance(each, (Generator, LateItems)) for each in options(value)):
            return value
        found: list[Value] = []
        for each in options(value):
            if isinstance(each, Generator):
                call = _Invocation(each.function, each.args, each.keys, node, frame, each.instance)
                found.append(self._body(call))
            else:
                found.append(self.drawn_late(each) if isinstance(each, LateItems) else each)
        return join(found)

    def _body(self, call: _Invocation) -> Value:
        function, args, keys, node, instance = call.function, call.args, call.keys, call.node, call.instance
        known = self.plain.result(function, [*args, *keys.values()])
        if known is not None:
            self._raise_again(function, node, call.frame)
            return known
        same = [each for each in self.calls if each.node is function.node and each.code is function.code]
        depth = sum(each.frame is function.frame for each in same)  # a decorator makes others of one text
        if len(self.calls) >= MOST_CALLS or depth > 1 or len(same) > MOST_SIMILAR:
            self.activity.is_lost = True
            if depth <= 1:
                self.activity.fact.is_open = True
                self.attributes.is_wild = True
            return Open(short(node))
        if depth:  # the second call stands for all further ones
            args = [Open("argument") if isinstance(each, Const) else each for each in args]
            keys = {key: Open(key) if isinstance(each, Const) else each for key, each in keys.items()}
        inner = Frame(function.frame.module, {}, function.frame, function=function, instance=instance)
        if instance is None and function.owner is not None and args and isinstance(args[0], (Object, Class)):
            inner.instance = args[0]
        elif instance is None and function.owner is None:
            inner.instance = function.frame.instance
        self._bind(function, args, keys, inner)
        self.calls.append(function)
        line, column = getattr(node, "lineno", 0), getattr(node, "col_offset", 0)
        self.trail.append((call.frame.module.path, line, column))
        activity = self.activity
        held, conditional = len(activity.holding), activity.conditional
        is_lost = _is_lost(function, node, self.awaited)
        body: list[Item] = []
        try:
            with self.block() as body:
                if isinstance(function.node, ast.Lambda):
                    self.gives_to_rclpy(function.node.body)
                    return self.evaluate(function.node.body, inner)
                ends = self.execute(function.node.body, inner)
        finally:
            activity.conditional = conditional
            if function.name != "__enter__":
                del activity.holding[held:]
            self.trail.pop()
            self.calls.pop()
            if body:
                activity.block.append(Called(body))
                activity.is_lost |= is_lost
        if "falls" in ends:
            inner.returns.append(Const(None))
        result = join(inner.returns)
        self.plain.keep(function, result, body)
        return result

    def _raise_again(self, function: Function, node: ast.AST, frame: Frame) -> None:
        """Record the errors that a call may raise whose function is not followed again."""
        errors = self.plain.errors(function)
        if not errors:
            return
        self.trail.append((frame.module.path, getattr(node, "lineno", 0), getattr(node, "col_offset", 0)))
        with self.block() as body, self.perhaps():
            for each in errors:
                self._run_Raise(each, function.frame)
        self.trail.pop()
        self.activity.block.append(Called(body))

    def _bind(self, function: Function, args: list[Value], keys: dict[str, Value], inner: Frame) -> None:
        """Assign arguments or defaults to parameters."""
        wanted = function.node.args
        named = [each.arg for each in (*wanted.posonlyargs, *wanted.args)]
        inner.names.update(zip(named, args, strict=False))
        if wanted.vararg is not None:
            inner.names[wanted.vararg.arg] = Items(list(args[len(named) :]), kind="tuple")
        known = {*named, *(each.arg for each in wanted.kwonlyargs)}
        rest = Mapping()
        for key, value in keys.items():
            if key in known:
                inner.names[key] = value
            else:
                rest.items[key] = value
        if wanted.kwarg is not None:
            inner.names[wanted.kwarg.arg] = rest
        for name in known:
            if name not in inner.names:
                inner.names[name] = function.defaults.get(name) or Open(name)

    # ------------------------------------------------------------------------------------------------ modules

    def module_frame(self, module: Module, *, is_script: bool = False) -> Frame:
        """Return the variables of a module, which runs on first use."""
        found = self.frames.get(module.path)
        if found is not None:
            return found
        frame = self.frames[module.path] = Frame(module)
        holder = frame.holder = Holder()
        name = "__main__" if is_script else module.stem
        self.write_slot(holder, "__name__", Const(name))
        self.write_slot(holder, "__file__", Const(module.path, "variable"))
        kept, self.calls = self.calls, []
        try:
            self.execute(module.tree.body, frame)
        finally:
            self.calls = kept
        return frame

    def read_slot(self, holder: Holder, name: str) -> Value | None:
        """Return an attribute; the name of a module is certain."""
        if name == "__name__" and name in holder.slots:
            return holder.slots[name].current
        return super().read_slot(holder, name)

    def described(self, function: Value) -> tuple[str, Place | None, bool]:
        """Return the name of a callback, its first line, and whether it is asynchronous."""
        if isinstance(function, Partial):
            return self.described(function.function)
        if isinstance(function, Bound):
            return self.described(function.function)
        if isinstance(function, Function):
            name = function.name
            if isinstance(function.node, ast.Lambda):
                body = function.node.body
                inner = body.func if isinstance(body, ast.Call) else None
                if isinstance(inner, ast.Attribute) and isinstance(inner.value, ast.Name):
                    name = f"lambda -> {inner.attr}"
                elif isinstance(inner, ast.Name):
                    name = f"lambda -> {inner.id}"
            is_async = isinstance(function.node, ast.AsyncFunctionDef)
            if function.original is not None:
                return *self.described(function.original)[:2], is_async
            return name, Place(function.frame.module.path, function.node.lineno), is_async
        if isinstance(function, Object):
            inner_call = self.look_up(function.cls, "__call__")
            if inner_call is not None:
                return self.described(inner_call)
        if isinstance(function, Either):
            for each in function.options:
                if not is_none(each):
                    return self.described(each)
        if isinstance(function, OutsideMethod):
            at = function.at if function.is_followed else None
            return function.text or function.name, at, False
        if isinstance(function, Outside):
            return function.path, None, False
        return (function.text if isinstance(function, Open) else "open"), None, False


def _is_unknown(method: OutsideMethod, instance: Object) -> bool:
    """Return whether no class of an object can have a method, although the classes are known."""
    if method.name.startswith("__") or instance.node is not None or instance.made is not None:
        return False
    return instance.cls.is_complete() and all(path.startswith(_EMPTY) for path in instance.cls.outside())


_EMPTY = ("abc.", "builtins.object", "object", "typing.", "Protocol", "Generic")
"""Bases outside of the folder that give no methods."""
CHANGES = frozenset(
    (
        *("append", "appendleft", "add", "extend", "insert", "put", "put_nowait", "update", "setdefault"),
        *("pop", "popleft", "popitem", "remove", "discard", "clear", "get_nowait", "set", "fill"),
    )
)
"""Methods that change their object, if it is a container."""


def _is_lost(function: Function, node: ast.AST, awaited: ast.AST | None) -> bool:
    """Return whether the body of a function does not run at its call: generators, decorators, tasks."""
    if any(each.rpartition(".")[2] not in _PLAIN for each in function.decorators):
        return True
    if isinstance(function.node, ast.AsyncFunctionDef) and node not in (awaited, function.node):
        return True
    return _is_generator(function)


def _is_generator(function: Function) -> bool:
    """Return whether a call of a function runs nothing of its body yet."""
    known: bool | None = getattr(function.node, "is_generator", None)
    if known is None:
        known = not isinstance(function.node, ast.Lambda) and _yields(function.node.body)
        function.node.is_generator = known  # type: ignore[union-attr]
    return known


def _yields(parts: Sequence[ast.AST]) -> bool:
    """Return whether code has a ``yield`` that is not in a function inside it."""
    return any(
        isinstance(each, (ast.Yield, ast.YieldFrom))
        or (not isinstance(each, _INNER) and _yields(list(ast.iter_child_nodes(each))))
        for each in parts
    )


_INNER = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)


_PLAIN = frozenset(("staticmethod", "classmethod", "property", "override", "abstractmethod"))
"""Decorators that do not change a function."""
