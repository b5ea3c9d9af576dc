"""Parsers of the languages of clauses, guards and formulas, made from grammars in Lark's notation.

A parser's tables are stored next to its grammar, in the folder of compiled Python modules: computing them
takes 10 to 40 ms.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lark import Lark


def parser_of(grammar: Path, **options: Any) -> Lark:
    """Return the LALR parser of a grammar.

    Stored tables are used only if they belong to this grammar, these options and this version of Lark. They
    are not written if Python does not write compiled modules, or if the folder is read-only.

    Parameters
    ----------
    grammar : Path
        The file of the grammar.
    **options
        Options of `lark.Lark`.
    """
    from lark import Lark

    folder = grammar.parent / "__pycache__"
    is_stored = not sys.dont_write_bytecode and folder.is_dir()
    cache = str(folder / f"{grammar.stem}.{sys.implementation.cache_tag}.tables") if is_stored else False
    return Lark(grammar.read_text(encoding="utf-8"), parser="lalr", cache=cache, **options)
