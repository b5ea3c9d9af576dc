"""Determines from the text of a loop in Python whether its own progress may end it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator

from dineros.sources.unknown_ends import OF_TIME

_OF_TIME = re.compile(OF_TIME, re.IGNORECASE)
_SLEEPS = re.compile(r"sleep(_for|_until)?$")
_TAKE = ("pop", "popleft", "popitem", "read", "readline")
"""Methods that change their object, wherever they stand."""
_QUIET = (
    *("sleep", "publish", "get_logger", "print", "str", "int", "float", "ok", "publish_feedback"),
    *("debug", "info", "warn", "warning", "error", "get_clock", "now", "to_msg"),
    *("wait_for_service", "wait_for_server", "service_is_ready", "server_is_ready"),
)
"""Functions and methods that leave attributes of the program alone, and do not raise to end a loop."""
_LOOPS = (ast.While, ast.For, ast.AsyncFor)
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)


def sleeps_itself(loop: ast.While) -> bool:
    r"""Return whether a loop sleeps in its own body, or has no inner loop that does so instead.

    Examples
    --------
    >>> sleeps_itself(ast.parse("while a(): rate.sleep()").body[0])
    True
    >>> sleeps_itself(ast.parse("while a():\n  for i in b: time.sleep(1)").body[0])
    False
    """
    own = list(_own_parts(loop))
    is_simple = not any(isinstance(each, _LOOPS) for each in own)
    return is_simple or any(
        isinstance(each, ast.Call) and _SLEEPS.search(ast.unparse(each.func)) for each in own
    )


def is_quiet(loop: ast.While) -> bool:
    r"""Return whether the body of a loop only sleeps, publishes, writes into the log, and makes messages.

    Examples
    --------
    >>> is_quiet(ast.parse("while a:\n  self.get_logger().info('waits')\n  time.sleep(1)").body[0])
    True
    >>> is_quiet(ast.parse("while a:\n  item = items.get_nowait()").body[0])
    False
    """
    calls = (each for each in _own_parts(loop) if isinstance(each, ast.Call))
    names = [ast.unparse(each.func).rpartition(".")[2] for each in calls]
    return all(name in _QUIET or name[:1].isupper() for name in names) and not any(
        isinstance(each, (ast.Yield, ast.YieldFrom, ast.Await)) for each in _own_parts(loop)
    )


def stored_names(loop: ast.While) -> frozenset[str]:
    """Return the names of variables that the body of a loop assigns."""
    return frozenset(
        each.id
        for each in _own_parts(loop)
        if isinstance(each, ast.Name) and not isinstance(each.ctx, ast.Load)
    )


def makes_progress(loop: ast.While, tests: Iterable[ast.expr]) -> bool:
    r"""Return whether tests that end a loop ask for time, or for something that its body changes.

    A variable that only keeps what a call has returned shows no progress.

    Examples
    --------
    >>> loop = ast.parse("while not done:\n  sleep(1)\n  done = arm.arrived()").body[0]
    >>> makes_progress(loop, [loop.test])
    False
    >>> loop = ast.parse("while items:\n  sleep(1)\n  items.pop()").body[0]
    >>> makes_progress(loop, [loop.test])
    True
    """
    asked: set[str] = set()
    for test in tests:
        if _OF_TIME.search(ast.unparse(test)):
            return True
        asked |= {ast.unparse(each) for each in ast.walk(test) if isinstance(each, (ast.Name, ast.Attribute))}
    return not asked.isdisjoint(_changed(loop))


def _changed(loop: ast.While) -> Iterator[str]:
    """Yield the texts of variables and attributes that the body of a loop changes."""
    for each in _own_parts(loop):
        if isinstance(each, (ast.AugAssign, ast.For)):
            yield ast.unparse(each.target)
        elif isinstance(each, ast.Assign) and not isinstance(_positive(each.value), ast.Call):
            for target in each.targets:
                yield from (ast.unparse(part) for part in ast.walk(target) if isinstance(part, ast.expr))
        elif isinstance(each, ast.Expr) and isinstance(each.value, ast.Call):
            function = each.value.func
            if isinstance(function, ast.Attribute) and isinstance(function.value, ast.Name):
                yield function.value.id  # a method of a variable, such as `items.pop()`
        elif isinstance(each, ast.Call) and isinstance(each.func, ast.Attribute) and each.func.attr in _TAKE:
            yield ast.unparse(each.func.value)


def _positive(value: ast.expr) -> ast.expr:
    return value.operand if isinstance(value, ast.UnaryOp) else value


def _own_parts(loop: ast.While) -> Iterator[ast.AST]:
    """Yield the parts of a loop's body, inner loops without their bodies, and nothing of functions in it."""
    todo: list[ast.AST] = list(reversed(loop.body))
    while todo:
        part = todo.pop()
        yield part
        if not isinstance(part, (*_LOOPS, *_FUNCTIONS)):
            todo += reversed(list(ast.iter_child_nodes(part)))
