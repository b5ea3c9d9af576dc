"""Reading the DiNeROS extension: places, transitions, pages, callback groups and input clauses.

The fields are in blocks of the tool ``de.tudresden.inf.st.pnml.distributedPN``; for topics and services see
`channels`.
"""

from __future__ import annotations

from copy import deepcopy

from lxml import etree

from dineros.metamodel import pn, positions, sym
from dineros.metamodel.elements import label, node_net_of
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.pnml.groups import identify, read_groups
from dineros.metamodel.files.pnml.layout import tool_info
from dineros.metamodel.files.pnml.records import Extension, PageRecord, item_text, items
from dineros.metamodel.files.pnml.source import Source, child, children, local, text_of
from dineros.metamodel.files.pnml.vocabulary import CALLBACK_TYPES, FIELDS, PLACE_TYPES, TRANSITION_TYPES

_UNBOUNDED = frozenset({"", "inf", "infinity", "∞", "w"})


def keep_leftover(element: pn.Element, extension: Extension, kind: str) -> None:
    """Keep fields that the extension does not have for this kind of element, as a block of another tool."""
    for block in extension.blocks:
        if all(local(inner) in FIELDS[kind] for inner in children(block)):
            continue
        rest = deepcopy(block)
        for inner in list(rest):
            if local(inner) in FIELDS[kind]:
                rest.remove(inner)
        element.toolInfos.append(tool_info(rest))


class ExtensionReader:
    """Sets features from the fields; what needs other elements waits until `set_groups` and `set_clauses`."""

    def __init__(self, source: Source, models: dict[str, pn.Element]) -> None:
        self._source = source
        self._models = models
        self._pages: list[tuple[sym.CallbackPage, Extension]] = []
        self._signals: dict[sym.NodeNet, set[str]] = {}
        self._clauses: list[tuple[sym.Transition, Extension]] = []

    def read(self, element: pn.Element, extension: Extension) -> None:
        """Read the fields of a place, a transition or a page."""
        if isinstance(element, sym.Place):
            self._place(element, extension)
        elif isinstance(element, sym.Transition):
            self._transition(element, extension)
        elif isinstance(element, sym.NodeNet):
            self._node_net(element, extension)
        elif isinstance(element, sym.CallbackPage):
            self._callback_page(element, extension)

    def _place(self, place: sym.Place, extension: Extension) -> None:
        if (kind := extension.text("type")) is not None:
            if kind not in PLACE_TYPES:
                hint = f"types are {', '.join(PLACE_TYPES)}"
                where = extension.fields["type"]
                raise self._source.error(f"{kind!r} is not a type of a place", where, id=place.id, hint=hint)
            place.kind = PLACE_TYPES[kind]
        marking = extension.fields.get("balloonMarking")
        if marking is None:
            return
        tokens = child(marking, "tokens")
        for token in items(marking if tokens is None else tokens, "token"):
            balloon = sym.BalloonToken(data=text_of(token) or "{}")
            positions.remember(balloon, self._source.location(token))
            place.balloons.append(balloon)
        xml = marking.getparent()
        outer = None if xml is None else xml.getparent()
        if outer is not None and child(outer, "initialMarking") is None:
            place.tokens = len(place.balloons)

    def _transition(self, transition: sym.Transition, extension: Extension) -> None:
        if (kind := extension.text("type")) is not None:
            transition.kind = TRANSITION_TYPES[kind]
        if (time := extension.fields.get("time")) is not None:
            transition.interval = self._interval(time)
        if extension.text("inputsignalclause") is not None:
            self._clauses.append((transition, extension))

    def _interval(self, xml: etree._Element) -> pn.TimeInterval:
        start, end = ((xml.get(name) or item_text(xml, name) or "").strip() for name in ("start", "end"))
        interval = pn.TimeInterval()
        if start:
            interval.earliest = self._source.number(start, xml, "the start time")
        if end.lower() not in _UNBOUNDED:
            interval.latest = self._source.number(end, xml, "the end time")
        return interval

    def _node_net(self, page: sym.NodeNet, extension: Extension) -> None:
        if (executor := extension.text("executor")) is not None:
            if executor.lower() not in ("single", "multi"):
                where = extension.fields["executor"]
                raise self._source.error(
                    f"the executor is single or multi, not {executor!r}", where, id=page.id
                )
            page.executor = executor.lower()
        if (threads := extension.text("threads")) is not None:
            page.threads = self._source.integer(threads, extension.fields["threads"], "the number of threads")

    def _callback_page(self, page: sym.CallbackPage, extension: Extension) -> None:
        if (kind := extension.text("type")) is not None:
            page.kind = CALLBACK_TYPES[kind]
        if (timer := extension.text("timer")) is not None:
            page.timer = self._source.number(timer, extension.fields["timer"], "the timer")
        if (priority := extension.text("priority")) is not None:
            page.priority = self._source.integer(priority, extension.fields["priority"], "the priority")
        if extension.text("group") is not None:
            self._pages.append((page, extension))

    def set_groups(self, net: PageRecord) -> None:
        """Make the callback groups and give callback pages theirs."""
        model = self._models[net.id]
        assert isinstance(model, pn.Net)
        read_groups(self._source, self._models, net, model, self._pages)

    # -------------------------------------------------------------------------------------- input clauses

    def set_clauses(self) -> None:
        """Parse the input clauses; signals that no block declares are made where they are used."""
        if not self._clauses:
            return
        from dineros.metamodel.clauses import set_clause, signal_names

        for transition, extension in self._clauses:
            if transition.clause is not None:  # our own block has it whole
                continue
            xml = extension.fields["inputsignalclause"]
            text = text_of(xml)
            try:
                self._declare(transition, signal_names(text), xml)
                set_clause(transition, text, extension.mark("clauseName"))
            except DinerosError as error:
                error.location = self._source.location(xml)
                error.element = transition.id
                raise

    def _declare(self, transition: sym.Transition, names: list[str], xml: etree._Element) -> None:
        node_net = node_net_of(transition)
        if node_net is None:
            hint = "signals belong to a node net; name one with <node>"
            raise self._source.error(f"{transition.id!r} has an input clause but no node", xml, hint=hint)
        if node_net not in self._signals:
            self._signals[node_net] = {label(signal) for signal in node_net.signals}
        for name in names:
            if name not in self._signals[node_net]:
                self._signals[node_net].add(name)
                signal = sym.InputSignal(node=node_net)
                identify(signal, name, node_net, self._models)
                positions.remember(signal, self._source.location(xml))
