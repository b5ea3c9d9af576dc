"""The rule language and its engine; both are independent of Petri nets. See `docs/rule_language.md`."""

from dineros.transformations.language.creation import Copy, ForAll, Fragment, New, image
from dineros.transformations.language.engine import Engine
from dineros.transformations.language.errors import RuleError
from dineros.transformations.language.expressions import Expression, Path
from dineros.transformations.language.functions import (
    ancestor,
    count,
    either,
    enclosing,
    first,
    greatest,
    less,
    number,
    position,
)
from dineros.transformations.language.patterns import Absent, Index, Made, Node, Pattern
from dineros.transformations.language.rule import Rule

__all__ = [
    "Absent",
    "Copy",
    "Engine",
    "Expression",
    "ForAll",
    "Fragment",
    "Index",
    "Made",
    "New",
    "Node",
    "Path",
    "Pattern",
    "Rule",
    "RuleError",
    "ancestor",
    "count",
    "either",
    "enclosing",
    "first",
    "greatest",
    "image",
    "less",
    "number",
    "position",
]
