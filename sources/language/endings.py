"""Determines from the code of a loop how it ends: never, or with an event that it waits for."""

from __future__ import annotations

import ast
import re

NO_IFS: frozenset[ast.If] = frozenset()


def why_endless(node: ast.While, never: frozenset[ast.If] = NO_IFS) -> str:
    """Return why a loop without a test may never end; empty if it may end, or waits in each iteration.

    The bodies of `never` are not run.
    """
    exits: list[ast.If | None] = []
    stored, has_call = set(), False
    todo: list[tuple[ast.AST, ast.If | None, bool]] = [(each, None, False) for each in node.body]
    while todo:
        part, under, is_inside = todo.pop()
        if part in never:
            todo += [(each, under, is_inside) for each in part.orelse]
            continue
        if isinstance(part, (ast.Return, ast.Raise)) or (isinstance(part, ast.Break) and not is_inside):
            exits.append(under)
        if isinstance(part, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)):
            continue
        if isinstance(part, (ast.Name, ast.Attribute)) and isinstance(part.ctx, ast.Store):
            stored.add(ast.unparse(part))
        if isinstance(part, (ast.Yield, ast.YieldFrom)):
            return ""  # what asks for values may stop
        if isinstance(part, ast.Try):
            return ""  # an exception may be its exit
        inner = part if isinstance(part, ast.If) else under
        is_inside = is_inside or isinstance(part, (ast.While, ast.For, ast.AsyncFor))
        todo += [(child, inner, is_inside) for child in ast.iter_child_nodes(part)]
    if not exits:
        return "the loop has no exit"
    for test in exits:
        if test is None:
            return ""
        asked = {
            ast.unparse(each) for each in ast.walk(test.test) if isinstance(each, (ast.Name, ast.Attribute))
        }
        has_call |= any(isinstance(each, (ast.Call, ast.Await)) for each in ast.walk(test.test))
        if has_call or asked & stored or any(each.startswith(f"{one}.") for each in asked for one in stored):
            return ""
        own = {
            ast.unparse(each.func.value)
            for each in ast.walk(node)
            if isinstance(each, ast.Call) and isinstance(each.func, ast.Attribute)
        }
        if asked & (own - {"self"}):
            return ""
    if any(isinstance(each, ast.Await) for each in ast.walk(node)):
        return ""
    return "the conditions of its exits do not depend on anything that the loop changes"


def exits_of(node: ast.While, never: frozenset[ast.If] = NO_IFS) -> list[ast.expr] | None:
    r"""Return the tests that decide whether a loop ends; None: it may also end otherwise.

    The bodies of `never` are not run.

    Examples
    --------
    >>> loop = ast.parse("while ok(): sleep(1) if a else exit()").body[0]
    >>> exits_of(loop)
    >>> loop = ast.parse("while ok() and not a: sleep(1)").body[0]
    >>> [ast.unparse(each) for each in exits_of(loop)]
    ['ok() and (not a)']
    >>> loop = ast.parse("while True:\n  if a: continue\n  break").body[0]
    >>> [ast.unparse(each) for each in exits_of(loop)]
    ['True', 'not a']
    """
    found = [node.test]
    todo: list[tuple[ast.AST, tuple[ast.expr, ...], bool]] = _after_continues(node)
    while todo:
        part, tests, is_inside = todo.pop()
        if part in never:
            todo += [(each, tests, is_inside) for each in part.orelse]
            continue
        if isinstance(part, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)):
            continue
        is_exit = isinstance(part, (ast.Return, ast.Raise)) or (isinstance(part, ast.Break) and not is_inside)
        if is_exit or (isinstance(part, ast.Call) and ast.unparse(part.func).rpartition(".")[2] in _ENDS):
            if not tests:
                return None
            found += tests
        inner = (*tests, part.test) if isinstance(part, ast.If) else tests
        is_inside = is_inside or isinstance(part, (ast.While, ast.For, ast.AsyncFor))
        todo += [(child, inner, is_inside) for child in ast.iter_child_nodes(part)]
    return list(dict.fromkeys(found))


