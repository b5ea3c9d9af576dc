"""Aliases and constants by name; of several meanings in branches of a directive, one is kept."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from dineros.sources.cpp.parsing import line_of, path_of, text_of

if TYPE_CHECKING:
    from tree_sitter import Node


@dataclass(frozen=True)
class Named:
    """An alias or a constant, with its location."""

    full: str
    path: str
    node: Node


def without_branches(aliases: dict[str, list[Named]]) -> list[str]:
    """Keep one of the meanings of an alias in the branches of a directive, and return a line for each node.

    A macro after ``#ifdef`` counts as not defined; of other conditions, the first branch is used.
    """
    lines: list[str] = []
    for name, found in aliases.items():
        by_directive: dict[tuple[str, int], dict[int, Named]] = {}
        roots: dict[int, Node] = {}
        for each in found:
            directive, branch = _branch(each.node)
            if directive is not None:
                roots[directive.id] = directive
                by_directive.setdefault((each.full, directive.id), {}).setdefault(branch, each)
        for (_, root), branches in by_directive.items():
            several = list(branches.values())
            if len({text_of(each.node) for each in several}) < 2:
                continue
            is_last = text_of(roots[root]).lstrip("# \t").startswith("ifdef")
            kept = several[-1 if is_last else 0]
            for each in several:
                if each is not kept:
                    found.remove(each)
            if any(path_of(each.node).endswith("Node") for each in several):
                lines.append(
                    f"{kept.path}:{line_of(kept.node)}: {name} has several meanings under conditions of the "
                    f"preprocessor; {path_of(kept.node)} is assumed"
                )
    return lines


def _branch(node: Node) -> tuple[Node | None, int]:
    """Return the innermost directive around a definition, and the branch of it."""
    branch, around = 0, node.parent
    while around is not None:
        if around.type.startswith(("preproc_else", "preproc_elif")):
            branch = branch or around.id
        elif around.type.startswith("preproc_if"):
            return around, branch or around.id
        around = around.parent
    return None, 0
