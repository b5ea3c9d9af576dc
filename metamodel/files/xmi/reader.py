"""Reading XMI: objects are made file by file, then references are resolved and required features checked."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import unquote

from dineros.metamodel.base import EObject
from dineros.metamodel.errors import (
    ClauseError,
    Location,
    ModelFileError,
    near_matches,
    raise_collected,
    with_article,
)
from dineros.metamodel.files.net_formats import SUFFIXES_OF_NETS, net_format
from dineros.metamodel.files.schema import Kind, class_of, describe, identity, shortened
from dineros.metamodel.files.xmi.tree import Document, Reference, TreeReader
from dineros.metamodel.positions import file_of, location_of, real_path

FILE_LIMIT = 64

_NOT_RELATIVE = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:|[/\\]|.*\0")
_STEP = re.compile(r"@([A-Za-z_]\w*)(?:\.([0-9]{1,9}))?")


class XmiReader:
    """Reads one file and the files it refers to, each once."""

    def __init__(self, models: Iterable[EObject] = ()) -> None:
        self._documents: dict[Path, Document] = {}
        self._waiting: list[Document] = []
        self._references: list[Reference] = []
        for root in models:
            file = file_of(root)
            if file is not None:
                self._documents[file] = _index(Document(file), root)

    def read(self, path: Path, content: bytes | None = None) -> EObject:
        """Return the root of the model in a file, whose content may be known.

        Raises
        ------
        ModelFileError
            See `read_xmi`. `CollectedModelFileError` where more than one thing is wrong.
        """
        document = Document(path, content=content)
        self._documents[real_path(path)] = document
        self._waiting.append(document)
        while self._waiting:
            self._read(self._waiting.pop(0))
        for reference in self._references:
            try:
                self._join(reference)
            except ModelFileError as error:
                reference.document.errors.append(error)
                reference.document.unread.add((reference.source, reference.feature.name))
        for known in self._documents.values():
            _check_required(known)
            _complete_clauses(known)
        self._raise_errors()
        assert document.root is not None
        return document.root

    def _raise_errors(self) -> None:
        raise_collected(error for document in self._documents.values() for error in document.errors)

    def _read(self, document: Document) -> None:
        suffix = document.path.suffix.lower()
        if suffix in SUFFIXES_OF_NETS:
            read, _ = net_format(suffix)
            _index(document, read(document.path))
        else:
            TreeReader(document, self._references, self._find_file).read()

    def _find_file(self, document: Document, name: str, line: int) -> Path:
        """Return the file that a reference names, and have it read."""
        location = Location(document.path, line)
        name = unquote(name)
        if _NOT_RELATIVE.match(name):
            raise ModelFileError(
                f"refers to {shortened(name)}", location=location, hint="name a file relative to this one"
            )
        path = document.path.parent / name
        resolved = real_path(path)
        if resolved not in self._documents:
            if len(self._documents) >= FILE_LIMIT:
                raise ModelFileError(f"refers to more than {FILE_LIMIT} files", location=location)
            if not os.path.exists(path):  # noqa: PTH110 - takes names of any length
                raise ModelFileError(
                    f"refers to the file {shortened(name)}, which does not exist", location=location
                )
            self._documents[resolved] = Document(path)
            self._waiting.append(self._documents[resolved])
        return resolved

    def _join(self, reference: Reference) -> None:
        """Let a reference hold its target."""
        source, feature, name = reference.source, reference.feature, reference.target
        document = self._documents[reference.file] if reference.file else reference.document
        target = _find(document, name)
        if target is None:
            if document.unread_ids and (name in document.unread_ids or name.startswith("/")):
                reference.document.unread.add((source, feature.name))
                return  # it is in a part that is reported as wrong
            raise _dangling(reference, document)
        if not isinstance(target, feature.type):
            kind = with_article(feature.type.__name__)
            raise _error(
                reference, f"{feature.name} of {describe(source)} takes {kind}, not the {describe(target)}"
            )
        if not feature.many:
            setattr(source, feature.name, target)
        elif target in getattr(source, feature.name):
            raise _error(reference, f"{feature.name} of {describe(source)} names {shortened(name)} twice")
        else:
            getattr(source, feature.name).append(target)


def _find(document: Document, name: str) -> EObject | None:
    """Return what a reference names: by id, by xmi:id, or by its path from the root."""
    known = document.ids.get(name) or document.xmi_ids.get(name)
    if known is None and name.startswith("#"):
        return _find(document, name[1:].lstrip("#"))
    return known or _at(document.root, name)


def _at(root: EObject | None, path: str) -> EObject | None:
    """Return the object at a path such as ``//@pages.0/@objects.1``, ``/0/@pages.0`` or ``/``."""
    if not path.startswith("/"):
        return None
    start, *steps = path[1:].split("/")
    if start not in ("", "0"):
        return None
    element = root
    for step in steps:
        match = _STEP.fullmatch(step)
        feature = class_of(element).features.get(match[1]) if match and element is not None else None
        if match is None or feature is None or feature.kind is not Kind.CONTAINMENT:
            return None
        value = getattr(element, feature.name)
        if feature.many:
            index = int(match[2] or 0)
            element = value[index] if index < len(value) else None
        else:
            element = value
    return element


def _index(document: Document, root: EObject) -> Document:
    """Make a document of a model that is loaded already."""
    document.root = root
    for element in (root, *root.eAllContents()):
        name = identity(element)
        if name:
            document.ids[name] = element
    return document


def _check_required(document: Document) -> None:
    for element in document.made:
        for feature in class_of(element).required:
            value = getattr(element, feature.name)
            if (element, feature.name) in document.unread:
                continue
            if value is None or (feature.many and not len(value)):
                document.errors.append(
                    ModelFileError(
                        f"{describe(element)} has no {feature.name}",
                        location=location_of(element),
                        element=identity(element),
                        hint="it must have one",
                    )
                )


def _complete_clauses(document: Document) -> None:
    """Give clauses that are written as text alone their normal form."""
    from dineros.metamodel import sym
    from dineros.metamodel.clauses import complete_clause

    for element in document.made:
        if isinstance(element, sym.InputClause) and element.text and not len(element.disjunctions):
            if document.errors and (element, "disjunctions") in document.unread:
                continue
            try:
                complete_clause(element)
            except ClauseError as error:
                document.errors.append(
                    ModelFileError(
                        f"clause of {error.element}: {error.message}",
                        location=location_of(element),
                        element=error.element,
                        hint=error.hint,
                    )
                )


def _dangling(reference: Reference, document: Document) -> ModelFileError:
    fitting = (name for name, target in document.ids.items() if isinstance(target, reference.feature.type))
    hint = near_matches(reference.target, fitting)
    if not reference.file and "#" in reference.target[1:]:
        hint = "a reference into another file is an element with href"
    target = shortened(reference.target) + (f" of {document.path.name}" if reference.file else "")
    source = f"{reference.feature.name} of {describe(reference.source)}"
    return _error(reference, f"{source} refers to {target}, which does not exist", hint)


def _error(reference: Reference, message: str, hint: str | None = None) -> ModelFileError:
    location = Location(reference.document.path, reference.line)
    return ModelFileError(message, location=location, element=identity(reference.source), hint=hint)
