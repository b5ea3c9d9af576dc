"""Larger editing steps composed of commands: copies, pages from selected elements, templates, token data.

`compose` returns the commands of such a step; they are executed as one group with one inverse.
"""

from dineros.metamodel.editing.composed.composing import compose
from dineros.metamodel.editing.composed.operations import (
    OPERATIONS,
    Copy,
    Fill,
    Group,
    Insert,
    Into,
    Join,
    Operation,
    Split,
    decode_operation,
)

__all__ = [
    "OPERATIONS",
    "Copy",
    "Fill",
    "Group",
    "Insert",
    "Into",
    "Join",
    "Operation",
    "Split",
    "compose",
    "decode_operation",
]
