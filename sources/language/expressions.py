"""Evaluates expressions to their possible values."""

from __future__ import annotations

import ast
from dataclasses import replace

from dineros.sources.language.computing.constants import call_constant
from dineros.sources.language.computing.names import Names
from dineros.sources.language.computing.operations import short
from dineros.sources.language.machine import TooLong
from dineros.sources.language.modules import Module, text_of_code
from dineros.sources.language.values import (
    Bound,
    Class,
    Const,
    Either,
    Frame,
    Function,
    Future,
    Goal,
    Holder,
    Items,
    Made,
    Mapping,
    ModuleValue,
    Object,
    Open,
    Outside,
    OutsideMethod,
    Partial,
    Response,
    SuperOf,
    Text,
    Value,
    is_none,
    join,
    options,
)

_NAMES = {each: f"_value_of_{each.__name__}" for each in ast.expr.__subclasses__()}
"""Names of the methods that evaluate expressions."""


class Expressions(Names):
    """The part of the interpreter that evaluates expressions."""

    def evaluate(self, node: ast.expr, frame: Frame) -> Value:
        """Return the value of an expression; its effects are recorded."""
        self.steps += 1  # as `step`, without a call for each expression
        if self.steps > self.most_steps:
            raise TooLong
        method = getattr(self, _NAMES[type(node)], None)
        if method is None:
            for child in ast.iter_child_nodes(node):
                if isinstance(child, ast.expr):
                    self.evaluate(child, frame)
            return Open(short(node))
        value: Value = method(node, frame)
        return value

    def _value_of_Constant(self, node: ast.Constant, _frame: Frame) -> Value:  # noqa: N802
        return Const(node.value)

    def _value_of_Attribute(self, node: ast.Attribute, frame: Frame) -> Value:  # noqa: N802
        value = self.evaluate(node.value, frame)
        return self.attribute(value, node.attr, short(node), node, frame)

    def attribute(self, value: Value, name: str, text: str, node: ast.AST, frame: Frame) -> Value:
        """Return an attribute of a value, including methods."""
        if isinstance(value, Object) and name != "__dict__":
            own = value.cls.own_reading
            if own is None or name.startswith("__") or any(each.node is own.node for each in self.calls):
                return self.plain_attribute(value, name, text, node, frame)
            return self.call(Bound(own, value), [Const(name)], {}, node, frame)
        if isinstance(value, Either):
            return join(
                self.attribute(each, name, text, node, frame) for each in value.options if not is_none(each)
            )
        if isinstance(value, Outside):
            return self.library.attribute(value, name) or Outside(f"{value.path}.{name}")
        if isinstance(value, ModuleValue):
            return self.member(value.module, name) or Open(text)
        if isinstance(value, SuperOf):
            of = value.instance
            cls = of.cls if isinstance(of, Object) else of if isinstance(of, Class) else None
            found = self.look_up(cls, name, value.cls) if cls is not None else None
            if found is None and isinstance(of, Class) and of.meta is not None:
                found = self.look_up(of.meta, name, value.cls)
            if isinstance(found, Function) and _is_property(found):
                return self.call(Bound(found, value.instance), [], {}, node, frame)
            return (
                Bound(found, value.instance)
                if isinstance(found, Function)
                else found or OutsideMethod(value, name, text)
            )
        if isinstance(value, Class):
            found = self.look_up(value, name)
            if found is None and value.meta is not None and name not in _OF_INSTANCES:
                found = self.look_up(value.meta, name)
                if isinstance(found, Function):
                    return Bound(found, value)
            if found is None and name == "__members__" and value.is_enum():
                return Mapping(
                    {key: as_member(each, value) for key, each in value.names.items() if key[:1] != "_"}
                )
            if found is None:
                return Const(value.node.name) if name == "__name__" else OutsideMethod(value, name, text)
            found = join(_wrapped(each) for each in options(found))
            if value.is_enum() and not name.startswith("_"):
                found = as_member(found, value)
            if isinstance(found, Function) and "classmethod" in found.decorators:
                return Bound(found, value)
            return found
        if isinstance(value, (Bound, Function)):
            inner = value.function if isinstance(value, Bound) else value
            if name in inner.attributes:
                return inner.attributes[name]
            of_code = _of_code(value, name)
            if of_code is not None:
                return of_code
        if name == "__dict__" and isinstance(value, (Object, Made)):
            return Mapping(
                {key: self.read_slot(value, key) or Open(key) for key in value.slots}, holder=value
            )
        return self.plain_attribute(value, name, text, node, frame)

    def plain_attribute(self, value: Value, name: str, text: str, node: ast.AST, frame: Frame) -> Value:
        """Return an attribute of an object, without its own ``__getattribute__``."""
        if isinstance(value, Holder):
            slot = self.read_slot(value, name)
            if slot is not None:
                return self._or_of_class(slot, value, name, node, frame)
        if isinstance(value, Object):
            found = self.look_up(value.cls, name)
            if found is not None:
                return join(self._of_class(each, value, node, frame) for each in options(found))
            if name == "__class__":
                return value.cls
            given = None if value.cls.outside() else self.look_up(value.cls, "__getattr__")
            if isinstance(given, Function):
                return self.call(Bound(given, value), [Const(name)], {}, node, frame)
        enum = value.enum if isinstance(value, (Const, Made)) else None
        method = self.look_up(enum, name) if enum is not None else None
        if isinstance(method, Function):
            if _is_property(method):
                return self.call(Bound(method, value), [], {}, node, frame)
            return method if "staticmethod" in method.decorators else Bound(method, value)
        if name in ("value", "_value_") and isinstance(value, (Function, Items, Partial)):
            return value  # of a member of an enumeration
        known = self.library.attribute(value, name)
        if known is not None:
            return known
        if (
            isinstance(value, Open)
            and (name == "value" or name.endswith("_value"))
            and value.text.startswith("parameter")
        ):
            return value
        return OutsideMethod(value, name, text, self.place(node, frame))

    def _or_of_class(self, found: Value, value: Holder, name: str, node: ast.AST, frame: Frame) -> Value:
        """Return the value of an attribute, or what the class has as long as the object has none."""
        slot = value.slots[name]
        is_own = slot.run == self.run and not slot.is_mixed
        if is_own or not isinstance(value, Object) or not (slot.is_perhaps or slot.is_late):
            return found
        default = self.look_up(value.cls, name)
        if default is None or any(
            isinstance(each, Function) and _is_property(each) for each in options(default)
        ):
            return found
        return join([found, *(self._of_class(each, value, node, frame) for each in options(default))])

    def _of_class(self, found: Value, instance: Object, node: ast.AST, frame: Frame) -> Value:
        """Return what the class of an instance has under a name, for the instance: also descriptors."""
        found = _wrapped(found)
        if isinstance(found, Function):
            if _is_property(found):
                return self.call(Bound(found, instance), [], {}, node, frame)
            return found if "staticmethod" in found.decorators else Bound(found, instance)
        if isinstance(found, Made) and found.path == PROPERTY:
            getter = found.argument(0, "fget")
            return self.call(getter or Open("fget"), [instance], {}, node, frame)
        if isinstance(found, Const):
            return Const(found.value, found.origin or "variable", found.enum)
        if isinstance(found, Made) and found.path == "functools.partialmethod" and found.args:
            inner = found.args[0]
            bound = Bound(inner, instance) if isinstance(inner, Function) else inner
            return Partial(bound, found.args[1:], found.keys)
        get = self.look_up(found.cls, "__get__") if isinstance(found, Object) else None
        if isinstance(get, Function):
            return self.call(Bound(get, found), [instance, instance.cls], {}, node, frame)
        return found

    def member(self, module: Module, name: str) -> Value | None:
        """Return a variable of a module, or a module in a package."""
        frame = self.module_frame(module)
        holder = frame.holder
        found = self.read_slot(holder, name) if holder else None
        if found is None and module.path.endswith("__init__.py"):
            path = self.modules.relative(module, 1, name)
            inner = self.modules.module(path) if path else None
            return ModuleValue(inner) if inner else None
        return found

    # ---------------------------------------------------------------------------------------------- functions

    def _value_of_Lambda(self, node: ast.Lambda, frame: Frame) -> Value:  # noqa: N802
        return self.function(node, frame, None)

    def function(
        self, node: ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda, frame: Frame, owner: Class | None
    ) -> Function:
        """Return a function that is defined here."""
        args = node.args
        defaults: dict[str, Value] = {}
        named = [*args.posonlyargs, *args.args]
        for each, default in zip(named[len(named) - len(args.defaults) :], args.defaults, strict=True):
            defaults[each.arg] = self.evaluate(default, frame)
        for each, value in zip(args.kwonlyargs, args.kw_defaults, strict=True):
            if value is not None:
                defaults[each.arg] = self.evaluate(value, frame)
        decorators = (
            [] if isinstance(node, ast.Lambda) else [text_of_code(each) for each in node.decorator_list]
        )
        return Function(node, frame, owner, defaults, tuple(decorators))

    def _value_of_Await(self, node: ast.Await, frame: Frame) -> Value:  # noqa: N802
        self.awaited = node.value
        value = self.evaluate(node.value, frame)
        for each in options(value):
            if isinstance(each, Future) and each.effect is not None:
                each.effect.how = "await"
        return join(self._result(each, node, frame) for each in options(value))

    def _result(self, value: Value, node: ast.Await, frame: Frame) -> Value:
        """Return what an awaited value gives."""
        if isinstance(value, Made) and value.path.endswith(".Future"):
            return self.library.call_method(OutsideMethod(value, "__await__"), [], {}, node, frame)
        of_class = self.special(value, "__await__", [], node, frame)
        if of_class is not None:
            return self.drawn(of_class, node, frame)
        return self.result_of(value) if isinstance(value, Future) else value

    def result_of(self, future: Future) -> Value:
        """Return the result of a future."""
        if future.of == "goal":
            return Goal("client", future.entity)
        return Response("result", future.effect) if future.of == "call" else Open("result")

    def _value_of_Starred(self, node: ast.Starred, frame: Frame) -> Value:  # noqa: N802
        return self.evaluate(node.value, frame)

    def _value_of_Yield(self, node: ast.Yield, frame: Frame) -> Value:  # noqa: N802
        if node.value is not None:
            frame.returns.append(Items([self.evaluate(node.value, frame)], is_open=True))
        return Open("yield")

    def _value_of_YieldFrom(self, node: ast.YieldFrom, frame: Frame) -> Value:  # noqa: N802
        values, _ = self.turns(self.drawn(self.evaluate(node.value, frame), node, frame))
        frame.returns.append(Items(values, is_open=True))
        return Open("yield from")

    def _value_of_Call(self, node: ast.Call, frame: Frame) -> Value:  # noqa: N802
        if isinstance(node.func, ast.Name) and node.func.id == "super":
            return self._super(node, frame)
        function = self.evaluate(node.func, frame)
        args: list[Value] = []
        is_task = (
            isinstance(function, OutsideMethod)
            and function.name == "create_task"
            and _is_executor(function.instance)
        )
        for each in node.args:
            if is_task and isinstance(each, ast.Call):
                args.append(self._later_coroutine(each, frame))
            elif isinstance(each, ast.Starred):
                values, is_exact = self.turns(self.drawn(self.evaluate(each.value, frame), each.value, frame))
                args += values if is_exact else [Open(short(each))]
            else:
                args.append(self.evaluate(each, frame))
        keys: dict[str, Value] = {}
        for keyword in node.keywords:
            value = self.evaluate(keyword.value, frame)
            if keyword.arg is not None:
                keys[keyword.arg] = value
            elif isinstance(value, Mapping):
                keys |= {key: each for key, each in value.items.items() if isinstance(key, str)}
        if isinstance(function, Const) or (
            isinstance(function, OutsideMethod) and isinstance(function.instance, (Const, Text))
        ):
            args = [self.drawn(each, node, frame) for each in args]
            if isinstance(function, OutsideMethod) and function.name == "format":
                for shown in args:
                    self.shown(shown, node, frame)
            found = call_constant(function, args, keys)
            if found is not None:
                return found
        return self.call(function, args, keys, node, frame)

    def _later_coroutine(self, node: ast.Call, frame: Frame) -> Value:
        """Return a coroutine that an executor runs later; what a call returns of another function."""
        function = self.evaluate(node.func, frame)
        inner = function.function if isinstance(function, Bound) else function
        if not isinstance(inner, Function) or not isinstance(inner.node, ast.AsyncFunctionDef):
            return self.evaluate(node, frame)
        args = [self.evaluate(each, frame) for each in node.args if not isinstance(each, ast.Starred)]
        keys = {each.arg: self.evaluate(each.value, frame) for each in node.keywords if each.arg is not None}
        return Partial(function, args, keys)

    def _super(self, node: ast.Call, frame: Frame) -> Value:
        here: Frame | None = frame
        while here is not None and (here.function is None or here.function.owner is None):
            here = here.outer
        if here is None or here.function is None or here.function.owner is None or here.instance is None:
            return Open("super()")
        return SuperOf(here.instance, here.function.owner)


