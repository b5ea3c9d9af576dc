"""Names, graphics, labels and blocks of other tools: what every element of a PNML file may have.

ISO/IEC 15909-2, clause 7.1.1 (graphics) and 7.1.3 (tool specific information).
"""

from __future__ import annotations

import math

from lxml import etree

from dineros.metamodel import pn
from dineros.metamodel.files.pnml.source import (
    Source,
    canonical,
    child,
    children,
    local,
    parse_fragment,
    text_of,
)
from dineros.metamodel.files.pnml.vocabulary import ALL_FIELDS, DINEROS, EDITOR, OWN, PNML, VERSIONS, tag
from dineros.metamodel.files.schema import number_text

LABELS = {"elementName": "name", "initialMarking": "initialMarking", "inscription": "inscription"}
"""PNML element of each kind of label, in the order in which labels are kept."""

_POINTS = ("position", "offset", "dimension")

# ---------------------------------------------------------------------------------------------- reading


def read_layout(xml: etree._Element, model: pn.Element, source: Source) -> None:
    """Read name, graphics, label layout and foreign blocks of an element."""
    labels: dict[str, etree._Element] = {}
    for inner in children(xml):
        kind = local(inner)
        if kind == "name" and (text := text_of(inner)):
            model.name = text
        if kind == "graphics":
            model.graphics = read_graphics(inner, source)
        elif kind in LABELS.values():
            labels.setdefault(kind, inner)
        elif kind == "toolspecific" and _is_foreign(inner):
            model.toolInfos.append(tool_info(inner))
    if model.name is None and (text := xml.get("name", "").strip()):
        model.name = text
    for label_kind, name in LABELS.items():
        if name in labels and len(labels[name]) > (child(labels[name], "text") is not None):
            _read_label(labels[name], label_kind, model, source)


def _read_label(xml: etree._Element, kind: str, model: pn.Element, source: Source) -> None:
    label = pn.Label(kind=kind)
    for inner in children(xml):
        if local(inner) == "graphics":
            label.graphics = read_graphics(inner, source)
        elif local(inner) == "toolspecific":
            label.toolInfos.append(tool_info(inner))
        elif local(inner) != "text":
            raise source.error(f"<{local(inner)}> is not part of a label", inner)
    model.labels.append(label)


def read_graphics(xml: etree._Element, source: Source) -> pn.Graphics:
    """Read positions, offset and dimension; keep the rest (fill, line, font) as XML text."""
    graphics = pn.Graphics()
    style = []
    for inner in children(xml):
        kind = local(inner)
        if kind == "position":
            graphics.positions.append(_read_point(inner, source))
        elif kind == "offset":
            graphics.offset = _read_point(inner, source)
        elif kind == "dimension":
            graphics.dimension = _read_point(inner, source)
        else:
            style.append(_style_text(inner))
    if style:
        graphics.style = "".join(style)
    return graphics


def _read_point(xml: etree._Element, source: Source) -> pn.Point:
    x, y = (source.number(source.attribute(xml, axis), xml, axis) for axis in ("x", "y"))
    return pn.Point(x=x, y=y)


def _style_text(xml: etree._Element) -> str:
    return canonical(xml).replace(f' xmlns="{PNML}"', "", 1)


def tool_info(xml: etree._Element) -> pn.ToolInfo:
    """Keep a block of another tool as it is."""
    info = pn.ToolInfo(tool=xml.get("tool", ""), version=xml.get("version", ""))
    if len(xml) or (xml.text or "").strip() or set(xml.attrib) - {"tool", "version"}:
        info.content = canonical(xml)
    return info


def _is_foreign(xml: etree._Element) -> bool:
    return xml.get("tool") not in (DINEROS, OWN) and not is_inhibitor_mark(xml)


def is_inhibitor_mark(xml: etree._Element) -> bool:
    """Return whether a block is the editor's mark of an inhibitor arc."""
    return xml.get("tool") == EDITOR and xml.get("type") == "inhibitor"


# ---------------------------------------------------------------------------------------------- writing


