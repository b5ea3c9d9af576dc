"""Reading the contest's property files: XML in the namespace ``http://mcc.lip6.fr/``.

Other tools, such as TAPAAL, add comparisons and sums, and omit the namespace or use another one; these files
are read, too.

In the contest, ``EX f`` requires a successor and ``AX f`` holds if there is none, while runs in this project
stay in a deadlock forever: the formulas are translated with ``deadlock``. In LTL both semantics are equal.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lxml import etree

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.syntax import (
    FALSE,
    OPERATORS,
    TRUE,
    And,
    Comparison,
    ComparisonOperator,
    Constant,
    Deadlock,
    Enabled,
    Equivalent,
    Exists,
    Finally,
    ForAll,
    Formula,
    Globally,
    Implies,
    Name,
    Next,
    Not,
    Or,
    Until,
)
from dineros.analysis.properties.property import GLOBAL_PROPERTIES, GroupedNames, Property
from dineros.metamodel.errors import DinerosError, Location, near_matches
from dineros.metamodel.files.xml import line_of, parse

NAMESPACE = "http://mcc.lip6.fr/"

_LARGEST_DIGITS = 18
QUANTIFIERS: dict[str, type[ForAll | Exists]] = {"all-paths": ForAll, "exists-path": Exists}
UNARY: dict[str, type[Not | Globally | Finally | Next]] = {
    "negation": Not,
    "not": Not,
    "globally": Globally,
    "finally": Finally,
    "next": Next,
}
MANY: dict[str, type[And | Or]] = {"conjunction": And, "disjunction": Or, "and": And, "or": Or}
BINARY: dict[str, type[Implies | Equivalent]] = {"implication": Implies, "equivalence": Equivalent}
COMPARISONS: dict[str, ComparisonOperator] = {
    "integer-le": "<=",
    "integer-lt": "<",
    "integer-ge": ">=",
    "integer-gt": ">",
    "integer-eq": "==",
    "integer-ne": "!=",
}
_CONSTANTS: dict[str, Formula] = {"true": TRUE, "false": FALSE, "deadlock": Deadlock()}
_TEXTS = ("integer-constant", "place", "transition")
_W3C = "{http://www.w3.org/"
_TEMPORAL = ("globally", "finally", "next", "until")


def read_properties(
    path: Path | str, names: GroupedNames, note: Callable[[str], None] | None = None
) -> list[Property]:
    """Read a property file and resolve its names.

    Parameters
    ----------
    names : GroupedNames
        Resolves names; groups of transitions are added.
    note : callable, optional
        Called with a sentence if the file deviates from the format.

    Raises
    ------
    DinerosError
        It cannot be read, is not a property file, or has an unknown name; with its line.
    """
    root = parse(path).getroot()
    if etree.QName(root).localname != "property-set":
        hint = f'the root is <property-set xmlns="{NAMESPACE}">'
        raise DinerosError("is not a property file", location=Location(path, line_of(root)), hint=hint)
    _adopt(root, note)
    reader = _Reader(path, names)
    found = [reader.property(node) for node in root.iterchildren(tag=etree.Element)]
    seen: set[str] = set()
    for one in found:
        if one.id in seen:
            raise DinerosError(f"holds two properties {one.id!r}", location=Location(path))
        seen.add(one.id)
    return found


class _Reader:
    def __init__(self, path: Path | str, names: GroupedNames) -> None:
        self.path, self.names = path, names

    def error(self, message: str, node: etree._Element, hint: str | None = None) -> DinerosError:
        return DinerosError(message, location=Location(self.path, line_of(node)), hint=hint)

    def children(self, node: etree._Element, least: int = 0, most: int | None = None) -> list[etree._Element]:
        """Return the child elements of an element; their number must be in the given range."""
        found = list(node.iterchildren(tag=etree.Element))
        if len(found) < least or (most is not None and len(found) > most):
            raise self.error(f"<{_local(node)}> holds {len(found)} elements", node)
        return found

    def property(self, node: etree._Element) -> Property:
        if _local(node) != "property":
            raise self.error(f"<{_local(node)}> is not a <property>", node)
        parts: dict[str, etree._Element] = {}
        for part in self.children(node):
            first = parts.setdefault(_local(part), part)
            if first is not part:
                lines = f"lines {line_of(first)} and {line_of(part)}"
                raise self.error(f"a <property> has two <{_local(part)}>, on {lines}", part)
        if "id" not in parts or "formula" not in parts:
            raise self.error("a <property> needs an <id> and a <formula>", node)
        id = self.text(parts["id"])
        self.refuse_extras(parts["formula"])
        # The contest's ids are "ReachabilityDeadlock" and "NET-ReachabilityDeadlock".
        examination = next((name for name in GLOBAL_PROPERTIES if f"-{id}".endswith(f"-{name}")), "")
        says_nothing = all(_local(part) in ("true", "false") for part in self.children(parts["formula"]))
        if examination not in ("", "ReachabilityDeadlock") and says_nothing:
            return Property(id, "global", examination=examination)
        (formula,) = self.children(parts["formula"], 1, 1)
        if _local(formula) == "place-bound":
            return Property(id, "bound", places=self.places(formula))
        is_linear = "LTL" in id or _is_linear(formula)
        if is_linear and _local(formula) == "all-paths":
            (formula,) = self.children(formula, 1, 1)
        return Property(id, "ltl" if is_linear else "ctl", self.formula(formula, is_linear))

    def refuse_extras(self, formula: etree._Element) -> None:
        """Refuse attributes and texts that no formula of the contest has, such as bounds of an operator."""
        for node in formula.iter(tag=etree.Element):
            kind = _local(node)
            name = next((str(each) for each in node.attrib if not str(each).startswith(_W3C)), None)
            if name is not None:
                hint = "formulas of the contest have no attributes, and their operators no bounds"
                raise self.error(f"<{kind}> has an unknown attribute {name!r}", node, hint)
            if kind in _TEXTS:
                self.children(node, 0, 0)
            elif text := "".join([node.text or "", *(each.tail or "" for each in node)]).strip():
                raise self.error(f"<{kind}> holds the text {text[:40]!r}", node)

    def text(self, node: etree._Element) -> str:
        text = (node.text or "").strip()
        if not text:
            raise self.error(f"<{_local(node)}> is empty", node)
        return text

    def formula(self, node: etree._Element, is_linear: bool) -> Formula:
        kind = _local(node)
        if kind in _CONSTANTS:
            return _CONSTANTS[kind]
        if kind in COMPARISONS:
            return self.comparison(node, COMPARISONS[kind])
        if kind == "is-fireable":
            return self.fireable(node)
        if kind in QUANTIFIERS:
            if is_linear:
                raise self.error(f"<{kind}> is not allowed within linear time", node)
            (path,) = self.children(node, 1, 1)
            return self.quantified(node, path)
        if kind == "until" and is_linear:
            return self.until(node, is_linear)
        if kind in _TEMPORAL and not is_linear:
            hint = "put <all-paths> or <exists-path> around it"
            raise self.error(f"<{kind}> is not allowed without a quantifier", node, hint)
        if kind in UNARY:
            (operand,) = self.children(node, 1, 1)
            return UNARY[kind](self.formula(operand, is_linear))
        if kind in MANY:
            operands = tuple(self.formula(part, is_linear) for part in self.children(node, 1))
            return operands[0] if len(operands) == 1 else MANY[kind](operands)
        if kind in BINARY:
            left, right = self.children(node, 2, 2)
            return BINARY[kind](self.formula(left, is_linear), self.formula(right, is_linear))
        if kind == "exclusive-disjunction":
            left, right = self.children(node, 2, 2)
            return Not(Equivalent(self.formula(left, is_linear), self.formula(right, is_linear)))
        known = [*_CONSTANTS, *QUANTIFIERS, *UNARY, *MANY, *BINARY, *COMPARISONS]
        known += ["exclusive-disjunction", "is-fireable", "until"]
        raise self.error(f"<{kind}> is not part of a formula", node, near_matches(kind, known))

    def quantified(self, node: etree._Element, path: etree._Element) -> Formula:
        quantifier, kind = QUANTIFIERS[_local(node)], _local(path)
        if kind == "until":
            return quantifier(self.until(path, False))
        if kind not in _TEMPORAL:
            raise self.error(f"<{_local(node)}> needs a temporal operator, not <{kind}>", path)
        (operand,) = self.children(path, 1, 1)
        inner = quantifier(UNARY[kind](self.formula(operand, False)))
        if kind != "next":
            return inner
        return And((inner, Not(Deadlock()))) if quantifier is Exists else Or((inner, Deadlock()))

    def until(self, node: etree._Element, is_linear: bool) -> Formula:
        before, reach = self.children(node, 2, 2)
        if (_local(before), _local(reach)) != ("before", "reach"):
            raise self.error("<until> holds <before> and <reach>", node)
        ((left,), (right,)) = (self.children(part, 1, 1) for part in (before, reach))
        return Until(self.formula(left, is_linear), self.formula(right, is_linear))

    def comparison(self, node: etree._Element, symbol: ComparisonOperator) -> Formula:
        left, right = (self.sum(part) for part in self.children(node, 2, 2))
        factors = {place: left.get(place, 0) - right.get(place, 0) for place in {**left, **right}}
        bound = -factors.pop("", 0)
        terms = tuple((factor, Name(place)) for place, factor in factors.items() if factor)
        return Comparison(terms, symbol, bound) if terms else Constant(OPERATORS[symbol](0, bound))

    def sum(self, node: etree._Element) -> dict[str, int]:
        """Return the factor of each place in a sum; that of the empty name is the constant."""
        kind = _local(node)
        if kind == "integer-constant":
            return {"": self.number(node)}
        total: dict[str, int] = {}
        if kind == "tokens-count":
            for place in self.places(node):
                total[place] = total.get(place, 0) + 1
        elif kind in ("integer-sum", "integer-difference"):
            most = None if kind == "integer-sum" else 2
            for index, part in enumerate(self.children(node, most or 1, most)):
                sign = -1 if index and kind == "integer-difference" else 1
                for place, factor in self.sum(part).items():
                    total[place] = total.get(place, 0) + sign * factor
        elif kind == "integer-product":
            total = {"": 1}
            for part in self.children(node, 1):
                other = self.sum(part)
                if set(total) <= {""}:
                    total, other = other, total
                elif not set(other) <= {""}:
                    raise self.error("a product of places is not linear", node)
                total = {place: factor * other.get("", 0) for place, factor in total.items()}
        else:
            raise self.error(f"<{kind}> is not a number", node)
        if any(abs(factor) >= 10**_LARGEST_DIGITS for factor in total.values()):
            raise self.error("is not a whole number of at most 18 digits", node)
        return total

    def number(self, node: etree._Element) -> int:
        text = self.text(node)
        digits = text.removeprefix("-")
        if not (digits.isascii() and digits.isdigit()) or len(digits) > _LARGEST_DIGITS:
            raise self.error("is not a whole number of at most 18 digits", node)
        return int(text)

    def places(self, node: etree._Element) -> tuple[str, ...]:
        return tuple(self.name(part, "place", self.names.places) for part in self.children(node, 1))

    def fireable(self, node: etree._Element) -> Formula:
        parts = self.children(node, 1)
        members = [self.name(part, "transition", self.names.transitions) for part in parts]
        return Enabled(Name(self.names.group(members)))

    def name(self, node: etree._Element, kind: str, resolve: Callable[[str], object]) -> str:
        if _local(node) != kind:
            raise self.error(f"<{_local(node)}> is not a <{kind}>", node)
        try:
            text = self.text(node)
            resolve(text)
        except FormulaError as error:
            raise self.error(error.message, node, error.hint) from None
        return text


def _local(node: etree._Element) -> str:
    """Return the tag of an element in the contest's namespace, and an unknown one for others."""
    tag = etree.QName(node)
    return tag.localname if tag.namespace == NAMESPACE else str(node.tag)


def _adopt(root: etree._Element, note: Callable[[str], None] | None) -> None:
    """Move all elements without a namespace, or with that of the root, into the contest's namespace."""
    own: str | None = etree.QName(root).namespace
    if own == NAMESPACE:
        return
    for node in root.iter(tag=etree.Element):
        if etree.QName(node).namespace in (own, None):
            node.tag = f"{{{NAMESPACE}}}{etree.QName(node).localname}"
    if note is not None:
        found = f"the namespace {own!r}" if own else "no namespace"
        note(f"has {found}; read as a property file of the contest ({NAMESPACE})")


def _is_linear(node: etree._Element) -> bool:
    """Whether a formula has a temporal operator that does not belong to a quantifier."""
    outer = node[0] if _local(node) == "all-paths" and len(node) == 1 else node
    for part in outer.iter(tag=etree.Element):
        parent = part.getparent()
        is_quantified = parent is not None and _local(parent) in QUANTIFIERS
        if _local(part) in _TEMPORAL and not is_quantified:
            return True
    return False
