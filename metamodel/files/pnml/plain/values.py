"""Values of one place, transition or arc: its marking, capacity, firing interval, weight and type.

Read are the forms of the standard and those of other tools that mean the same beyond doubt. A doubled or
contradictory value is an error that names both lines.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import NamedTuple

from lxml import etree

from dineros.metamodel.errors import ModelFileError, with_article
from dineros.metamodel.files.exact import fraction_of
from dineros.metamodel.files.pnml.layout import is_inhibitor_mark
from dineros.metamodel.files.pnml.plain.known import HARMLESS_NAMESPACES, TEXTS
from dineros.metamodel.files.pnml.source import Source, children, local
from dineros.metamodel.files.pnml.vocabulary import DINEROS, OWN, tag
from dineros.metamodel.files.schema import shortened
from dineros.metamodel.files.xml import line_of

_TYPES = {
    "normal": "normal",
    "ordinary": "normal",
    "inhibitor": "inhibitor",
    "read": "read",
    "test": "read",
    "timed": "normal",
    "transport": "normal",
    "tapnInhibitor": "inhibitor",
}
"""Types of arcs; those of nets with time are what they are without: what their intervals say is checked."""
_REFUSED_TYPES = {
    "reset": "a reset arc takes all tokens, which arcs cannot express here",
    "stopwatch": "stopwatch arcs stop a clock, which arcs cannot express here",
    "stopwatch-inhibitor": "stopwatch arcs stop a clock, which arcs cannot express here",
}
_SPECIAL = frozenset({"inhibitor", "read", "test", "transfer", *_REFUSED_TYPES})
"""Kinds of arcs that a block of another tool may name."""
_BEHAVIOUR = frozenset({"capacity", "priority", "guard", "urgent", "invariant", "delay", "interval"})
"""What a block of another tool may say of a place or transition that changes the behaviour."""
_NOT = frozenset({"false", "no", "none", "null", "normal"})
_UNTIMED = re.compile(r"\[0,\s*inf\)(:\d+)?")
"""An interval of ages that restricts nothing, with the number of a transport arc."""
_UNBOUNDED = frozenset({"0", "-1", "inf", "infinity", "∞", "w", "omega"})
"""How tools write that a place has no capacity."""
_OPEN = {
    "closed": (False, False),
    "open": (True, True),
    "closed-open": (False, True),
    "open-closed": (True, False),
}
_COLOURED = re.compile(r"[^\W\d][^,]*,\s*\d+(?:\s*,\s*[^\W\d][^,]*,\s*\d+)*")
"""A list of class names, each with a number. A name does not begin with a digit: 1,000 is a number."""


class Interval(NamedTuple):
    """A firing interval: bounds in the file's unit of time, `latest` None if it is unbounded."""

    earliest: float
    latest: float | None
    earliest_excluded: bool
    latest_excluded: bool


def label_text(label: etree._Element, source: Source) -> str:
    """Return the text of a label: in ``<text>``, in ``<value>`` (renamed to ``<text>``), or plain.

    Raises
    ------
    ModelFileError
        It has two texts, or elements and attributes that a label does not have.
    """
    check_attributes_of(label, ("value",) if local(label) in ("type", "arctype") else (), source)
    found: etree._Element | None = None
    for part in children(label):
        kind = local(part)
        if kind in ("graphics", "toolspecific"):
            continue
        if kind not in ("text", "value") or part.tag != tag(kind):
            raise source.error(f"<{kind}> is not part of a label", part)
        if found is not None:
            first = line_of(found)
            raise source.error(f"<{local(label)}> has two texts, on lines {first} and {line_of(part)}", part)
        if len(part):
            raise source.error(f"<{kind}> holds elements", part, hint="a text is expected")
        found = part
        if kind == "value":
            part.tag = tag("text")
            source.note("<value> taken as <text>")
        check_attributes_of(part, (), source)
    loose = loose_text(label)
    if found is not None and loose:
        hint = "write its text into <text> alone"
        what = f"<{local(label)}> holds the text {shortened(loose)} outside of <text>, too"
        raise source.error(what, label, hint=hint)
    if found is None and loose != (label.text or "").strip():
        hint = "write its text into <text> alone"
        raise source.error(f"<{local(label)}> holds the text {shortened(loose)} in parts", label, hint=hint)
    text = (label.text if found is None else found.text) or ""
    if found is None and loose and local(label) in ("initialMarking", "inscription"):
        source.note(f"text of <{local(label)}> outside of <text>")
    return text.strip()


