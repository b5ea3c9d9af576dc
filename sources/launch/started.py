"""What a launch file starts: nodes, and other launch files."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from dineros.sources.places import Place


@dataclass(eq=False)
class Started:
    """A node that a launch file starts, or another file that it includes."""

    at: Place
    """Where."""
    package: str = ""
    executable: str = ""
    plugin: str = ""
    """`package`, `executable`, `plugin`: the started program; a plugin is a component."""
    name: str = ""
    namespace: str = ""
    """`name`, `namespace`: as given; empty: that of the code."""
    remappings: dict[str, str] = field(default_factory=dict)
    """From names in the code to others."""
    parameters: list[Any] = field(default_factory=list)
    """Dicts of values, and paths of files, in order."""
    when: str = ""
    """Under which conditions."""
    is_enabled: bool = True
    """Whether they hold with the values of the arguments."""
    kind: str = "node"
    """``node``, ``lifecycle``, ``container``, ``component`` or ``include``."""
    container: str = ""
    """Of a component: the name of its container."""
    within: Started | None = None
    """Of a component: its container, if the launch file loads it by this object and not by its name."""
    has_threads: bool = False
    """Of a container whose components have executors of their own: whether these have several threads."""
    arguments: list[str] = field(default_factory=list)
    """Of the command line, without those of ROS."""
    included: str = ""
    file: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return it in the schema of the facts."""
        found: dict[str, Any] = {"at": str(self.at)}
        for key in ("package", "executable", "plugin", "container", "when"):
            if getattr(self, key):
                found[key] = getattr(self, key)
        if self.kind == "include":
            found["include"] = self.included
        if self.name:
            found["name"] = full(self.name, self.namespace)
        if self.namespace:
            found["namespace"] = self.namespace
        if self.remappings:
            found["remappings"] = self.remappings
        if self.parameters:
            found["parameters"] = self.parameters
        if self.kind not in ("node", "include"):
            found["kind"] = self.kind
        if not self.is_enabled:
            found["enabled"] = False
        return found


def full(name: str, namespace: str) -> str:
    """Return a name in a namespace.

    Examples
    --------
    >>> full("arm", "left"), full("/arm", "left"), full("arm", "")
    ('/left/arm', '/arm', '/arm')
    """
    return name if name.startswith("/") else "/".join(["", *filter(None, namespace.split("/")), name])
