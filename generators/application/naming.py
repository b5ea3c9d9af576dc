"""Names in generated code: ROS packages, Python functions and classes, and collisions between names."""

from __future__ import annotations

import builtins
import keyword
import re
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass

from dineros.generators.application.taken import owner_of
from dineros.generators.templates.filters import Name
from dineros.metamodel import sym
from dineros.metamodel.elements import label, node_nets
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.ros_names import (
    camel_case,
    full_name,
    interfaces_package,
    reserved_services,
    reserved_topics,
    resource_name,
    snake_case,
)
from dineros.metamodel.token_data import field_type

_PACKAGE = re.compile(r"[a-z][a-z0-9_]*[a-z0-9]")
_INTERFACE = re.compile(r"[A-Z][A-Za-z0-9]*")
LONGEST = 200
"""Longest name of a package or an interface, in bytes: file names add to it, and end at 255."""
_BUILTINS = frozenset(dir(builtins))
# Macros of C and C++ in headers that every interface package includes.
_MACROS = frozenset({"NULL", "EOF", "TRUE", "FALSE", "errno", "linux", "unix"})
# Names that the class of a message has, or uses in its body (rosidl_generator_py).
_MESSAGE_CLASS = frozenset({"builtins", "get_fields_and_field_types"})
# Reserved words of C++; interface packages are C++ packages, too (ISO C++ 17, table 5).
_CPP_KEYWORDS = frozenset(
    """
    alignas alignof and_eq asm auto bitand bitor bool case catch char char16_t char32_t class compl concept
    const const_cast constexpr decltype default delete do double dynamic_cast else enum explicit export extern
    false float for friend goto if inline int long mutable namespace new noexcept not_eq nullptr operator
    or_eq private protected public register reinterpret_cast requires return short signed sizeof static
    static_assert static_cast struct switch template this thread_local throw true try typedef typeid typename
    union unsigned using virtual void volatile wchar_t while xor xor_eq
    """.split()  # noqa: SIM905  (the list has 92 lines)
)


class NamingError(DinerosError):
    """A name of the model cannot be used in a ROS workspace, or two names collide."""


@dataclass(frozen=True)
class Reserved:
    """Names that templates use in generated modules; names of the model must not hide them."""

    handlers: frozenset[str] = frozenset()
    firings: frozenset[str] = frozenset()
    tokens: frozenset[str] = frozenset()
    """`handlers`, `firings`, `tokens`: names in the modules `handlers`, `firings` and `tokens`."""

    @property
    def type_names(self) -> frozenset[str]:
        """Prefixes that the types of transitions must not have."""
        suffixes = ("Firing", "Inputs", "Outputs")
        return frozenset(
            name.removesuffix(suffix) for name in self.firings for suffix in suffixes if name.endswith(suffix)
        )


NOTHING_RESERVED = Reserved()


def bringup_package(model: str) -> Name:
    """Return the name of the package that starts a model's nodes, from the id of the model.

    Examples
    --------
    >>> bringup_package("sorting")
    'sorting_bringup'
    """
    return Name(f"{snake_case(model)}_bringup")


def require_own_packages(model: str) -> None:
    """Refuse a model whose interface or launch package would have the name of another package.

    Raises
    ------
    NamingError
        Packages of these names are known, or the names are too long.
    """
    for name in (interfaces_package(model), bringup_package(model)):
        require_short(name, "the package", model)
        owner = owner_of(name)
        if owner is not None:
            raise NamingError(
                f"the package {name!r} of the model is that of {owner}",
                element=model,
                hint="give the model another id",
            )


def require_short(name: str, what: str, element: str | None) -> None:
    """Refuse a name that is too long for the files named after it.

    Raises
    ------
    NamingError
        It is too long.
    """
    if len(name.encode()) > LONGEST:
        raise NamingError(
            f"the name of {what}, {name[:20]!r}..., has {len(name.encode())} bytes; at most {LONGEST} fit",
            element=element and element[:40],
            hint="shorten it",
        )


def node_packages(model: sym.SystemModel, node_nets: Iterable[sym.NodeNet]) -> dict[str, Name]:
    """Return the name of each node net's package, by the id of the node net.

    Raises
    ------
    NamingError
        Two node nets have the same package name, or a package has the name of a required one.
    """
    own = {interfaces_package(model.id): "the interfaces", bringup_package(model.id): "the launch files"}
    packages: dict[str, Name] = {}
    for node in node_nets:
        name = node.package or snake_case(label(node))
        require_short(name, "the package", node.id)
        whose = own.get(name) or owner_of(name)
        if whose is None and name in packages.values():
            whose = next(repr(id) for id, package in packages.items() if package == name)
        if whose is not None:
            raise NamingError(
                f"the package {name!r} of node net {node.id!r} is that of {whose}",
                element=node.id,
                hint=f"set the package of the node net, such as {snake_case(model.id)}_{snake_case(node.id)}",
            )
        if not _PACKAGE.fullmatch(name) or keyword.iskeyword(name):
            raise NamingError(
                f"{name!r} is not a name for the package of node net {node.id!r}",
                element=node.id,
                hint="set the package of the node net: two or more small letters, digits and _",
            )
        packages[node.id] = Name(name)
    return packages


