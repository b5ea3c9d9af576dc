"""Names of model elements in ROS 2: packages, interface types and fields (ROS 2, "Interfaces").

The generators write these names and the run-time reads them, so both ask here.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

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