def _wrapped(value: Value) -> Value:
    """Return the function of ``staticmethod(function)``, with its decorator."""
    if not isinstance(value, Made) or value.path not in _WRAPPERS or not value.args:
        return value
    inner = value.args[0]
    if not isinstance(inner, Function):
        return inner
    return replace(inner, decorators=(*inner.decorators, value.path.rpartition(".")[2]))


def as_member(value: Value, cls: Class) -> Value:
    """Return a member of an enumeration, which knows its class."""
    if isinstance(value, Const):
        return Const(value.value, value.origin, cls)
    if isinstance(value, Made):
        value.enum = cls
    return value


def _of_code(value: Bound | Function, name: str) -> Value | None:
    """Return an attribute of a function or method; None: another one."""
    function = value.function if isinstance(value, Bound) else value
    if name == "__call__":
        return value
    if name == "__func__":
        return function
    if name == "__self__" and isinstance(value, Bound):
        return value.instance
    if name == "__wrapped__":
        return function.original or function
    return Const(function.name) if name in ("__name__", "__qualname__") else None


PROPERTY = "builtins.property"
"""Path of a property that a call makes, and no decorator."""
_WRAPPERS = ("builtins.staticmethod", "builtins.classmethod")
_OF_INSTANCES = ("__call__", "__init__", "__new__")
"""Methods of a metaclass that make instances of its classes."""


def _is_executor(value: Value) -> bool:
    return any(
        (isinstance(each, Made) and each.path.endswith("Executor"))
        or (isinstance(each, (Open, OutsideMethod)) and each.text.endswith("executor"))
        for each in options(value)
    )


def _is_property(function: Function) -> bool:
    return any(each.split(".")[-1] in ("property", "cached_property") for each in function.decorators)
