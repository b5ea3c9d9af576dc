"""Our own blocks: what PNML and the DiNeROS extension cannot say, written by reflection over the metamodel.

A block is in the element it belongs to and holds one ``<element>``. Its attributes are attributes and
single references (by id) of the model element, its children contained elements and many-valued references::

    <toolspecific tool="org.dineros" version="1.0">
      <element namespace="/left">
        <signals id="Danger" initial="true"/>
      </element>
    </toolspecific>

``class`` names the metamodel class where it is not the one a reader would expect.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from typing import Any

from lxml import etree
from pyecore.ecore import EAttribute

from dineros.metamodel import pn, pnm, positions, rtm, sym
from dineros.metamodel.base import EObject, features_of, remembered
from dineros.metamodel.errors import DinerosError, near_matches, with_article
from dineros.metamodel.files.pnml.source import LARGEST, Source, children, local
from dineros.metamodel.files.pnml.vocabulary import OWN, OWN_VERSION, tag

_PACKAGES = {"pn": pn, "sym": sym, "rtm": rtm, "pnm": pnm}
MARKS = frozenset({"class", "clauseName", "half"})
"""Attributes of ``<element>`` that are not features."""


def class_name(cls: type[EObject]) -> str:
    """Return the name of a metamodel class as blocks write it, such as ``sym.Place``."""
    return f"{cls.__module__.rpartition('.')[2]}.{cls.__name__}"


def class_named(name: str, source: Source, element: etree._Element) -> type[EObject]:
    """Return the metamodel class of this name.

    Raises
    ------
    ModelFileError
        There is no such class, or it is abstract.
    """
    package, _, kind = name.partition(".")
    module = _PACKAGES.get(package)
    cls = getattr(module, kind) if module is not None and kind in module.eClassifiers else None
    if not isinstance(cls, type) or not issubclass(cls, EObject) or cls.eClass.abstract:
        known = [
            f"{package}.{each}"
            for package, module in _PACKAGES.items()
            for each in sorted(module.eClassifiers)
        ]
        raise source.error(
            f"the metamodels have no class {name!r} to be made", element, hint=near_matches(name, known)
        )
    return cls


# ---------------------------------------------------------------------------------------------- writing


def block(element: etree._Element) -> etree._Element:
    """Add a block with an empty ``<element>`` to a PNML element and return that."""
    outer = etree.SubElement(element, tag("toolspecific"), tool=OWN, version=OWN_VERSION)
    return etree.SubElement(outer, tag("element"))


def encode(
    xml: etree._Element, model: EObject, said: Collection[str], refer: Callable[[EObject], str]
) -> None:
    """Write the features of a model element that differ from their defaults and are not `said` elsewhere.

    Parameters
    ----------
    xml : lxml element
        Gets attributes and children.
    model : EObject
        The model element.
    said : collection of str
        Features that stand elsewhere in the file.
    refer : callable
        Gives the id of a referenced element.
    """
    todo: list[tuple[etree._Element, EObject, Collection[str]]] = [(xml, model, said)]
    while todo:
        xml, model, said = todo.pop()
        for name, feature in _stored_features(type(model)).items():
            if name in said:
                continue
            value = getattr(model, name)
            if isinstance(feature, EAttribute):
                if value is not None and value != feature.get_default_value():
                    xml.set(name, _to_text(value))
            elif not feature.containment:
                if not feature.many and value is not None:
                    xml.set(name, refer(value))
                for target in value if feature.many else ():
                    etree.SubElement(xml, tag(name), ref=refer(target))
            else:
                for inner in value if feature.many else [value] if value is not None else []:
                    inside = etree.SubElement(xml, tag(name))
                    if type(inner) is not _target(feature):
                        inside.set("class", class_name(type(inner)))
                    todo.append((inside, inner, ()))


@remembered
def _stored_features(cls: type[EObject]) -> dict[str, Any]:
    """Return the features to write: id and name first, and of two opposite references only one."""
    stored = [pair for pair in features_of(cls).items() if not _follows(pair[1])]
    return dict(sorted(stored, key=lambda pair: pair[0] not in ("id", "name")))


def _follows(feature: Any) -> bool:
    opposite = getattr(feature, "eOpposite", None)
    if opposite is None:
        return False
    return bool(opposite.containment or (feature.many and not opposite.many and not feature.containment))


def _target(feature: Any) -> type[EObject]:
    """Return the class that a reference points at; generated packages give the class itself."""
    target: type[EObject] = getattr(feature._eType, "python_class", feature._eType)
    return target


def _to_text(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


# ---------------------------------------------------------------------------------------------- reading


class Decoder:
    """Reads own blocks; references are set by `resolve` once every element exists."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.made: list[tuple[pn.Element, etree._Element]] = []
        """Elements with an id that are in blocks, in the order of the file."""
        self._references: list[tuple[EObject, Any, str, etree._Element]] = []

    def decode(self, xml: etree._Element, model: EObject, done: Collection[str] = ()) -> None:
        """Set features of a model element from an ``<element>``; values of a block take precedence."""
        todo = [(xml, model, frozenset(done) | MARKS)]
        while todo:
            xml, model, skip = todo.pop()
            for name, text in xml.attrib.items():
                if name not in skip:
                    self._set(model, str(name), str(text), xml)
            begun: set[str] = set()
            for inner in children(xml):
                feature = self._feature(model, local(inner), inner)
                if inner.get("ref") is not None:
                    self._references.append((model, feature, inner.get("ref", ""), inner))
                    continue
                todo.append((inner, self._contain(model, feature, inner, begun), MARKS))

    def resolve(self, find: Callable[[str], EObject | None], known: Callable[[], Iterable[str]]) -> None:
        """Set all references by id.

        Raises
        ------
        ModelFileError
            No element has the id, or it is of the wrong kind.
        """
        for model, feature, id, xml in self._references:
            target = find(id) if id else None
            if target is None:
                if id:
                    raise self.source.error(f"nothing has the id {id!r}", xml, hint=near_matches(id, known()))
                setattr(model, feature.name, None)
            elif not isinstance(target, _target(feature)):
                kind = with_article(type(target).__name__)
                raise self.source.error(f"{feature.name} cannot be {id!r}, which is {kind}", xml)
            elif not feature.many:
                setattr(model, feature.name, target)
            else:
                values = getattr(model, feature.name)
                if target in values:  # contained already, by where it stands; the block gives the order
                    values.remove(target)
                values.append(target)

    def _feature(self, model: EObject, name: str, xml: etree._Element) -> Any:
        known = _stored_features(type(model))
        if name not in known:
            kind = type(model).__name__
            raise self.source.error(f"{kind} has no feature {name!r}", xml, hint=near_matches(name, known))
        return known[name]

    def _set(self, model: EObject, name: str, text: str, xml: etree._Element) -> None:
        feature = self._feature(model, name, xml)
        if isinstance(feature, EAttribute):
            try:
                setattr(model, name, self._value(feature._eType, text, name, xml))
            except DinerosError as error:
                error.location = error.location or self.source.location(xml)
                raise
        elif feature.many or feature.containment:
            raise self.source.error(f"{name} is not an attribute", xml, hint=f"use <{name}>")
        else:
            self._references.append((model, feature, text, xml))

    def _value(self, kind: Any, text: str, name: str, xml: etree._Element) -> object:
        if kind.name in ("EInt", "EIntegerObject"):
            return self.source.integer(text, xml, name, -LARGEST - 1)
        if kind.name in ("EDouble", "EDoubleObject"):
            return float(text) if text in _NOT_FINITE else self.source.number(text, xml, name)
        if kind.name == "EBoolean":
            if text not in ("true", "false"):
                raise self.source.error(f"{name} is true or false, not {text!r}", xml)
            return text == "true"
        return text  # text, or an enumeration, which the feature checks

    def _contain(self, model: EObject, feature: Any, xml: etree._Element, begun: set[str]) -> EObject:
        if isinstance(feature, EAttribute) or not feature.containment:
            raise self.source.error(f"{feature.name} contains nothing", xml)
        expected: type[EObject] = _target(feature)
        named = xml.get("class")
        if named is None and expected.eClass.abstract:
            raise self.source.error(f"<{feature.name}> needs a class", xml)
        cls = expected if named is None else class_named(named, self.source, xml)
        if not issubclass(cls, expected):
            raise self.source.error(f"{feature.name} cannot be {with_article(cls.__name__)}", xml)
        inner = cls()
        positions.remember(inner, self.source.location(xml))
        if feature.many:
            if feature.name not in begun:  # the block is complete: it replaces what stands elsewhere
                getattr(model, feature.name).clear()
                begun.add(feature.name)
            getattr(model, feature.name).append(inner)
        else:
            setattr(model, feature.name, inner)
        if isinstance(inner, pn.Element):
            self.made.append((inner, xml))
        return inner


_NOT_FINITE = ("inf", "-inf", "nan")
