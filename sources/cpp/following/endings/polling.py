"""Loops of C++ that wait until another callback changes a member, as in ``while (!ready_) { sleep }``."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dineros.sources.cpp.declarators import name_of
from dineros.sources.cpp.parsing import nodes_in, path_of, text_of
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
_WHOLE = re.compile(r"[0-9]{1,20}")
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
    *(
        "c_str",
        "str",
        "get_goal",
        "is_canceling",
        "is_active",
        "is_executing",
        "get_name",
        "count_subscribers",
        "count_publishers",
        "service_is_ready",
    ),
}
"""Functions that change no member and run no callback."""
_PURE = {
    *("abs", "fabs", "sqrt", "hypot", "pow", "min", "max", "atan2", "floor", "round", "norm", "distance"),
    *("load", "empty", "size", "length", "has_value", "test", "count", "front", "back", "at", "value", "get"),
    *("find", "end", "begin", "c_str", "compare"),
}
"""Functions whose value changes only with their arguments and their object."""
_WORD = re.compile(r"(?P<before>\.|->)?\b(?P<name>[A-Za-z_]\w*(?:::\w+)*)(?P<call>\s*\()?")
_SPINS = re.compile(r"spin(_(some|all|once|node_\w+|until_\w+))?")
"""Functions that run callbacks."""
_DEPTH = 3
"""Methods that call each other, in a loop, that are looked through."""
_LEAVES = ("break_statement", "return_statement", "throw_statement", "goto_statement", "co_return_statement")


@dataclass(frozen=True)
class Polled:
    """A member that a loop waits for."""

    holder: str
    """The first name of the expression: the member, or one that has it."""
    name: str
    """The member."""
    value: str = ""
    """The value with which it is compared; empty: something else is tested."""
    is_equal: bool = True
    """Whether the loop ends when it is equal."""

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


def polled_members(
    loop: Node,
    meaning: Callable[[str], str],
    bodies: Callable[[str], list[Node]],
    kind: Callable[[str], str],
) -> list[Polled]:
    """Return the members that a loop waits for; none: it may do something else, or end otherwise.

    Parameters
    ----------
    meaning : callable
        Returns what a test means: of a method that only returns a member, that member.
    bodies : callable
        Returns the bodies of the methods of this object with a name.
    kind : callable
        Returns what a name is: ``member``, ``local`` for a variable of the function, or empty.

    Notes
    -----
    Each part of its condition is a test of members, or asks whether the program shall end. Its body does not
    change these members, runs no callbacks, and ends the loop by such tests only.
    """
    body, asked = loop.child_by_field_name("body"), text_of(loop.child_by_field_name("condition")).strip()
    if body is None or loop.child_by_field_name("update") is not None:
        return []
    if asked.startswith("("):
        asked = asked.removeprefix("(").removesuffix(")")
    tests = [(each.strip(), False) for each in re.split(r"&&|\|\|", asked) if not _OK.fullmatch(each.strip())]
    todo = [body]
    while todo:
        each = todo.pop()
        if each.type in _LEAVES:
            return []
        if each.type == "if_statement" and _ends(each):
            condition = text_of(each.child_by_field_name("condition"))[1:-1].strip()
            if not _NOT_OK.fullmatch(condition):
                tests += [(one.strip(), True) for one in re.split(r"&&|\|\|", condition)]
            continue
        todo += each.named_children
    made = _declared(body)

    def inside(name: str) -> str:
        return "local" if name in made else kind(name)

    found: list[Polled] = []
    for asked, is_negated in tests:
        test = meaning(asked)
        one = _tested(test, negated=is_negated)
        is_known = one is not None and (one.name == CANCELED or kind(one.holder) == "member")
        more = [one] if one is not None and is_known else _depends_on(test, kind, _assigned(body))
        if not more:
            return []
        found += more
    return found if all(_only_waits(body, each, bodies, inside, _DEPTH) for each in found) else []


def _declared(body: Node) -> set[str]:
    """Return the variables that code declares with a value."""
    return {name_of(each) for each in nodes_in(body) if each.type == "init_declarator"}


def _assigned(body: Node) -> set[str]:
    """Return the first names of what code assigns."""
    found: set[str] = set()
    for each in nodes_in(body):
        if each.type in ("assignment_expression", "update_expression", "init_declarator"):
            names = ("left", "argument", "declarator")
            target = next((one for one in map(each.child_by_field_name, names) if one is not None), None)
            found |= set(re.findall(r"\w+", text_of(target)))
    return found


def _depends_on(test: str, kind: Callable[[str], str], assigned: set[str]) -> list[Polled]:
    """Return the members on which alone the value of a test depends; none: it depends on something else."""
    found: list[Polled] = []
    for each in _WORD.finditer(re.sub(r'"[^"]*"', "", test)):
        before, name, is_called = each["before"], each["name"], bool(each["call"])
        last = name.rpartition("::")[2]
        if is_called and last not in _PURE:
            return []
        if before or is_called or "::" in name or name in ("this", "true", "false", "nullptr", "NULL"):
            continue
        if kind(name) == "member":
            found.append(Polled(name, name))
        elif kind(name) != "local" or name in assigned:
            return []
    return found


def _only_waits(
    body: Node,
    polled: Polled,
    bodies: Callable[[str], list[Node]],
    kind: Callable[[str], str],
    depth: int,
) -> bool:
    """Return whether code does not run callbacks and does not change what a loop waits for.

    Methods of local variables that this object does not have change only these. Nothing in a loop requests
    to cancel a goal, so other code may do anything but run callbacks there.
    """
    for each in nodes_in(body):
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
        root = re.split(r"\.|->|::", path)[0]
        is_own = re.fullmatch(r"(?:this->)?\w+", path) is not None
        inner = bodies(name) if is_own or kind(root) == "local" else []
        if _SPINS.fullmatch(name) or (not inner and "spin" in name.lower()):
            return False
        if inner and depth:
            if not all(_only_waits(one, polled, bodies, lambda _: "", depth - 1) for one in inner):
                return False
        elif polled.name != CANCELED and (is_own or kind(root) != "local"):
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
    number = int(value) if sign and _WHOLE.fullmatch(value) else None
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
