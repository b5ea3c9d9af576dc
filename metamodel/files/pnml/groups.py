"""Reading the callback groups of the DiNeROS extension, which are in a block of the net."""

from __future__ import annotations

from lxml import etree

from dineros.metamodel import pn, positions, sym
from dineros.metamodel.elements import label, node_net_of, node_nets
from dineros.metamodel.files.pnml.layout import read_graphics
from dineros.metamodel.files.pnml.records import Extension, PageRecord, item_text, items
from dineros.metamodel.files.pnml.source import Source, child


def read_groups(
    source: Source,
    models: dict[str, pn.Element],
    record: PageRecord,
    net: pn.Net,
    pages: list[tuple[sym.CallbackPage, Extension]],
) -> None:
    """Make the callback groups of a net, and give callback pages theirs.

    A group that only a page names is made with the default values; of a group that one of our own blocks
    declares, the extension's fields say nothing more.

    Raises
    ------
    ModelFileError
        A group names no node, or a page with a group is outside of all node nets.
    """
    groups = _Groups(source, models, net, pages)
    for xml in items(record.extension.fields.get("callbackgroups"), "group"):
        groups.declare(xml)
    for page, extension in pages:
        where = extension.fields["group"]
        name = extension.text("group") or ""
        node_net = node_net_of(page)
        if node_net is None:
            hint = "a group belongs to a node net; put the page into one"
            raise source.error(f"{page.id!r} names the group {name!r}", where, id=page.id, hint=hint)
        page.group = groups.find(node_net, name) or groups.add(node_net, name, where)


def identify(element: pn.Element, name: str, node_net: sym.NodeNet, models: dict[str, pn.Element]) -> None:
    """Give an element that files know by its name that name as its id, or else ``<node>.<name>``."""
    id, number = name, 1
    while id in models:
        id = f"{node_net.id}.{name}" + (f".{number}" if number > 1 else "")
        number += 1
    element.id = id
    if id != name:
        element.name = name
    models[id] = element


class _Groups:
    """The callback groups made so far, by node net and name."""

    def __init__(
        self,
        source: Source,
        models: dict[str, pn.Element],
        net: pn.Net,
        pages: list[tuple[sym.CallbackPage, Extension]],
    ) -> None:
        self._source = source
        self._models = models
        self._nodes: dict[str, sym.NodeNet] = {}
        self._groups: dict[tuple[sym.NodeNet, str], sym.CallbackGroup] = {}
        for node_net in node_nets(net):
            self._nodes.setdefault(label(node_net).strip(), node_net)
            for group in node_net.callbackGroups:
                self._groups[node_net, group.id] = group
        for node_net in node_nets(net):
            self._nodes.setdefault(node_net.id, node_net)
            for group in node_net.callbackGroups:
                self._groups.setdefault((node_net, label(group)), group)
        self._users: dict[str, set[sym.NodeNet]] = {}
        for page, extension in pages:
            if (user := node_net_of(page)) is not None:
                self._users.setdefault(extension.text("group") or "", set()).add(user)

    def find(self, node_net: sym.NodeNet, name: str) -> sym.CallbackGroup | None:
        """Return the group of this id or name, or None."""
        return self._groups.get((node_net, name))

    def add(self, node_net: sym.NodeNet, name: str, xml: etree._Element) -> sym.CallbackGroup:
        """Make a group."""
        group = self._groups[node_net, name] = sym.CallbackGroup()
        identify(group, name, node_net, self._models)
        node_net.callbackGroups.append(group)
        positions.remember(group, self._source.location(xml))
        return group

    def declare(self, xml: etree._Element) -> None:
        """Make a group from its fields, unless it is there."""
        name = item_text(xml, "id")
        if name is None:
            raise self._source.error("a callback group has no <id>", xml)
        node_net = self._node(name, xml)
        if self.find(node_net, name) is not None:
            return
        group = self.add(node_net, name, xml)
        if (kind := item_text(xml, "type")) is not None:
            plain = kind.lower().removeprefix("mutually")
            if not plain.startswith(("exclusive", "reentrant")):
                hint = "kinds are exclusive and reentrant"
                raise self._source.error(f"{kind!r} is not a kind of callback group", xml, id=name, hint=hint)
            group.kind = "exclusive" if plain.startswith("exclusive") else "reentrant"
        if (priority := item_text(xml, "priority")) is not None:
            group.priority = self._source.integer(priority, xml, "the priority")
        if (graphics := child(xml, "graphics")) is not None:
            group.graphics = read_graphics(graphics, self._source)

    def _node(self, name: str, xml: etree._Element) -> sym.NodeNet:
        """Return the node net a group names, or that of the pages that name the group, or the only one."""
        node = item_text(xml, "node")
        known = set(self._nodes.values())
        found = {self._nodes.get(node)} - {None} if node is not None else self._users.get(name) or known
        if len(found) == 1:
            (node_net,) = found
            assert node_net is not None
            return node_net
        what = f"names the node {node!r}, which does not exist" if node else "names no node"
        hint = f"nodes are {', '.join(sorted(label(each) for each in known)) or 'missing'}"
        raise self._source.error(f"the callback group {name!r} {what}", xml, id=name, hint=hint)
