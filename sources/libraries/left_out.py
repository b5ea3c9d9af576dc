"""Calls in Python that make entities, found by their names and not by what runs."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from dineros.sources.language.modules import Module
from dineros.sources.left_out import MakingCall
from dineros.sources.libraries.making import CREATES


def calls_of(modules: Iterable[Module]) -> Iterator[MakingCall]:
    """Yield the calls of modules that make entities, dead code among them."""
    for module in modules:
        for node in ast.walk(module.tree):
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Attribute)
                and node.func.attr in CREATES
            ):
                yield MakingCall(module.path, node.func.end_lineno or node.lineno, node.func.attr)
