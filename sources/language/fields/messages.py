"""Decides from the text of a function which truth values the fields of a message or a response have.

A field is certain only if its message has one name in one function, which does nothing with it but read and
assign its fields: nothing else could change it or exchange it. Everything else is left open.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

FunctionNode = ast.FunctionDef | ast.AsyncFunctionDef
_HIDDEN = frozenset(("locals", "vars", "exec", "eval", "globals"))
"""Functions that reach variables without their names."""


def is_only_read(function: ast.AST, name: str) -> bool:
    """Return whether a function does nothing with one of its parameters but read fields of it.

    `name`: the parameter.

    Examples
    --------
    >>> read = ast.parse("def f(msg): return msg.data").body[0]
    >>> kept = ast.parse("def f(msg): keep(msg)").body[0]
    >>> is_only_read(read, "msg"), is_only_read(kept, "msg"), is_only_read(read, "data")
    (True, False, False)
    """
    if not is_plain(function) or not is_parameter(function, name):
        return False
    reads = {id(each.value) for each in fields(function, name) if isinstance(each.ctx, ast.Load)}
    return uses(function, name) == reads


def sent(function: ast.AST | None, call: ast.Call) -> tuple[dict[str, ast.expr], ast.expr | None]:
    """Return the fields of the message that a function publishes by a call, with what it assigns to them.

    Parameters
    ----------
    function : ast.AST or None
        The function that has the call; None: a module.
    call : ast.Call
        ``publish(Bool(data=True))``, or ``publish(msg)`` of a message that the same block makes.

    Returns
    -------
    dict of str to ast.expr, ast.expr or None
        The fields; what makes the message, which must be its class.

    Examples
    --------
    >>> function = ast.parse("def f(self): self.pub.publish(Bool(data=True))").body[0]
    >>> {name: ast.unparse(value) for name, value in sent(function, function.body[0].value)[0].items()}
    {'data': 'True'}
    """
    if call.keywords or len(call.args) != 1:
        return {}, None
    argument = call.args[0]
    if isinstance(argument, ast.Call):
        return _made(argument), argument.func
    if function is None or not isinstance(argument, ast.Name) or not is_plain(function):
        return {}, None
    block = next((each for each in blocks(function) if any(_is_call(one, call) for one in each)), [])
    return _assigned(function, block, argument, call)


def answered(function: ast.AST) -> dict[str, bool]:
    r"""Return the fields of the response of a service's callback that are the same in each run.

    Examples
    --------
    >>> text = "def f(self, request, response):\n    response.success = True\n    return response"
    >>> answered(ast.parse(text).body[0])
    {'success': True}
    """
    if not isinstance(function, FunctionNode) or not is_plain(function) or not function.args.args:
        return {}
    name = function.args.args[-1].arg
    if not is_parameter(function, name) or not isinstance(function.body[-1], ast.Return):
        return {}
    returned = [each.value for each in ast.walk(function) if isinstance(each, ast.Return)]
    if not all(isinstance(each, ast.Name) and each.id == name for each in returned):
        return {}
    used = fields(function, name)
    if uses(function, name) != {*map(id, returned), *(id(each.value) for each in used)}:
        return {}
    found: dict[str, bool] = {}
    for statement in function.body:
        field = stored(statement, name)
        is_only = sum(each.attr == field and not isinstance(each.ctx, ast.Load) for each in used) == 1
        value = _truth(statement.value) if isinstance(statement, ast.Assign) else None
        if field is not None and is_only and value is not None:
            found[field] = value
        if any(isinstance(each, ast.Return) for each in ast.walk(statement)):
            break  # what is assigned later is not part of each answer
    return found


def _assigned(
    function: ast.AST, block: list[ast.stmt], argument: ast.Name, call: ast.Call
) -> tuple[dict[str, ast.expr], ast.expr | None]:
    """Return the fields of a message that statements of one block make, change and publish, in this order."""
    name = argument.id
    used = fields(function, name)
    known = {id(argument), *(id(each.value) for each in used)}
    found: dict[str, ast.expr] = {}
    maker: ast.expr | None = None
    stores = 0
    for statement in block:
        if _is_call(statement, call):
            break
        field = stored(statement, name)
        if isinstance(statement, ast.Assign) and _is_name(statement.targets, name):
            if maker is not None or not isinstance(statement.value, ast.Call):
                return {}, None
            found, maker = _made(statement.value), statement.value.func
            known.add(id(statement.targets[0]))
        elif isinstance(statement, ast.Assign) and field is not None:
            if maker is None:
                return {}, None
            stores += 1
            found[field] = statement.value
    is_all = stores == sum(not isinstance(each.ctx, ast.Load) for each in used)
    return (found, maker) if is_all and uses(function, name) == known else ({}, None)


def _is_name(targets: list[ast.expr], name: str) -> bool:
    """Return whether an assignment has one target, a variable."""
    return len(targets) == 1 and isinstance(targets[0], ast.Name) and targets[0].id == name


def _made(call: ast.Call) -> dict[str, ast.expr]:
    """Return the fields that the call of a message's class gets."""
    if call.args or any(each.arg is None for each in call.keywords):
        return {}
    return {each.arg: each.value for each in call.keywords if each.arg is not None}


