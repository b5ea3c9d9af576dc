"""Writing the DiNeROS extension; what its version cannot say is left to our own block."""

from __future__ import annotations

import math
from collections.abc import Callable

from lxml import etree

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.elements import label, node_net_of, node_nets
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.exact import decimal_text, fraction_of
from dineros.metamodel.files.pnml.layout import graphics_xml
from dineros.metamodel.files.pnml.vocabulary import (
    ACTION,
    CALLBACK_TYPES,
    DINEROS,
    NODE_PAGE,
    PLACE_TYPES,
    SERVICE,
    TOPIC,
    TRANSITION_TYPES,
    Version,
    tag,
)
from dineros.metamodel.files.schema import number_text

_PLACE_TYPE = {kind: name for name, kind in PLACE_TYPES.items()}
_TRANSITION_TYPE = {kind: name for name, kind in TRANSITION_TYPES.items()}
_CALLBACK_TYPE = {kind: name for name, kind in CALLBACK_TYPES.items()}


class ExtensionWriter:
    """Adds blocks of the extension; methods for elements return the features that these blocks store."""

    def __init__(self, version: Version, refer: Callable[[EObject], str]) -> None:
        self._version = version
        self._refer = refer
        self.wrote = False
        """Whether any block was written."""
        self._called: dict[str, sym.NodeNet] = {}
        self._plain_clauses: set[sym.InputClause] = set()

    def element(self, xml: etree._Element, element: pn.Element) -> set[str]:
        """Add the block of an element, if it has one."""
        if isinstance(element, sym.Place):
            return self._place(xml, element)
        if isinstance(element, sym.Transition):
            return self._transition(xml, element)
        if isinstance(element, sym.NodeNet):
            return self._node_net(xml, element)
        if isinstance(element, sym.CallbackPage):
            return self._callback_page(xml, element)
        if isinstance(element, sym.TopicChannel):
            return self._topic(xml, element)
        if isinstance(element, sym.ServiceChannel):
            return self._service(xml, element)
        if isinstance(element, sym.ActionChannel):
            return self._action(xml, element)
        return set()

    def kind(self, element: pn.Element, kind: str) -> str:
        """Return the kind of record that a reader will make of the element."""
        if kind == "page" and self._version == "0.2":
            return {sym.NodeNet: "node", sym.CallbackPage: "callback"}.get(type(element), kind)
        return kind

    def marks(self, element: pn.Element) -> dict[str, str]:
        """Return attributes for our own block that are not features."""
        clause = element.clause if isinstance(element, sym.Transition) else None
        if clause is None or clause.name is None or clause not in self._plain_clauses:
            return {}
        return {"clauseName": clause.name}

    def net(self, xml: etree._Element, net: pn.Net) -> None:
        """Add the callback groups of all node nets, and note which pages `<node>` can name."""
        nets = node_nets(net)
        for node_net in reversed(nets):
            self._called[label(node_net).strip()] = node_net
        groups = [(node_net, group) for node_net in nets for group in node_net.callbackGroups]
        if self._version == "0.1" or not groups:
            return
        outer = etree.SubElement(self._block(xml), tag("callbackgroups"))
        for node_net, group in groups:
            inside = etree.SubElement(outer, tag("group"))
            _add(inside, "id", group.id)
            _add(inside, "type", str(group.kind))
            _add(inside, "priority", str(group.priority))
            if (graphics := _plain_graphics(group)) is not None:
                inside.append(graphics)
            _add(inside, "node", self._name_of(node_net))

    def _block(self, xml: etree._Element) -> etree._Element:
        self.wrote = True
        return etree.SubElement(xml, tag("toolspecific"), tool=DINEROS, version=self._version)

    def _name_of(self, node_net: sym.NodeNet) -> str:
        name = label(node_net).strip()
        return name if name and self._called.get(name) is node_net else node_net.id

    def _where(self, xml: etree._Element, node: pn.Node) -> None:
        """Name the node net, and the page inside it, that an element is in."""
        node_net = node_net_of(node)
        if node_net is None:
            return
        _add(xml, "node", self._name_of(node_net))
        if node.page is not None and node.page is not node_net and label(node.page).strip():
            _add(xml, "subnet", label(node.page).strip())

    # --------------------------------------------------------------------------------- places, transitions

    def _place(self, xml: etree._Element, place: sym.Place) -> set[str]:
        said: set[str] = set()
        block = etree.Element(tag("toolspecific"), tool=DINEROS, version=self._version)
        self._where(block, place)
        if self._version == "0.2" and str(place.kind) in _PLACE_TYPE:
            _add(block, "type", _PLACE_TYPE[str(place.kind)])
            said.add("kind")
        data = [balloon.data for balloon in place.balloons]
        if data and all(_is_plain(each) for each in data):
            tokens = etree.SubElement(etree.SubElement(block, tag("balloonMarking")), tag("tokens"))
            for each in data:
                _add(tokens, "token", each)
            said.add("balloons")
        if len(block):
            self.wrote = True
            xml.append(block)
        return said

    def _transition(self, xml: etree._Element, transition: sym.Transition) -> set[str]:
        said: set[str] = set()
        block = self._block(xml)
        self._where(block, transition)
        kind = str(transition.kind)
        if self._version == "0.2" or kind == "discrete":
            _add(block, "type", _TRANSITION_TYPE[kind])
            said.add("kind")
        else:
            _add(block, "type", _TRANSITION_TYPE["discrete"])
        if transition.clause is not None:
            said |= self._clause(block, transition.clause)
        interval = transition.interval
        if interval is not None and self.says_interval(transition):
            time = etree.SubElement(block, tag("time"), start=number_text(interval.earliest))
            if interval.latest is not None:
                time.set("end", number_text(interval.latest))
            said.add("interval")
        return said

    def says_interval(self, transition: pn.Transition) -> bool:
        """Return whether the block of a transition states its interval."""
        interval = transition.interval
        return (
            self._version == "0.2"
            and isinstance(transition, sym.Transition)
            and str(transition.kind) == "timed"
            and interval is not None
            and _is_closed(interval)
        )

    def _clause(self, xml: etree._Element, clause: sym.InputClause) -> set[str]:
        if _is_plain(clause.text):
            _add(xml, "inputsignalclause", clause.text)
        if not _says_all(clause):
            return set()
        self._plain_clauses.add(clause)
        return {"clause"}

    # ----------------------------------------------------------------------------------------------- pages

    def _node_net(self, xml: etree._Element, page: sym.NodeNet) -> set[str]:
        if self._version == "0.1":
            return set()
        block = self._block(xml)
        _add(block, "type", NODE_PAGE)
        _add(block, "executor", str(page.executor))
        _add(block, "threads", str(page.threads))
        said = {"executor", "threads"}
        if all(_is_plain_group(group) for group in page.callbackGroups):
            said.add("callbackGroups")
        return said

    def _callback_page(self, xml: etree._Element, page: sym.CallbackPage) -> set[str]:
        if self._version == "0.1":
            return set()
        said = {"kind", "priority"}
        block = self._block(xml)
        _add(block, "type", _CALLBACK_TYPE[str(page.kind)])
        node_net = node_net_of(page)
        if page.group is not None and node_net is not None and page.group in node_net.callbackGroups:
            _add(block, "group", page.group.id)
            said.add("group")
        if page.timer is not None and math.isfinite(page.timer):
            _add(block, "timer", number_text(page.timer))
            said.add("timer")
        _add(block, "priority", str(page.priority))
        return said

    # -------------------------------------------------------------------------------------------- channels

    def _topic(self, xml: etree._Element, channel: sym.TopicChannel) -> set[str]:
        block = self._block(xml)
        _add(block, "type", TOPIC)
        said = {"publishers"} if all(_is_plain_port(port) for port in channel.publishers) else set()
        if all(_is_plain_port(port) for port in channel.subscribers):
            said.add("subscribers")
        if _is_plain(channel.topic):
            _add(block, "topicName", channel.topic)
            said.add("topic")
        for name, ports in (("publisher", channel.publishers), ("subscriber", channel.subscribers)):
            outer = etree.SubElement(block, tag(f"{name}s"))
            for port in ports:
                inside = etree.SubElement(outer, tag(name))
                _add(inside, "id", self._refer(port.place))
                _add(inside, "limit", str(port.limit))
        return said

    def _service(self, xml: etree._Element, channel: sym.ServiceChannel) -> set[str]:
        block = self._block(xml)
        _add(block, "type", SERVICE)
        said = {"instances"}
        if _is_plain(channel.service):
            _add(block, "serviceName", channel.service)
            said.add("service")
        server: sym.ServerPort | None = channel.server
        if server is not None:
            entry: pn.Place | None = server.entry
            exit_: pn.Place | None = server.exit
            for name, place in (("serverInput", entry), ("serverOutput", exit_)):
                if place is not None:
                    _add(block, name, self._refer(place))
            if entry is not None and server.page is entry.page:
                said.add("server")
        if channel.instances is not None:
            _add(block, "serverCapacity", str(channel.instances))
        outer = etree.SubElement(block, tag("channels"))
        for client in channel.clients:
            inside = etree.SubElement(outer, tag("channel"))
            if _is_plain(client.client):
                _add(inside, "cid", client.client)
            _add(inside, "request", self._refer(client.request))
            _add(inside, "response", self._refer(client.response))
        if all(_is_plain_client(client) for client in channel.clients):
            said.add("clients")
        return said

    def _action(self, xml: etree._Element, channel: sym.ActionChannel) -> set[str]:
        """Write that it is an action; ports and everything else are in our own block."""
        block = self._block(xml)
        _add(block, "type", ACTION)
        if not _is_plain(channel.action):
            return set()
        _add(block, "actionName", channel.action)
        return {"action"}


