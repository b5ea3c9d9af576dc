"""Which ROS interfaces the ports of a node use, and how tokens become their messages."""

from __future__ import annotations

from typing import Any

from dineros.runtime.nets.ports import ClientPort, Port, Ports, PublisherPort, ServerPort, SubscriberPort
from dineros.runtime.ros.conversion.interfaces import load_interface
from dineros.runtime.ros.conversion.mappings import MappedCodec
from dineros.runtime.ros.conversion.messages import (
    Codec,
    PartCodec,
    TokenCodec,
    service_interface,
    token_interface,
)


class Codecs:
    """The codecs of a node's ports.

    Parameters
    ----------
    ports : Ports
        Model, token types and ports.
    """

    def __init__(self, ports: Ports) -> None:
        self._ports = ports
        self._made: dict[str, tuple[Any, TokenCodec]] = {}

    def _token(self, place: str) -> tuple[Any, TokenCodec]:
        """Return the class of the messages that the tokens of a place are, and their codec."""
        model, token_type = self._ports.model, self._ports.type_at(place)
        name = token_interface(model, token_type)
        if name not in self._made:
            interface = load_interface(name)
            self._made[name] = interface, TokenCodec(interface, model, token_type)
        return self._made[name]

    def topic(self, port: PublisherPort | SubscriberPort) -> tuple[Any, Codec]:
        """Return the message class of a topic and its codec.

        Raises
        ------
        InterfaceError
            It is not installed, or does not fit the model.
        """
        if port.type is None or port.type == self._ports.type_at(port.place).ros:
            return self._token(port.place)
        interface = load_interface(port.type)
        return interface, self._mapped(interface, port, "message", port.place)

    def service(self, port: ClientPort | ServerPort) -> tuple[Any, Codec, Codec]:
        """Return the class of a service, and the codecs of its requests and responses.

        Raises
        ------
        InterfaceError
            It is not installed, or does not fit the model.
        """
        if isinstance(port, ClientPort):
            request, response = port.request, port.response
        else:
            request, response = port.entries[0], port.exits[0]
        if port.type is None:
            interface = load_interface(service_interface(self._ports.model, port.channel))
            asked, answered = self._token(request)[1], self._token(response)[1]
            return interface, PartCodec(interface.Request, asked), PartCodec(interface.Response, answered)
        interface = load_interface(port.type)
        return (
            interface,
            self._mapped(interface.Request, port, "request", request),
            self._mapped(interface.Response, port, "response", response),
        )

    def _mapped(self, interface: Any, port: Port, part: str, place: str) -> MappedCodec:
        name = port.type if part == "message" else f"the {part} of {port.type}"
        mappings = [mapping for mapping in port.mappings if mapping.part == part]
        return MappedCodec(interface, str(name), mappings, self._ports.type_at(place))
