"""Determines the routines that may use ROS, by the words in them and in the routines that they may call."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

from dineros.sources.cpp.entries import Routine
from dineros.sources.cpp.index import Index

if TYPE_CHECKING:
    from tree_sitter import Node

_ROS = re.compile(
    r"publish|Publish|subscri|advertise|sleep|spin|wait|lock_guard|_lock$|async|thread|notify|rclcpp|tf2|nav2|timer|"
    r"future|promise|Callback|_callback|executor",
)
_EXACT = {
    *("create_publisher", "create_subscription", "create_generic_publisher", "create_service"),
    *("create_generic_subscription", "create_client", "create_server", "create_callback_group"),
    *("declare_parameter", "get_parameter", "get_parameter_or", "get_parameters", "has_parameter"),
    *("declare_or_get_parameter", "declare_parameter_if_not_declared", "sendTransform", "shutdown"),
    *("lock", "unlock", "join", "call", "bind", "cin", "getline", "getchar", "scanf", "message_filters"),
    *("image_transport", "diagnostic_updater", "on_activate", "on_deactivate", "succeed", "canceled"),
}
"""Words of code that makes ports or uses them, waits, or keeps callbacks."""
_MAKES = ("create_", "declare_")
"""Beginnings of names of methods that make ports."""
_WORD = re.compile(rb"[A-Za-z_]\w*")


class Reach:
    """The words that the routines of a folder may reach; names are over-approximated, so that none is missed.

    Parameters
    ----------
    index : Index
        What the folder defines.
    idioms : iterable of str
        Names of the classes and functions of the table of libraries.
    """

    def __init__(self, index: Index, idioms: Iterable[str] = ()) -> None:
        self._exact = _EXACT | {path.rpartition("::")[2] for path in idioms}
        self._named: dict[str, list[Routine]] = {}
        self._own: dict[int, frozenset[str]] = {}
        self._all: dict[int, frozenset[str]] = {}
        self._ros: set[str] = set()
        self._rclcpp: set[str] = set()
        self._making: set[str] = set()
        self._using: dict[str, list[Routine]] = {}
        self._makes = {path.rpartition("::")[2] for path in idioms} | {"advertise", "subscribe"}
        self._is_collected = False
        self._index = index
        self.was_asked = False
        """Whether there was a query since this was set: answers depend on all files."""

    def words(self, routine: Routine) -> frozenset[str]:
        """Return the words of a routine and of all that it may call."""
        self.was_asked = True
        key = id(routine)
        if key not in self._all:
            self._collect()
            found: set[str] = set()
            todo, seen = [routine], {key}
            while todo:
                each = todo.pop()
                if id(each) in self._all:
                    found |= self._all[id(each)]
                    continue
                inner = self._words(each) - found
                found |= inner
                for one in (one for word in inner for one in self._named.get(word, ())):
                    if id(one) not in seen:
                        seen.add(id(one))
                        todo.append(one)
            self._all[key] = frozenset(found)
        return self._all[key]

    def does_matter(self, routine: Routine) -> bool:
        """Return whether a routine, or a routine that it may call, may use ROS."""
        self.was_asked = True
        self._collect()
        return not self._words(routine).isdisjoint(self._ros)

    def does_code_matter(self, node: Node) -> bool:
        """Return whether code, or a routine that it may call, may use ROS."""
        self.was_asked = True
        self._collect()
        words = {each.decode() for each in _WORD.findall(node.text or b"")}
        return bool(words & (self._exact | {"publish"})) or any(
            self.does_matter(each) for word in sorted(words) for each in self._named.get(word, ())
        )

    def is_named(self, routine: Routine) -> bool:
        """Return whether other code names a routine: it may call it."""
        self.was_asked = True
        self._collect()
        return any(each.name != routine.name for each in self._using.get(routine.name, ()))

    def may_make_ports(self, node: Node) -> bool:
        """Return whether code, or a routine that it may call, may make a port."""
        self.was_asked = True
        self._collect()
        return not self._making.isdisjoint(each.decode() for each in _WORD.findall(node.text or b""))

    def may_make_nodes(self, main: Routine) -> bool:
        """Return whether a program may make a node: all that do name ``rclcpp``, to initialise it."""
        self.was_asked = True
        self._collect()
        return not self._words(main).isdisjoint(self._rclcpp)

    def _words(self, routine: Routine) -> frozenset[str]:
        key = id(routine)
        if key not in self._own:
            text = routine.node.text or b""
            self._own[key] = frozenset(each.decode() for each in _WORD.findall(text))
        return self._own[key]

    def _collect(self) -> None:
        if self._is_collected:
            return
        self._is_collected = True
        classes = (each for found in self._index.classes.values() for each in found)
        methods = (found for cls in classes for found in cls.methods.values())
        using = self._using
        for found in (*self._index.functions.values(), *methods):
            for each in found:
                self._named.setdefault(each.name, []).append(each)
                for word in self._words(each):
                    using.setdefault(word, []).append(each)
        self._ros = _reaching({each for each in using if each in self._exact or _ROS.search(each)}, using)
        makes = {each for each in using if each in self._makes or each.startswith(_MAKES)}
        self._making = _reaching(makes, using) | self._makes
        self._rclcpp = _reaching({each for each in using if each.startswith("rclcpp")}, using)


def _reaching(words: set[str], using: dict[str, list[Routine]]) -> set[str]:
    """Return the words, and the names of all routines that may reach a routine with one of them."""
    todo = list(words)
    while todo:
        for each in using.get(todo.pop(), ()):
            if each.name not in words:
                words.add(each.name)
                todo.append(each.name)
    return words
