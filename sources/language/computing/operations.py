"""Applies operators to partly known values: strings, sums and tests."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from dineros.sources.branches import Anything, Branch
from dineros.sources.language.computing.constants import format_text
from dineros.sources.language.machine import Machine
from dineros.sources.language.modules import LARGE, text_of_code
from dineros.sources.language.values import (
    Bound,
    Class,
    Const,
    Either,
    Frame,
    Function,
    Items,
    Made,
    Mapping,
    Object,
    Open,
    Outside,
    Port,
    RunningNode,
    Text,
    Value,
    hole,
    is_none,
    join,
    options,
    spread,
)

OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.BitOr: operator.or_,
    ast.BitAnd: operator.and_,
}
COMPARED: dict[type, Callable[[Any, Any], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_MOST_TEXT = 10_000

Verdict = tuple[bool | None, str]
"""Whether a test holds, and the origin of this result: empty if it is certain."""


class Operations(Machine):
    """The part of the interpreter that evaluates operators."""

    # ----------------------------------------------------------------------------------------- texts and sums

    def _value_of_JoinedStr(self, node: ast.JoinedStr, frame: Frame) -> Value:  # noqa: N802
        parts: list[Value] = []
        for each in node.values:
            if isinstance(each, ast.FormattedValue):
                value = self.evaluate(each.value, frame)
                value = self.shown(value, each, frame, "__format__")
                if each.format_spec is not None and isinstance(value, Const):
                    spec = self.evaluate(each.format_spec, frame)
                    value = format_text("{:" + hole(spec) + "}", [value], {})
                if not all(isinstance(option, (Const, Text)) for option in options(value)):
                    value = Open(short(each.value))
                parts.append(value)
            else:
                parts.append(self.evaluate(each, frame))
        return spread(parts, joined)

    def shown(self, value: Value, node: ast.AST, frame: Frame, *first: str) -> Value:
        """Return the text of an object whose class makes it, or else the value."""
        for name in (*first, "__str__", "__repr__"):
            args: list[Value] = [Const("")] if name == "__format__" else []
            found = self.special(value, name, args, node, frame)
            if found is not None:
                return found
        return value

    def special(
        self, value: Value, name: str, args: list[Value], node: ast.AST, frame: Frame
    ) -> Value | None:
        """Call a method that Python calls without a name; None: no class of the program has it."""
        able = [
            (each, method)
            for each in options(value)
            if isinstance(each, Object) and isinstance(method := self.look_up(each.cls, name), Function)
        ]
        if len(able) == 1 and able[0][0] is value:
            return self.call(Bound(able[0][1], value), args, {}, node, frame)
        found: list[Value] = []
        for each, method in able:
            with self.perhaps():
                found.append(self.call(Bound(method, each), list(args), {}, node, frame))
        return join([*found, Open(short(node))]) if found else None

    def augmented(
        self, op: ast.operator, left: Value, right: Value, node: ast.AST, frame: Frame
    ) -> Value | None:
        """Return what ``left += right`` assigns; None: no class of the program says it."""
        name = _SPECIAL.get(type(op))
        if name is None or not isinstance(left, (Object, Either)):
            return None
        found = self.special(left, f"__i{name}__", [right], node, frame)
        return self.special(left, f"__{name}__", [right], node, frame) if found is None else found

    def _value_of_BinOp(self, node: ast.BinOp, frame: Frame) -> Value:  # noqa: N802
        left, right = self.evaluate(node.left, frame), self.evaluate(node.right, frame)
        name = _SPECIAL.get(type(node.op))
        if name is not None and isinstance(left, (Object, Either)):
            found = self.special(left, f"__{name}__", [right], node, frame)
            if found is not None:
                return found
        if name is not None and isinstance(right, (Object, Either)):
            found = self.special(right, f"__r{name}__", [left], node, frame)
            if found is not None:
                return found
        if isinstance(node.op, ast.Mod):
            for each in right.items if isinstance(right, Items) else [right]:
                self.shown(each, node, frame)
        return spread([left, right], lambda each: self.combined(node.op, each[0], each[1], short(node)))

    def combined(self, op: ast.operator, left: Value, right: Value, text: str) -> Value:
        """Return the value of an operation."""
        if isinstance(left, Const) and isinstance(right, Const):
            if isinstance(op, ast.Div) and isinstance(left.value, str) and isinstance(right.value, str):
                return Const(f"{left.value}/{right.value}", left.origin or right.origin)  # of paths
            function = OPERATORS.get(type(op))
            if function is not None and _is_small(left.value, op) and _is_small(right.value, op):
                try:
                    return Const(function(left.value, right.value), left.origin or right.origin)
                except (TypeError, ValueError, ArithmeticError):
                    return Open(text)
        if isinstance(op, ast.BitOr) and isinstance(left, Mapping) and isinstance(right, Mapping):
            rest = [*left.rest, *right.rest]
            return Mapping({**left.items, **right.items}, rest, left.is_open or right.is_open)
        if isinstance(op, ast.Mult) and isinstance(left, Items):
            return Items(list(left.items), True, left.kind)
        if isinstance(op, ast.Add):
            if isinstance(left, Items) and isinstance(right, Items):
                return Items([*left.items, *right.items], left.is_open or right.is_open, left.kind)
            texts = [each for each in (left, right) if isinstance(each, (Const, Text))]
            if texts and all(isinstance(each, Text) or isinstance(each.value, str) for each in texts):
                return joined([left, right])
        if isinstance(op, ast.Mod) and isinstance(left, Const) and isinstance(left.value, str):
            args = right.items if isinstance(right, Items) else [right]
            pieces = left.value.split("%s")
            if len(pieces) == len(args) + 1 and "%" not in "".join(pieces):
                mixed: list[Value] = [Const(pieces[0])]
                for arg, piece in zip(args, pieces[1:], strict=True):
                    mixed += [arg, Const(piece)]
                return joined(mixed)
        return Open(text)

    def _value_of_UnaryOp(self, node: ast.UnaryOp, frame: Frame) -> Value:  # noqa: N802
        value = self.evaluate(node.operand, frame)
        if isinstance(node.op, ast.Not):
            self._asked_for_truth(value, node, frame)
            verdict, origin = self.truth(value)
            return Open(short(node)) if verdict is None else Const(not verdict, origin)
        if (
            isinstance(node.op, ast.USub)
            and isinstance(value, Const)
            and isinstance(value.value, (int, float))
        ):
            return Const(-value.value, value.origin)
        of_class = self.special(value, _UNARY.get(type(node.op), "__neg__"), [], node, frame)
        return Open(short(node)) if of_class is None else of_class

    # -------------------------------------------------------------------------------------------------- tests

    def truth(self, value: Value) -> Verdict:
        """Return whether a value is true, and the origin of this result; None: unknown."""
        if isinstance(value, Const):
            return bool(value.value), value.origin
        if isinstance(value, Items) and not value.is_open:
            return bool(value.items), "variable"
        if isinstance(value, Mapping) and not value.is_open:
            return bool(value.items), "variable"
        if isinstance(value, Object):
            own = [self.look_up(value.cls, each) for each in ("__bool__", "__len__")]
            return (True, "") if own == [None, None] else (None, "")
        if isinstance(value, (Port, Function, Bound, Class, RunningNode)):
            return True, ""
        if isinstance(value, Made):
            return True, "variable"
        return None, ""

    def decide(self, test: ast.expr, frame: Frame) -> Verdict:
        """Evaluate a test; return whether it holds."""
        value = self.evaluate(test, frame)
        self._asked_for_truth(value, test, frame)
        return self.truth(value)

    def _asked_for_truth(self, value: Value, node: ast.AST, frame: Frame) -> None:
        """Call the method that says whether an object is true."""
        if isinstance(value, (Object, Either)):
            found = self.special(value, "__bool__", [], node, frame)
            if found is None:
                self.special(value, "__len__", [], node, frame)

    def _value_of_Compare(self, node: ast.Compare, frame: Frame) -> Value:  # noqa: N802
        values = [self.evaluate(each, frame) for each in (node.left, *node.comparators)]
        if len(values) != 2:
            for op, left, right in zip(node.ops, values, values[1:], strict=False):
                name = _SPECIAL.get(type(op))
                if name in _REFLECTED and isinstance(left, (Object, Either)):
                    self.special(left, f"__{name}__", [right], node, frame)
                if name in _REFLECTED and isinstance(right, (Object, Either)):
                    self.special(right, f"__{_REFLECTED[name]}__", [left], node, frame)
            return Open(short(node))
        (left, right), op = values, node.ops[0]
        name = _SPECIAL.get(type(op))
        holder, other = (right, left) if name == "contains" else (left, right)
        if name is not None and isinstance(holder, (Object, Either)):
            found = self.special(holder, f"__{name}__", [other], node, frame)
            if found is not None:
                return found if name != "contains" else Open(short(node))
        if name is not None and isinstance(other, (Object, Either)) and name in _REFLECTED:
            found = self.special(other, f"__{_REFLECTED[name]}__", [holder], node, frame)
            if found is not None:
                return found
        if name in _ORDER and isinstance(holder, Object):  # ``functools.total_ordering``
            for each in _ORDER:
                if (found := self.special(holder, f"__{each}__", [other], node, frame)) is not None:
                    return Open(short(node))
        if name == "contains":
            self.drawn(holder, node, frame)
            if isinstance(holder, Mapping) or (isinstance(holder, Items) and holder.kind == "set"):
                self.hashed(other, node, frame)
        if isinstance(op, (ast.Is, ast.IsNot)) and is_none(right):
            if isinstance(left, Const):
                verdict = (left.value is None) == isinstance(op, ast.Is)
                return Const(verdict, left.origin)
            if isinstance(
                left, (Object, Port, Function, Bound, Class, RunningNode, Items, Mapping, Made, Outside)
            ):
                return Const(
                    isinstance(op, ast.IsNot), "" if not isinstance(left, (Made, Outside)) else "variable"
                )
            return Open(short(node))
        if isinstance(left, Const) and isinstance(right, Const) and type(op) in COMPARED:
            try:
                return Const(bool(COMPARED[type(op)](left.value, right.value)), left.origin or right.origin)
            except TypeError:
                return Open(short(node))
        if isinstance(op, (ast.In, ast.NotIn)) and isinstance(left, Const):
            if isinstance(right, Outside) and right.path == "sys.argv" and str(left.value).startswith("-"):
                return Const(isinstance(op, ast.NotIn), "environment command line")  # without options
            known = right.items if isinstance(right, Items) and not right.is_open else None
            constants = [each for each in known or () if isinstance(each, Const)]
            if known is not None and len(constants) == len(known):
                is_in = any(left.value == each.value for each in constants)
                origin = left.origin or next((each.origin for each in constants if each.origin), "")
                return Const(is_in == isinstance(op, ast.In), origin)
        return Open(short(node))

    def _value_of_BoolOp(self, node: ast.BoolOp, frame: Frame) -> Value:  # noqa: N802
        is_or = isinstance(node.op, ast.Or)
        found: list[Value] = []
        asked = self.operands[id(node)] = []
        count = 0
        try:
            for index, each in enumerate(node.values):
                with self.block() as done:
                    value = self.evaluate(each, frame)
                asked.append(done)
                if done:
                    self.activity.block += [Branch(Anything(), done, [])] if index else done
                verdict, origin = self.truth(value)
                is_last = index == len(node.values) - 1
                if verdict is None or is_last:
                    found.append(value)
                elif verdict == is_or:
                    found.append(value)
                    if not origin or origin.startswith(("parameter", "environment")):
                        break
                elif origin and not origin.startswith(("parameter", "environment")):
                    found.append(value)
                if not is_last:
                    self.activity.conditional += 1
                    count += 1
        finally:
            self.activity.conditional -= count
        return join(found)

    def _value_of_IfExp(self, node: ast.IfExp, frame: Frame) -> Value:  # noqa: N802
        verdict, origin = self.decide(node.test, frame)
        if verdict is not None and not origin:
            return self.evaluate(node.body if verdict else node.orelse, frame)
        is_setting = origin.startswith(("parameter", "environment"))
        values = []
        for is_body, part in ((True, node.body), (False, node.orelse)):
            is_off = is_setting and verdict is not is_body
            with self.perhaps(is_disabled=is_off):
                value = self.evaluate(part, frame)
            if not is_off:
                values.append(value)
        found = join(values)
        return (
            Const(found.value, found.origin or origin) if is_setting and isinstance(found, Const) else found
        )


def joined(parts: list[Value]) -> Value:
    """Concatenate texts; unknown parts are in braces."""
    text = "".join(hole(each) for each in parts)[:_MOST_TEXT]
    if all(isinstance(each, Const) for each in parts):
        origin = next((each.origin for each in parts if isinstance(each, Const) and each.origin), "")
        return Const(text, origin)
    return Text(text)


def _is_small(value: object, op: ast.operator) -> bool:
    """Return whether a value can be used in calculations: not for products of strings or huge numbers."""
    if isinstance(value, (str, bytes)):
        return isinstance(op, ast.Add) and len(value) < _MOST_TEXT
    return isinstance(value, (bool, float)) or (isinstance(value, int) and abs(value) < LARGE)


def short(node: ast.AST) -> str:
    """Return a short text of an expression."""
    known = text_of_code(node)
    return known if len(known) <= 80 else f"{known[:77]}..."


_ORDER = ("lt", "le", "gt", "ge")
_REFLECTED = {"lt": "gt", "gt": "lt", "le": "ge", "ge": "le", "eq": "eq", "ne": "ne"}
_UNARY = {ast.USub: "__neg__", ast.UAdd: "__pos__", ast.Invert: "__invert__"}
_SPECIAL: dict[type[ast.AST], str] = {
    **{ast.Pow: "pow", ast.FloorDiv: "floordiv", ast.BitXor: "xor"},
    **{ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.Div: "truediv", ast.Mod: "mod"},
    **{ast.BitOr: "or", ast.BitAnd: "and", ast.RShift: "rshift", ast.LShift: "lshift", ast.MatMult: "matmul"},
    **{ast.Eq: "eq", ast.NotEq: "ne", ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge"},
    **{ast.In: "contains", ast.NotIn: "contains"},
}
"""Methods of operators, without underscores."""
