"""Reading a symmetric net: its places, transitions and arcs on all pages, with references resolved."""

from __future__ import annotations

from dataclasses import dataclass, field

from lxml import etree

from dineros.metamodel import pn
from dineros.metamodel.colours.sorts import Sort
from dineros.metamodel.colours.terms import (
    Junction,
    Multiset,
    NegativeCountError,
    Truth,
    multiset_of,
    variables_of,
)
from dineros.metamodel.colours.unfolding import (
    ColouredPlace,
    ColouredTransition,
    TooLargeError,
    TooManyValuesError,
    Unfolding,
)
from dineros.metamodel.files.pnml.layout import is_inhibitor_mark
from dineros.metamodel.files.pnml.plain.known import COLOURED_ATTRIBUTES, HARMLESS_NAMESPACES
from dineros.metamodel.files.pnml.plain.values import only
from dineros.metamodel.files.pnml.source import Source, children, local, text_of
from dineros.metamodel.files.pnml.symmetric.building import build_net
from dineros.metamodel.files.pnml.symmetric.declarations import Declarations
from dineros.metamodel.files.pnml.symmetric.term_reader import TermReader
from dineros.metamodel.files.schema import shortened
from dineros.metamodel.files.xml import line_of
from dineros.metamodel.limits import most

_ANY = frozenset({"name", "graphics", "toolspecific"})
_ELEMENTS = {
    "net": _ANY | {"page", "declaration"},
    "page": _ANY
    | {"page", "declaration", "place", "transition", "arc", "referencePlace", "referenceTransition"},
    "place": _ANY | {"type", "hlinitialMarking"},
    "transition": _ANY | {"condition"},
    "referencePlace": _ANY,
    "referenceTransition": _ANY,
    "arc": _ANY | {"hlinscription"},
}
_LABEL = frozenset({"text", "structure", "graphics", "toolspecific"})
_HINT = "it may change the behaviour; remove it if it does not"
_MISSING = {"hlinscription": "how many tokens it moves, and of which colours, is not known"}


@dataclass
class ColouredNet:
    """The content of a file, before it is unfolded."""

    places: list[ColouredPlace] = field(default_factory=list)
    transitions: list[ColouredTransition] = field(default_factory=list)
    nodes: dict[str, etree._Element] = field(default_factory=dict)
    arcs: list[etree._Element] = field(default_factory=list)


def read_symmetric(net: etree._Element, source: Source) -> pn.Net:
    """Return the plain net of a symmetric net; `origins_of` maps places to their colours.

    Raises
    ------
    ModelFileError
        Something is wrong or not supported, or the plain net is too large.
    """
    limit = most("elements")
    hint = f"raise the limit with --limit elements=NUMBER (now {limit})"
    try:
        coloured = _SymmetricReader(net, source).read()
        unfolding = Unfolding(coloured.places, coloured.transitions, limit)
    except TooManyValuesError:
        message = "conditions have variables that no arc binds, with too many values to try"
        raise source.error(message, net, hint=hint) from None
    except TooLargeError:
        raise source.error("the unfolded net is too large", net, hint=hint) from None
    except NegativeCountError:
        raise source.error("an arc takes away more tokens than there are", net) from None
    if sum(map(len, unfolding.colours)) + len(unfolding.firings) > limit:
        raise source.error("the unfolded net is too large", net, hint=hint)
    return build_net(net, coloured.places, coloured.transitions, coloured.nodes, unfolding, source)


