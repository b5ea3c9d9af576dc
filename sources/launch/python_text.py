"""Evaluates small Python expressions over constants, without executing them."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from dineros.sources.language.computing.operations import COMPARED, OPERATORS

_DEEPEST = 20
_MOST_CHARACTERS = 10_000
_COMPARED: dict[type, Callable[[Any, Any], bool]] = {
    **COMPARED,
    ast.In: lambda left, right: left in right,
    ast.NotIn: lambda left, right: left not in right,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {"int": int, "float": float, "str": str, "bool": bool, "len": len}
_METHODS = ("lower", "upper", "strip", "startswith", "endswith", "split")
"""Of texts."""


def worth(node: ast.expr, depth: int = 0) -> Any:
    """Return the value of an expression.

    Raises
    ------
    ValueError
        It has parts that are not supported.
    TypeError, ArithmeticError
        It has no value.

    Examples
    --------
    >>> worth(ast.parse("'Mock'.lower() == 'mock' and 2 * 3 > 5", mode="eval").body)
    True
    """
    if depth > _DEEPEST:
        raise ValueError("the expression is nested too deeply")

    def inner(part: ast.expr) -> Any:
        return worth(part, depth + 1)

    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Name) and node.id in ("true", "false"):
        return node.id == "true"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.Not, ast.USub)):
        return not inner(node.operand) if isinstance(node.op, ast.Not) else -inner(node.operand)
    if isinstance(node, ast.BoolOp):
        values = [inner(each) for each in node.values]
        return all(values) if isinstance(node.op, ast.And) else any(values)
    if isinstance(node, ast.Compare):
        values = [inner(each) for each in (node.left, *node.comparators)]
        if any(type(op) not in _COMPARED for op in node.ops):
            raise ValueError("the comparison is not supported")
        pairs = zip(node.ops, values[:-1], values[1:], strict=True)
        return all(_COMPARED[type(op)](left, right) for op, left, right in pairs)
    if isinstance(node, ast.IfExp):
        return inner(node.body if inner(node.test) else node.orelse)
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        return _computed(OPERATORS[type(node.op)], inner(node.left), inner(node.right))
    if isinstance(node, (ast.List, ast.Tuple)):
        return [inner(each) for each in node.elts]
    if isinstance(node, ast.Call) and not node.keywords:
        return _called(node.func, [inner(each) for each in node.args], inner)
    raise ValueError("the expression is not supported")


def _computed(compute: Callable[[Any, Any], Any], left: Any, right: Any) -> Any:
    """Return the result of an operation on numbers, or a sum of texts or lists."""
    if compute is not operator.add and not all(isinstance(each, (int, float)) for each in (left, right)):
        raise ValueError("only numbers are multiplied")  # repeated texts can be large
    found = compute(left, right)
    if isinstance(found, (str, list)) and len(found) > _MOST_CHARACTERS:
        raise ValueError("the result is too long")
    return found


def _called(function: ast.expr, args: list[Any], inner: Callable[[ast.expr], Any]) -> Any:
    if isinstance(function, ast.Name) and function.id in _FUNCTIONS:
        return _FUNCTIONS[function.id](*args)
    if isinstance(function, ast.Attribute) and function.attr in _METHODS:
        text = inner(function.value)
        if isinstance(text, str):
            return getattr(text, function.attr)(*args)
    raise ValueError("the function is not supported")
