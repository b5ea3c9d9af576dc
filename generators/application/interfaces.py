"""The messages, services and actions for a model's tokens (ROS 2 design, "Interface definition").

Field kinds become ``string``, ``int64``, ``float64`` or ``bool``, unless the field names a ROS type. A list
becomes an array, of fixed length if the token type has one; a map becomes an array of entries. Each generated
message ends with its id, by which a node recognises messages that it has received before. Token types that
are installed messages are used unchanged.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

from dineros.generators.application.naming import (
    NOTHING_RESERVED,
    NamingError,
    Reserved,
    interface,
    require_own_packages,
)
from dineros.generators.application.tokens import (
    ROS_TYPES,
    Field,
    TokenClass,
    entry_name,
    token_classes,
)
from dineros.generators.templates.filters import Name, Written
from dineros.metamodel import pn, sym
from dineros.metamodel.calls import exits
from dineros.metamodel.elements import token_types
from dineros.metamodel.ros_names import camel_case, interfaces_package
from dineros.metamodel.token_types.declared import type_of_place

Served = TypeVar("Served", sym.ServiceChannel, sym.ActionChannel)


@dataclass(frozen=True)
class Service:
    """A service with a generated type."""

    name: Name
    """Name of the type."""
    request: TokenClass
    response: TokenClass
    """`request`, `response`: token types of its parts."""


@dataclass(frozen=True)
class Action:
    """An action with a generated type."""

    name: Name
    """Name of the type."""
    goal: TokenClass
    """Token type of goals."""
    result: TokenClass | None
    feedback: TokenClass | None
    """`result`, `feedback`: token types of results and feedback; None: there are none."""


@dataclass(frozen=True)
class Interfaces:
    """The interface package of a model."""

    package: Name
    """Its name."""
    types: tuple[TokenClass, ...]
    """The token types, beginning with the model's first one."""
    nested: tuple[TokenClass, ...]
    """The ROS types nested in installed messages; a type follows the types nested in it."""
    entries: tuple[tuple[Name, Written], ...]
    """Messages for the entries of maps: name, and ROS type of the value."""
    services: tuple[Service, ...]
    """The service types."""
    actions: tuple[Action, ...]
    """The action types."""

    @property
    def token(self) -> Name:
        """Name of the first token type: that of its message and of the class in handlers."""
        return self.types[0].name

    @property
    def fields(self) -> tuple[Field, ...]:
        """Fields of the first token type."""
        return self.types[0].fields

    @property
    def generated(self) -> tuple[TokenClass, ...]:
        """Token types with generated messages; the interface package has at least one message."""
        own = tuple(each for each in self.types if each.ros is None)
        if own or self.services or self.actions:
            return own
        return (TokenClass(None, Name("Token"), Name("token"), (), None),)

    @property
    def dependencies(self) -> list[Name]:
        """Packages of the installed messages in services and actions."""
        carried = [part for service in self.services for part in (service.request, service.response)]
        for action in self.actions:
            carried += [part for part in (action.goal, action.result, action.feedback) if part is not None]
        return sorted({part.package for part in carried if part.package is not None})

    @property
    def files(self) -> list[str]:
        """The interface files, in the notation of CMake."""
        names = (*(each.name for each in self.generated), *(name for name, _ in self.entries))
        return [
            *(f"msg/{name}.msg" for name in names),
            *(f"srv/{each.name}.srv" for each in self.services),
            *(f"action/{each.name}.action" for each in self.actions),
        ]

    def type_named(self, token_type: sym.TokenType | None) -> TokenClass:
        """Return the class of a token type of the model, or of its copy; None: of the first one."""
        if token_type is None:
            return self.types[0]
        return next(each for each in self.types if each.id == token_type.id)


def interfaces_of(model: sym.SystemModel, reserved: Reserved = NOTHING_RESERVED) -> Interfaces:
    """Return the interface package of a model; no name of the model hides one of `reserved`.

    Raises
    ------
    NamingError
        Names of the model collide in ROS.
    UnknownInterfaceError
        A token type is a ROS message that is not installed.
    """
    require_own_packages(model.id)
    types, nested = token_classes(model, reserved)
    own = [field for each in token_types(model) if not each.ros for field in each.fields]
    used = {str(field.elementKind) for field in own if str(field.kind) == "map"}
    entries = tuple((entry_name(kind), Written(ros)) for kind, ros in ROS_TYPES.items() if kind in used)
    for each in types:
        if each.ros is None and each.name.lower() in {entry.lower() for entry, _ in entries}:
            raise NamingError(
                f"the token type {each.name!r} has the name of a message for maps",
                element=each.id,
                hint="rename the token type",
            )
    interfaces = Interfaces(Name(interfaces_package(model.id)), types, nested, entries, (), ())
    services = tuple(
        Service(
            name,
            _class_at(channel.server.entry, interfaces, model),
            _class_at(channel.server.exit, interfaces, model),
        )
        for name, channel in _named(model, sym.ServiceChannel, "service").items()
    )
    actions = tuple(
        _action(name, channel, interfaces, model)
        for name, channel in _named(model, sym.ActionChannel, "action").items()
    )
    return replace(interfaces, services=services, actions=actions)


def _named(model: sym.SystemModel, kind: type[Served], word: str) -> dict[Name, Served]:
    """Return the channels of a kind with generated types, by the names of these types."""
    named: dict[Name, Served] = {}
    files: dict[str, str] = {}  # not all systems distinguish case, and headers are in lower case
    for channel in model.channels:
        if isinstance(channel, kind) and not channel.type:
            name = interface(f"the {word} {channel.id[:40]!r}", camel_case(channel.id), channel.id)
            same = files.setdefault(name.lower(), channel.id)
            if same != channel.id:
                raise NamingError(
                    f"{word}s {same!r} and {channel.id!r} both become the type {name}",
                    element=channel.id,
                    hint="rename one of them",
                )
            named[name] = channel
    return named


def _action(name: Name, channel: sym.ActionChannel, interfaces: Interfaces, model: sym.SystemModel) -> Action:
    server = channel.server
    result = next(iter(exits(server)), None)
    return Action(
        name,
        _class_at(server.entry, interfaces, model),
        None if result is None else _class_at(result, interfaces, model),
        None if server.feedback is None else _class_at(server.feedback, interfaces, model),
    )


def _class_at(place: pn.Node, interfaces: Interfaces, model: sym.SystemModel) -> TokenClass:
    return interfaces.type_named(type_of_place(place, model))
