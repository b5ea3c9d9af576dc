"""Finds calls in Python that create entities, by their names, whether or not a program executes them."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from dineros.sources.language.modules import Module
from dineros.sources.left_out import MakingCall
from dineros.sources.libraries.making import CREATES


def calls_of(modules: Iterable[Module]) -> Iterator[MakingCall]:
    """Yield the calls in modules that create entities, including dead code."""
    for module in modules:
        for node in module.nodes:
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Attribute)
                and node.func.attr in CREATES
            ):
                yield MakingCall(module.path, node.func.end_lineno or node.lineno, node.func.attr)
