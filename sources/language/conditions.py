"""Finds the attributes that callbacks set to constants and test, as far as the program shows it."""

from __future__ import annotations

import ast
import re

from dineros.sources.branches import (
    FALSE,
    OTHER,
    SOME,
    TRUE,
    Accepted,
    Answered,
    Anything,
    Branch,
    Compared,
    Condition,
    Do,
    Give,
    Joined,
    Negated,
    Put,
    Received,
    constant,
)
from dineros.sources.facts import CallbackFact, Item
from dineros.sources.language.activities import Activity
from dineros.sources.language.fields.messages import is_only_read
from dineros.sources.language.fields.responses import asked_call, asked_future, response_of
from dineros.sources.language.importing import Imports
from dineros.sources.language.values import (
    Bound,
    Class,
    Const,
    Either,
    Frame,
    Function,
    Future,
    Goal,
    Message,
    Object,
    Outside,
    Port,
    Response,
    Value,
    options,
)
from dineros.sources.places import Place
from dineros.sources.variables import Known, Variable

_RESPONSE = re.compile(r"\w+\.srv\.\w+\.Response")
"""Path of the class of a service's responses."""
_SIMPLE = (bool, int, str, type(None))
"""Types of constants that a variable of a model may have."""


class Conditions(Imports):
    """The part of the interpreter that records which attributes are set and tested."""

    # ------------------------------------------------------------------------------------------------ tests

    def condition(self, test: ast.expr, frame: Frame, before: list[Item] | None = None) -> Condition:
        """Return the condition of a test, after it was evaluated; unknown parts may hold or not.

        Parameters
        ----------
        frame : Frame
            Its variables.
        before : list of Item
            Effects of its evaluation.
        """
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            return Negated(self.condition(test.operand, frame, before))
        if isinstance(test, ast.BoolOp):
            done = self.operands.get(id(test), [])
            parts = [self.condition(each, frame, one) for each, one in zip(test.values, done, strict=False)]
            return Joined(
                [*parts, *([Anything()] if len(parts) < len(test.values) else [])],
                isinstance(test.op, ast.Or),
            )
        if before:
            return self._called_and_asked(test, frame, before) or Anything(before)
        if isinstance(test, ast.Attribute):
            return self._asked(test, frame)
        if isinstance(test, ast.Compare) and len(test.ops) == 1:
            return self.compared(test.left, test.ops[0], test.comparators[0], frame)
        return Anything()

    def _asked(self, test: ast.Attribute, frame: Frame) -> Condition:
        field = self._field(test, frame)
        if field is not None:
            return field
        value = self.alone(test.value, frame)
        if isinstance(value, Goal) and value.side == "client" and test.attr == "accepted":
            return Accepted(value.entity)
        variable = self._attribute(value, test.attr)
        return Anything() if variable is None else Compared(variable, "==", self.place(test, frame))

    def _field(self, test: ast.Attribute, frame: Frame) -> Received | Answered | None:
        """Return the condition that a field of a message or a response is true; None: of something else."""
        if self._is_received(test, frame):
            return Received(name=test.attr, at=self.place(test, frame))
        value = self.alone(test.value, frame)
        return self._answered(test, value, frame) if isinstance(value, Response) else None

    def _is_received(self, test: ast.Attribute, frame: Frame) -> bool:
        """Return whether a test asks a field of the message that the callback has received, unchanged."""
        if not isinstance(test.value, ast.Name) or len(self.calls) != 1 or test.attr.startswith("_"):
            return False
        value, function = frame.names.get(test.value.id), frame.function
        return (
            isinstance(value, Message)
            and value.entity is not None
            and value.entity.callbacks.get("callback") is self.activity.fact
            and function is self.calls[0]
            and is_only_read(function.node, test.value.id)
        )

    def _answered(self, test: ast.Attribute, value: Response, frame: Frame) -> Answered | None:
        """Return the condition of a test that asks a field of a response that a client has received."""
        effect, function = value.effect, frame.function
        if effect is None or function is None or test.attr.startswith("_"):
            return None
        at = self.place(test, frame)
        if asked_call(function.node, test.value) is not None:
            return Answered(name=test.attr, call=effect, at=at)
        is_first = len(self.calls) == 1 and function is self.calls[0] and effect.then is self.activity.fact
        if is_first and asked_future(function.node, test.value) is not None:
            return Answered(name=test.attr, call=effect, starts=True, at=at)
        return None

    def _called_and_asked(self, test: ast.expr, frame: Frame, before: list[Item]) -> Condition | None:
        """Return the condition of ``self.client.call(request).success``, whose call has been read."""
        if not isinstance(test, ast.Attribute) or test.attr.startswith("_") or frame.function is None:
            return None
        if isinstance(test.value, ast.Name) or asked_call(frame.function.node, test.value) is None:
            return None
        (first, *others) = before
        if others or not isinstance(first, Do) or first.effect.do != "call":
            return None
        return Answered(before, test.attr, first.effect, at=self.place(test, frame))

    def gives(self, target: ast.Attribute, expr: ast.expr | None, frame: Frame) -> None:
        """Record that the callback of a service assigns a field of its response."""
        function = frame.function
        if function is None or len(self.calls) != 1 or function is not self.calls[0]:
            return
        if self.activity.fact.kind != "service" or not isinstance(target.value, ast.Name):
            return
        value, found = frame.names.get(target.value.id), response_of(function.node)
        if not isinstance(value, Response) or value.effect is not None or found is None:
            return
        if target.value.id != found[0] or target.attr not in found[1]:
            return
        at, test = self.place(target, frame), None
        known = None if expr is None else self.fixed(expr, frame)
        if known is None and expr is not None:
            test = (
                self._asked(expr, frame)
                if isinstance(expr, ast.Attribute)
                else self._truth_value(expr, frame)
            )
        if test is None or isinstance(test, Anything):
            self.activity.block.append(Give(target.attr, known, at))
            return
        yes, no = (Give(target.attr, each, at) for each in (TRUE, FALSE))
        self.activity.block.append(Branch(test, [yes], [no]))

    def returns(self, expr: ast.expr | None, frame: Frame) -> None:
        """Record that the callback of a service returns another response than its parameter."""
        function = frame.function
        if function is None or len(self.calls) != 1 or function is not self.calls[0]:
            return
        found = response_of(function.node) if self.activity.fact.kind == "service" else None
        if found is None or expr is None or (isinstance(expr, ast.Name) and expr.id == found[0]):
            return
        at = self.place(expr, frame)
        self.activity.block.append(Give("", None, at))
        if not isinstance(expr, ast.Call) or expr.args or any(each.arg is None for each in expr.keywords):
            return
        made = self.alone(expr.func, frame) if isinstance(expr.func, ast.Attribute) else None
        if not isinstance(made, Outside) or made.is_star or not _RESPONSE.fullmatch(made.path):
            return
        for each in expr.keywords:
            self.activity.block.append(Give(str(each.arg), self.fixed(each.value, frame), at))

    def fixed(self, expr: ast.expr, frame: Frame) -> Known | None:
        """Return the truth value, whole number or constant of an interface that an expression names."""
        known = self._known(expr, None, frame)
        if known is None or known[0] not in ("const", "outside"):
            return None
        return known if known[0] == "outside" or isinstance(known[2], int) else None

    def compared(self, left: ast.expr, operator: ast.cmpop, right: ast.expr, frame: Frame) -> Condition:
        """Return the condition of a comparison."""
        return self._field_compared(left, operator, right, frame) or self._variable_compared(
            left, operator, right, frame
        )

    def _field_compared(
        self, left: ast.expr, operator: ast.cmpop, right: ast.expr, frame: Frame
    ) -> Condition | None:
        """Return the condition of a comparison of a field with constants; None: of another comparison."""
        pairs = [(left, right)]
        if isinstance(operator, (ast.Eq, ast.NotEq)):
            pairs.append((right, left))
        elif not isinstance(operator, (ast.In, ast.NotIn)):
            return None
        for asked, other in pairs:
            field = self._field(asked, frame) if isinstance(asked, ast.Attribute) else None
            if field is None:
                continue
            several = isinstance(operator, (ast.In, ast.NotIn))
            if several and not isinstance(other, (ast.Tuple, ast.List, ast.Set)):
                return Anything()
            values = [self.fixed(each, frame) for each in (other.elts if several else [other])]  # type: ignore[attr-defined]
            known = [each for each in values if each is not None]
            if len(known) < len(values):
                return Anything()
            field.values = frozenset(known)
            return Negated(field) if isinstance(operator, (ast.NotEq, ast.NotIn)) else field
        return None

    def _variable_compared(
        self, left: ast.expr, operator: ast.cmpop, right: ast.expr, frame: Frame
    ) -> Condition:
        if isinstance(operator, (ast.Eq, ast.NotEq)) and not isinstance(left, ast.Attribute):
            left, right = right, left
        variable = None
        if isinstance(left, ast.Attribute):
            variable = self._attribute(self.alone(left.value, frame), left.attr)
        if variable is None:
            return Anything()
        at = self.place(left, frame)
        if isinstance(operator, (ast.In, ast.NotIn)) and isinstance(right, (ast.Tuple, ast.List, ast.Set)):
            parts = [self._known(each, None, frame) for each in right.elts]
            if any(part is None for part in parts):
                return Anything()
            found: Condition = Joined([Compared(variable, "==", at, part) for part in parts], is_or=True)
            return found if isinstance(operator, ast.In) else Negated(found)
        known = self._known(right, None, frame)
        if known in (None, SOME, OTHER):
            return Anything()
        if isinstance(operator, (ast.Eq, ast.NotEq)):
            found = Compared(variable, "==", at, known)
        elif isinstance(operator, (ast.Is, ast.IsNot)):
            found = Compared(variable, "is", at, known)
        else:
            return Anything()
        return Negated(found) if isinstance(operator, (ast.NotEq, ast.IsNot)) else found

    def alone(self, node: ast.expr, frame: Frame) -> Value | None:
        """Return the value of an expression that is evaluated again; None: several values, or effects."""
        aside = Activity(CallbackFact("test", "test", self.activity.fact.at), self.activity.node)
        with self.doing(aside):
            value = self.evaluate(node, frame)
        return None if aside.block or aside.is_lost or isinstance(value, Either) else value

    def _attribute(self, value: Value | None, name: str) -> Variable | None:
        """Return the variable of an attribute of an object; None: not a variable."""
        if not isinstance(value, Object) or isinstance(self.look_up(value.cls, name), Function):
            return None
        return self.attributes.of(value, name, Place("", 0))

    # ----------------------------------------------------------------------------------------------- values

    def put(
        self,
        holder: Object,
        name: str,
        value: Value,
        expr: ast.expr | None,
        node: ast.AST,
        frame: Frame,
        *,
        is_certain: bool,
    ) -> None:
        """Record an assignment to an attribute of an object; if not certain, it may be another object."""
        at, activity = self.place(node, frame), self.activity
        variable = self.attributes.of(holder, name, at)
        values = self._values(value, expr, frame)
        if not self.run and activity.fact.kind == "constructor" and not self.attributes.has_begun:
            is_certain &= not (activity.conditional or activity.loops)
            self.attributes.begin(variable, values, at, is_certain=is_certain)
            return
        test = self._truth_value(expr, frame) if expr is not None and values is None else None
        found: Item = Put(variable, values, at)
        if test is not None:
            yes, no = (Put(variable, (constant(each),), at) for each in (True, False))
            found = Branch(test, [yes], [no])
        activity.block.append(found if is_certain else Branch(Anything(), [found], []))

    def _truth_value(self, expr: ast.expr, frame: Frame) -> Condition | None:
        """Return the condition of an expression: ``not self.busy``, ``self.mode == 1``."""
        is_test = isinstance(expr, ast.Compare) or (
            isinstance(expr, ast.UnaryOp) and isinstance(expr.op, ast.Not)
        )
        found = self.condition(expr, frame) if is_test else None
        while isinstance(found, Negated) and isinstance(found.condition, Negated):
            found = found.condition.condition
        inner = found.condition if isinstance(found, Negated) else found
        return None if isinstance(inner, Anything) else found

    def _values(self, value: Value, expr: ast.expr | None, frame: Frame) -> tuple[Known, ...] | None:
        known = self._known(expr, value, frame)
        if known is not None:
            return (known,)
        found = [self._known(None, each, frame) for each in options(value)]
        return None if None in found or OTHER in found else tuple(dict.fromkeys(e for e in found if e))

    def _known(self, expr: ast.expr | None, value: Value | None, frame: Frame) -> Known | None:
        """Return a constant, or `SOME`; None: unknown."""
        if isinstance(expr, ast.Constant):
            return constant(expr.value) if isinstance(expr.value, _SIMPLE) else None
        if isinstance(expr, (ast.Attribute, ast.Name)):
            found = self._named(expr, frame)
            if found is not None:
                return found
        if isinstance(value, Const):
            return None if value.origin else simple(value)
        if isinstance(value, Object):
            names = [self.look_up(value.cls, each) for each in ("__bool__", "__len__", "__eq__")]
            return SOME if names == [None, None, None] else None
        if isinstance(value, (Goal, Future, Port, Function, Bound)):
            return SOME
        return None

    def _named(self, expr: ast.Attribute | ast.Name, frame: Frame) -> Known | None:
        """Return a named constant: a member of an enumeration, a constant of a class or module."""
        name = expr.attr if isinstance(expr, ast.Attribute) else expr.id
        if not name.isupper():
            return None
        value = self.alone(expr, frame)
        owner = self.alone(expr.value, frame) if isinstance(expr, ast.Attribute) else None
        if isinstance(owner, Class):
            if any(path.startswith("enum.") for path in owner.outside()):
                member = value.value if isinstance(value, Const) else name
                return ("member", owner.node.name, repr(member)) if name in owner.names else None
            return simple(self.look_up(owner, name))
        if isinstance(owner, Object):
            return None if name in owner.slots else simple(self.look_up(owner.cls, name))
        if isinstance(value, Outside):
            return ("outside", value.path)
        is_fixed = isinstance(expr, ast.Name) and self._is_constant(name, frame)
        return simple(value) if is_fixed else None

    def _is_constant(self, name: str, frame: Frame) -> bool:
        """Return whether a variable of a module has one value in the whole program."""
        here: Frame | None = frame
        while here is not None:
            holder = here.holder
            if holder is not None:
                return name in holder.slots and len(holder.slots[name].values) == 1
            if name in here.names:
                return False
            here = here.outer
        return False


def simple(value: Value | None) -> Known | None:
    """Return a constant as a value of a variable; None: not a constant that a model may have."""
    is_simple = isinstance(value, Const) and isinstance(value.value, _SIMPLE)
    return constant(value.value) if is_simple else None  # type: ignore[union-attr]
