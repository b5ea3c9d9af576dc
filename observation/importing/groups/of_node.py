"""The callback groups of a node, with their names in its model.

The callback of a response, a result or feedback holds the group of its client in `rclcpp`: the executor takes
the response and runs the callback at once. In `rclpy` the callbacks of a future are tasks of the executor and
hold no group. A callback page of the kind `client` is in no group if it names none. So the default group of a
node in C++ gets a name if such a callback is in it.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from dineros.observation.importing.assuming import Taken
from dineros.observation.importing.groups.sharing import OF_NODES, free_name
from dineros.sources.facts import Entity, NodeFact, is_open
from dineros.sources.places import Place

DEFAULT = "default_group"
"""Name of the default group of a node in C++ whose clients begin callbacks in it."""
OUTSIDE = "outside_of_callbacks"
"""Name of the group for actions of a node outside of callbacks."""


class GroupsOfNode:
    """Names the callback groups of a node when they are needed.

    Parameters
    ----------
    taken : Taken
        Gets the assumptions.
    at : callable
        Returns a line of code, with its folder.
    """

    def __init__(self, fact: NodeFact, taken: Taken, at: Callable[[Place], str]) -> None:
        self._taken, self._at, self._fact = taken, at, fact
        self._names: dict[Entity, str] = {}
        self._outside: list[str] = []
        self.answers_hold = not fact.at.file.endswith(".py")
        """Whether callbacks of responses, results and feedback hold the group of their client."""
        clients = [*fact.of("clients"), *fact.of("action_clients")]
        is_needed = any(fact.group_of(each) is None for each in clients)
        self._default = DEFAULT if self.answers_hold and is_needed else ""

    def of(self, entity: Entity) -> str | None:
        """Return the group of a callback or a client; None: the default group, which has no name."""
        group = self._fact.group_of(entity)
        if group is None:
            if self.is_open(entity):  # in another group, other callbacks wait, or run at the same time
                said = entity.details["group"]
                self._taken.lack(
                    f"{self._at(entity.at)}: the callback group is {said}; that of the node is assumed"
                )
            return self._default or None
        if group not in self._names:
            wanted = group.port.rpartition(".")[2]
            if group.is_anonymous_group:
                wanted = f"group_{group.at.line}"
            if str(group.details.get("executor", "")).startswith("none"):
                words = f"no executor gets callback group {wanted}; in the model, that of its node runs it"
                self._taken.lack(f"{self._at(group.at)}: {words}")
            if group.details.get("shared"):
                wanted = f"{OF_NODES}{wanted}_{group.at.line}"
            self._names[group] = free_name(re.sub(r"\W+", "_", wanted).strip("_"), self._used())
        return self._names[group]

    def is_open(self, entity: Entity) -> bool:
        """Return whether the code does not say the group of a callback or a client."""
        return entity.group is None and is_open(str(entity.details.get("group", "default")))

    def outside(self) -> str:
        """Return another separate group for actions of the node outside of callbacks."""
        self._outside.append(free_name(OUTSIDE, self._used()))
        return self._outside[-1]

    @property
    def has_outside(self) -> bool:
        """Whether the node has actions outside of callbacks."""
        return bool(self._outside)

    @property
    def kinds(self) -> dict[str, str]:
        """The named groups, with their kinds: ``exclusive`` or ``reentrant``."""
        unnamed = [each for each in (self._default, *self._outside) if each]
        return {
            **{name: self._kind(group) for group, name in self._names.items()},
            **dict.fromkeys(unnamed, "exclusive"),
        }

    def _used(self) -> set[str]:
        return {*self._names.values(), *self._outside, self._default}

    def _kind(self, group: Entity) -> str:
        kind = str(group.details.get("kind", ""))
        if is_open(kind):
            self._taken.lack(
                f"{self._at(group.at)}: the kind of the callback group is {kind}; exclusive is assumed"
            )
        return "reentrant" if kind.startswith("reentrant") else "exclusive"
