"""Bundles the modules of `views/static` as one script: pages are single files, and V8 alone loads no modules.

A module becomes a function that runs once, after those it imports from, and returns what it exports; so names
that it does not export stay its own. Read are the forms that our modules use: named imports from relative
paths, and ``export`` before a function, a class or a constant.
"""

from __future__ import annotations

import re
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from posixpath import dirname, join, normpath

_IMPORT = re.compile(r'^import \{([^}]*)\} from "(\.[^"]+)";$', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:(?:async )?function|class|const) (\w+))", re.MULTILINE)
_OTHER = re.compile(r"^(?:import|export)\b.*", re.MULTILINE)


@cache
def linked(entry: str, root: Traversable | None = None) -> str:
    """Return an expression of JavaScript whose value is an object with what a module exports.

    Parameters
    ----------
    entry : str
        Path of the module below `root`, such as ``net/page.js``.
    root : Traversable, optional
        Folder of modules; `views/static` unless another is given.

    Raises
    ------
    ValueError
        Modules import each other in a circle, or in a form that is not read.
    """
    modules: dict[str, str] = {}
    _add(entry, files("dineros.views") / "static" if root is None else root, modules, ())
    return "\n".join(["(() => {", '"use strict";', *modules.values(), f"return {name_of(entry)};", "})()"])


def _add(path: str, root: Traversable, modules: dict[str, str], around: tuple[str, ...]) -> None:
    """Add a module after those from which it imports."""
    if path in around:
        raise ValueError(f"modules import each other: {' -> '.join((*around, path))}")
    if path in modules:
        return
    text = (root / path).read_text(encoding="utf-8")

    def binding(found: re.Match[str]) -> str:
        imported = normpath(join(dirname(path), found[2]))
        _add(imported, root, modules, (*around, path))
        return f"const {{{found[1].replace(' as ', ': ')}}} = {name_of(imported)};"

    body, exported = _IMPORT.sub(binding, text), _EXPORT.findall(text)
    body = _EXPORT.sub("", body)
    if other := _OTHER.search(body):
        raise ValueError(f"{path}: unsupported form of import or export: {other[0]}")
    modules[path] = f"const {name_of(path)} = (() => {{\n{body}return {{ {', '.join(exported)} }};\n}})();"


def name_of(path: str) -> str:
    """Return the name of a module in the script, from its path."""
    return "module_" + re.sub(r"\W", "_", path)
