"""Writing XMI: one pass over the containment tree, text out, in the order of the metamodel."""

from __future__ import annotations

import os
from pathlib import Path
from urllib.parse import quote

from dineros.metamodel.base import EObject
from dineros.metamodel.errors import Location, ModelFileError, with_article
from dineros.metamodel.files.schema import (
    NOT_XML,
    Feature,
    Kind,
    ModelClass,
    class_of,
    describe,
    identity,
    values_of,
)
from dineros.metamodel.positions import file_of, real_path

XMI = "http://www.omg.org/XMI"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
DEPTH_LIMIT = 250  # readers stop at 256

_ESCAPES = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\t": "&#9;", "\n": "&#10;", "\r": "&#13;"}
)


def xmi_bytes(root: EObject, path: Path | None = None) -> bytes:
    """Return a model as XMI; `path` is the file it goes to, which references into other files start from.

    Raises
    ------
    ModelFileError
        The model cannot be stored in a file (see `write_xmi`).
    """
    return _XmiWriter(root, path).content()


def fragment(element: EObject) -> str:
    """Return the path of an object inside its model, such as ``//@pages.0/@objects.1``."""
    steps: list[str] = []
    container = element.eContainer()
    while container is not None:
        feature = element.eContainmentFeature()
        index = f".{getattr(container, feature.name).index(element)}" if feature.many else ""
        steps.append(f"@{feature.name}{index}")
        element, container = container, container.eContainer()
    return "//" + "/".join(reversed(steps)) if steps else "/"


