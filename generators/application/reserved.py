"""Finds the names that templates use, by rendering a probe model; a fixed list would become outdated.

So user templates may use other names than the built-in ones.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from dineros.generators.application.application import Application
from dineros.generators.application.collecting import application_of
from dineros.generators.application.naming import Reserved
from dineros.metamodel import sym
from dineros.metamodel.ros_names import snake_case

_PROBE = "ProbeOfNames"


def reserved_names(render: Callable[[Application, str], bytes]) -> Reserved:
    """Return the names used in the modules of a node.

    `render`: renders a module of the first node of an application, without stubs, by the module's name.
    """
    probe = application_of(_probe())
    names = {module: _names(render(probe, module)) for module in ("handlers", "firings", "tokens")}
    return Reserved(**names)


def _probe() -> sym.SystemModel:
    """Return a model for which the templates write all their parts: two transitions, all kinds of fields."""
    fields = [
        sym.TokenField(name=f"{_PROBE}{kind}{element}", kind=kind, elementKind=element)
        for kind in ("text", "integer", "number", "boolean", "list", "map")
        for element in (("text", "number") if kind in ("list", "map") else ("text",))
    ]
    transitions = [sym.Transition(id=f"{_PROBE}{number}") for number in (1, 2)]
    node = sym.NodeNet(id=f"{_PROBE}Node", objects=transitions)
    token_type = sym.TokenType(id=f"{_PROBE}Token", fields=fields)
    return sym.SystemModel(id=f"{_PROBE}Model", tokenType=token_type, pages=[node])


def _names(module: bytes) -> frozenset[str]:
    """Return the names that a module binds or uses, except those of the probe."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(module)):
        if isinstance(node, ast.Name):
            found.add(node.id)
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            found.add(node.name)
        elif isinstance(node, ast.alias):
            found.add(node.asname or node.name.partition(".")[0])
    return frozenset(name for name in found if not name.startswith((_PROBE, snake_case(_PROBE))))