def _truth(value: ast.expr | None) -> bool | None:
    return value.value if isinstance(value, ast.Constant) and isinstance(value.value, bool) else None


def _is_call(statement: ast.stmt, call: ast.Call) -> bool:
    return isinstance(statement, ast.Expr) and statement.value is call


def stored(statement: ast.AST, name: str) -> str | None:
    """Return the field of a message that a statement assigns, if it does just that."""
    if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
        return None
    target = statement.targets[0]
    if not isinstance(target, ast.Attribute) or not isinstance(target.value, ast.Name):
        return None
    return target.attr if target.value.id == name else None


def is_plain(function: ast.AST) -> bool:
    """Return whether a function shows all uses of its variables."""
    if not isinstance(function, FunctionNode) or function.decorator_list:
        return False
    return not any(
        isinstance(each, (ast.Yield, ast.YieldFrom, ast.Global, ast.Nonlocal))
        or (isinstance(each, ast.Name) and each.id in _HIDDEN)
        or (isinstance(each, ast.Attribute) and each.attr in ("f_locals", "currentframe", "_getframe"))
        for each in ast.walk(function)
    )


def is_parameter(function: ast.AST, name: str) -> bool:
    """Return whether a name is a parameter of a function, without a default."""
    assert isinstance(function, FunctionNode)
    wanted = function.args
    able = len(wanted.args) - len(wanted.defaults)
    return name in [each.arg for each in wanted.args[: max(able, 0)]]


def fields(function: ast.AST, name: str) -> list[ast.Attribute]:
    """Return the uses of fields of a variable, such as ``msg.data``; not of hidden ones, as ``msg._data``."""
    return [
        each
        for each in ast.walk(function)
        if isinstance(each, ast.Attribute)
        and isinstance(each.value, ast.Name)
        and each.value.id == name
        and not each.attr.startswith("_")
    ]


def uses(function: ast.AST, name: str) -> set[int]:
    """Return all uses of a name in a function; a parameter counts once."""
    found = set[int]()
    parameters = 0
    for each in ast.walk(function):
        if isinstance(each, ast.Name) and each.id == name:
            found.add(id(each))
        elif isinstance(each, ast.arg) and each.arg == name:
            parameters += 1
            if parameters > 1:
                found.add(id(each))
        elif each is not function and name in _bound(each):
            found.add(id(each))
    return found


def _bound(node: ast.AST) -> Iterator[str]:
    """Yield the names that a part of the code binds as texts, as `except`, `import`, `case` and `def` do."""
    for key in ("name", "asname", "rest"):
        found = getattr(node, key, None)
        if isinstance(found, str):
            yield found.split(".")[0]


def blocks(function: ast.AST) -> Iterator[list[ast.stmt]]:
    """Yield the lists of statements of a function."""
    for each in ast.walk(function):
        for key in ("body", "orelse", "finalbody"):
            found = getattr(each, key, None)
            if isinstance(found, list):
                yield found
