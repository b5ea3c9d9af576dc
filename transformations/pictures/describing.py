"""Rules as text: one line for each element that is matched or made."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Sequence

from dineros.metamodel import pn
from dineros.transformations.language.creation import Copy, ForAll, Fragment, Image, New
from dineros.transformations.language.expressions import Constant, Expression, Text, Variable
from dineros.transformations.language.functions import Ancestor
from dineros.transformations.language.patterns import Absent, Index, Made, Node
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules.catalogue import name_of

Row = tuple[str, str]


def lhs_rows(rule: type[Rule]) -> list[Row]:
    """Return name and description of each element that a rule matches, with its conditions."""
    rows = [_matched(node) for node in rule.lhs]
    rows += [("where", str(condition)) for condition in rule.where]
    for pattern in rule.absent:
        rows.append(("no", _absent(pattern)))
    return rows


def rhs_rows(rule: type[Rule]) -> list[Row]:
    """Return name and description of each element that a rule makes; those of a for-all are indented."""
    rows = list(_made(rule.rhs))
    rows += [(str(node), "deleted") for node in rule.deleted]
    return rows


def rule_text(rule: type[Rule]) -> str:
    """Return a rule as lines of text: ``LHS`` with the matched elements, ``RHS`` with the made ones."""
    left, right = lhs_rows(rule), rhs_rows(rule)
    width = max(len(name) for name, _ in [*left, *right])
    lines = ["LHS", *(f"  {name:{width}}  {text}".rstrip() for name, text in left)]
    lines += ["RHS: the same, and", *(f"  {name:{width}}  {text}".rstrip() for name, text in right)]
    return "\n".join(lines)


def maker_of(node: Made) -> str:
    """Describe the rule and the sources of the result of a lookup: ``by T1 for channel``."""
    role = node._role
    if isinstance(role, type):
        maker = f"any {role.__name__}"
    else:
        assert role.rule is not None
        maker = f"by {name_of(role.rule.__name__)}"
    sources = ", ".join(map(str, node._of))
    return f"{maker} for {sources}" if sources else maker


def _matched(node: Variable) -> Row:
    if isinstance(node, Index):
        return str(node), f"1, 2, … up to {node._upto}"
    if isinstance(node, Made):
        maker = maker_of(node)
        return str(node), maker if maker.startswith("any") else f"{_kind(node)} made {maker}"
    text = _kind(node)
    if isinstance(node, Node):
        if isinstance(node._of, Image):
            text += f", the {node._of}"
        elif isinstance(node._of, Ancestor):
            text += f" around {node._of.base}"
        elif node._of is not None:
            text += f" of {node._of}"
        conditions = [f"{name} = {value_text(value)}" for name, value in node._features.items()]
        if conditions:
            text += f" with {' and '.join(conditions)}"
    return node.symbol, text


def _kind(node: Variable) -> str:
    if isinstance(node, Made) and node._fragment is not None:
        return node._fragment.__name__
    return node.eclass.__name__ if node.eclass is not None else "value"


def value_text(value: Expression) -> str:
    """Return the value of a feature, Booleans in lower case."""
    return str(value).lower() if isinstance(value, Constant) and isinstance(value.value, bool) else str(value)


def _absent(pattern: Absent) -> str:
    parts = [" ".join(_matched(node)).strip() for node in pattern.nodes] + [
        str(condition) for condition in pattern.where
    ]
    return ", ".join(parts)


def _made(items: Sequence[Variable | ForAll], indent: str = "") -> Iterator[Row]:
    groups: set[str] = set()
    for item in items:
        if isinstance(item, ForAll):
            where = f" with {' and '.join(map(str, item.where))}" if item.where else ""
            nodes = "; ".join(" ".join(_matched(node)).strip() for node in item.nodes)
            yield f"{indent}for all", f"{nodes}{where}"
            yield from _made(item.make, f"{indent}  ")
        elif isinstance(item, New):
            name, point, _ = item.symbol.partition(".")
            if point and name not in groups:
                groups.add(name)
                group: Fragment = getattr(item.rule, name)
                yield f"{indent}{name}", type(group).__name__
            yield _created(item, indent)
        elif isinstance(item, Copy):
            yield f"{indent}{item}", f"copy of {item.original}, its elements named {item.id}"


def _created(item: New, indent: str) -> Row:
    assert item.eclass is not None
    if issubclass(item.eclass, pn.Arc):
        return f"{indent}arc", _arc(item)
    text = item.eclass.__name__
    identity = item.features.get("id")
    if isinstance(identity, Text):
        text += f" {identity}"
    shown = [
        f"{name} = {value_text(value)}"
        for name, value in item.features.items()
        if name not in ("id", "page") and str(value) != "0"
    ]
    name = str(item)
    return f"{indent}{name}", f"{text} with {' and '.join(shown)}" if shown else text


def _arc(item: New) -> str:
    source, target = item.features["source"], item.features["target"]
    kind = str(item.features.get("kind", "normal"))
    line = {"read": "<->", "inhibitor": "-o"}.get(kind, "->")
    weight = str(item.features.get("weight", "1"))
    return f"{source} {line} {target}" + ("" if weight == "1" else f" with weight {weight}")


def documentation_of(rule: type[Rule]) -> str:
    """Return the docstring of a rule."""
    return inspect.cleandoc(rule.__doc__ or "it has no description")