def loose_text(xml: etree._Element) -> str:
    """Return the text of an element, without that of the elements inside."""
    return "".join([xml.text or "", *(part.tail or "" for part in children(xml))]).strip()


def check_attributes_of(xml: etree._Element, known: Collection[str], source: Source) -> None:
    """Check the attributes of a part of a label.

    Raises
    ------
    ModelFileError
        It has an attribute that is not known.
    """
    for name in map(str, xml.attrib):
        if name not in known and not name.startswith(HARMLESS_NAMESPACES):
            raise source.error(f"<{local(xml)}> has an unknown attribute {shortened(name)}", xml)


def only(xml: etree._Element, name: str, source: Source) -> etree._Element | None:
    """Return the one child of this name, or None.

    Raises
    ------
    ModelFileError
        There are two.
    """
    found = None
    for inner in xml.iterchildren(tag=tag(name)):
        if found is not None:
            lines = f"lines {line_of(found)} and {line_of(inner)}"
            raise source.error(f"<{local(xml)}> {_named(xml)} has two <{name}>, on {lines}", inner)
        found = inner
    return found


def check_labels(xml: etree._Element, source: Source) -> None:
    """Check labels that no value is read of here, such as the name."""
    for name in TEXTS:
        label = only(xml, name, source)
        if label is not None:
            label_text(label, source)


def tokens_of(place: etree._Element, source: Source) -> int | None:
    """Return the initial marking of a place, or None if it has none."""
    label = only(place, "initialMarking", source)
    text = label_text(label, source) if label is not None else ""
    attribute = place.get("initialMarking")
    if attribute is not None:
        source.note("attribute initialMarking taken as the marking")
        if text and text != attribute.strip():
            raise contradiction(place, "marking", text, attribute, source)
    if not text and attribute is None:
        return None
    where = place if label is None or not text else label
    return _count(text or attribute or "", where, "the initial marking", 0, source)


def capacity_of(place: etree._Element, source: Source) -> int | None:
    """Return the capacity of a place, or None if it has none."""
    label = only(place, "capacity", source)
    attribute = place.get("capacity")
    text = label_text(label, source) if label is not None else ""
    if label is not None and not text:
        raise source.error("the capacity is empty", label)
    if attribute is not None and text and text != attribute.strip():
        raise contradiction(place, "capacity", text, attribute, source)
    said = (text or attribute or "").strip()
    if not said:
        return None
    if said.lower() in _UNBOUNDED:
        source.note(f"capacity {said} taken as none")
        return None
    source.note("capacities kept")
    return _count(said, place if label is None else label, "the capacity", 1, source)


def weight_of(arc: etree._Element, source: Source) -> int:
    """Return the weight of an arc; 1 if the file has none."""
    label = only(arc, "inscription", source)
    said = label_text(label, source) if label is not None else ""
    where = arc if label is None else label
    aged = (arc.get("inscription") or "").strip()
    attribute = (arc.get("weight") or "").strip()
    if _UNTIMED.fullmatch(aged):
        aged = ""
    elif "[" in aged or "(" in aged:
        hint = "only intervals [0,inf) are read: tokens have no age here"
        raise source.error(f"arc {_named(arc)} has the interval {shortened(aged)}", arc, hint=hint)
    if aged == "1" and attribute:
        aged = ""  # TAPAAL writes both, and means the weight
    for name, value in (("inscription", aged), ("weight", attribute)):
        if value and said and value != said:
            raise contradiction(arc, "weight", said, value, source)
        if value:
            source.note(f"attribute {name} taken as the weight")
            said = value
    return _count(said, where, "the weight", 1, source) if said else 1


