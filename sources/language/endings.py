"""Determines from the code of a loop how it ends: never, or with an event that it waits for."""

from __future__ import annotations

import ast


def why_endless(node: ast.While) -> str:
    """Return why a loop without a test may never end; empty if it may end, or waits in each iteration."""
    exits: list[ast.If | None] = []
    stored, has_call = set(), False
    todo: list[tuple[ast.AST, ast.If | None, bool]] = [(each, None, False) for each in node.body]
    while todo:
        part, under, is_inside = todo.pop()
        if isinstance(part, (ast.Return, ast.Raise)) or (isinstance(part, ast.Break) and not is_inside):
            exits.append(under)
        if isinstance(part, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)):
            continue
        if isinstance(part, (ast.Name, ast.Attribute)) and isinstance(part.ctx, ast.Store):
            stored.add(ast.unparse(part))
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


_SERVERS = ("wait_for_service", "wait_for_server")
"""Methods of clients that wait until a server is there; they return whether it is."""


def waits_for_server(node: ast.While) -> bool:
    """Return whether a loop ends only once a server is there, or at shutdown.

    Examples
    --------
    >>> waits_for_server(ast.parse("while not c.wait_for_service(1.0): print('waiting')").body[0])
    True
    >>> waits_for_server(ast.parse("while not c.wait_for_service(1.0): break").body[0])
    False
    """
    test = (
        node.test.operand
        if isinstance(node.test, ast.UnaryOp) and isinstance(node.test.op, ast.Not)
        else None
    )
    if not (
        isinstance(test, ast.Call) and isinstance(test.func, ast.Attribute) and test.func.attr in _SERVERS
    ):
        return False
    todo: list[ast.AST] = list(node.body)
    while todo:
        part = todo.pop()
        if isinstance(part, ast.If) and "ok()" in ast.unparse(part.test):
            todo += part.orelse  # it ends at shutdown
        elif isinstance(part, (ast.Break, ast.Return, ast.Raise)) or (
            isinstance(part, ast.Call) and ast.unparse(part.func).rpartition(".")[2] in ("exit", "_exit")
        ):
            return False
        else:
            todo += ast.iter_child_nodes(part)
    return True
