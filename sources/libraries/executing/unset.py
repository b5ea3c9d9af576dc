"""Finds waits for events that no code sets."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from dineros.sources.facts import NEVER_SET, Effect
from dineros.sources.language.modules import Module, Modules
from dineros.sources.places import Place

_LOOKS = ("wait", "clear", "is_set", "isSet", "acquire", "release", "locked")
"""Methods of events and conditions that end no wait."""
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)


def mark_never_set(modules: Modules, waits: Iterable[tuple[Effect, Place]]) -> None:
    """Mark waits for an event that stays in one variable or attribute, of which no code asks for more.

    A finding needs certainty. So each use of a variable of that name counts, and an event that also has
    another name, or that any code passes on, may be set.
    """
    known = list(modules.all.values())
    for effect, made_at in waits:
        if not effect.how.endswith(NEVER_SET) and _is_never_set(known, made_at):
            effect.how += NEVER_SET


def _is_never_set(modules: list[Module], made_at: Place) -> bool:
    module = next((each for each in modules if each.path == made_at.file), None)
    found = None if module is None else _assigned(module.tree, made_at.line, ())
    if found is None:
        return False
    name, around = found
    trees: Iterable[ast.AST] = (each.tree for each in modules) if around is None else [around]
    return not any(_may_set(tree, name) for tree in trees)


def _assigned(node: ast.AST, line: int, around: tuple[ast.AST, ...]) -> tuple[str, ast.AST | None] | None:
    """Return the only name of what a line makes, and the function whose local variable it is."""
    for each in ast.iter_child_nodes(node):
        inside = (*around, each) if isinstance(each, (*_FUNCTIONS, ast.ClassDef)) else around
        if isinstance(each, (ast.Assign, ast.AnnAssign)) and each.lineno == line:
            targets = each.targets if isinstance(each, ast.Assign) else [each.target]
            if len(targets) != 1 or not isinstance(each.value, ast.Call):
                return None
            if isinstance(targets[0], ast.Attribute):
                return targets[0].attr, None
            if not isinstance(targets[0], ast.Name):
                return None
            is_local = bool(around) and isinstance(around[-1], _FUNCTIONS)
            return targets[0].id, around[-1] if is_local else None
        found = _assigned(each, line, inside)
        if found is not None:
            return found
    return None


def _may_set(tree: ast.AST, name: str) -> bool:
    """Return whether code does more with a variable or an attribute of a name than to wait for it."""
    return any(
        (_last(each) == name and not _only_waits(each, parent))
        or (isinstance(each, ast.Constant) and each.value == name)
        for each, parent in _with_parents(tree)
    )


def _only_waits(use: ast.AST, parent: ast.AST) -> bool:
    if isinstance(use, (ast.Name, ast.Attribute)) and not isinstance(use.ctx, ast.Load):
        return True
    if isinstance(parent, ast.Attribute):
        return parent.attr in _LOOKS
    if isinstance(parent, ast.withitem):
        return parent.optional_vars is None
    return isinstance(parent, ast.Call) and parent.func is use  # a function of that name


def _last(node: ast.AST) -> str:
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def _with_parents(tree: ast.AST) -> Iterator[tuple[ast.AST, ast.AST]]:
    todo = [tree]
    while todo:
        parent = todo.pop()
        for each in ast.iter_child_nodes(parent):
            yield each, parent
            todo.append(each)
