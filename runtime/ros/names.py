"""Names of a node's own ROS resources, mended where ROS does not accept those of the model."""

from __future__ import annotations

import re
from collections.abc import Iterable

from dineros.metamodel.ros_names import snake_case

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def resource_name(name: str) -> str:
    """Return a name as a part of a topic, service or parameter, or as a node has it.

    Examples
    --------
    >>> resource_name("TooHot"), resource_name("left-arm.idle"), resource_name("2nd arm")
    ('TooHot', 'left_arm_idle', 'x2nd_arm')
    """
    is_fit = _NAME.fullmatch(name) and "__" not in name and not name.endswith("_")
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
