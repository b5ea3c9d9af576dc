"""Making the model from records: elements first, then what joins them."""

from __future__ import annotations

from lxml import etree

from dineros.metamodel import pn, positions, rtm, sym
from dineros.metamodel.errors import with_article
from dineros.metamodel.files.pnml.channels import ChannelReader
from dineros.metamodel.files.pnml.extension import ExtensionReader, keep_leftover
from dineros.metamodel.files.pnml.layout import read_layout
from dineros.metamodel.files.pnml.own import Decoder, class_named
from dineros.metamodel.files.pnml.records import (
    ArcRecord,
    NetRecord,
    NodeRecord,
    PageRecord,
    Record,
)
from dineros.metamodel.files.pnml.source import Source, local

_PLAIN: dict[str, type[pn.Element]] = {
    "net": pn.Net,
    "page": pn.Page,
    "place": pn.Place,
    "transition": pn.Transition,
    "referencePlace": pn.ReferencePlace,
    "referenceTransition": pn.ReferenceTransition,
    "arc": pn.Arc,
}
_SYSTEM: dict[str, type[pn.Element]] = {
    **_PLAIN,
    "net": sym.SystemModel,
    "node": sym.NodeNet,
    "callback": sym.CallbackPage,
    "place": sym.Place,
    "transition": sym.Transition,
    "topic": sym.TopicChannel,
    "service": sym.ServiceChannel,
    "action": sym.ActionChannel,
}


def expected_class(kind: str, extended: bool, net: type[pn.Net]) -> type[pn.Element]:
    """Return the class of an element whose own block names none.

    Parameters
    ----------
    kind : str
        Kind of record.
    extended : bool
        Whether the element has a block of the DiNeROS extension.
    net : type
        Class of the net.
    """
    if issubclass(net, rtm.RuntimeModel) and kind == "place":
        return rtm.Place
    system = extended or issubclass(net, (sym.SystemModel, rtm.RuntimeModel))
    return (_SYSTEM if system or kind not in _PLAIN else _PLAIN)[kind]


class Builder:
    """Makes one model from the records of one file."""

    def __init__(self, net: NetRecord, source: Source) -> None:
        self._net = net
        self._source = source
        self._decoder = Decoder(source)
        self._models: dict[str, pn.Element] = {}
        self._net_class: type[pn.Net] = sym.SystemModel if net.extended else pn.Net

    def build(self) -> pn.Net:
        """Return the model.

        Raises
        ------
        ModelFileError
            A value is wrong, or a port, a group or a block names something that is not there.
        ClauseError
            An input clause is not a boolean expression.
        """
        root = self._net.root
        model = self._make(root, pn.Net)
        assert isinstance(model, pn.Net)
        extension = ExtensionReader(self._source, self._models)
        channels = ChannelReader(self._source, self._models)
        for page in root.pages():
            self._fill(page, model, extension, channels)
        for node in root.nodes():
            if node.ref is not None:
                reference = self._models[node.id]
                assert isinstance(reference, (pn.ReferencePlace, pn.ReferenceTransition))
                reference.target = self._models[node.ref]  # type: ignore[assignment] # checked when read
        for arc in self._net.arcs:
            self._arc(arc)
        for element, xml in self._decoder.made:
            self._register_made(element, xml)
        extension.set_groups(root)
        channels.finish()
        self._decoder.resolve(self._models.get, lambda: self._models)
        extension.set_clauses()
        return model

    def _fill(
        self, page: PageRecord, net: pn.Net, extension: ExtensionReader, channels: ChannelReader
    ) -> None:
        outer = self._models[page.id]
        for record in page.objects:
            if isinstance(record, NodeRecord) and record.is_channel:
                if not isinstance(net, sym.SystemModel):
                    hint = "only system models have channels"
                    raise self._source.error(
                        f"a {record.kind} in a plain net", record.xml, id=record.id, hint=hint
                    )
                channel = self._make(record, sym.Channel)
                assert isinstance(channel, sym.Channel) and isinstance(outer, pn.Page)
                channel.canvas = outer
                net.channels.append(channel)
                channels.read(channel, record.extension)
                self._finish(record, channel, record.kind)
                continue
            element = self._make(record, pn.PageObject)
            assert isinstance(element, pn.PageObject)
            if isinstance(outer, pn.Net):
                assert isinstance(element, pn.Page)
                outer.pages.append(element)
            elif isinstance(outer, pn.Page):
                outer.objects.append(element)
            if isinstance(element, pn.Node) and isinstance(record, NodeRecord):
                self._values(element, record)
            kind = "page" if isinstance(record, PageRecord) else record.kind
            if isinstance(record, NodeRecord) and record.ref is not None:
                kind = "reference"
            extension.read(element, record.extension)
            self._finish(record, element, kind)
        if page is self._net.root:
            self._finish(page, outer, "net")

    def _finish(self, record: Record, element: pn.Element, kind: str) -> None:
        """Read what every element may have; our own block last, because it wins."""
        keep_leftover(element, record.extension, kind)
        if record.xml is not None:
            read_layout(record.xml, element, self._source)
        if record.extension.own is not None:
            self._decoder.decode(record.extension.own, element, _DONE.get(kind, ()))
        if isinstance(record, PageRecord) and (
            record.xml is None or (kind == "page" and element.name is None)
        ):
            element.name = record.name

    def _make(self, record: Record, expected: type[pn.Element]) -> pn.Element:
        kind = record.kind if isinstance(record, (NodeRecord, PageRecord)) else "arc"
        extension = record.extension
        named = extension.mark("class")
        if named is not None:
            assert extension.own is not None
            cls = class_named(named, self._source, extension.own)
        else:
            cls = expected_class(kind, bool(extension.blocks), self._net_class)
        if not issubclass(cls, _PLAIN.get(kind, expected)):
            what = f"{named} is not a class of {with_article(kind)}"
            raise self._source.error(what, extension.own, id=record.id)
        if kind == "net":
            assert issubclass(cls, pn.Net)
            self._net_class = cls
        element = cls(id=record.id)
        positions.remember(element, self._source.location(record.where()))
        self._models[record.id] = element
        return element

    def _register_made(self, element: pn.Element, xml: etree._Element) -> None:
        if not (element.id or "").strip():
            raise self._source.error(f"<{local(xml)}> has no id", xml, hint='add id="..."')
        if element.id in self._models:
            raise self._source.error(f"the id {element.id!r} is taken", xml, id=element.id)
        self._models[element.id] = element

    # ------------------------------------------------------------------------------------- core features

    def _values(self, node: pn.Node, record: NodeRecord) -> None:
        if isinstance(node, pn.Place):
            node.tokens, node.capacity = record.tokens or 0, record.capacity
        elif isinstance(node, pn.Transition) and record.interval is not None:
            low, high, low_open, high_open = record.interval
            node.interval = pn.TimeInterval(
                earliest=low, latest=high, earliestExcluded=low_open, latestExcluded=high_open
            )

    def _arc(self, record: ArcRecord) -> None:
        arc = self._make(record, pn.Arc)
        assert isinstance(arc, pn.Arc) and record.page is not None
        page, source, target = (self._models[id] for id in (record.page.id, record.source, record.target))
        assert isinstance(page, pn.Page) and isinstance(source, pn.Node) and isinstance(target, pn.Node)
        arc.page, arc.source, arc.target = page, source, target
        arc.kind, arc.weight = record.kind, record.weight
        self._finish(record, arc, "arc")


_DONE = {"arc": ("kind",)}
