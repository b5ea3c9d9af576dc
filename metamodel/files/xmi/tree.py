"""Making model objects from the XML tree of an XMI file; references are only collected (see `reader`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from lxml import etree

from dineros.metamodel.base import EObject
from dineros.metamodel.errors import Location, ModelFileError, near_matches
from dineros.metamodel.files.schema import (
    Feature,
    Kind,
    ModelClass,
    describe,
    find_class,
    model_class,
    shortened,
)
from dineros.metamodel.files.xmi.writer import XMI, XSI
from dineros.metamodel.files.xml import Tree, attributes_of, line_of, parse, parse_bytes
from dineros.metamodel.positions import location_of, remember, remember_file

_TYPES = (f"{{{XSI}}}type", f"{{{XMI}}}type")
_XMI_ID = f"{{{XMI}}}id"
_XMI_REFERENCE = f"{{{XMI}}}idref"
_NIL = f"{{{XSI}}}nil"
_QUIET = {f"{{{XMI}}}{name}" for name in ("version", "uuid", "label")} | {
    *_TYPES,
    f"{{{XSI}}}schemaLocation",
    f"{{{XSI}}}noNamespaceSchemaLocation",
}


@dataclass(slots=True)
class Document:
    """A model file: its root and what references can name."""

    path: Path
    root: EObject | None = None
    content: bytes | None = None
    ids: dict[str, EObject] = field(default_factory=dict)
    xmi_ids: dict[str, EObject] = field(default_factory=dict)
    made: list[EObject] = field(default_factory=list)
    errors: list[ModelFileError] = field(default_factory=list)
    #: Unreadable elements: their ids, and the features that lack a value because of them.
    unread_ids: set[str] = field(default_factory=set)
    unread: set[tuple[EObject, str]] = field(default_factory=set)


@dataclass(slots=True)
class Reference:
    """A reference that waits until all files are read; `file` is None for one inside its own file."""

    document: Document
    source: EObject
    feature: Feature
    target: str
    line: int
    file: Path | None = None


class TreeReader:
    """Makes the objects of one file.

    Parameters
    ----------
    document : Document
        The file; its root, ids and objects are filled in.
    references : list of Reference
        Where references are collected.
    find_file : callable
        Returns the file that an ``href`` in this document names, given the name and the line.
    """

    def __init__(
        self,
        document: Document,
        references: list[Reference],
        find_file: Callable[[Document, str, int], Path],
    ) -> None:
        self._document = document
        self._references = references
        self._find_file = find_file
        self._classes: dict[str, ModelClass] = {}
        self._prefixes: dict[str | None, str] = {}
        self._families: list[tuple[EObject, Feature, list[EObject]]] = []

    def read(self) -> None:
        """Make all objects; what is wrong with a part is noted in the document, and the part is left out.

        Raises
        ------
        ModelFileError
            There is no root to begin with.
        """
        path, content = self._document.path, self._document.content
        tree = parse(path) if content is None else parse_bytes(content, path)
        self._collect_prefixes(tree)
        node = self._root_node(tree)
        uri, name = _split(node.tag)
        information = find_class(uri, name)
        if isinstance(information, str):
            raise self._error(
                node,
                f"the root is not a model: no class {shortened(name)} in {shortened(uri or '')}",
                information,
            )
        root = self._make(node, information)
        self._document.root = root
        remember_file(root, self._document.path)
        stack = [(node, root, information)]
        while stack:
            stack.extend(reversed(self._fill(*stack.pop())))
        self._join_families()

    def _collect_prefixes(self, tree: Tree) -> None:
        for _, (prefix, uri) in etree.iterwalk(tree, events=("start-ns",)):
            if self._prefixes.setdefault(prefix, uri) != uri:
                raise self._error(
                    None, f"the prefix {prefix!r} has two meanings, {self._prefixes[prefix]!r} and {uri!r}"
                )

    def _root_node(self, tree: Tree) -> etree._Element:
        node = tree.getroot()
        if node.tag != f"{{{XMI}}}XMI":
            return node
        if len(node) != 1:
            raise self._error(node, f"has {len(node)} roots, but a model has one")
        return node[0]

    def _make(self, node: etree._Element, information: ModelClass) -> EObject:
        if information.abstract:
            raise self._error(
                node, f"{information.qualified_name} is abstract", "name one of its subclasses by xsi:type"
            )
        element = information.python_class()
        remember(element, Location(self._document.path, line_of(node)))
        self._document.made.append(element)
        return element

    def _fill(
        self, node: etree._Element, element: EObject, information: ModelClass
    ) -> list[tuple[etree._Element, EObject, ModelClass]]:
        """Set the features of an object and return its children, which are still bare."""
        given: set[str] = set()
        for name, text in attributes_of(node):
            feature = information.features.get(name)
            if feature is None or feature.kind is Kind.NOT_STORED or feature.kind is Kind.CONTAINMENT:
                self._other_attribute(node, element, information, name, text)
                continue
            given.add(name)
            with self._noting(element, name):
                if feature.kind is Kind.ATTRIBUTE:
                    self._set(node, element, feature, text)
                else:
                    self._refer(node, element, feature, text)
        with self._noting():
            self._refuse_text(node, node.text, element)
        children: list[tuple[etree._Element, EObject, ModelClass]] = []
        families: dict[str, list[EObject]] = {}
        for child in node:
            with self._noting():
                self._refuse_text(child, child.tail, element)
            with self._noting(element, child.tag, child):
                kind = self._read_child(child, element, information, given)
                if kind is not None:
                    made = self._make(child, kind)
                    families.setdefault(child.tag, []).append(made)
                    children.append((child, made, kind))
        for name, members in families.items():
            self._families.append((element, information.features[name], members))
        return children

    def _read_child(
        self, child: etree._Element, element: EObject, information: ModelClass, given: set[str]
    ) -> ModelClass | None:
        """Return the class of a contained object; None if the child was a value and is read."""
        feature = information.features.get(child.tag)
        if feature is None or feature.kind is Kind.NOT_STORED:
            raise self._unknown(child, information, child.tag)
        if not feature.many and feature.name in given:
            raise self._error(
                child, f"{feature.name} of {describe(element)} is given twice, but there is only one"
            )
        given.add(feature.name)
        if child.get(_NIL) == "true":
            return None
        if feature.kind is not Kind.CONTAINMENT:
            self._child_value(child, element, feature)
            return None
        return self._class_of_child(child, element, feature)

    @contextmanager
    def _noting(
        self, element: EObject | None = None, name: str = "", part: etree._Element | None = None
    ) -> Iterator[None]:
        """Note an error, and what is left out for it: the named feature of an element, a part of the tree."""
        try:
            yield
        except ModelFileError as error:
            document = self._document
            document.errors.append(error)
            if element is not None:
                document.unread.add((element, name))
            if part is not None:
                document.unread_ids.update(
                    value for inner in part.iter() for value in (inner.get("id"), inner.get(_XMI_ID)) if value
                )

    def _join_families(self) -> None:
        """Put children into their parents, innermost first: pyecore asks all containers at every change."""
        for parent, feature, members in reversed(self._families):
            if feature.many:
                getattr(parent, feature.name).extend(members)
            else:
                setattr(parent, feature.name, members[0])

    def _other_attribute(
        self, node: etree._Element, element: EObject, information: ModelClass, name: str, text: str
    ) -> None:
        with self._noting():
            if name == _XMI_ID:
                self._register(node, element, text, self._document.xmi_ids)
            elif name not in _QUIET:
                raise self._unknown(node, information, name)

    def _child_value(self, child: etree._Element, element: EObject, feature: Feature) -> None:
        """Read an attribute or a reference that is an element of its own."""
        if len(child):
            raise self._error(child[0], f"{feature.name} of {describe(element)} cannot hold elements")
        href = child.get("href")
        if feature.kind is Kind.ATTRIBUTE:
            self._set(child, element, feature, child.text or "")
        elif href is None:
            self._refer(child, element, feature, child.get(_XMI_REFERENCE) or child.text or "")
        else:
            name, _, target = href.partition("#")
            line = line_of(child) or 0
            file = self._find_file(self._document, name, line) if name else None
            self._references.append(Reference(self._document, element, feature, target, line, file))

    def _class_of_child(self, child: etree._Element, element: EObject, feature: Feature) -> ModelClass:
        name = child.get(_TYPES[0]) or child.get(_TYPES[1])
        if child.get("href") is not None:
            raise self._error(
                child, f"{feature.name} of {describe(element)} is in another file", "move it here"
            )
        if name is None:
            return model_class(feature.type)
        information = self._classes.get(name)
        if information is None:
            prefix, _, local = name.rpartition(":")
            uri = self._prefixes.get(prefix or None)
            if uri is None:
                raise self._error(child, f"the prefix of the type {shortened(name)} is not declared")
            found = find_class(uri, local)
            if isinstance(found, str):
                raise self._error(child, f"no class {shortened(local)} in {shortened(uri)}", found)
            information = self._classes[name] = found
        if not issubclass(information.python_class, feature.type):
            expected = model_class(feature.type).qualified_name
            raise self._error(
                child,
                f"{feature.name} of {describe(element)} takes {expected}, not {information.qualified_name}",
            )
        return information

    def _set(self, node: etree._Element, element: EObject, feature: Feature, text: str) -> None:
        try:
            value = feature.read(text)
        except ValueError as error:
            reason, hint = (*error.args, None)[:2]
            raise self._error(
                node, f"{feature.name} of {describe(element)} {reason}, not {shortened(text)}", hint
            ) from error
        if feature.identifies:
            if not text or any(character.isspace() for character in text):
                raise self._error(node, f"the id {shortened(text)} is empty or has white space")
            if text.startswith("//@"):
                raise self._error(node, f"the id {shortened(text)} looks like the path of an element")
            self._register(node, element, text, self._document.ids)
        setattr(element, feature.name, value)

    def _register(self, node: etree._Element, element: EObject, name: str, known: dict[str, EObject]) -> None:
        other = known.setdefault(name, element)
        if other is not element:
            first = location_of(other)
            lines = f"lines {first.line} and {line_of(node)}" if first else "two elements"
            hint = "give one of them another: all elements of a file, channels too, share one space of ids"
            raise self._error(node, f"the id {shortened(name)} is used twice, on {lines}", hint)

    def _refer(self, node: etree._Element, element: EObject, feature: Feature, text: str) -> None:
        targets = text.split()
        if len(targets) > 1 and not feature.many:
            raise self._error(
                node,
                f"{feature.name} of {describe(element)} names {len(targets)} elements, but there is only one",
            )
        line = line_of(node) or 0
        for target in targets:
            self._references.append(Reference(self._document, element, feature, target, line))

    def _refuse_text(self, node: etree._Element, text: str | None, element: EObject) -> None:
        if text and not text.isspace():
            raise self._error(node, f"text {text.strip()[:40]!r} inside {describe(element)}")

    def _unknown(self, node: etree._Element, information: ModelClass, name: str) -> ModelFileError:
        feature = information.features.get(name)
        if feature is None:
            stored = [
                known.name for known in information.features.values() if known.kind is not Kind.NOT_STORED
            ]
            return self._error(
                node,
                f"{information.qualified_name} has no feature {shortened(name)}",
                near_matches(name, stored),
            )
        if feature.kind is Kind.CONTAINMENT:
            return self._error(
                node, f"{name} of {information.qualified_name} is an element, not an attribute"
            )
        return self._error(
            node, f"{name} of {information.qualified_name} is not stored; it follows from the rest"
        )

    def _error(self, node: etree._Element | None, message: str, hint: str | None = None) -> ModelFileError:
        line = line_of(node) if node is not None else None
        return ModelFileError(message, location=Location(self._document.path, line), hint=hint)


def _split(tag: str) -> tuple[str | None, str]:
    name = etree.QName(tag)
    return name.namespace, name.localname
