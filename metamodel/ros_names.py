"""Names of model elements in ROS 2: packages, interface types and fields (ROS 2, "Interfaces").

The generators write these names and the run-time reads them, so both ask here.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence

SET_SIGNAL, SIGNALS, SIGNALS_WANTED, STATE = "set_signal", "signals", "signals_wanted", "state"
"""A service and topics of each node, under its own name: what sets its signals, and how it is."""

CONTROLS = ("proceed", "release", "describe")
"""Services of each node, under its own name."""

COMPANIONS = ("_messages", "_requests")
"""Last part of the topics that carry the ids of messages, and of requests, of existing types."""

_TEXT = "std_msgs/msg/String"
_OF_ALL_NODES = {
    "/rosout": "rcl_interfaces/msg/Log",
    "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/clock": "rosgraph_msgs/msg/Clock",
}
_PARAMETERS = (
    *("describe_parameters", "get_parameter_types", "get_parameters", "list_parameters"),
    *("set_parameters", "set_parameters_atomically", "get_type_description"),
)
_LIFECYCLE = (
    *("change_state", "get_state", "get_available_states"),
    *("get_available_transitions", "get_transition_graph"),
)
_HIDDEN = ("_action", "_service_event", *COMPANIONS)

_RESOURCE = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z0-9]+|[0-9]+")


def _words(name: str) -> list[str]:
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    return _WORD.findall(plain)


def snake_case(name: str) -> str:
    """Return a name as ROS packages, nodes and fields have it: small letters, digits and single underscores.

    Examples
    --------
    >>> snake_case("pickSuccess"), snake_case("HTTPServer 2"), snake_case("2nd-arm")
    ('pick_success', 'http_server_2', 'x2nd_arm')
    """
    joined = "_".join(word.lower() for word in _words(name))
    return joined if joined[:1].isalpha() else f"x{joined}"


def camel_case(name: str) -> str:
    """Return a name as ROS interface types have it: a capital at the start of each word, no underscores.

    Examples
    --------
    >>> camel_case("sorting_token"), camel_case("GetControl"), camel_case("2nd arm")
    ('SortingToken', 'GetControl', 'X2ndArm')
    """
    joined = "".join(word[:1].upper() + word[1:] for word in _words(name))
    return joined if joined[:1].isalpha() else f"X{joined}"


def interfaces_package(model: str) -> str:
    """Return the name of the package that holds a model's messages and services, by the id of the model.

    Examples
    --------
    >>> interfaces_package("sorting")
    'sorting_interfaces'
    """
    return f"{snake_case(model)}_interfaces"


def resource_name(name: str) -> str:
    """Return a name as a part of a topic, service or parameter, or as a node has it.

    Examples
    --------
    >>> resource_name("TooHot"), resource_name("left-arm.idle"), resource_name("2nd arm")
    ('TooHot', 'left_arm_idle', 'x2nd_arm')
    """
    is_fit = _RESOURCE.fullmatch(name) and "__" not in name and not name.endswith("_")
    return name if is_fit else snake_case(name)


def resource_names(names: Iterable[str]) -> dict[str, str]:
    """Return a resource name for each name, all different.

    Examples
    --------
    >>> resource_names(["a-b", "a_b"])
    {'a-b': 'a_b_2', 'a_b': 'a_b'}
    """
    known = list(dict.fromkeys(names))
    found = {name: name for name in known if resource_name(name) == name}
    used = set(found)
    for name in known:
        if name not in found:
            stem = fresh = resource_name(name)
            number = 1
            while fresh in used:
                number += 1
                fresh = f"{stem}_{number}"
            used.add(fresh)
            found[name] = fresh
    return {name: found[name] for name in known}


def full_name(name: str, namespace: str, node: str) -> str | None:
    """Return the full name of a topic, service or action as a node resolves it; None with substitutions.

    Examples
    --------
    >>> full_name("scan", "/left", "eye"), full_name("~/state", "", "eye"), full_name("/map", "/left", "eye")
    ('/left/scan', '/eye/state', '/map')
    """
    above = namespace.rstrip("/")
    if set(name) & set("{}"):
        return None
    if name.startswith("~"):
        return f"{above}/{node}{name[1:]}"
    return name if name.startswith("/") else f"{above}/{name}"


def reserved_services(own: str, signals: Mapping[str, Sequence[str]], is_managed: bool) -> dict[str, str]:
    """Return the services that a node of this full name has besides those of its model, and what they do.

    Parameters
    ----------
    own : str
        Full name of the node, such as ``/left/eye``.
    signals : mapping of str to sequence of str
        Ids of its signals, with the names of their values.
    is_managed : bool
        Whether it is a lifecycle node.
    """
    found = {f"{own}/{name}": "controls the node" for name in CONTROLS}
    names = resource_names(signals)
    booleans = [names[id] for id, values in signals.items() if not values]
    found |= {f"{own}/{SET_SIGNAL}/{name}": "sets a signal" for name in booleans}
    found |= {f"{own}/{name}": "is the parameter interface of ROS" for name in _PARAMETERS}
    if is_managed:
        found |= {f"{own}/{name}": "manages the node's lifecycle" for name in _LIFECYCLE}
    return found


def reserved_topics(
    own: str, signals: Mapping[str, Sequence[str]], is_managed: bool
) -> dict[str, tuple[str, bool]]:
    """Return the topics that a node of this full name has besides those of its model.

    The parameters are those of `reserved_services`.

    Returns
    -------
    dict of str to (str, bool)
        Full name -> its type, and whether only the node itself may publish on it.
    """
    found = {name: (type, False) for name, type in _OF_ALL_NODES.items()}
    found[f"{own}/{STATE}"] = (_TEXT, True)
    names = resource_names(signals)
    if names:
        found |= {f"{own}/{SIGNALS}": (_TEXT, False), f"{own}/{SIGNALS_WANTED}": (_TEXT, True)}
        found |= {
            f"{own}/{SIGNALS}/{names[id]}": (signal_type(values), False) for id, values in signals.items()
        }
    if is_managed:
        found[f"{own}/transition_event"] = ("lifecycle_msgs/msg/TransitionEvent", True)
    return found


def signal_type(values: Sequence[str]) -> str:
    """Return the type of the topic that sets a signal with these values; none: it is true or false."""
    return _TEXT if values else "std_msgs/msg/Bool"


def hidden_part(name: str) -> str | None:
    """Return the part of a name that ROS 2 or a node uses for topics and services behind others, if any.

    Examples
    --------
    >>> hidden_part("/power/_requests"), hidden_part("/power/requests")
    ('_requests', None)
    """
    return next((part for part in name.split("/") if part in _HIDDEN), None)