def node_name(node: sym.NodeNet) -> Name:
    """Return the name of the ROS node: that of the node net, changed if ROS does not accept it.

    Raises
    ------
    NamingError
        It is too long.
    """
    name = Name(resource_name(label(node)))
    require_short(name, "the node", node.id)
    return name


def functions(ids: Iterable[str], reserved: Reserved = NOTHING_RESERVED) -> dict[str, Name]:
    """Return a distinct name of a Python function for each id; none hides another name."""
    return _distinct(ids, snake_case, reserved.handlers | _BUILTINS)


def classes(ids: Iterable[str], reserved: Reserved = NOTHING_RESERVED) -> dict[str, Name]:
    """Return a distinct prefix of type names for each id."""
    return _distinct(ids, camel_case, reserved.type_names)


def _distinct(ids: Iterable[str], case: Callable[[str], str], taken: Container[str]) -> dict[str, Name]:
    names: dict[str, Name] = {}
    used: set[str] = set()
    for id in ids:
        stem = case(id)
        name = f"{stem}_" if keyword.iskeyword(stem) or stem in taken else stem
        number = 1
        while name in used:
            number += 1
            name = f"{stem}_{number}"
        used.add(name)
        names[id] = Name(name)
    return names


def require_short_paths(paths: Iterable[str]) -> None:
    """Refuse file names that are too long.

    Raises
    ------
    NamingError
        A part of a path, with some reserve, exceeds `LONGEST` bytes.
    """
    for path in paths:
        for part in path.split("/"):
            if len(part.encode()) > LONGEST + 20:
                raise NamingError(
                    f"the file {part[:20]!r}... would have a name of {len(part.encode())} bytes, at most "
                    f"{LONGEST + 20} fit",
                    hint="shorten the name that it comes from",
                )


def interface(what: str, name: str, element: str | None, reserved: Reserved = NOTHING_RESERVED) -> Name:
    """Return the name of a message or service type, which becomes a class in Python and in C++.

    Raises
    ------
    NamingError
        It is invalid, or hides a name that the module of tokens uses.
    """
    require_short(name, what, element)
    taken = {name, f"{name}Changes"} & reserved.tokens
    if taken or keyword.iskeyword(name) or name in _MACROS or not _INTERFACE.fullmatch(name):
        reason = f"{taken.pop()!r} is taken in Python" if taken else "it is a word of Python or C"
        raise NamingError(
            f"{what} becomes the interface {name!r}, but {reason}", element=element, hint=f"rename {what}"
        )
    return Name(name)


def message_fields(token_type: sym.TokenType | None) -> dict[str, Name]:
    """Return the name of each token field in messages.

    Raises
    ------
    NamingError
        Two fields get the same name, or a field gets a name that ROS does not allow.
    """
    names: dict[str, Name] = {}
    for field in token_type.fields if token_type else ():
        name = snake_case(field.name)
        for value, _ in field_type(field).range.names:
            if value in _MACROS:
                raise NamingError(
                    f"the value {value} of token field {field.name!r} has the name of a macro of C",
                    element=token_type.id if token_type else None,
                    hint="rename the value",
                )
        problem = None
        if name == "message_id":
            problem = "which carries the id of the message"
        elif name in names.values():
            problem = f"as does {next(repr(known) for known, same in names.items() if same == name)}"
        elif name in _CPP_KEYWORDS or keyword.iskeyword(name):
            problem = "a keyword of C++ or Python"
        elif name in _MESSAGE_CLASS | _MACROS:
            problem = "which the code of messages uses itself"
        if problem:
            raise NamingError(
                f"token field {field.name!r} becomes the message field {name!r}, {problem}",
                element=token_type.id if token_type else None,
                hint="rename the field",
            )
        require_short(name, "the message field", token_type.id if token_type else None)
        names[field.name] = Name(name)
    return names


def require_lifecycle_names(model: sym.SystemModel) -> None:
    """Check that no channel has a name that its nodes need once all of them are lifecycle nodes.

    The names of nodes that the model itself manages are checked by the constraint `channel-name-reserved`.

    Raises
    ------
    NamingError
        A service or a topic has such a name.
    """
    places = [((node.namespace or "").rstrip("/"), resource_name(label(node))) for node in node_nets(model)]
    added = set[str]()
    for above, node in places:
        own = f"{above}/{node}"
        added |= reserved_services(own, {}, True).keys() - reserved_services(own, {}, False).keys()
        added |= reserved_topics(own, {}, True).keys() - reserved_topics(own, {}, False).keys()
    for channel in model.channels:
        name = getattr(channel, "topic", None) or getattr(channel, "service", None)
        for taken in sorted(added & {full_name(name, *place) for place in places} if name else ()):
            raise NamingError(
                f"{taken} of {channel.id!r} is a name that a lifecycle node has itself",
                element=channel.id,
                hint="rename it, or generate plain nodes",
            )
