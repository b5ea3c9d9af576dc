"""Determines from the text of a loop in C++ what ends it: its own progress, or what is not known."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dineros.sources.cpp.declarators import name_of
from dineros.sources.cpp.parsing import nodes_in, text_of
from dineros.sources.unknown_ends import OF_TIME, UNKNOWN_END

if TYPE_CHECKING:
    from tree_sitter import Node

    _Tests = tuple[tuple[Node | None, bool], ...]

NO_EXIT = "the loop has no exit"
"""Why a loop may never end."""
_OF_TIME = re.compile(
    rf"{OF_TIME}|count|tries|attempt|retr|wait_for|future_status|FutureReturnCode", re.IGNORECASE
)
"""In tests that hold after some time, or that ask what a wait returned."""
_RUNS = re.compile(r"(\w+(::|\.|->))*ok\([^()]*\)|true|1|")
_LEAVES = ("return_statement", "throw_statement", "goto_statement", "co_return_statement")
_ENDS = re.compile(r"(std::)?(exit|_exit|abort|quick_exit|terminate)|(rclcpp::)?shutdown")
_SLEEP = re.compile(r"\bu?(nano)?sleep(_for|_until)?$")
_LOOPS = ("while_statement", "do_statement", "for_statement", "for_range_loop")
_ASKS_IN = ("if_statement", "switch_statement", "catch_clause")
_NAMES = ("identifier", "field_identifier")
_DEPTH = 3
"""Variables of variables that are looked through."""


@dataclass(frozen=True)
class _Exit:
    """A way out of a loop: tests that must hold, each with its value; None: something else decides."""

    tests: _Tests


def why_open(loop: Node, *, sleeps: bool) -> str:
    """Return why it is not known that a loop ends; empty: it ends by its own progress, or may do so.

    Parameters
    ----------
    loop : Node
        A loop of any kind.
    sleeps : bool
        Whether its body is known to sleep; calls that are named so count, too. Such a loop waits: only time,
        or a variable that it counts, ends it for certain. In another one, everything that it changes, gets or
        calls may do so.
    """
    if loop.type == "for_range_loop" or loop.child_by_field_name("update") is not None:
        return ""
    sleeps = sleeps or _sleeps(loop)
    exits = _exits(loop)
    if not exits:
        return NO_EXIT
    changed = _changed(loop, sleeps=sleeps)
    if any(
        all(_comes(test, wanted, changed, sleeps, _DEPTH) for test, wanted in each.tests) for each in exits
    ):
        return ""
    return UNKNOWN_END


def _sleeps(loop: Node) -> bool:
    """Return whether the text of a loop, without the loops in it, has a call that is named for sleeping."""
    return any(
        each.type == "call_expression" and _SLEEP.search(text_of(each.child_by_field_name("function")))
        for part in loop.named_children
        for each in nodes_in(part, without=(*_LOOPS, "lambda_expression"))
    )


def _exits(loop: Node) -> list[_Exit]:
    """Return the ways out of a loop while the program runs."""
    test, body = loop.child_by_field_name("condition"), loop.child_by_field_name("body")
    found = [] if _RUNS.fullmatch(_plain(test)) else [_Exit(((test, False),))]
    todo: list[tuple[Node, tuple[tuple[Node | None, bool], ...], bool]] = (
        [] if body is None else [(body, (), True)]
    )
    while todo:
        each, tests, is_own = todo.pop()
        if each.type in ("lambda_expression", "class_specifier", "struct_specifier"):
            continue
        is_call = each.type == "call_expression" and _ENDS.fullmatch(
            text_of(each.child_by_field_name("function"))
        )
        if each.type in _LEAVES or is_call or (each.type == "break_statement" and is_own):
            found.append(_Exit(tests))
        asked = each.child_by_field_name("condition") if each.type in _ASKS_IN else None
        is_inside = is_own and each.type not in (*_LOOPS, "switch_statement")
        for child in each.named_children:
            more = tests
            if each.type == "if_statement" and child != asked:
                more = (*tests, (asked, child != each.child_by_field_name("alternative")))
            elif each.type in (*_ASKS_IN, *_LOOPS, "try_statement") and child != asked:
                more = (*tests, (None, True))
            todo.append((child, more, is_inside))
    return [each for each in found if not any(_ends_program(*one) for one in each.tests)]


def _ends_program(test: Node | None, wanted: bool) -> bool:
    """Return whether a test says that ROS no longer runs."""
    text = _plain(test)
    is_negated = text.startswith(("!", "not "))
    asks = _RUNS.fullmatch(text.removeprefix("!").removeprefix("not ").strip())
    return bool(text) and asks is not None and wanted == is_negated


def _plain(test: Node | None) -> str:
    text = text_of(test).strip().removesuffix(";")
    while text.startswith("(") and text.endswith(")"):
        text = text[1:-1].strip()
    return text


def _changed(loop: Node, *, sleeps: bool) -> dict[str, list[Node]]:
    """Return what a loop changes, each with the expressions that it gets.

    None: it counts, or is changed in place.
    """
    found: dict[str, list[Node]] = {}
    for each in nodes_in(loop):
        if each.type == "update_expression":
            found.setdefault(_last(each.child_by_field_name("argument")), [])
        elif each.type == "assignment_expression":
            name, right = _last(each.child_by_field_name("left")), each.child_by_field_name("right")
            is_own = text_of(each.child_by_field_name("operator")) != "=" or name in _names(right)
            found.setdefault(name, []).extend([] if is_own or right is None else [right])
        elif each.type == "init_declarator":
            value = each.child_by_field_name("value")
            found.setdefault(name_of(each), []).extend([] if value is None else [value])
        elif each.type == "call_expression" and not sleeps:
            for name in _names(each):
                found.setdefault(name, [])
    return found


def _last(target: Node | None) -> str:
    names = re.findall(r"\w+", text_of(target))
    return names[-1] if names else ""


def _names(node: Node | None) -> set[str]:
    return {text_of(each) for each in nodes_in(node) if each.type in _NAMES}


def _comes(
    test: Node | None,
    wanted: bool,
    changed: dict[str, list[Node]],
    sleeps: bool,
    depth: int,
) -> bool:
    """Return whether a test has a value at some time, by the loop's own progress."""
    if test is None:
        return not sleeps  # an exception, a case, or the turn of an inner loop
    if test.type in ("parenthesized_expression", "condition_clause") and len(test.named_children) == 1:
        return _comes(test.named_children[0], wanted, changed, sleeps, depth)
    if test.type == "unary_expression" and text_of(test.child_by_field_name("operator")) in ("!", "not"):
        return _comes(test.child_by_field_name("argument"), not wanted, changed, sleeps, depth)
    sign = text_of(test.child_by_field_name("operator")) if test.type == "binary_expression" else ""
    if sign in ("&&", "and", "||", "or"):
        sides = [test.child_by_field_name(each) for each in ("left", "right")]
        needs_both = (sign in ("&&", "and")) == wanted
        join = all if needs_both else any
        return join(_comes(each, wanted, changed, sleeps, depth) for each in sides)
    text = _plain(test)
    if _RUNS.fullmatch(text):
        return wanted  # ROS runs
    if _OF_TIME.search(text) or (not sleeps and "(" in text):
        return True
    for name in _names(test) & changed.keys():
        values = changed[name]
        if (
            not values
            or not sleeps
            or (depth and any(_comes(one, True, changed, sleeps, depth - 1) for one in values))
        ):
            return True
    return False
