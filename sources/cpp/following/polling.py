"""Loops of C++ that wait until another callback changes a member, as in ``while (!ready_) { sleep }``."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dineros.sources.cpp.parsing import path_of, text_of
from dineros.sources.cpp.values import Const, Made, Value

if TYPE_CHECKING:
    from tree_sitter import Node

POLLED = "polled, without time-out"
CHANGES = {
    **dict.fromkeys(("push", "push_back", "push_front", "emplace", "emplace_back", "insert"), "true"),
    **dict.fromkeys(("pop", "pop_front", "pop_back", "erase", "clear"), "false"),
    **dict.fromkeys(("store", "exchange", "set", "assign", "swap"), ""),
    **dict.fromkeys(("fetch_add", "fetch_sub", "fetch_or", "fetch_and"), ""),
    "test_and_set": "true",
}
"""Methods of the standard library that change their object, with what it becomes; empty: not known.

What adds items makes it true, and what removes items may make it false.
"""

_MEMBER = re.compile(
    r"(!?)\s*\(*(?:this->)?((?:\w+(?:\.|->))*\w+)"
    r"((?:\.|->)(?:load\([\w:]*\)|(?:empty|has_value|size|length|test)\(\)))?\s*"
    r'(?:(==|!=|<=?|>=?)\s*((?:\w+::)*\w+|"[^"\\]*"))?\)*'
)
CANCELED = "a request to cancel the goal"
"""What a loop waits for if it asks whether the goal is to be cancelled."""
_CANCELED = re.compile(r"(!?)\s*\w+->is_canceling\(\)")
_OK = re.compile(r"(?:rclcpp::)?ok\([^()]*\)|true|1|")
_NOT_OK = re.compile(r"!\s*(?:rclcpp::)?ok\([^()]*\)")
_FALSE = ("false", "nullptr", "NULL", "0")
_HARMLESS = {
    *("sleep_for", "sleep_until", "sleep", "yield", "usleep", "nanosleep", "ok", "get_logger", "get_clock"),
    *("hours", "minutes", "seconds", "milliseconds", "microseconds", "nanoseconds", "duration", "Duration"),
    *("load", "empty", "size", "length", "has_value", "test", "Rate", "WallRate"),
    *("publish", "publish_feedback", "sendTransform", "now", "make_shared", "make_unique", "to_string"),
    *("c_str", "str", "get_goal", "get_name", "count_subscribers", "count_publishers", "service_is_ready"),
}
"""Functions that change no member and run no callback."""
_SPINS = re.compile(r"spin(_(some|all|once|node_\w+|until_\w+))?")
"""Functions that run callbacks."""
_DEPTH = 3
"""Methods that call each other, in a loop, that are looked through."""
_LEAVES = ("break_statement", "return_statement", "throw_statement", "goto_statement", "co_return_statement")


@dataclass(frozen=True)
class Polled:
    """A member that a loop waits for.

    Attributes
    ----------
    holder : str
        The first name of the expression: the member, or one that has it.
    name : str
        The member.
    value : str
        The value with which it is compared; empty: something else is tested.
    is_equal : bool
        Whether the loop ends when it is equal.
    """

    holder: str
    name: str
    value: str = ""
    is_equal: bool = True

    def may_end_at(self, value: str) -> bool:
        """Return whether the loop may end when the member has a value; empty: any value."""
        if value and self.value.startswith('"'):
            value = '""' if value == "false" else value  # it was cleared
            return not value.startswith('"') or (value == self.value) == self.is_equal
        is_enumerator = "::" in value and "::" in self.value
        if not value or not self.value or not (is_enumerator or {value, self.value} <= {"true", "false"}):
            return True
        return (value == self.value) == self.is_equal


def value_in_words(value: Value | None) -> str:
    """Return a value to compare with a member: ``true``, an enumerator, a quoted text; empty: another."""
    if isinstance(value, Const) and isinstance(value.value, str):
        return f'"{value.value}"'
    if isinstance(value, Const):
        is_negative = isinstance(value.value, (int, float)) and value.value < 0
        return "" if is_negative else "true" if value.value else "false"
    return value.path if isinstance(value, Made) and not value.args and "::" in value.path else ""


def polled_member(
    loop: Node, meaning: Callable[[str], str], bodies: Callable[[str], list[Node]]
) -> Polled | None:
    """Return the member that a loop waits for; None: it may do something else, or end otherwise.

    `meaning` returns what a test means: of a method that only returns a member, that member. `bodies` returns
    the bodies of the methods of this object with a name.

    Each part of its condition is a test of this member, or asks whether the program shall end. Its body does
    not change the member, runs no callbacks, and ends the loop by such tests only.
    """
    body, asked = loop.child_by_field_name("body"), text_of(loop.child_by_field_name("condition")).strip()
    if body is None or "||" in asked or loop.child_by_field_name("update") is not None:
        return None
    if asked.startswith("("):
        asked = asked.removeprefix("(").removesuffix(")")
    parts = [each.strip() for each in asked.split("&&")]
    found = [_tested(meaning(each)) for each in parts if not _OK.fullmatch(each)]
    todo = [body]
    while todo:
        each = todo.pop()
        if each.type in _LEAVES:
            return None
        if each.type == "if_statement" and _ends(each):
            condition = text_of(each.child_by_field_name("condition"))[1:-1].strip()
            if not _NOT_OK.fullmatch(condition):
                found.append(_tested(meaning(condition), negated=True))
            continue
        todo += each.named_children
    polled = found[0] if len({each and each.name for each in found}) == 1 else None
    return polled if polled is not None and _only_waits(body, polled, bodies, _DEPTH) else None


def _only_waits(body: Node, polled: Polled, bodies: Callable[[str], list[Node]], depth: int) -> bool:
    """Return whether code does not run callbacks and does not change what a loop waits for.

    Nothing in a loop requests to cancel a goal, so other code may do anything but run callbacks there.
    """
    todo = [body]
    while todo:
        each = todo.pop()
        todo += each.named_children
        if each.type in ("assignment_expression", "update_expression"):
            target = each.child_by_field_name("left") or each.child_by_field_name("argument")
            if {polled.holder, polled.name} & set(re.findall(r"\w+", text_of(target))):
                return False
        if each.type != "call_expression":
            continue
        path = path_of(each.child_by_field_name("function"))
        name = re.split(r"\.|->|::", path)[-1]
        if name in _HARMLESS or name.startswith(("RCLCPP_", "RCUTILS_")) or "msg::" in path:
            continue
        inner = bodies(name) if re.fullmatch(r"(?:this->)?\w+", path) else []
        if _SPINS.fullmatch(name) or (not inner and "spin" in name.lower()):
            return False
        if inner and depth:
            if not all(_only_waits(one, polled, bodies, depth - 1) for one in inner):
                return False
        elif polled.name != CANCELED:
            return False
    return True


def _ends(statement: Node) -> bool:
    """Return whether a statement only ends its loop under a condition."""
    body = statement.child_by_field_name("consequence")
    inner = [] if body is None else body.named_children if body.type == "compound_statement" else [body]
    last = next((each.type for each in reversed(inner) if each.type != "comment"), "")
    return statement.child_by_field_name("alternative") is None and last in _LEAVES


def _tested(asked: str, *, negated: bool = False) -> Polled | None:
    """Return the member that the condition of a loop tests; if negated, of ending the loop."""
    found = _CANCELED.fullmatch(asked)
    if found is not None:
        return Polled(CANCELED, CANCELED, "false", (found[1] != "!") != negated)
    found = _MEMBER.fullmatch(asked)
    if found is None:
        return None
    mark, name, method, sign, value = found.groups(default="")
    is_equal = (sign == "==") == (mark == "!") if sign else mark != "!"
    number = int(value) if sign and value.isdigit() else None
    if sign in ("<", "<=", ">", ">=") and number is not None:
        is_equal, value = sign.startswith(">"), "false" if number <= 1 or sign.startswith("<") else ""
    elif number is not None and number > 0:
        value = ""
    else:
        value = "false" if not sign or value in _FALSE else value
    if method.endswith("empty()"):
        is_equal = not is_equal
    parts = re.split(r"\.|->", name)
    return Polled(parts[0], parts[-1], value, is_equal != negated)
