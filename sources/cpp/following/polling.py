"""Loops of C++ that wait until another callback changes a member, as in ``while (!ready_) { sleep }``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from dineros.sources.cpp.parsing import path_of, text_of
from dineros.sources.facts import Effect

if TYPE_CHECKING:
    from tree_sitter import Node

    from dineros.sources.cpp.following.machine import Machine

POLLED = "polled, without time-out"
CHANGES = {
    *("store", "exchange", "push", "push_back", "push_front", "emplace", "emplace_back", "insert", "set"),
    *("clear", "fetch_add", "fetch_sub", "fetch_or", "test_and_set", "swap", "assign"),
}
"""Methods of the standard library that change their object."""

_MEMBER = re.compile(
    r"!?\s*\(*(?:this->)?(\w+)(?:\.(?:load|empty|has_value)\(\)|\.size\(\))?\s*"
    r"(?:(?:==|!=|<=?|>=?)\s*(?:true|false|nullptr|NULL|\d+))?\)*"
)
_OK = re.compile(r"(?:rclcpp::)?ok\([^()]*\)")
_HARMLESS = {
    *("sleep_for", "sleep_until", "sleep", "yield", "usleep", "nanosleep", "ok", "get_logger", "get_clock"),
    *("hours", "minutes", "seconds", "milliseconds", "microseconds", "nanoseconds", "duration", "Duration"),
    *("load", "empty", "size", "has_value", "Rate", "WallRate"),
}
"""Functions that change no member."""
_LEAVES = ("break_statement", "return_statement", "throw_statement", "goto_statement", "co_return_statement")


def polled_member(loop: Node) -> str | None:
    """Return the member that a loop waits for; None: it may do something else, or end otherwise.

    Each part of its condition is a test of this member, or asks whether the program shall end. Its body only
    sleeps and writes into the log.
    """
    body, asked = loop.child_by_field_name("body"), text_of(loop.child_by_field_name("condition")).strip()
    if body is None or "||" in asked:
        return None
    asked = asked.removeprefix("(").removesuffix(")")
    parts = [each.strip() for each in asked.split("&&")]
    tests = [each for each in parts if not _OK.fullmatch(each)]
    found = [_MEMBER.fullmatch(each) for each in tests]
    names = {each[1] for each in found if each is not None}
    if len(names) != 1 or None in found:
        return None
    todo = [body]
    while todo:
        each = todo.pop()
        if each.type in _LEAVES or each.type in ("assignment_expression", "update_expression"):
            return None
        if each.type == "call_expression":
            name = path_of(each.child_by_field_name("function")).rpartition("::")[2]
            if name.rpartition(".")[2] not in _HARMLESS and not name.startswith(("RCLCPP_", "RCUTILS_")):
                return None
        todo += each.named_children
    return names.pop()


def add_setters(machine: Machine) -> None:
    """Give each callback that changes a polled member an effect that says so.

    If code was not followed again, it is not known who else changes it, so nothing is added.
    """
    waited = {
        effect.what
        for todo in machine.todo
        for effect in todo.fact.effects
        if (effect.do, effect.how) == ("wait", POLLED)
    }
    for name in waited if not machine.skipped else ():
        for fact in machine.changed.get(name, {}).values():
            fact.effects.append(Effect("notify", name, fact.at, "conditional"))