def kind_of(arc: etree._Element, source: Source) -> str:
    """Return the kind of an arc: normal, inhibitor or read."""
    said: list[tuple[str, etree._Element]] = []
    for block in arc.iterchildren(tag=tag("toolspecific")):
        if is_inhibitor_mark(block):
            said.append(("inhibitor", block))
    for name in ("type", "arctype"):
        label = only(arc, name, source)
        if label is not None:
            text = label_text(label, source)
            value = (label.get("value") or text).strip()
            if text and label.get("value") is not None and text != value:
                raise contradiction(arc, "type", text, value, source)
            said.append((_type(value, label, arc, source), label))
    attribute = arc.get("type")
    if attribute is not None:
        kind = _type(attribute.strip(), arc, arc, source)
        if kind != "normal" and not said:
            source.note(f"attribute type={attribute.strip()!r} taken as {with_article(kind)} arc")
        said.append((kind, arc))
    lines = {kind: line_of(where) for kind, where in reversed(said)}
    for block in arc.iterchildren(tag=tag("toolspecific")):
        named = _kind_in_block(block)
        if named is not None and _TYPES.get(named) not in lines:
            read, tool = next(iter(lines), "normal"), block.get("tool")
            source.note(f"arcs that blocks of {tool!r} call {named} taken as {read}: blocks are not read")
    if len(lines) > 1:
        what = " and ".join(f"{kind} on line {lines[kind]}" for kind in sorted(lines))
        raise source.error(f"arc {_named(arc)} is {what}", arc, id=arc.get("id"))
    return next(iter(lines), "normal")


def _kind_in_block(block: etree._Element) -> str | None:
    """Return the special kind of arc that a block of another tool names: as a value, or as a flag."""
    for name, value in _said_in_block(block):
        flag = name.removeprefix("is").strip("_-").removesuffix("arc").strip("_-")
        word = value if value in _SPECIAL else flag
        if word in _SPECIAL and value not in _NOT | _UNBOUNDED:
            return word
    return None


def note_blocks(node: etree._Element, source: Source) -> None:
    """Note what blocks of other tools say of the behaviour of a place or transition: it is not read."""
    for block in node.iterchildren(tag=tag("toolspecific")):
        for name, value in _said_in_block(block):
            if name in _BEHAVIOUR and value not in _NOT | _UNBOUNDED:
                source.note(
                    f"blocks of {block.get('tool')!r} that name a {name} left out: blocks are not read"
                )


def _said_in_block(block: etree._Element) -> Iterator[tuple[str, str]]:
    """Yield names and values of elements and attributes in a block of another tool, in lower case."""
    if block.get("tool") in (DINEROS, OWN) or is_inhibitor_mark(block):
        return
    for xml in block.iter("{*}*"):
        said = [(str(name).rpartition("}")[2], str(value)) for name, value in xml.attrib.items()]
        if xml is block:
            said = [each for each in said if each[0] not in ("tool", "version")]
        for name, value in [*said, (local(xml), xml.text or "")]:
            yield name.lower(), value.strip().lower()


def _type(said: str, where: etree._Element, arc: etree._Element, source: Source) -> str:
    if said in _TYPES:
        return _TYPES[said]
    if not said:
        return "normal"
    hint = _REFUSED_TYPES.get(said, "types are normal, inhibitor, read, test")
    raise source.error(f"{shortened(said)} is not a type of an arc", where, id=arc.get("id"), hint=hint)


