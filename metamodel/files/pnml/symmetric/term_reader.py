"""Terms of a symmetric net: colours, multisets and conditions, checked for their sorts."""

from __future__ import annotations

from typing import TypeVar

from lxml import etree

from dineros.metamodel.colours.sorts import BOOL, DOT, IntegerRange, Product, Sort
from dineros.metamodel.colours.terms import (
    All,
    Comparison,
    Condition,
    Constant,
    Difference,
    Junction,
    Mapped,
    Multiset,
    Not,
    Shift,
    Sum,
    Times,
    Truth,
    Tuple,
    Tuples,
    Value,
)
from dineros.metamodel.errors import near_matches
from dineros.metamodel.files.pnml.source import Source, children, local
from dineros.metamodel.files.pnml.symmetric.declarations import Declarations

_COMPARISONS = {
    "equality": "==",
    "inequality": "!=",
    "lessthan": "<",
    "lessthanorequal": "<=",
    "greaterthan": ">",
    "greaterthanorequal": ">=",
    "lt": "<",
    "leq": "<=",
    "gt": ">",
    "geq": ">=",
    "ltp": "<",
    "gtp": ">",
}
_SHIFTS = {"successor": 1, "predecessor": -1}
_VALUES = (
    "variable",
    "useroperator",
    "dotconstant",
    "booleanconstant",
    "finiteintrangeconstant",
    "partitionelementof",
    "tuple",
)
_MULTISETS = ("all", "empty", "numberof", "add", "subtract", "scalarproduct")
_CONDITIONS = (*_COMPARISONS, "and", "or", "not", "imply", "booleanconstant")
_COUNTS = ("cardinality", "cardinalityof", "contains")
_COUNTS_HINT = "terms cannot ask about the size of a multiset; write the number or the colours"
_Found = TypeVar("_Found")


