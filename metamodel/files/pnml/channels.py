"""Reading topics, services and actions of the DiNeROS extension, which are in a file like transitions."""

from __future__ import annotations

from lxml import etree

from dineros.metamodel import pn, positions, sym
from dineros.metamodel.elements import resolve
from dineros.metamodel.errors import DinerosError, near_matches, with_article
from dineros.metamodel.files.pnml.records import Extension, item_text, items
from dineros.metamodel.files.pnml.source import Source, child


class ChannelReader:
    """Sets names and limits at once, and the places of ports once every place exists (`finish`)."""

    def __init__(self, source: Source, models: dict[str, pn.Element]) -> None:
        self._source = source
        self._models = models
        self._ports: list[
            tuple[sym.PublisherPort | sym.SubscriberPort | sym.ClientPort, str, etree._Element]
        ] = []
        self._servers: list[tuple[sym.ServerPort, Extension]] = []

    def read(self, channel: sym.Channel, extension: Extension) -> None:
        """Read the fields of a topic, a service or an action."""
        if isinstance(channel, sym.TopicChannel):
            self._topic(channel, extension)
        elif isinstance(channel, sym.ServiceChannel):
            self._service(channel, extension)
        elif isinstance(channel, sym.ActionChannel) and (name := extension.text("actionName")) is not None:
            channel.action = name  # its ports are in our own block

    def _topic(self, channel: sym.TopicChannel, extension: Extension) -> None:
        if (name := extension.text("topicName")) is not None:
            channel.topic = name
        for xml in items(extension.fields.get("publishers"), "publisher"):
            publisher = sym.PublisherPort(channel=channel)
            self._limit(publisher, xml)
            self._port(publisher, "id", xml)
        for xml in items(extension.fields.get("subscribers"), "subscriber"):
            subscriber = sym.SubscriberPort(channel=channel)
            self._limit(subscriber, xml)
            self._port(subscriber, "id", xml)

    def _limit(self, port: sym.PublisherPort | sym.SubscriberPort, xml: etree._Element) -> None:
        positions.remember(port, self._source.location(xml))
        if (limit := item_text(xml, "limit")) is not None:
            port.limit = self._source.integer(limit, xml, "the limit")

    def _service(self, channel: sym.ServiceChannel, extension: Extension) -> None:
        if (name := extension.text("serviceName")) is not None:
            channel.service = name
        if (capacity := extension.text("serverCapacity")) is not None:
            where = extension.fields["serverCapacity"]
            channel.instances = self._source.integer(capacity, where, "the capacity")
        if extension.text("serverInput") or extension.text("serverOutput"):
            channel.server = sym.ServerPort()
            self._servers.append((channel.server, extension))
        for xml in items(extension.fields.get("channels"), "channel"):
            client = sym.ClientPort(channel=channel)
            positions.remember(client, self._source.location(xml))
            if (name := item_text(xml, "cid")) is not None:
                client.client = name
            self._port(client, "request", xml)
            self._port(client, "response", xml)

    def _port(
        self, port: sym.PublisherPort | sym.SubscriberPort | sym.ClientPort, field: str, xml: etree._Element
    ) -> None:
        if child(xml, field) is None or item_text(xml, field) is None:
            raise self._source.error(f"a port names no place: it has no <{field}>", xml)
        self._ports.append((port, field, xml))

    def finish(self) -> None:
        """Find the places that ports name, and the server pages.

        Raises
        ------
        ModelFileError
            A port names something that is not a place, or references in a circle.
        """
        for port, field, xml in self._ports:
            place = self._find_place(item_text(xml, field) or "", child(xml, field))
            if isinstance(port, sym.ClientPort):
                setattr(port, field, place)
            else:
                port.place = place
        for server, extension in self._servers:
            for field, feature in (("serverInput", "entry"), ("serverOutput", "exit")):
                if (id := extension.text(field)) is not None:
                    setattr(server, feature, self._find_place(id, extension.fields[field]))
            positions.remember(server, self._source.location(next(iter(extension.fields.values()))))
            entry: pn.Place | None = server.entry
            if entry is not None and entry.page is not None:
                server.page = entry.page

    def _find_place(self, id: str, xml: etree._Element | None) -> pn.Place:
        found = self._models.get(id)
        if not isinstance(found, pn.PlaceNode):
            hint = near_matches(
                id, [key for key, each in self._models.items() if isinstance(each, pn.PlaceNode)]
            )
            is_there = found is not None
            what = (
                f"{with_article(type(found).__name__)}, not a place" if is_there else "which does not exist"
            )
            raise self._source.error(f"a port names {id!r}, {what}", xml, id=id, hint=hint)
        try:
            place = resolve(found)
        except DinerosError as error:
            error.location = self._source.location(xml)
            raise
        assert isinstance(place, pn.Place)
        return place