class Layout:
    """How one element's name, graphics, labels and foreign blocks are written.

    Features that PNML cannot say without loss are left out of `said`; they go into our own block.

    Parameters
    ----------
    model : pn.Element
        The element.
    frozen : list
        Gets the XML fragments that must be written as they are, without indentation.
    texts : tuple of str
        The text labels that elements of this kind have besides their name.
    """

    def __init__(self, model: pn.Element, frozen: list[etree._Element], texts: tuple[str, ...] = ()) -> None:
        self.said = {"id"}
        self._frozen = frozen
        self._model = model
        name = model.name
        if name is None or (name and name == name.strip()):
            self.said.add("name")
        self._graphics = graphics_xml(model.graphics) if model.graphics else None
        if not isinstance(model, pn.Net) and (model.graphics is None or self._graphics is not None):
            self.said.add("graphics")
        self._labels = _labels_xml(list(model.labels), ("name", *texts))
        if self._labels is not None:
            self.said.add("labels")
        self._tool_infos = _tool_infos_xml(list(model.toolInfos))
        if self._tool_infos is not None:
            self.said.add("toolInfos")

    def has_label(self, name: str) -> bool:
        """Return whether a text label has a layout to be written."""
        return name in (self._labels or {})

    def text(self, xml: etree._Element, name: str, text: str | None) -> None:
        """Add a text label such as ``<initialMarking>`` with its layout."""
        outer = etree.SubElement(xml, tag(name))
        if text is not None:
            etree.SubElement(outer, tag("text")).text = text
        for inner in (self._labels or {}).get(name, ()):
            self._add(outer, inner)

    def head(self, xml: etree._Element) -> None:
        """Add name and graphics."""
        name = self._model.name if "name" in self.said else None
        if name is not None or self.has_label("name"):
            self.text(xml, "name", name)
        if self._graphics is not None and "graphics" in self.said:
            self._add(xml, self._graphics)

    @property
    def extended(self) -> bool:
        """Whether the blocks of other tools include fields of the DiNeROS extension that we do not know."""
        return any(inner.get("tool") == DINEROS for inner in self._tool_infos or ())

    def foreign(self, xml: etree._Element) -> None:
        """Add the blocks of other tools."""
        for inner in self._tool_infos or ():
            self._add(xml, inner)

    def _add(self, xml: etree._Element, inner: etree._Element) -> None:
        xml.append(inner)
        if local(inner) == "graphics":
            self._frozen.extend(each for each in inner if local(each) not in _POINTS)
        else:
            self._frozen.append(inner)


def graphics_xml(graphics: pn.Graphics) -> etree._Element | None:
    """Return ``<graphics>``, or None if reading it again would not give the same."""
    style = graphics.style
    if not all(_is_finite(point) for point in [*graphics.positions, graphics.dimension, graphics.offset]):
        return None
    xml: etree._Element | None = etree.Element(tag("graphics"))
    if style is not None:
        xml = parse_fragment(f'<graphics xmlns="{PNML}">{style}</graphics>')
        if xml is None or not style or "".join(_style_text(inner) for inner in children(xml)) != style:
            return None
    assert xml is not None
    if any(local(inner) in _POINTS for inner in xml):
        return None
    for index, point in enumerate(graphics.positions):
        xml.insert(index, _point_xml("position", point))
    at = len(graphics.positions)
    for name, value in (("dimension", graphics.dimension), ("offset", graphics.offset)):
        if value is not None:
            xml.insert(at, _point_xml(name, value))
    return xml


def _is_finite(point: pn.Point | None) -> bool:
    values: list[float | None] = [] if point is None else [point.x, point.y]
    return all(value is not None and math.isfinite(value) for value in values)


def _point_xml(name: str, point: pn.Point) -> etree._Element:
    return etree.Element(tag(name), x=number_text(point.x), y=number_text(point.y))


def _labels_xml(labels: list[pn.Label], texts: tuple[str, ...]) -> dict[str, list[etree._Element]] | None:
    names = [LABELS[str(label.kind)] for label in labels]
    if names != [name for name in LABELS.values() if name in names] or not set(names) <= set(texts):
        return None
    result: dict[str, list[etree._Element]] = {}
    for name, label in zip(names, labels, strict=True):
        graphics = [] if label.graphics is None else [graphics_xml(label.graphics)]
        infos = _tool_infos_xml(list(label.toolInfos))
        parts = [*graphics, *(infos or ())]
        if infos is None or not parts:
            return None
        result[name] = [part for part in parts if part is not None]
        if len(result[name]) < len(parts):
            return None
    return result


def _tool_infos_xml(infos: list[pn.ToolInfo]) -> list[etree._Element] | None:
    result = []
    for info in infos:
        xml = _tool_info_xml(info)
        if xml is None:
            return None
        result.append(xml)
    return result


def _tool_info_xml(info: pn.ToolInfo) -> etree._Element | None:
    """Return the block, or None if reading it again would not give the same."""
    if info.content is None:
        xml = etree.Element(tag("toolspecific"), tool=info.tool or "", version=info.version or "")
    else:
        parsed = parse_fragment(info.content)
        if parsed is None or parsed.tag != tag("toolspecific"):
            return None
        xml = parsed
    back = tool_info(xml)
    if (back.tool, back.version, back.content) != (info.tool, info.version, info.content):
        return None
    if info.tool == DINEROS:
        fields = {local(inner) for inner in children(xml)}
        return xml if fields and not fields & ALL_FIELDS and info.version in VERSIONS else None
    return xml if info.tool not in (OWN, EDITOR) else None
