"""Refusing what a P/T net does not have, so that nothing that concerns the behaviour is dropped."""

from __future__ import annotations

import re

from lxml import etree

from dineros.metamodel.errors import near_matches
from dineros.metamodel.files.pnml.plain.known import (
    ATTRIBUTES,
    DISTRIBUTION,
    DRAWN,
    ELEMENTS,
    HARMLESS_NAMESPACES,
    LEFT_OUT,
    MEANINGS,
)
from dineros.metamodel.files.pnml.plain.values import contradiction, label_text, loose_text, only
from dineros.metamodel.files.pnml.source import Source, children, local
from dineros.metamodel.files.pnml.vocabulary import tag
from dineros.metamodel.files.schema import shortened
from dineros.metamodel.files.xml import line_of

_NO_INVARIANT = re.compile(r"<\s*=?\s*inf")
_HINT = "it may change the behaviour; remove it if it does not"


def check_attributes(xml: etree._Element, kind: str, source: Source) -> None:
    """Complain about each attribute that is not known for this kind of element."""
    allowed = ATTRIBUTES[kind] | (
        DISTRIBUTION if kind == "transition" and "distribution" in xml.attrib else set()
    )
    for each, value in xml.attrib.items():
        name = str(each)
        if name in allowed:
            if name in LEFT_OUT and not (name == "player" and value.strip() in ("", "0")):
                source.note(LEFT_OUT[name])
        elif not name.startswith(HARMLESS_NAMESPACES):
            hint = MEANINGS.get(name) or near_matches(name, allowed - DRAWN) or _HINT
            what = f"<{local(xml)}> {xml.get('id')!r} has an unknown attribute {shortened(name)}"
            source.complain(what, xml, id=xml.get("id"), hint=hint)


def check_element(
    xml: etree._Element, allowed: frozenset[str], outer: etree._Element, source: Source
) -> bool:
    """Return whether an element may be in another; complain if not."""
    kind = local(xml)
    if kind == "variables" and not len(xml) and not loose_text(xml):
        return True  # PM4Py writes the element even if the net has no data
    if kind in allowed and xml.tag == tag(kind):
        if kind in LEFT_OUT:
            source.note(LEFT_OUT[kind])
        return True
    if kind in allowed:
        hint: str | None = f"its namespace is {etree.QName(xml).namespace!r}, not that of PNML"
    else:
        hint = MEANINGS.get(kind) or near_matches(kind, allowed) or _HINT
    source.complain(f"<{kind}> is not part of the <{local(outer)}> of a P/T net", xml, hint=hint)
    return False


def check_parts(xml: etree._Element, kind: str, source: Source) -> None:
    """Complain about each attribute, element and text of a node or an arc that is not known."""
    check_attributes(xml, kind, source)
    check_text(xml, source)
    allowed = ELEMENTS[kind]
    for part in children(xml):
        check_element(part, allowed, xml, source)


def check_text(xml: etree._Element, source: Source) -> None:
    """Complain about text of a page, a node or an arc that is not in a label."""
    text = loose_text(xml)
    if text:
        what = f"<{local(xml)}> {xml.get('id')!r} holds the text {shortened(text)}"
        source.complain(what, xml, id=xml.get("id"), hint=_HINT)


class NetWide:
    """What has no effect if it is the same for all transitions: priorities, and whether they take time.

    `transition` sees each of them, `finish` complains where two differ.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._priorities: list[tuple[str | None, etree._Element]] = []
        self._timed: list[tuple[str | None, etree._Element]] = []

    def place(self, xml: etree._Element) -> None:
        """Refuse an invariant on the age of tokens."""
        invariant = xml.get("invariant")
        if invariant is not None and not _NO_INVARIANT.fullmatch(invariant.strip()):
            what = f"place {xml.get('id')!r} has the invariant {shortened(invariant)}"
            hint = "only '< inf' is read: tokens have no age here"
            self._source.complain(what, xml, id=xml.get("id"), hint=hint)

    def transition(self, xml: etree._Element) -> None:
        """Refuse urgency, and remember priority and timing.

        Raises
        ------
        ModelFileError
            Priority or timing is given twice.
        """
        if xml.get("urgent", "false").strip().lower() not in ("false", "0", ""):
            what = f"transition {xml.get('id')!r} is urgent"
            self._source.complain(what, xml, id=xml.get("id"), hint="urgent transitions are not understood")
        has_delay = any(local(part) == "delay" for part in children(xml))
        if has_delay and (self._said(xml, "infiniteServer") or "false") not in ("false", "0"):
            what = f"transition {xml.get('id')!r} has an interval and infinitely many servers"
            hint = "only one clock of a transition is understood: remove infiniteServer or the interval"
            self._source.complain(what, xml, id=xml.get("id"), hint=hint)
        self._priorities.append((self._said(xml, "priority"), xml))
        self._timed.append((self._said(xml, "timed"), xml))

    def _said(self, xml: etree._Element, name: str) -> str | None:
        """Return the value of an attribute or of the element of the same name, in lower case."""
        label, attribute = only(xml, name, self._source), xml.get(name)
        said = label_text(label, self._source) if label is not None else attribute
        if attribute is not None and said is not None and _plain(attribute) != _plain(said):
            raise contradiction(xml, name, said, attribute, self._source)
        return None if said is None else _plain(said)

    def finish(self) -> None:
        """Report priorities that differ, and immediate transitions next to timed ones."""
        inside = any(said is not None and xml.get("priority") is None for said, xml in self._priorities)
        hint = "a net with priorities can be written as .net or .xmi"
        self._differ(self._priorities, "1" if inside else "0", "the priority {}", hint)
        hint = "immediate transitions fire first, which is a priority: remove one of both"
        truths = {"0": "false", "1": "true"}
        timed = [(said if said is None else truths.get(said, said), xml) for said, xml in self._timed]
        self._differ(timed, "false", "timed = {}", hint)

    def _differ(
        self, said: list[tuple[str | None, etree._Element]], default: str, words: str, hint: str
    ) -> None:
        values = [(default if value is None else value, xml) for value, xml in said]
        first = next(iter(values), None)
        other = next((each for each in values if first is not None and each[0] != first[0]), None)
        if first is None or other is None:
            return
        one, two = (f"{xml.get('id')!r} has {words.format(value)}" for value, xml in (first, other))
        message = f"transition {two}, and {one} on line {line_of(first[1])}"
        self._source.complain(message, other[1], id=other[1].get("id"), hint=hint)


def _plain(said: str) -> str:
    """Return a value in lower case, a whole number without zeros before it."""
    text = said.strip().lower()
    return text.lstrip("0") or "0" if text.isdecimal() else text
