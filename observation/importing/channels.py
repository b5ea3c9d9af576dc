"""The channels of a model that is being imported: one for each topic, service and action; their ports."""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.matching import Quality
from dineros.metamodel.token_types.installed import installed_interfaces
from dineros.observation.importing.flows.labels import Deciding, of_service
from dineros.observation.importing.names import Ids, flat
from dineros.observation.systems import USUAL, Endpoint, TopicEndpoint


class Channels:
    """Topics, services and actions; each is created with its first port."""

    def __init__(self, deciding: Mapping[str, Deciding] | None = None) -> None:
        self.ids = Ids()
        """Creates the ids of the model."""
        self.deciding = deciding or {}
        """Topics whose messages carry data, as callbacks depend on it."""
        self.types: dict[str, sym.TokenType] = {}
        """Token types of such messages, by the type of the message."""
        self.topics: dict[str, sym.TopicChannel] = {}
        self.services: dict[str, sym.ServiceChannel] = {}
        self.actions: dict[str, sym.ActionChannel] = {}
        """`topics`, `services`, `actions`: the channels by their full names."""

    def tokens(self, topic: str) -> sym.TokenType | None:
        """Return the token type of the messages of a topic; None: their data does not matter."""
        if topic not in self.deciding:
            return None
        deciding = self.deciding[topic]
        if deciding.numbers or installed_interfaces(deciding.type.partition("/")[0]) is None:
            return self._type(deciding)
        name = deciding.type
        if name not in self.types:
            id = self.ids.new(f"type.{flat(name)}")
            self.types[name] = sym.TokenType(id=id, ros=name)
        return self.types[name]

    def responses(self, service: str) -> sym.TokenType | None:
        """Return the token type of the responses of a service; None: their data does not matter."""
        deciding = self.deciding.get(of_service(service))
        return None if deciding is None else self._type(deciding)

    def _type(self, deciding: Deciding) -> sym.TokenType:
        """Return a token type with the field that decides, and the values that are distinguished."""
        name = f"{deciding.type}.{deciding.name}"
        values = ", ".join(
            f"{text}={number}" for text, number in zip(deciding.texts, deciding.numbers, strict=False)
        )
        key = f"{name} {values}"
        if key not in self.types:
            field = sym.TokenField(name=deciding.name, kind="integer" if values else "boolean")
            if values:
                field.values = values
                field.default = str(deciding.numbers[0])
            self.types[key] = sym.TokenType(id=self.ids.new(f"type.{flat(name)}"), fields=[field])
        return self.types[key]

    def all(self) -> list[sym.Channel]:
        """Return all channels, by their names."""
        kinds = (self.topics, self.services, self.actions)
        return [kind[name] for kind in kinds for name in sorted(kind)]

    def publish(self, endpoint: TopicEndpoint, place: sym.Place, limit: int) -> sym.PublisherPort:
        """Add a publisher."""
        port = sym.PublisherPort(place=place, limit=limit, qos=_quality(endpoint.quality))
        self._topic(endpoint).publishers.append(port)
        return port

    def subscribe(self, endpoint: TopicEndpoint, place: sym.Place, limit: int) -> sym.SubscriberPort:
        """Add a subscription."""
        port = sym.SubscriberPort(place=place, limit=limit, qos=_quality(endpoint.quality))
        self._topic(endpoint).subscribers.append(port)
        return port

    def serve(self, endpoint: Endpoint, port: sym.ServerPort, instances: int) -> None:
        """Add the server of a service."""
        channel = self._service(endpoint)
        channel.server, channel.instances = port, instances

    def ask(
        self,
        endpoint: Endpoint,
        client: str,
        request: pn.Place,
        response: pn.Place,
        group: sym.CallbackGroup | None,
    ) -> sym.ClientPort:
        """Add a client of a service."""
        port = sym.ClientPort(client=client, request=request, response=response, group=group)
        self._service(endpoint).clients.append(port)
        return port

    def work(self, endpoint: Endpoint, port: sym.ActionServerPort) -> None:
        """Add the server of an action."""
        self._action(endpoint).server = port

    def want(self, endpoint: Endpoint, port: sym.ActionClientPort) -> None:
        """Add a client of an action."""
        self._action(endpoint).clients.append(port)

    def _topic(self, endpoint: TopicEndpoint) -> sym.TopicChannel:
        name = endpoint.topic
        if name not in self.topics:
            id = self.ids.new(f"topic.{flat(name)}")
            type = None if name in self.deciding else endpoint.type  # that of its tokens
            self.topics[name] = sym.TopicChannel(id=id, topic=name, type=type)
        return self.topics[name]

    def _service(self, endpoint: Endpoint) -> sym.ServiceChannel:
        name = endpoint.name
        if name not in self.services:
            id = self.ids.new(f"service.{flat(name)}")
            type = None if of_service(name) in self.deciding else endpoint.type  # tokens have fields of it
            self.services[name] = sym.ServiceChannel(id=id, service=name, type=type)
        return self.services[name]

    def _action(self, endpoint: Endpoint) -> sym.ActionChannel:
        name = endpoint.name
        if name not in self.actions:
            id = self.ids.new(f"action.{flat(name)}")
            self.actions[name] = sym.ActionChannel(id=id, action=name, type=endpoint.type)
        return self.actions[name]


def _quality(quality: Quality) -> sym.QualityOfService | None:
    """Return the quality of service of a port; None if it is the default."""
    if quality == USUAL:
        return None
    return sym.QualityOfService(
        reliability=quality.reliability,
        durability=quality.durability,
        liveliness=quality.liveliness,
        deadline=quality.deadline,
        leaseDuration=quality.lease_duration,
        lifespan=quality.lifespan,
    )
