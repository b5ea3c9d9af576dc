"""Larger steps of drawing, composed of commands: copies, pages of what is drawn, templates, data of tokens.

`compose` returns the commands that such a step is; they are done as one group, which has one inverse.
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
