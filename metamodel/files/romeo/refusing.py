"""Refuses what Romeo's files may contain beyond time Petri nets, by its name, with the reason."""

from __future__ import annotations

import re
from pathlib import Path

from lxml import etree

from dineros.metamodel.errors import Location, ModelFileError, near_matches
from dineros.metamodel.files.schema import read_integer
from dineros.metamodel.files.xml import line_of

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_TRUE = frozenset({"1", "true", "True"})
_FALSE = frozenset({"0", "false", "False"})


class Attributes:
    """The attributes of an element, with errors that name its line."""

    def __init__(self, xml: etree._Element, path: Path) -> None:
        self.xml = xml
        self._path = path

    def error(self, message: str, hint: str | None = None) -> ModelFileError:
        """Return an error about the element, to be raised."""
        name = self.xml.get("identifier") or self.xml.get("label") or self.xml.get("id")
        what = f"{self.xml.tag} {name}: " if name and self.xml.tag in ("place", "transition") else ""
        return ModelFileError(
            f"{what}{message}", location=Location(self._path, line_of(self.xml)), element=name, hint=hint
        )

    def text(self, name: str) -> str:
        """Return an attribute that must be there."""
        value = (self.xml.get(name) or "").strip()
        if not value:
            raise self.error(f"<{self.xml.tag}> has no {name}", f'add {name}="..."')
        return value

    def integer(self, name: str, default: int, least: int) -> int:
        """Return a whole number."""
        text = (self.xml.get(name) or str(default)).strip()
        try:
            value = read_integer(text)
        except ValueError as error:
            hint = "expressions of variables are not read"
            raise self.error(f"{name} {error.args[0]}, not {text[:40]!r}", hint) from None
        if value < least:
            raise self.error(f"{name} is {least} or more, not {value}")
        return value

    def flag(self, name: str) -> bool:
        """Return whether a bound belongs to its interval; it does unless the file states otherwise."""
        text = (self.xml.get(name) or "1").strip()
        if text not in _TRUE | _FALSE:
            raise self.error(f"{name} is 1 or 0, not {text[:40]!r}")
        return text in _TRUE

    def refuse(self, name: str, neutral: tuple[str, ...], reason: str) -> None:
        """Refuse an attribute with a value that is not neutral."""
        text = (self.xml.get(name) or "").strip()
        if text and text not in neutral:
            raise self.error(f"{name} {text[:40]!r} is not read", reason)

    def refuse_unknown(self) -> None:
        """Refuse attributes, elements and text that Romeo does not write: they may change the behaviour."""
        attributes, elements = _PARTS[str(self.xml.tag)]
        for name in map(str, self.xml.attrib):
            if name not in attributes:
                raise self.error(f"has an unknown attribute {name[:40]!r}", near_matches(name, attributes))
        for inner in self.xml.iterchildren(tag=etree.Element):
            if inner.tag not in elements:
                what = f"<{str(inner.tag)[:40]}> is not part of a <{self.xml.tag}>"
                raise Attributes(inner, self._path).error(what)
        refuse_text(self.xml, self._path)

    def refuse_place(self) -> None:
        """Refuse what places of a time Petri net do not have."""
        self.refuse_unknown()
        reason = "intervals of places are not read: clocks belong to transitions"
        self.refuse("eft", ("0", "0.0"), reason)
        self.refuse("lft", ("inf", "infini", "infinity"), reason)
        for inner in self.xml.iterchildren("scheduling"):
            scheduling = Attributes(inner, self._path)
            scheduling.refuse("gamma", ("0",), "processors stop the clocks of what has to wait: a stopwatch")
            scheduling.refuse("omega", ("0",), "priorities on processors stop clocks: a stopwatch")

    def refuse_transition(self) -> None:
        """Refuse what transitions of a time Petri net do not have."""
        self.refuse_unknown()
        parametric = "a bound that is a parameter has no value: parametric nets are not analysed"
        for name in ("eft_param", "lft_param", "minparam", "maxparam"):
            self.refuse(name, (), parametric)
        self.refuse("speed", ("1", "1.0"), "clocks that run at another speed are stopwatches")
        self.refuse("guard", ("true", "1"), "guards on variables are not read")
        for inner in self.xml.iterchildren("update"):
            if _has_code(inner):
                raise Attributes(inner, self._path).error(
                    "an update is not read", "variables other than places are not analysed"
                )

    def refuse_arc(self) -> None:
        """Refuse what arcs of a time Petri net do not have."""
        self.refuse_unknown()
        self.refuse("tokenColor", ("-1",), "tokens with colours are not read: unfold the net")
        self.refuse("inhibitingCondition", (), "conditions on inhibitor arcs are not read: use a weight")


_NODE = frozenset({"id", "identifier", "label", "eft", "lft"})
_PARTS: dict[str, tuple[frozenset[str], frozenset[str]]] = {
    "place": (_NODE | {"initialMarking"}, frozenset({"graphics", "scheduling"})),
    "transition": (
        _NODE
        | {"eftIncl", "lftIncl", "eft_param", "lft_param", "minparam", "maxparam"}
        | {"speed", "priority", "cost", "unctrl", "obs", "guard"},
        frozenset({"graphics", "update"}),
    ),
    "arc": (
        frozenset({"place", "transition", "type", "weight", "tokenColor", "inhibitingCondition"}),
        frozenset({"nail", "graphics"}),
    ),
}
"""Attributes and elements of places, transitions and arcs that are read, refused by value, or harmless."""


def refuse_text(xml: etree._Element, path: Path) -> None:
    """Refuse text next to the elements inside an element.

    Raises
    ------
    ModelFileError
        There is some.
    """
    text = "".join([xml.text or "", *(part.tail or "" for part in xml)]).strip()
    if text:
        raise Attributes(xml, path).error(f"the text {text[:40]!r} inside <{xml.tag}> is not read")


def refuse_extras(net: etree._Element, path: Path) -> None:
    """Refuse statements of a file about the whole net beyond places, transitions and arcs.

    Raises
    ------
    ModelFileError
        Constraints on parameters, nets in other files, synchronised transitions, or an unknown element.
    """
    refuse_text(net, path)
    for xml in net.iterchildren(tag=etree.Element):
        attributes = Attributes(xml, path)
        if xml.tag == "misc" and (inner := xml.find("constraint")) is not None:
            hint = "parametric nets are not analysed"
            raise Attributes(inner, path).error("a constraint on parameters is not read", hint)
        if xml.tag == "project" and (inner := xml.find("input")) is not None:
            raise Attributes(inner, path).error(
                "the net continues in another file", "join the files in Romeo, and save them as one net"
            )
        if xml.tag == "synchronization":
            attributes.refuse("listSynch", ("0",), "transitions that fire together are not read")
        if xml.tag not in _KNOWN:
            raise attributes.error(f"<{str(xml.tag)[:40]}> is not an element of Romeo's nets")


_KNOWN = frozenset(
    {
        *("place", "transition", "arc", "misc", "project", "synchronization", "preferences"),
        *("timedCost", "nbTokenColor", "declaration", "initialization"),
    }
)


def _has_code(xml: etree._Element) -> bool:
    """Return whether a text is more than comments."""
    return bool(_COMMENT.sub("", "".join(map(str, xml.itertext()))).strip(" \t\r\n;"))
