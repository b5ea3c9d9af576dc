"""Declarations of a symmetric net: named sorts with their constants, partitions, and variables."""

from __future__ import annotations

from dataclasses import dataclass

from lxml import etree

from dineros.metamodel.colours.sorts import BOOL, DOT, Enumeration, IntegerRange, Product, Sort
from dineros.metamodel.colours.terms import Constant, Variable
from dineros.metamodel.errors import near_matches
from dineros.metamodel.files.pnml.source import Source, children, local
from dineros.metamodel.limits import most

_LISTED = ("cyclicenumeration", "finiteenumeration")
_SORTS = (*_LISTED, "finiteintrange", "productsort", "dot", "bool", "usersort", "multisetsort")
_HINTS = {
    "namedoperator": "write its definition where it is used",
    "arbitraryoperator": "it has no definition, so it cannot be computed",
    "arbitrarysort": "it has no values; declare them as an enumeration",
}


@dataclass(frozen=True)
class Partition:
    """A partition of a sort.

    Attributes
    ----------
    sort : Enumeration
        Its elements.
    table : tuple of int
        By value of the divided sort: the element that holds it.
    divided : Sort
        The sort that is divided.
    """

    sort: Enumeration
    table: tuple[int, ...]
    divided: Sort


class Declarations:
    """All declarations of a net, by their ids.

    Attributes
    ----------
    sorts : dict of str to Sort
        Named sorts and partitions.
    constants : dict of str to Constant
        Constants of enumerations and elements of partitions.
    variables : dict of str to Variable
        Variables.
    partitions : dict of str to Partition
        Partitions.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self.sorts: dict[str, Sort] = {}
        self.constants: dict[str, Constant] = {}
        self.variables: dict[str, Variable] = {}
        self.partitions: dict[str, Partition] = {}
        self._elements: dict[str, etree._Element] = {}
        self._open: set[str] = set()

    def read(self, declarations: list[etree._Element]) -> None:
        """Read ``<declaration>`` elements; sorts may be used before they are declared.

        Raises
        ------
        ModelFileError
            A declaration is wrong, doubled, or of a kind that is not known.
        """
        found = [each for one in declarations for each in _declared(one, self._source)]
        named = {"namedsort": self._named_sort, "partition": self._partition}
        for xml in found:
            if local(xml) in named:
                id = self._source.attribute(xml, "id")
                if id in self._elements:
                    raise self._source.error(f"the sort {id!r} is declared twice", xml, id=id)
                self._elements[id] = xml
        for id in self._elements:
            self.sort_named(id, self._elements[id])
        for xml in found:
            kind = local(xml)
            if kind == "variabledecl":
                id = self._source.attribute(xml, "id")
                if id in self.variables:
                    raise self._source.error(f"the variable {id!r} is declared twice", xml, id=id)
                self.variables[id] = Variable(id, self.sort(self.only(xml)))
            elif kind not in named:
                hint = _HINTS.get(kind) or near_matches(kind, [*named, "variabledecl"])
                hint = hint or "symmetric nets have sorts and variables"
                raise self._source.error(f"the declaration <{kind}> is not supported", xml, hint=hint)

    def only(self, xml: etree._Element) -> etree._Element:
        """Return the one element inside of another.

        Raises
        ------
        ModelFileError
            There is none, or more than one.
        """
        inner = list(children(xml))
        if len(inner) != 1:
            raise self._source.error(f"<{local(xml)}> holds {len(inner)} elements instead of one", xml)
        return inner[0]

    def sort_named(self, id: str, where: etree._Element) -> Sort:
        """Return a declared sort.

        Raises
        ------
        ModelFileError
            There is none, or it is declared by itself.
        """
        if id not in self.sorts:
            xml = self._elements.get(id)
            if xml is None:
                hint = near_matches(id, self._elements)
                raise self._source.error(f"the sort {id!r} is not declared", where, hint=hint)
            if id in self._open:
                raise self._source.error(f"the sort {id!r} is declared by itself", xml, id=id)
            self._open.add(id)
            self.sorts[id] = (self._partition if local(xml) == "partition" else self._named_sort)(id, xml)
            self._open.remove(id)
        return self.sorts[id]

    def sort(self, xml: etree._Element, name: str | None = None) -> Sort:
        """Return the sort that an element denotes.

        Raises
        ------
        ModelFileError
            It is of a kind that is not known, empty, or too large.
        """
        kind = local(xml)
        name = name or kind
        if kind == "usersort":
            return self.sort_named(self._source.attribute(xml, "declaration"), xml)
        if kind == "multisetsort":
            return self.sort(self.only(xml), name)
        if kind == "dot":
            return DOT
        if kind == "bool":
            return BOOL
        if kind == "finiteintrange":
            first, last = (self.integer(xml, attribute) for attribute in ("start", "end"))
            if last < first:
                raise self._source.error(f"the range from {first} to {last} is empty", xml)
            return self._sized(IntegerRange(name, first, last), xml)
        if kind == "productsort":
            parts = tuple(self.sort(part) for part in children(xml))
            if not parts:
                raise self._source.error("a product of no sorts", xml)
            return parts[0] if len(parts) == 1 else self._sized(Product(name, parts), xml)
        if kind in _LISTED:
            return self._listed(xml, name)
        hint = near_matches(kind, _SORTS) or f"sorts are {', '.join(_SORTS)}"
        raise self._source.error(f"the sort <{kind}> is not supported", xml, hint=hint)

    def integer(self, xml: etree._Element, attribute: str) -> int:
        """Return an attribute that is a whole number."""
        return self._source.integer(self._source.attribute(xml, attribute), xml, attribute)

    def _sized(self, sort: Sort, xml: etree._Element) -> Sort:
        limit = most("elements")
        if sort.size > limit**2:
            raise self._source.error(f"the sort has {sort.size} values, at most {limit**2} are allowed", xml)
        return sort

    def _named_sort(self, id: str, xml: etree._Element) -> Sort:
        inner = self.only(xml)
        return self._listed(inner, id) if local(inner) in _LISTED else self.sort(inner, xml.get("name") or id)

    def _listed(self, xml: etree._Element, name: str) -> Sort:
        labels = [(each, self._source.attribute(each, "id")) for each in children(xml)]
        if not labels:
            raise self._source.error("an enumeration without values", xml)
        sort = Enumeration(name, tuple(each.get("name") or id for each, id in labels))
        for value, (each, id) in enumerate(labels):
            self._add_constant(id, Constant(value, sort), each)
        return sort

    def _partition(self, id: str, xml: etree._Element) -> Sort:
        divided: Sort | None = None
        groups: list[tuple[str, str, list[int], etree._Element]] = []
        for inner in children(xml):
            if local(inner) != "partitionelement":
                divided = self.sort(inner)
                continue
            element = self._source.attribute(inner, "id")
            values = [self.constant(each, divided) for each in children(inner)]
            groups.append((element, inner.get("name") or element, values, inner))
        if divided is None or not groups:
            raise self._source.error("a partition needs a sort and its elements", xml, id=id)
        holder = {value: number for number, (_, _, values, _) in enumerate(groups) for value in values}
        if not len(holder) == sum(len(values) for _, _, values, _ in groups) == divided.size:
            what = f"the partition {id!r} does not have each value of {divided.name} exactly once"
            raise self._source.error(what, xml, id=id)
        sort = Enumeration(id, tuple(label for _, label, _, _ in groups))
        for number, (element, _, _, inner) in enumerate(groups):
            self._add_constant(element, Constant(number, sort), inner)
        table = tuple(holder[value] for value in range(divided.size))
        self.partitions[id] = Partition(sort, table, divided)
        return sort

    def constant(self, xml: etree._Element, sort: Sort | None) -> int:
        """Return the value of a constant of a sort.

        Raises
        ------
        ModelFileError
            It is not a constant of the sort.
        """
        if local(xml) == "finiteintrangeconstant" and isinstance(sort, IntegerRange):
            number = self.integer(xml, "value")
            if sort.first <= number <= sort.last:
                return number - sort.first
        elif local(xml) == "useroperator":
            found = self.constants.get(self._source.attribute(xml, "declaration"))
            if found is not None and found.sort == sort:
                return found.value
        raise self._source.error(f"<{local(xml)}> is not a constant of the divided sort", xml)

    def _add_constant(self, id: str, constant: Constant, xml: etree._Element) -> None:
        if id in self.constants:
            raise self._source.error(f"the constant {id!r} is declared twice", xml, id=id)
        self.constants[id] = constant


def _declared(declaration: etree._Element, source: Source) -> list[etree._Element]:
    """Return the declarations in a ``<declaration>``."""
    found: list[etree._Element] = []
    for structure in children(declaration):
        if local(structure) == "structure":
            for inner in children(structure):
                found.extend(children(inner) if local(inner) == "declarations" else [inner])
        elif local(structure) not in ("text", "graphics", "toolspecific"):
            raise source.error(f"<{local(structure)}> is not part of a declaration", structure)
    return found