class _SymmetricReader:
    def __init__(self, net: etree._Element, source: Source) -> None:
        self._net, self._source = net, source
        self._declared = Declarations(source)
        self._terms = TermReader(self._declared, source)
        self._references: dict[str, etree._Element] = {}
        self._coloured = ColouredNet()

    def read(self) -> ColouredNet:
        declarations: list[etree._Element] = []
        pages = [self._net]
        while pages:
            page = pages.pop()
            for xml in self._parts(page):
                kind = local(xml)
                if kind == "page":
                    pages.append(xml)
                elif kind == "declaration":
                    declarations.append(xml)
                elif kind == "arc":
                    self._parts(xml)
                    self._coloured.arcs.append(xml)
                elif kind not in _ANY:
                    self._node(xml)
        if not self._coloured.nodes and not self._source.errors:
            hint = "put its elements into a <page>"
            raise self._source.error("the net has no page with nodes", self._net, hint=hint)
        self._declared.read(declarations)
        self._source.refuse_errors()
        self._fill()
        self._source.refuse_errors()
        return self._coloured

    def _parts(self, xml: etree._Element) -> list[etree._Element]:
        """Return the elements inside; complain about those that are not known there."""
        kind = local(xml)
        for name in map(str, xml.attrib):
            is_known = name in COLOURED_ATTRIBUTES and (name, kind) != ("type", "arc")
            if not is_known and not name.startswith(HARMLESS_NAMESPACES):
                what = f"<{kind}> {xml.get('id')!r} has an unknown attribute {shortened(name)}"
                self._source.complain(what, xml, id=xml.get("id"), hint=_HINT)
        found = []
        for inner in children(xml):
            if kind == "arc" and is_inhibitor_mark(inner):
                hint = "inhibitor arcs of coloured nets are not read"
                self._source.complain(f"arc {xml.get('id')!r} is an inhibitor arc", inner, hint=hint)
            elif local(inner) in _ELEMENTS[kind]:
                found.append(inner)
            else:
                what = f"<{local(inner)}> is not part of the <{kind}> of a symmetric net"
                self._source.complain(what, inner, hint=_HINT)
        return found

    def _node(self, xml: etree._Element) -> None:
        id = self._source.attribute(xml, "id")
        first = self._coloured.nodes.get(id, self._references.get(id))
        if first is not None:
            raise self._source.error(f"the id {id!r} is taken by line {line_of(first)}", xml, id=id)
        self._parts(xml)
        (self._references if local(xml).startswith("reference") else self._coloured.nodes)[id] = xml

    def _fill(self) -> None:
        coloured, number = self._coloured, {}
        sorts: list[Sort] = []
        for id, xml in coloured.nodes.items():
            if local(xml) == "place":
                number[id] = len(coloured.places)
                coloured.places.append(self._place(id, xml))
                sorts.append(coloured.places[-1].sort)
        arcs: dict[str, tuple[list[tuple[int, Multiset]], list[tuple[int, Multiset]]]] = {
            id: ([], []) for id, xml in coloured.nodes.items() if local(xml) == "transition"
        }
        for xml in coloured.arcs:
            ends = [self._end(xml, attribute) for attribute in ("source", "target")]
            kinds = [local(coloured.nodes[end]) for end in ends]
            if kinds[0] == kinds[1]:
                raise self._source.error(f"the arc joins two {kinds[0]}s", xml, id=xml.get("id"))
            place, transition = ends if kinds[0] == "place" else reversed(ends)
            term = self._terms.multiset(self._needed(xml, "hlinscription"), sorts[number[place]])
            arcs[transition][kinds[0] != "place"].append((number[place], term))
        for id, (takes, puts) in arcs.items():
            structure = self._structure(coloured.nodes[id], "condition")
            condition = Truth(True) if structure is None else self._terms.condition(structure)
            made = ColouredTransition(id, Junction(True, (condition,)), tuple(takes), tuple(puts))
            coloured.transitions.append(made)

    def _place(self, id: str, xml: etree._Element) -> ColouredPlace:
        sort = self._declared.sort(self._needed(xml, "type"))
        structure = self._structure(xml, "hlinitialMarking")
        if structure is None:
            return ColouredPlace(id, sort, {})
        term = self._terms.multiset(structure, sort)
        if (variable := next(variables_of(term), None)) is not None:
            what = f"the initial marking has the variable {variable.name!r}"
            raise self._source.error(what, xml, id=id)
        try:
            return ColouredPlace(id, sort, multiset_of(term, most("elements"))({}))
        except NegativeCountError:
            what = "the initial marking takes away more tokens than there are"
            raise self._source.error(what, xml, id=id) from None

    def _needed(self, xml: etree._Element, name: str) -> etree._Element:
        """Return the term of a label that must be there."""
        structure = self._structure(xml, name)
        if structure is None:
            what = f"<{local(xml)}> {xml.get('id')!r} has no <{name}>"
            hint = (
                "how many tokens it moves, and of which colours, is not known"
                if name == "hlinscription"
                else None
            )
            raise self._source.error(what, xml, id=xml.get("id"), hint=hint)
        return structure

    def _structure(self, xml: etree._Element, name: str) -> etree._Element | None:
        """Return the term of a label; None if the element does not have this label."""
        label = only(xml, name, self._source)
        if label is None:
            return None
        for part in children(label):
            if local(part) not in _LABEL:
                raise self._source.error(f"<{local(part)}> is not part of <{name}>", part)
        structure = only(label, "structure", self._source)
        if structure is None:
            hint = f"only <structure> is read, not the text {text_of(label)[:40]!r}"
            raise self._source.error(f"<{name}> has no <structure>", label, hint=hint)
        return self._declared.only(structure)

    def _end(self, arc: etree._Element, attribute: str) -> str:
        """Return the id of the node at an end of an arc, references followed."""
        id, seen = self._source.attribute(arc, attribute), set()
        while id in self._references and id not in seen:
            seen.add(id)
            id = self._source.attribute(self._references[id], "ref")
        if id in seen:
            raise self._source.error(f"the reference {id!r} refers to itself", self._references[id], id=id)
        if id not in self._coloured.nodes:
            raise self._source.error(f"there is no node {id!r}", arc, id=arc.get("id"))
        return id
