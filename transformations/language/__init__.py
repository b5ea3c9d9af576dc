"""The rule language and its engine; both are independent of Petri nets. See `docs/rule_language.md`."""

from dineros.transformations.language.creation import Copy, ForAll, Fragment, New, image
from dineros.transformations.language.datatypes import REAL, TRUTH, WHOLE
from dineros.transformations.language.engine import Engine
from dineros.transformations.language.errors import RuleError
from dineros.transformations.language.expressions import Expression, Match, Path, Text
from dineros.transformations.language.functions import (
    Query,
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
from dineros.transformations.language.meaning import Meaning
from dineros.transformations.language.patterns import Absent, Index, Made, Node, Pattern
from dineros.transformations.language.rule import Rule

__all__ = [
    "REAL",
    "TRUTH",
    "WHOLE",
    "Absent",
    "Copy",
    "Engine",
    "Expression",
    "ForAll",
    "Fragment",
    "Index",
    "Made",
    "Match",
    "Meaning",
    "New",
    "Node",
    "Path",
    "Pattern",
    "Query",
    "Rule",
    "RuleError",
    "Text",
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
