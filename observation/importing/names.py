"""Ids of imported elements, and names of ROS that models can have."""

from __future__ import annotations

import re

from dineros.observation.systems import MOST_CHARACTERS

_TYPE = {
    kind: re.compile(rf"[a-z][a-z0-9_]*/{kind}/[A-Z][A-Za-z0-9]*", re.ASCII)
    for kind in ("msg", "srv", "action")
}
_NOT_IN_IDS = re.compile(r"[^\w.-]")


def is_type(name: str, kind: str) -> bool:
    """Return whether a text names an interface of a kind: ``msg``, ``srv`` or ``action``.

    Examples
    --------
    >>> is_type("std_msgs/msg/String", "msg"), is_type("std_msgs/msg/String", "srv")
    (True, False)
    """
    return len(name) <= MOST_CHARACTERS and _TYPE[kind].fullmatch(name) is not None


def flat(name: str) -> str:
    """Return a full name, or the value of a variable, as a part of an id.

    Examples
    --------
    >>> flat("/arm/joint_states")
    'arm_joint_states'
    >>> flat("'at home'")
    'at_home'
    >>> flat("-1")
    '-1'
    """
    return _NOT_IN_IDS.sub("_", name.strip("/'\"")) or "_"


def split(name: str) -> tuple[str, str]:
    """Return the namespace of a full name, empty for the root, and the last part.

    Examples
    --------
    >>> split("/left/arm"), split("/arm")
    (('/left', 'arm'), ('', 'arm'))
    """
    namespace, _, last = name.rpartition("/")
    return namespace, last


class Ids:
    """Creates distinct ids; the same sequence of requests gets the same ids."""

    def __init__(self) -> None:
        self._used: set[str] = set()

    def new(self, wanted: str) -> str:
        """Return an id: the wanted one, or with a number appended.

        Examples
        --------
        >>> ids = Ids()
        >>> ids.new("scan"), ids.new("scan")
        ('scan', 'scan_2')
        """
        found, number = wanted, 1
        while found in self._used:
            number += 1
            found = f"{wanted}_{number}"
        self._used.add(found)
        return found