def _add(xml: etree._Element, name: str, text: str) -> None:
    etree.SubElement(xml, tag(name)).text = text


def _is_plain_port(port: sym.TopicPort) -> bool:
    """Return whether the dialect can express all features of a port of a topic."""
    return all(
        getattr(port, name) == feature.get_default_value()
        for name, feature in features_of(type(port)).items()
        if name not in ("place", "limit", "channel") and not feature.many
    )


def _is_plain(text: str | None) -> bool:
    """Return whether a text survives readers that strip white space."""
    return text is not None and text != "" and text == text.strip()


def _is_closed(interval: pn.TimeInterval) -> bool:
    bounds = [bound for bound in (interval.earliest, interval.latest) if bound is not None]
    is_closed = not (interval.earliestExcluded or interval.latestExcluded)
    return is_closed and all(math.isfinite(bound) and _is_decimal(bound) for bound in bounds)


def _is_decimal(bound: float) -> bool:
    return decimal_text(fraction_of(bound)) is not None


def _plain_graphics(group: sym.CallbackGroup) -> etree._Element | None:
    graphics = group.graphics
    return graphics_xml(graphics) if graphics is not None and graphics.style is None else None


def _is_plain_group(group: sym.CallbackGroup) -> bool:
    drawn = group.graphics is None or _plain_graphics(group) is not None
    more = len(group.labels) or len(group.toolInfos) or len(group.suppressions)
    return group.name is None and group.sourceLine is None and drawn and not more


def _is_plain_client(client: sym.ClientPort) -> bool:
    """Return whether the dialect can express all features of a client."""
    timed = client.timeout is not None or client.timedOut is not None
    more = timed or client.group is not None or client.waitsForService or client.latency is not None
    is_assumed = client.assumed is not None
    return _is_plain(client.client) and client.outstanding is None and not more and not is_assumed


def _says_all(clause: sym.InputClause) -> bool:
    """Return whether parsing the text gives this very normal form again."""
    from dineros.metamodel.clauses import parse, to_cnf

    node_net = node_net_of(clause)
    if node_net is None or not _is_plain(clause.text):
        return False
    signals = {label(signal): signal for signal in node_net.signals}
    try:
        form = [
            [(signals.get(each.signal), each.negated, each.value) for each in part]
            for part in to_cnf(parse(clause.text))
        ]
    except DinerosError:
        return False
    stored = [
        [(each.signal, each.negated, each.value) for each in part.literals] for part in clause.disjunctions
    ]
    return form == stored
