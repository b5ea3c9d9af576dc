"""Conditions on fields of messages and responses in C++, and what callbacks publish and answer."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from dineros.sources.branches import (
    FALSE,
    TRUE,
    Answered,
    Anything,
    Block,
    Branch,
    Condition,
    Do,
    Give,
    Joined,
    Negated,
    Received,
    Turns,
    conditions,
    constant,
    walk,
)
from dineros.sources.cpp.following.answers import FunctionText
from dineros.sources.cpp.following.calls import Calls
from dineros.sources.cpp.following.expressions import named
from dineros.sources.cpp.parsing import nodes_in, path_of, text_of
from dineros.sources.cpp.values import Const, Frame, Made
from dineros.sources.facts import CallbackFact, Effect
from dineros.sources.variables import Known

if TYPE_CHECKING:
    from tree_sitter import Node

_FUTURES = ("SharedFuture", "shared_future", "auto")
"""In the types of parameters that are the future of a response."""
_PART = re.compile(r"(\w+)_(Request|Response)")
_WHOLE = re.compile(r"-?(0|[1-9][0-9]{0,19})")
_MOST_CASES = 40
"""Limit of the cases of a ``switch`` whose order is followed."""


class Fields(Calls):
    """The part of the interpreter that records which fields of responses are asked and assigned."""

    def _text(self, routine: Node) -> FunctionText:
        """Return the text of a function; it is looked through once."""
        if routine.id not in self._texts:
            self._texts[routine.id] = FunctionText(routine)
        return self._texts[routine.id]

    def condition(self, node: Node, frame: Frame) -> Condition:
        """Return the condition of an expression that was evaluated; unknown parts may hold or not."""
        if node.type in ("parenthesized_expression", "condition_clause"):
            inner = named(node)
            return self.condition(inner[0], frame) if len(inner) == 1 else Anything()
        if node.type == "unary_expression" and text_of(node.child_by_field_name("operator")) in ("!", "not"):
            argument = node.child_by_field_name("argument")
            return Anything() if argument is None else Negated(self.condition(argument, frame))
        if node.type == "field_expression":
            return self._field_asked(node, frame) or Anything()
        if node.type != "binary_expression":
            return Anything()
        left, right = node.child_by_field_name("left"), node.child_by_field_name("right")
        sign = text_of(node.child_by_field_name("operator"))
        if left is None or right is None:
            return Anything()
        if sign in ("&&", "||", "and", "or"):
            both = [self.condition(left, frame), self.condition(right, frame)]
            return Joined(both, sign in ("||", "or"))
        if sign not in ("==", "!="):
            return Anything()
        found = self._compared(left, right, frame) or self._compared(right, left, frame)
        if found is None:
            return Anything()
        return Negated(found) if sign == "!=" else found

    def chosen(self, node: Node, cases: list[Node], blocks: dict[int, Block], frame: Frame) -> Block:
        """Return what a ``switch`` does, with what follows the label of each case."""
        asked = named(node.child_by_field_name("condition"))
        inside = nodes_in(node.child_by_field_name("body"), without=("lambda_expression",))
        if any(each.type == "continue_statement" for each in inside) or len(cases) > _MOST_CASES:
            self.is_lost = True
            return []
        following = [
            [one for at in range(first, len(cases)) for one in blocks.get(at, [])]
            for first in range(len(cases))
        ]
        labels = [each.child_by_field_name("value") for each in cases]
        is_default = [
            each.type == "case_statement" and label is None for each, label in zip(cases, labels, strict=True)
        ]
        rest: Block = following[is_default.index(True)] if True in is_default else []
        for at in reversed(range(len(cases))):
            label = labels[at]
            if label is not None:
                holds = self._compared(asked[0], label, frame) if len(asked) == 1 else None
                rest = [Branch(holds or Anything(), following[at], rest)]
        return [Turns([rest])]

    def gives(self, node: Node, frame: Frame) -> None:
        """Record that the callback of a service assigns a field of its response."""
        left, right = node.child_by_field_name("left"), node.child_by_field_name("right")
        if left is None or right is None or left.type != "field_expression" or len(self.calls) != 1:
            return
        if self.role != "service" or frame.routine is None:
            return
        text = self._text(frame.routine)
        holder, name = left.child_by_field_name("argument"), text.response()
        field = text_of(left.child_by_field_name("field"))
        if name is None or text_of(holder) != name or field not in text.assigned(name):
            return
        at, known = self.place(left, frame), self._fixed(right, frame)
        test = self.condition(right, frame) if known is None else Anything()
        inner = test.condition if isinstance(test, Negated) else test
        if known is not None or (isinstance(inner, Anything) and not isinstance(inner, (Answered, Received))):
            self.block.append(Give(field, known, at))
        else:
            self.block.append(Branch(test, [Give(field, TRUE, at)], [Give(field, FALSE, at)]))

    def body_of(self, fact: CallbackFact, routine: Node | None) -> Block | None:
        """Return the branches of a callback that has been read; None: not known, or not needed.

        They are needed if a field decides, or if the callback sleeps.
        """
        block = self.block
        asks = any(isinstance(each, (Answered, Received)) for each in conditions(block))
        gives = [each for each in walk(block) if isinstance(each, Give)]
        done = {id(each.effect): each.effect for each in walk(block) if isinstance(each, Do)}
        if self.is_lost or not (asks or gives or any(each.do == "sleep" for each in done.values())):
            return None
        if any(id(each) not in done for each in fact.effects):
            return None
        if gives and routine is not None:
            text = self._text(routine)
            name = text.response()
            seen = {(each.name, each.at.line) for each in gives}
            wanted = {} if name is None else text.assigned(name)
            for each in gives:
                if any((each.name, line) not in seen for line in wanted.get(each.name, ())):
                    each.value = None
        return block

    def sends(self, effect: Effect, call: Node, frame: Frame, *, is_new: bool) -> None:
        """Record the fields of a published message that have one value each time."""
        nodes = {} if frame.routine is None else self._text(frame.routine).sent(call)
        values = {name: self._fixed(value, frame) for name, value in nodes.items()}
        known = {name: value for name, value in values.items() if value is not None}
        before = known if is_new else effect.sends
        effect.sends = {name: value for name, value in before.items() if known.get(name) == value}

    def _compared(self, asked: Node, value: Node, frame: Frame) -> Answered | Received | None:
        """Return the condition that a field of a message or response has a value; None: of something else."""
        while asked.type == "parenthesized_expression" and len(named(asked)) == 1:
            asked = named(asked)[0]
        found = self._field_asked(asked, frame) if asked.type == "field_expression" else None
        known = None if found is None else self._fixed(value, frame)
        if found is None or known is None:
            return None
        found.values = frozenset((known,))
        return found

    def _field_asked(self, node: Node, frame: Frame) -> Answered | Received | None:
        """Return the condition that a field of a message or a response is true; None: of something else."""
        if frame.routine is None:
            return None
        text = self._text(frame.routine)
        if self.role == "subscription" and len(self.calls) == 1 and self.entity is not None:
            is_own = self.entity.callbacks.get("callback") is self.fact
            if is_own and text.asked_message(node):
                return Received(name=text_of(node.child_by_field_name("field")), at=self.place(node, frame))
        future = text.asked_future(node)
        if future is None:
            return None
        name, at = text_of(node.child_by_field_name("field")), self.place(node, frame)
        parameters = text.parameters()
        if future in [each for each, _ in parameters]:
            is_first = len(self.calls) == 1 and self.role == "done callback" and parameters[0][0] == future
            if not is_first or not any(each in parameters[0][1] for each in _FUTURES):
                return None
            started = [
                each
                for node in self.nodes
                for one in node.callbacks
                for each in one.effects
                if each.then is self.fact
            ]
            if len({id(each.entity) for each in started}) != 1 or started[0].do != "call":
                return None
            return Answered(name=name, call=started[0], starts=True, at=at)
        made = frame.values.get(future)
        effect = made.effect if isinstance(made, Made) and made.path == "future" else None
        if effect is None or effect.do != "call" or effect not in self.fact.effects:
            return None
        return Answered(name=name, call=effect, at=at) if text.asks(effect.at.line) else None

    def _fixed(self, node: Node, frame: Frame) -> Known | None:
        """Return the truth value, whole number or constant of an interface that an expression names."""
        if node.type in ("true", "false"):
            return TRUE if node.type == "true" else FALSE
        if node.type == "number_literal" or (
            node.type == "unary_expression" and text_of(node).startswith("-")
        ):
            return constant(int(text_of(node))) if _WHOLE.fullmatch(text_of(node)) else None
        if node.type != "qualified_identifier":
            return None
        if isinstance(self.value(node, frame), Const):
            return None  # a constant of the folder
        scope, _, name = path_of(node).rpartition("::")
        path = _PART.sub(r"\1::\2", self.type_text_of(scope, frame))
        return ("outside", f"{path}::{name}".replace("::", ".")) if name.isupper() else None
