"""Which ROS interfaces the ports of a node use, and how tokens become their messages."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from dineros.runtime.nets.ports import ClientPort, Ports, PublisherPort, ServerPort, SubscriberPort
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
        Model, token type and ports.
    """

    def __init__(self, ports: Ports) -> None:
        self._model = ports.model
        self._token_type = ports.token_type

    @cached_property
    def _token(self) -> tuple[Any, TokenCodec]:
        interface = load_interface(token_interface(self._model, self._token_type))
        return interface, TokenCodec(interface, self._model, self._token_type)

    def topic(self, port: PublisherPort | SubscriberPort) -> tuple[Any, Codec]:
        """Return the message class of a topic and its codec.

        Raises
        ------
        InterfaceError
            It is not installed, or does not fit the model.
        """
        if port.type is None:
            return self._token
        interface = load_interface(port.type)
        return interface, self._mapped(interface, port, "message")

    def service(self, port: ClientPort | ServerPort) -> tuple[Any, Codec, Codec]:
        """Return the class of a service, and the codecs of its requests and responses.

        Raises
        ------
        InterfaceError
            It is not installed, or does not fit the model.
        """
        if port.type is None:
            interface = load_interface(service_interface(self._model, port.channel))
            token = self._token[1]
            return interface, PartCodec(interface.Request, token), PartCodec(interface.Response, token)
        interface = load_interface(port.type)
        return (
            interface,
            self._mapped(interface.Request, port, "request"),
            self._mapped(interface.Response, port, "response"),
        )

    def _mapped(
        self, interface: Any, port: PublisherPort | SubscriberPort | ClientPort | ServerPort, part: str
    ) -> MappedCodec:
        name = port.type if part == "message" else f"the {part} of {port.type}"
        mappings = [mapping for mapping in port.mappings if mapping.part == part]
        return MappedCodec(interface, str(name), mappings, self._token_type)
