"""Decides from the text of a function where it has the response of a service from, and how it makes one.

A response is certain only if it has one name in one function, which does nothing with it but ask and assign
its fields. Everything else is left open.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from dineros.sources.branches import Block, Give, walk
from dineros.sources.language.fields.messages import (
    FunctionNode,
    blocks,
    fields,
    is_parameter,
    is_plain,
    stored,
    uses,
)

_OF_FUTURE = frozenset(("cancelled", "done", "exception", "result"))
"""Methods that leave a future as it is."""
_CALLS = ("call", "call_async")


def asked_future(function: ast.AST, asked: ast.expr) -> str | None:
    """Return the parameter whose result an expression is: a future that the function only asks.

    `asked`: ``future.result()``, or the variable that alone has it.

    Examples
    --------
    >>> function = ast.parse("def f(future): return future.result().success").body[0]
    >>> asked_future(function, function.body[0].value.value)
    'future'
    """
    call = _source(function, asked)
    name = _called(call, "result")
    if name is None or not is_plain(function) or not is_parameter(function, name):
        return None
    assert isinstance(call, ast.Call)
    if call.args or call.keywords:
        return None
    known = {id(each.func.value) for each in _calls(function) if _called(each, *_OF_FUTURE) == name}  # type: ignore[attr-defined]
    return name if uses(function, name) == known else None


def asked_call(function: ast.AST, asked: ast.expr) -> ast.Call | None:
    r"""Return the call of a service whose response an expression is.

    Parameters
    ----------
    function : ast.AST
        The function.
    asked : ast.expr
        ``self.client.call(request)``, ``await self.client.call_async(request)``, or the variable that alone
        has it.

    Examples
    --------
    >>> text = "def f(self):\n    response = self.client.call(1)\n    return response.success"
    >>> function = ast.parse(text).body[0]
    >>> ast.unparse(asked_call(function, function.body[1].value.value))
    'self.client.call(1)'
    """
    found = _source(function, asked)
    is_awaited = isinstance(found, ast.Await)
    call = found.value if isinstance(found, ast.Await) else found
    if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Attribute):
        return None
    if call.func.attr != _CALLS[is_awaited]:
        return None
    others = [
        each
        for each in _calls(function)
        if isinstance(each.func, ast.Attribute) and each.func.attr in _CALLS and each.lineno == call.lineno
    ]
    return call if others == [call] else None  # effects of one line are one effect


def response_of(function: ast.AST) -> tuple[str, frozenset[str]] | None:
    r"""Return the parameter that is the response of a service's callback, and the fields it assigns plainly.

    The callback may return something else, too. None: something else may change the response.

    Examples
    --------
    >>> text = "def f(self, request, response):\n    response.success = True\n    return response"
    >>> name, plain = response_of(ast.parse(text).body[0])
    >>> name, sorted(plain)
    ('response', ['success'])
    """
    if not isinstance(function, FunctionNode) or not is_plain(function) or not function.args.args:
        return None
    name = function.args.args[-1].arg
    returned = _returned(function)
    if not is_parameter(function, name) or not returned or None in returned:
        return None
    own = {id(each) for each in returned if isinstance(each, ast.Name) and each.id == name}
    asked = fields(function, name)
    if uses(function, name) != own | {id(each.value) for each in asked}:
        return None
    inner = [each for each in ast.walk(function) if isinstance(each, _INNER) and each is not function]
    if any(uses(each, name) for each in inner):
        return None
    plain = {id(each.targets[0]) for each in ast.walk(function) if stored(each, name) is not None}  # type: ignore[attr-defined]
    names = {each.attr for each in asked}
    others = {each.attr for each in asked if not isinstance(each.ctx, ast.Load) and id(each) not in plain}
    return name, frozenset(names - others)


def _returned(function: ast.AST) -> list[ast.expr | None]:
    return [each.value for each in ast.walk(function) if isinstance(each, ast.Return)]


def leave_open(function: ast.AST, body: Block) -> None:
    """Leave fields of a response open if the reader has not followed an assignment in the text.

    Parameters
    ----------
    function : ast.AST
        The callback of a service.
    body : list of Item
        What was followed.
    """
    found = response_of(function)
    gives = [each for each in walk(body) if isinstance(each, Give)]
    seen = {(each.name, each.at.line) for each in gives}
    others = [
        each
        for each in _returned(function)
        if each is not None and (found is None or not isinstance(each, ast.Name) or each.id != found[0])
    ]
    if any(("", each.lineno) not in seen for each in others):
        for give in gives:
            give.value = None
    lost = {
        each.attr
        for each in (fields(function, found[0]) if found is not None else ())
        if isinstance(each.ctx, ast.Store) and (each.attr, each.lineno) not in seen
    }
    for each in gives:
        if each.name in lost:
            each.value = None


_INNER = (
    *(ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef),
    *(ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp),
)


def _source(function: ast.AST, asked: ast.expr) -> ast.expr | None:
    """Return what a variable has, if it has one value only and is not used but for its fields."""
    if not isinstance(asked, ast.Name):
        return asked
    name = asked.id
    if not is_plain(function):
        return None
    made = [
        each
        for each in ast.walk(function)
        if isinstance(each, ast.Assign)
        and len(each.targets) == 1
        and isinstance(each.targets[0], ast.Name)
        and each.targets[0].id == name
    ]
    if len(made) != 1:
        return None
    known = {id(made[0].targets[0])}
    known |= {id(each.value) for each in fields(function, name) if isinstance(each.ctx, ast.Load)}
    known |= {id(each) for each in _presence(function)}
    inner = [each for each in ast.walk(function) if isinstance(each, _INNER) and each is not function]
    is_own = not any(uses(each, name) for each in inner)
    parameters = [each.arg for each in ast.walk(function) if isinstance(each, ast.arg)]
    if not is_own or name in parameters or not uses(function, name) <= known:
        return None
    return made[0].value if _is_new(function, made[0], asked) else None


def _is_new(function: ast.AST, made: ast.Assign, asked: ast.Name) -> bool:
    """Return whether a variable that is asked cannot have its value from an earlier turn of a loop."""
    loops = [each for each in ast.walk(function) if isinstance(each, (ast.For, ast.AsyncFor, ast.While))]
    if not any(made in ast.walk(each) for each in loops):
        return True
    block = next(each for each in blocks(function) if made in each)
    later = block[block.index(made) + 1 :]
    return any(asked in ast.walk(each) for each in later)


def _presence(function: ast.AST) -> Iterator[ast.Name]:
    """Yield the variables whose presence is tested: ``if response``, ``response is not None``."""
    todo: list[ast.expr] = []
    for each in ast.walk(function):
        if isinstance(each, (ast.If, ast.While, ast.IfExp, ast.Assert)):
            todo.append(each.test)
        elif isinstance(each, ast.UnaryOp) and isinstance(each.op, ast.Not):
            todo.append(each.operand)
        elif isinstance(each, ast.Compare) and all(isinstance(one, (ast.Is, ast.IsNot)) for one in each.ops):
            todo.append(each.left)
    while todo:
        test = todo.pop()
        if isinstance(test, ast.Name):
            yield test
        elif isinstance(test, ast.BoolOp):
            todo.extend(test.values)


def _calls(function: ast.AST) -> list[ast.Call]:
    return [each for each in ast.walk(function) if isinstance(each, ast.Call)]


def _called(call: ast.expr | None, *methods: str) -> str | None:
    """Return the variable of which an expression calls one of some methods."""
    if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Attribute):
        return None
    owner = call.func.value
    return owner.id if call.func.attr in methods and isinstance(owner, ast.Name) else None
