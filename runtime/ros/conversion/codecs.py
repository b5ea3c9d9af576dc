"""The ROS interfaces of a node's ports, and the conversion of tokens to their messages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dineros.runtime.nets.ports import (
    ActionClientPort,
    ActionServerPort,
    ClientPort,
    Data,
    Message,
    Port,
    Ports,
    PublisherPort,
    ServerPort,
    SubscriberPort,
)
from dineros.runtime.ros.conversion.interfaces import load_interface
from dineros.runtime.ros.conversion.mappings import MappedCodec
from dineros.runtime.ros.conversion.messages import (
    Codec,
    PartCodec,
    TokenCodec,
    action_interface,
    service_interface,
    token_interface,
)


@dataclass(frozen=True)
class ActionCodecs:
    """Converts the goals, results and feedback of an action to messages and back.

    Attributes
    ----------
    interface : class
        The action's class.
    goal : Codec
        Codec of goals.
    result, feedback : Codec or None
        Codecs of results and feedback; None: the node has no place for them.
    has_numbers : bool
        Whether feedback has a number, as in generated actions.
    """

    interface: Any
    goal: Codec
    result: Codec | None
    feedback: Codec | None
    has_numbers: bool

    def encode_result(self, goal: str, data: Data) -> Any:
        """Return a result as a ROS message."""
        return self.interface.Result() if self.result is None else self.result.encode(Message(goal, data))

    def decode_result(self, ros_message: Any) -> Data:
        """Return the data of a result message."""
        return {} if self.result is None else self.result.decode(ros_message).data

    def encode_feedback(self, goal: str, number: int, data: Data) -> Any:
        """Return feedback as a ROS message."""
        assert self.feedback is not None
        made = self.feedback.encode(Message(goal, data))
        if self.has_numbers:
            made.number = number
        return made

    def decode_feedback(self, ros_message: Any) -> tuple[int, Data]:
        """Return number and data of a feedback message."""
        number = int(ros_message.number) if self.has_numbers else 0
        return number, {} if self.feedback is None else self.feedback.decode(ros_message).data


class Codecs:
    """The codecs of a node's ports.

    Parameters
    ----------
    ports : Ports
        Model, token types and ports of the node.
    """

    def __init__(self, ports: Ports) -> None:
        self._ports = ports
        self._made: dict[str, tuple[Any, TokenCodec]] = {}

    def _token(self, place: str) -> tuple[Any, TokenCodec]:
        """Return the message class for the tokens of a place, and their codec."""
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
            The interface is not installed, or does not fit the model.
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
            The interface is not installed, or does not fit the model.
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

    def action(self, port: ActionClientPort | ActionServerPort) -> ActionCodecs:
        """Return the class of an action and the codecs of its parts.

        Raises
        ------
        InterfaceError
            The interface is not installed, or does not fit the model.
        """
        if isinstance(port, ActionClientPort):
            goal, feedback = port.goal, port.feedback
            result = next(iter(port.outcomes.values()), None)
        else:
            goal, feedback = port.entries[0], next(iter(port.feedbacks), None)
            result = next((places[0] for places in port.outcomes.values()), None)
        interface = load_interface(port.type or action_interface(self._ports.model, port.channel))
        parts = {"goal": interface.Goal, "result": interface.Result, "feedback": interface.Feedback}
        made: dict[str, Codec | None] = {}
        for part, place in (("goal", goal), ("result", result), ("feedback", feedback)):
            if place is None or (port.type is None and not hasattr(parts[part], "token")):
                made[part] = None
            elif port.type is None:
                made[part] = PartCodec(parts[part], self._token(place)[1])
            else:
                made[part] = self._mapped(parts[part], port, part, place)
        assert made["goal"] is not None
        has_numbers = port.type is None and hasattr(interface.Feedback, "number")
        return ActionCodecs(interface, made["goal"], made["result"], made["feedback"], has_numbers)

    def _mapped(self, interface: Any, port: Port, part: str, place: str) -> MappedCodec:
        name = port.type if part == "message" else f"the {part} of {port.type}"
        mappings = [mapping for mapping in port.mappings if mapping.part == part]
        return MappedCodec(interface, str(name), mappings, self._ports.type_at(place))