def interval_of(transition: etree._Element, source: Source) -> Interval | None:
    """Return the firing interval of a transition, as TINA writes it: MathML inside of ``<delay>``."""
    delay = only(transition, "delay", source)
    if delay is None:
        return None
    parts = [part for part in children(delay) if local(part) not in ("graphics", "toolspecific")]
    if len(parts) != 1 or local(parts[0]) != "interval":
        raise source.error("<delay> holds one <interval>", delay)
    (xml,) = parts
    check_attributes_of(delay, (), source)
    check_attributes_of(xml, ("closure",), source)
    if loose_text(delay) or loose_text(xml):
        raise source.error("<delay> and <interval> hold no text", delay)
    closure = xml.get("closure", "closed")
    bounds = list(children(xml))
    if closure not in _OPEN or len(bounds) != 2:
        hint = f"closures are {', '.join(_OPEN)}, and it holds two numbers"
        raise source.error("<interval> is not understood", xml, hint=hint)
    low, high = ((local(bound), _bound_text(bound, source)) for bound in bounds)
    low_open, high_open = _OPEN[closure]
    earliest = source.number(low[1], bounds[0], "the earliest time")
    latest = None
    if high[0] != "ci" and high[1].lower() not in ("infty", "inf", "infinity", "w"):
        latest = source.number(high[1], bounds[1], "the latest time")
    elif high[0] == "ci" and high[1].lower() not in ("infty", "inf", "infinity", "w"):
        raise source.error(f"the latest time {shortened(high[1])} is not a number", bounds[1])
    low_exact, high_exact = fraction_of(earliest), None if latest is None else fraction_of(latest)
    empty = high_exact is not None and (
        high_exact < low_exact or (high_exact == low_exact and (low_open or high_open))
    )
    if earliest < 0 or empty:
        raise source.error("the interval is empty or begins before 0", xml)
    return Interval(earliest, latest, low_open, high_open and latest is not None)


def _bound_text(xml: etree._Element, source: Source) -> str:
    """Return the text of a MathML number; ``1<sep/>3`` is ``1/3``."""
    check_attributes_of(xml, ("type",), source)
    if local(xml) not in ("cn", "ci"):
        raise source.error(f"<{local(xml)}> is not a number", xml, hint="numbers are <cn>0.5</cn>")
    kind = "rational" if len(xml) else xml.get("type", "real")
    if xml.get("type", kind) != kind or kind not in ("real", "integer", "rational") or len(xml) > 1:
        hint = "numbers are <cn>0.5</cn> and <cn>1<sep/>2</cn>"
        raise source.error(f"<{local(xml)}> is not understood", xml, hint=hint)
    if any(local(part) != "sep" or len(part) or part.text for part in xml):
        raise source.error(f"<{local(xml)}> holds more than <sep/>", xml)
    parts = [xml.text or "", *(part.tail or "" for part in xml)]
    return "/".join(part.strip() for part in parts)


def _count(text: str, where: etree._Element, what: str, least: int, source: Source) -> int:
    """Return a whole number, which PIPE writes behind the name of the one class of its tokens."""
    if _COLOURED.fullmatch(text.strip()):
        parts = [part.strip() for part in text.split(",")]
        counts = [
            (name, number) for name, number in zip(parts[::2], parts[1::2], strict=True) if number.strip("0")
        ]
        if len(counts) > 1:
            hint = "only nets with tokens of one class are read"
            raise source.error(f"{what} {shortened(text)} has tokens of several classes", where, hint=hint)
        text = counts[0][1] if counts else "0"
        for name, _ in counts:
            source.use_class(name, where)
        source.note("tokens of one class taken as plain tokens")
    return source.integer(text, where, what, least)


def contradiction(xml: etree._Element, what: str, first: str, second: str, source: Source) -> ModelFileError:
    """Return the error about an element with two statements of one thing."""
    both = f"{shortened(first)} and {shortened(second.strip())}"
    message = f"<{local(xml)}> {_named(xml)} gives its {what} twice: {both}"
    return source.error(message, xml, id=xml.get("id"))


def _named(xml: etree._Element) -> str:
    return repr(xml.get("id") or f"{xml.get('source')} to {xml.get('target')}")