class TermReader:
    """Reads terms; each method raises `ModelFileError` where a term is wrong or not supported.

    Parameters
    ----------
    declarations : Declarations
        What terms may name.
    source : Source
        The file.
    """

    def __init__(self, declarations: Declarations, source: Source) -> None:
        self._declared = declarations
        self._source = source

    def value(self, xml: etree._Element, expected: Sort | None) -> Value:
        """Return a colour of the expected sort; None for any sort."""
        term = self._value(xml, expected)
        if expected is not None and term.sort != expected:
            what = f"<{local(xml)}> has the sort {term.sort.name}, expected is {expected.name}"
            raise self._source.error(what, xml)
        return term

    def _value(self, xml: etree._Element, expected: Sort | None) -> Value:
        kind, source = local(xml), self._source
        if kind == "variable":
            return self._named(self._declared.variables, "variable", xml, "refvariable")
        if kind == "useroperator":
            return self._named(self._declared.constants, "constant", xml, "declaration")
        if kind == "dotconstant":
            return Constant(0, DOT)
        if kind == "booleanconstant":
            return Constant(int(self._truth(xml)), BOOL)
        if kind in _SHIFTS:
            term = self.value(self._operand(xml), expected)
            if isinstance(term.sort, Product):
                raise source.error(f"<{kind}> of a tuple: tuples have no order", xml)
            return Shift(term, _SHIFTS[kind])
        if kind == "finiteintrangeconstant":
            return self._number(xml)
        if kind == "partitionelementof":
            return self._element(xml)
        if kind == "tuple":
            operands = self._operands(xml)
            return (
                self.value(operands[0], expected) if len(operands) == 1 else self._tuple_value(xml, expected)
            )
        hint = _COUNTS_HINT if kind in _COUNTS else near_matches(kind, [*_VALUES, *_SHIFTS])
        raise source.error(f"the term <{kind}> is not supported", xml, hint=hint)

    def _named(self, known: dict[str, _Found], what: str, xml: etree._Element, attribute: str) -> _Found:
        name = self._source.attribute(xml, attribute)
        if name not in known:
            raise self._source.error(
                f"the {what} {name!r} is not declared", xml, hint=near_matches(name, known)
            )
        return known[name]

    def _number(self, xml: etree._Element) -> Constant:
        number, sort = self._declared.integer(xml, "value"), self._declared.sort(self._declared.only(xml))
        if not isinstance(sort, IntegerRange) or not sort.first <= number <= sort.last:
            raise self._source.error(f"{number} is not in the range {sort.name}", xml)
        return Constant(number - sort.first, sort)

    def _element(self, xml: etree._Element) -> Mapped:
        name = self._source.attribute(xml, "refpartition")
        partition = self._declared.partitions.get(name)
        if partition is None:
            raise self._source.error(f"the partition {name!r} is not declared", xml)
        return Mapped(self.value(self._operand(xml), partition.divided), partition.table, partition.sort)

    def _tuple_value(self, xml: etree._Element, expected: Sort | None) -> Tuple:
        operands = self._operands(xml)
        sorts = self._component_sorts(xml, expected, len(operands))
        terms = tuple(self.value(operand, sort) for operand, sort in zip(operands, sorts, strict=True))
        sort = expected if isinstance(expected, Product) else Product("tuple", tuple(t.sort for t in terms))
        return Tuple(terms, sort)

    def _component_sorts(self, xml: etree._Element, expected: Sort | None, number: int) -> list[Sort | None]:
        if expected is None:
            return [None] * number
        if not isinstance(expected, Product):
            raise self._source.error(f"a tuple, expected is the sort {expected.name}", xml)
        if len(expected.parts) != number:
            what = f"a tuple of {number} components, expected are {len(expected.parts)}"
            raise self._source.error(what, xml)
        return list(expected.parts)

    def _truth(self, xml: etree._Element) -> bool:
        return self._source.attribute(xml, "value").strip().lower() in ("true", "1")

    # ---------------------------------------------------------------------------------------- multisets

    def multiset(self, xml: etree._Element, sort: Sort) -> Multiset:
        """Return a multiset of colours of a sort."""
        kind = local(xml)
        if kind in ("all", "empty"):
            found = self._declared.sort(self._declared.only(xml))
            if found != sort:
                raise self._source.error(f"<{kind}> of {found.name}, expected is {sort.name}", xml)
            return All(sort) if kind == "all" else Sum(())
        if kind in ("numberof", "scalarproduct"):
            return self._times(xml, sort)
        if kind == "add":
            return Sum(tuple(self.multiset(operand, sort) for operand in self._operands(xml)))
        if kind == "subtract":
            operands = self._operands(xml)
            if len(operands) < 2:
                raise self._source.error(f"<subtract> of {len(operands)} multisets, at least two", xml)
            first, *others = (self.multiset(operand, sort) for operand in operands)
            return Difference(first, others[0] if len(others) == 1 else Sum(tuple(others)))
        if kind == "tuple":
            return self._tuples(xml, sort)
        if kind == "useroperator" and (colours := self._colours_of_element(xml, sort)):
            return Sum(colours)
        if kind not in (*_VALUES, *_SHIFTS):
            hint = _COUNTS_HINT if kind in _COUNTS else near_matches(kind, [*_MULTISETS, *_VALUES, *_SHIFTS])
            raise self._source.error(f"the term <{kind}> is not supported", xml, hint=hint)
        return self.value(xml, sort)

    def _times(self, xml: etree._Element, sort: Sort) -> Times:
        operands = self._operands(xml)
        numbers = [operand for operand in operands if local(operand) == "numberconstant"]
        inner = [operand for operand in operands if local(operand) != "numberconstant"]
        if not inner:
            raise self._source.error(f"<{local(xml)}> without tokens", xml)
        if len(numbers) > 1:
            raise self._source.error(f"<{local(xml)}> with {len(numbers)} numbers", xml)
        number = 1
        for each in numbers:
            number = self._source.integer(self._source.attribute(each, "value"), each, "number of tokens", 0)
        parts = tuple(self.multiset(operand, sort) for operand in inner)
        return Times(number, parts[0] if len(parts) == 1 else Sum(parts))

    def _colours_of_element(self, xml: etree._Element, sort: Sort) -> tuple[Constant, ...]:
        """Return the colours in an element of a partition of the sort; empty for any other constant."""
        element = self._named(self._declared.constants, "constant", xml, "declaration")
        for partition in self._declared.partitions.values():
            if partition.sort == element.sort != sort == partition.divided:
                held = (value for value, holder in enumerate(partition.table) if holder == element.value)
                return tuple(Constant(value, sort) for value in held)
        return ()

    def _tuples(self, xml: etree._Element, sort: Sort) -> Multiset:
        operands = self._operands(xml)
        if len(operands) == 1:
            return self.multiset(operands[0], sort)
        sorts = self._component_sorts(xml, sort, len(operands))
        assert isinstance(sort, Product)
        parts = [self.multiset(inner, part) for inner, part in zip(operands, sorts, strict=True) if part]
        values = [part for part in parts if not isinstance(part, (All, Times, Sum, Difference, Tuples))]
        return Tuple(tuple(values), sort) if len(values) == len(parts) else Tuples(tuple(parts), sort)

    # --------------------------------------------------------------------------------------- conditions

    def condition(self, xml: etree._Element) -> Condition:
        """Return a condition."""
        kind = local(xml)
        if kind in _COMPARISONS:
            return self._comparison(xml, _COMPARISONS[kind])
        if kind == "booleanconstant":
            return Truth(self._truth(xml))
        operands = self._operands(xml)
        if kind in ("and", "or"):
            return Junction(kind == "and", tuple(self.condition(operand) for operand in operands))
        if kind == "not" and len(operands) == 1:
            return Not(self.condition(operands[0]))
        if kind == "imply" and len(operands) == 2:
            return Junction(False, (Not(self.condition(operands[0])), self.condition(operands[1])))
        hint = _COUNTS_HINT if kind in _COUNTS else near_matches(kind, _CONDITIONS)
        what = f"the condition <{kind}>" + (f" of {len(operands)} operands" if kind in _CONDITIONS else "")
        raise self._source.error(f"{what} is not supported", xml, hint=hint)

    def _comparison(self, xml: etree._Element, operator: str) -> Comparison:
        operands = self._operands(xml)
        if len(operands) != 2:
            raise self._source.error(f"<{local(xml)}> compares {len(operands)} terms instead of two", xml)
        left, right = (self.value(operand, None) for operand in operands)
        first, second = left.sort, right.sort
        if isinstance(first, IntegerRange) and isinstance(second, IntegerRange):
            return Comparison(operator, left, right, first.first - second.first)
        if first != second:
            raise self._source.error(f"compares the sorts {first.name} and {second.name}", xml)
        if operator not in ("==", "!=") and isinstance(first, Product):
            raise self._source.error("tuples have no order", xml)
        return Comparison(operator, left, right)

    # ------------------------------------------------------------------------------------------ operands

    def _operands(self, xml: etree._Element) -> list[etree._Element]:
        found = []
        for subterm in children(xml):
            if local(subterm) != "subterm":
                raise self._source.error(f"<{local(subterm)}> stands where <subterm> is expected", subterm)
            found.append(self._declared.only(subterm))
        return found

    def _operand(self, xml: etree._Element) -> etree._Element:
        operands = self._operands(xml)
        if len(operands) != 1:
            raise self._source.error(f"<{local(xml)}> has {len(operands)} operands instead of one", xml)
        return operands[0]