class _XmiWriter:
    def __init__(self, root: EObject, path: Path | None) -> None:
        self._root = root
        self._path = path
        self._folder = real_path(path).parent if path else None
        self._location = Location(path)
        self._lines: list[str] = []
        self._classes: dict[str, str] = {}
        self._uses_types = False
        self._references: dict[EObject, str] = {}

    def content(self) -> bytes:
        self._number()
        # Closing tags wait on the stack as text; an object's children are pushed in reverse.
        stack: list[tuple[EObject, Feature | None, int] | str] = [(self._root, None, 0)]
        while stack:
            entry = stack.pop()
            if isinstance(entry, str):
                self._lines.append(entry)
            else:
                self._write(*entry, stack)
        self._lines[0] = self._lines[0].replace("\0", self._namespaces(), 1)
        return ('<?xml version="1.0" encoding="UTF-8"?>\n' + "\n".join(self._lines) + "\n").encode()

    def _number(self) -> None:
        """Find what references to each object look like; ids must be unique."""
        owners: dict[str, EObject] = {}
        stack = [(self._root, 0)]
        while stack:
            element, depth = stack.pop()
            if depth > DEPTH_LIMIT:
                raise self._error(f"nests deeper than {DEPTH_LIMIT} elements", element)
            information = class_of(element)
            if information.identifier:
                name = getattr(element, information.identifier)
                self._check_id(element, name, owners)
                # Eclipse takes these for paths and other files.
                self._references[element] = fragment(element) if "#" in name or name[0] == "/" else name
            for feature in information.containments:
                stack.extend((child, depth + 1) for child in values_of(element, feature))

    def _check_id(self, element: EObject, name: str | None, owners: dict[str, EObject]) -> None:
        if not name:
            raise self._error(f"{describe(element)} has no id", element, hint="give every element an id")
        if any(character.isspace() for character in name):
            raise self._error(f"the id {name!r} has white space", element)
        if name.startswith("//@"):
            raise self._error(f"the id {name!r} looks like the path of an element", element)
        other = owners.setdefault(name, element)
        if other is not element:
            both = " and ".join(with_article(class_of(each).name) for each in (other, element))
            raise self._error(f"the id {name!r} is used twice, by {both}", element)

    def _write(
        self,
        element: EObject,
        role: Feature | None,
        depth: int,
        stack: list[tuple[EObject, Feature | None, int] | str],
    ) -> None:
        information = class_of(element)
        indent = "  " * depth
        attributes: list[str] = []
        children: list[tuple[EObject, Feature | None, int] | str] = []
        if role is None:
            tag = self._use(information)
            attributes.append("\0")  # the namespaces, once all are known
        else:
            tag = role.name
            if role.type is not information.python_class:
                self._uses_types = True
                attributes.append(f'xsi:type="{self._use(information)}"')
        for feature in information.features.values():
            if feature.kind is Kind.ATTRIBUTE:
                value = getattr(element, feature.name)
                if feature.mandatory or value != feature.default:
                    attributes.append(f'{feature.name}="{self._text(element, feature, value)}"')
            elif feature.kind is Kind.CONTAINMENT:
                children.extend((child, feature, depth + 1) for child in values_of(element, feature))
            elif feature.kind is Kind.REFERENCE:
                own, other = self._targets(element, feature)
                if own:
                    attributes.append(f'{feature.name}="{" ".join(own).translate(_ESCAPES)}"')
                children.extend(f"{indent}  {line}" for line in other)
        start = " ".join([f"{indent}<{tag}", *attributes])
        if not children:
            self._lines.append(start + "/>")
            return
        self._lines.append(start + ">")
        stack.append(f"{indent}</{tag}>")
        stack.extend(reversed(children))

    def _text(self, element: EObject, feature: Feature, value: object) -> str:
        if value is None:
            raise self._error(f"{describe(element)} has no {feature.name}", element)
        try:
            text = feature.write(value)
        except ValueError as error:
            raise self._error(
                f"{feature.name} of {describe(element)} {error}, not {value!r}", element
            ) from error
        match = NOT_XML.search(text)
        if match:
            raise self._error(
                f"{feature.name} of {describe(element)} holds the character {match.group()!r}, "
                "which XML cannot carry",
                element,
            )
        return text.translate(_ESCAPES)

    def _targets(self, element: EObject, feature: Feature) -> tuple[list[str], list[str]]:
        """Return references inside the model and, as elements, those into other files."""
        own: list[str] = []
        other: list[str] = []
        for target in values_of(element, feature):
            reference = self._references.get(target)
            if reference is None and _root_of(target) is self._root:
                reference = self._references[target] = fragment(target)
            if reference is not None:
                own.append(reference)
            else:
                self._uses_types = True
                kind = self._use(class_of(target))
                href = self._href(element, feature, target).translate(_ESCAPES)
                other.append(f'<{feature.name} xsi:type="{kind}" href="{href}"/>')
        return own, other

    def _href(self, element: EObject, feature: Feature, target: EObject) -> str:
        file = file_of(target)
        if file is None or self._folder is None:
            raise self._error(
                f"{feature.name} of {describe(element)} refers to {describe(target)}, "
                "which is not in the model",
                element,
                hint="add it to the model, or save its own model first",
            )
        relative = quote(Path(os.path.relpath(file, self._folder)).as_posix())
        name = identity(target)
        plain = name is not None and "#" not in name and name[0] != "/"
        return f"{relative}#{name if plain else fragment(target)}"

    def _use(self, information: ModelClass) -> str:
        self._classes[information.prefix] = information.uri
        return information.qualified_name

    def _namespaces(self) -> str:
        declared = {"xmi": XMI}
        if self._uses_types:
            declared["xsi"] = XSI
        declared.update(sorted(self._classes.items()))
        return " ".join(
            ['xmi:version="2.0"', *(f'xmlns:{prefix}="{uri}"' for prefix, uri in declared.items())]
        )

    def _error(self, message: str, element: EObject, hint: str | None = None) -> ModelFileError:
        return ModelFileError(message, location=self._location, element=identity(element), hint=hint)


def _root_of(element: EObject) -> EObject:
    container = element.eContainer()
    while container is not None:
        element, container = container, container.eContainer()
    return element
