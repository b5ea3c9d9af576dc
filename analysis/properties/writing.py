"""Writes the contest's property files; names are those of the net, for system models the flattened one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lxml import etree

from dineros.analysis.logic.ctl.fixpoints import basic
from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, NoneEnabled, SomeEnabled
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.syntax import (
    And,
    Atom,
    Constant,
    Deadlock,
    Exists,
    ForAll,
    Formula,
    Next,
    Not,
    Or,
    Release,
    Until,
    WeakUntil,
)
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.properties.property import Property, said_of_all
from dineros.analysis.properties.reading import BINARY, MANY, NAMESPACE, QUANTIFIERS, UNARY
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.atomic import write_atomically

_TAGS: dict[type[Formula], str] = {
    kind: tag for tag, kind in (*QUANTIFIERS.items(), *UNARY.items(), *MANY.items(), *BINARY.items())
}


def write_properties(
    path: Path | str, properties: Sequence[Property], net: CompiledNet, names: Names
) -> None:
    """Write a property file, completely or not at all.

    Raises
    ------
    DinerosError
        A formula cannot be expressed in the contest's files: it has `fired` atoms or weighted sums.

        Questions about any net are written as equivalent CTL formulas.
    """
    root = etree.Element("property-set", xmlns=NAMESPACE)
    for one in properties:
        add_property(root, one, net, names)
    etree.indent(root)
    write_atomically(path, etree.tostring(root, xml_declaration=True, encoding="UTF-8") + b"\n")


def add_property(root: etree._Element, one: Property, net: CompiledNet, names: Names) -> None:
    """Add a property to a set of them.

    Raises
    ------
    DinerosError
        As for `write_properties`.
    """
    node = etree.SubElement(root, "property")
    etree.SubElement(node, "id").text = one.id
    etree.SubElement(node, "description").text = "written by DiNeROS"
    formula = etree.SubElement(node, "formula")
    if one.kind == "bound":
        bound = etree.SubElement(formula, "place-bound")
        _names(bound, "place", [net.places[p] for name in one.places for p in names.places(name)])
        return
    says = one.formula or said_of_all(one.examination, net)
    writer = _Writer(net, BoundAtoms(net, says, names if one.formula else NetNames(net)))
    if one.kind == "ltl":
        writer.linear(etree.SubElement(formula, "all-paths"), says)
    else:
        writer.branching(formula, says)


def _names(node: etree._Element, kind: str, names: Sequence[str]) -> None:
    for name in names:
        etree.SubElement(node, kind).text = name


class _Writer:
    def __init__(self, net: CompiledNet, atoms: BoundAtoms) -> None:
        self.net, self.atoms = net, atoms

    def linear(self, outer: etree._Element, formula: Formula) -> None:
        """Write an LTL formula, without the operators that the contest does not have."""
        match formula:
            case Release(left, right):
                formula = Not(Until(Not(left), Not(right)))
            case WeakUntil(left, right):
                formula = Not(Until(Not(right), And((Not(left), Not(right)))))
        if isinstance(formula, Until):
            self.until(outer, formula, True)
        else:
            self.plain(outer, formula, True)

    def branching(self, outer: etree._Element, formula: Formula) -> None:
        """Write a CTL formula, for the contest's semantics, in which a deadlock has no next marking."""
        match formula:
            case And((Exists(Next() as path), Not(Deadlock()))) | Or((ForAll(Next() as path), Deadlock())):
                (quantified, _) = formula.operands
                self.quantified(outer, type(quantified), path)
            case Exists(Next(inner) as path):
                either = etree.SubElement(outer, "disjunction")
                self.quantified(either, Exists, path)
                self.plain(either, And((Deadlock(), inner)), False)
            case ForAll(Next(inner) as path):
                both = etree.SubElement(outer, "conjunction")
                self.quantified(both, ForAll, path)
                self.plain(both, Or((Not(Deadlock()), inner)), False)
            case ForAll(Release() | WeakUntil()) | Exists(Release() | WeakUntil()):
                self.branching(outer, basic(formula))
            case ForAll(path) | Exists(path):
                self.quantified(outer, type(formula), path)
            case _:
                self.plain(outer, formula, False)

    def quantified(self, outer: etree._Element, quantifier: type[Formula], path: Formula) -> None:
        node = etree.SubElement(outer, _TAGS[quantifier])
        if isinstance(path, Until):
            self.until(node, path, False)
        else:
            self.branching(etree.SubElement(node, _TAGS[type(path)]), path.operands[0])

    def until(self, outer: etree._Element, formula: Until, is_linear: bool) -> None:
        node = etree.SubElement(outer, "until")
        for tag, operand in (("before", formula.left), ("reach", formula.right)):
            (self.linear if is_linear else self.branching)(etree.SubElement(node, tag), operand)

    def plain(self, outer: etree._Element, formula: Formula, is_linear: bool) -> None:
        """Write an atom, or an operator and its operands."""
        match formula:
            case Constant(value):
                etree.SubElement(outer, "true" if value else "false")
            case Atom():
                self.atom(outer, formula)
            case _:
                node = etree.SubElement(outer, _TAGS[type(formula)])
                for operand in formula.operands:
                    (self.linear if is_linear else self.branching)(node, operand)

    def atom(self, outer: etree._Element, atom: Atom) -> None:
        match NoneEnabled() if isinstance(atom, Deadlock) else self.atoms.conditions[atom]:
            case NoneEnabled():
                etree.SubElement(outer, "deadlock")
            case SomeEnabled(transitions):
                node = etree.SubElement(outer, "is-fireable")
                _names(node, "transition", [self.net.transitions[t] for t in sorted(transitions)])
            case Linear(factors, symbol, bound):
                self.comparison(outer, atom, factors, symbol, bound)
            case _:
                raise DinerosError(f"{atom} cannot be expressed in a property file: it refers to steps")

    def comparison(
        self, outer: etree._Element, atom: Atom, factors: dict[int, int], symbol: str, bound: int
    ) -> None:
        if symbol in ("==", "!="):
            node = outer if symbol == "==" else etree.SubElement(outer, "negation")
            node = etree.SubElement(node, "conjunction")
            self.comparison(node, atom, factors, "<=", bound)
            self.comparison(node, atom, factors, ">=", bound)
            return
        if symbol in (">=", ">"):
            factors, bound = {place: -factor for place, factor in factors.items()}, -bound
        if symbol in ("<", ">"):
            bound -= 1
        sides = [
            [self.net.places[p] for p, factor in factors.items() for _ in range(factor * sign)]
            for sign in (1, -1)
        ]
        if bound and all(sides):
            raise DinerosError(
                f"{atom} cannot be expressed in a property file",
                hint="compare a sum of places with a number, or two sums of places",
            )
        node = etree.SubElement(outer, "integer-le")
        for side, constant in zip(sides, (-bound, bound), strict=True):
            if side:
                _names(etree.SubElement(node, "tokens-count"), "place", side)
            else:
                etree.SubElement(node, "integer-constant").text = str(constant)