def _after_continues(node: ast.While) -> list[tuple[ast.AST, tuple[ast.expr, ...], bool]]:
    """Return the statements of a loop, with the tests under which no ``continue`` before them is taken."""
    found: list[tuple[ast.AST, tuple[ast.expr, ...], bool]] = []
    tests: tuple[ast.expr, ...] = ()
    for each in node.body:
        found.append((each, tests, False))
        if isinstance(each, ast.If) and isinstance(each.body[-1], ast.Continue):
            tests = (*tests, ast.copy_location(ast.UnaryOp(ast.Not(), each.test), each.test))
    return found


_ENDS = ("exit", "_exit", "shutdown", "try_shutdown")
"""Functions that end the program."""
SERVERS = ("wait_for_service", "wait_for_server")
"""Methods of clients that wait until a server is there; they return whether it is."""
TRANSFORMS = ("can_transform", "can_transform_full")
"""Methods of a buffer that return whether a transform is there."""


def asks_for_shutdown(test: ast.AST) -> bool:
    """Return whether code only asks whether ROS still runs: ``rclpy.ok()``, ``self.context.ok()``."""
    return isinstance(test, ast.Call) and _last_name(test.func) == "ok"


def runs_callbacks(node: ast.AST) -> bool:
    """Return whether code calls a function or method whose name begins with ``spin``."""
    calls = (each for each in ast.walk(node) if isinstance(each, ast.Call))
    return any(_last_name(each.func).startswith("spin") for each in calls)


def _last_name(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _awaited(test: ast.expr) -> ast.expr | None:
    """Return what the test of a loop waits for: ``x`` of ``not x`` or ``rclpy.ok() and not x``."""
    if isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And):
        rest = [each for each in test.values if not asks_for_shutdown(each)]
        return _awaited(rest[0]) if len(rest) == 1 else None
    return test.operand if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not) else None


_OF_TIME = re.compile(r"time|clock|now|elapsed|deadline|until|count|tries|attempt", re.IGNORECASE)


def may_give_up(node: ast.While, never: frozenset[ast.If] = NO_IFS) -> bool:
    """Return whether a loop that tests a future may end before that is done, as time passes.

    Either its test asks for something else, too, or an exit of its body depends on time or on a number. The
    bodies of `never` are not run.

    Examples
    --------
    >>> may_give_up(ast.parse("while rclpy.ok() and not f.done(): sleep(1)").body[0])
    False
    >>> may_give_up(ast.parse("while not f.done() and time() < end: sleep(1)").body[0])
    True
    """
    if _awaited(node.test) is None:
        return True
    return any(
        isinstance(each, ast.If)
        and each not in never
        and _OF_TIME.search(ast.unparse(each.test)) is not None
        and any(isinstance(exit, (ast.Break, ast.Return, ast.Raise)) for exit in ast.walk(each))
        for each in ast.walk(node)
    )


def waits_for(
    node: ast.While, methods: tuple[str, ...] = SERVERS, never: frozenset[ast.If] = NO_IFS
) -> ast.Attribute | None:
    """Return the method of a loop that ends only once it returns true, or at shutdown.

    It is the test of the loop, or that of its way out: ``if x: break``. None: it may end otherwise. The
    bodies of `never` are not run.

    Examples
    --------
    >>> loop = ast.parse("while ok() and not c.wait_for_service(1.0): print('waiting')").body[0]
    >>> ast.unparse(waits_for(loop))
    'c.wait_for_service'
    >>> waits_for(ast.parse("while not c.wait_for_service(1.0): break").body[0])
    """
    test, rest = _awaited(node.test), list[ast.AST](node.body)
    if asks_for_shutdown(node.test) or ast.unparse(node.test) in ("True", "1"):
        choices = [each for each in node.body if isinstance(each, ast.If)]
        for each in choices[:1]:
            if isinstance(each.body[-1], (ast.Break, ast.Return)):
                test, rest = each.test, [one for one in rest if one is not each] + list(each.orelse)
    if not (
        isinstance(test, ast.Call) and isinstance(test.func, ast.Attribute) and test.func.attr in methods
    ):
        return None
    todo = rest
    while todo:
        part = todo.pop()
        if part in never or (isinstance(part, ast.If) and any(map(asks_for_shutdown, ast.walk(part.test)))):
            todo += part.orelse  # or it ends at shutdown
        elif isinstance(part, (ast.Break, ast.Return, ast.Raise)) or (
            isinstance(part, ast.Call) and ast.unparse(part.func).rpartition(".")[2] in ("exit", "_exit")
        ):
            return None
        else:
            todo += ast.iter_child_nodes(part)
    return test.func
