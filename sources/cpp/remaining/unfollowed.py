"""Finds functions that code names but that were not followed: what they do is missing in the facts."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from dineros.sources.cpp.entries import Routine
from dineros.sources.cpp.parsing import line_of, text_of

if TYPE_CHECKING:
    from tree_sitter import Node

    from dineros.sources.cpp.following.routines import Routines

_ACTS = re.compile(
    rb"\b(?:publish|async_send_request|async_send_goal|spin\w*|sleep_for|sleep_until|wait|wait_for|"
    rb"wait_until|arrive_and_wait|acquire|notify_one|notify_all|set_value|"
    rb"lock_guard|unique_lock|scoped_lock|send_response|create_\w+)\b"
)
"""Words of code that does something that a model represents."""
_WORD = re.compile(rb"[A-Za-z_]\w*")
_CALLED = re.compile(rb"(?<![\w:])(?:\w+::)*(?=\w)([A-Za-z_]\w*)\s*\(|&\s*(?:\w+::)*([A-Za-z_]\w*)")
"""A function that code calls, or of which it takes the address."""
_MOST_DEEP = 12
"""Limit of the calls from a function to one that acts."""


def unfollowed(machine: Routines) -> Iterator[str]:
    """Yield a line for each function that followed code names or defines, that acts, and was not followed.

    Methods count if an object of their class was made; lambdas, if the code around them was followed.
    """
    known = _Known(machine)
    for routine in known.routines():
        if routine.node.id in machine.followed or routine.body is None or known.is_replaced(routine):
            continue
        if known.is_named(routine) and known.acts(routine.node):
            yield f"{routine.path}:{routine.line}: {routine.name} {_WORDS}"
    for path, _, node in known.lambdas():
        if node.id not in machine.followed and known.acts(node):
            yield f"{path}:{line_of(node)}: a lambda {_WORDS}"


_WORDS = "is used in a way that is not followed; what it does is missing"


class _Known:
    """What a program has followed, and what it names."""

    def __init__(self, machine: Routines) -> None:
        self._machine = machine
        index = machine.index
        self._classes = [each for found in index.classes.values() for each in found]
        self._functions = [each for found in index.functions.values() for each in found]
        methods = [each for cls in self._classes for found in cls.methods.values() for each in found]
        self._every = [*self._functions, *methods]
        self._followed = [each for each in self._every if each.node.id in machine.followed]
        self._words: dict[int, frozenset[bytes]] = {}
        self._acting: dict[int, bool] = {}
        self._by_name: dict[bytes, list[Routine]] = {}
        for each in self._every:
            self._by_name.setdefault(each.name.encode(), []).append(each)
        made = {id(each.cls): each.cls for each in machine.made.values() if each.cls is not None}
        self._made = {id(base) for cls in made.values() for base in machine.bases(cls)}
        self._read = [(each.path, each.node) for each in self._followed]
        for cls in (each for each in self._classes if id(each) in self._made):
            self._read += [(cls.path, value) for _, value in cls.fields.values() if value is not None]
        self._used: set[bytes] = set()
        self._use(self._read)
        named = [
            (each.path, each.node)
            for name, found in index.constants.items()
            if name.encode() in self._used
            for each in found
        ]
        self._read += named
        self._use(named)

    def _use(self, read: list[tuple[str, Node]]) -> None:
        """Add the words of code that was followed and of values; lambdas that were not do not count."""
        lost: dict[int, list[Node]] = {}
        for _, around, node in self.lambdas():
            if node.id not in self._machine.followed:
                lost.setdefault(around.id, []).append(node)
        for _, around in read:
            text = around.text or b""
            for node in lost.get(around.id, ()):
                text = text.replace(node.text or b"", b"")
            self._used.update(_WORD.findall(text))

    def routines(self) -> Iterator[Routine]:
        """Yield the functions, and the methods of classes of which objects were made."""
        for each in self._every:
            if (each.cls is None and each.name != "main") or id(each.cls) in self._made:
                yield each

    def lambdas(self) -> Iterator[tuple[str, Node, Node]]:
        """Yield the lambdas in followed functions and in values that are used, with their file and this code.

        Those within lambdas that were not followed are left out.
        """
        for path, around in self._read:
            if b"[" not in (around.text or b""):
                continue
            todo = [around]
            while todo:
                each = todo.pop()
                if each.type == "lambda_expression":
                    yield path, around, each
                    if each.id not in self._machine.followed:
                        continue
                todo += each.named_children

    def is_named(self, routine: Routine) -> bool:
        """Return whether followed code may call a function: by its name, or as an operator."""
        if routine.name.startswith("operator"):
            return routine.cls is not None or self._is_operator_of_made(routine)
        return routine.name.encode() in self._used

    def _is_operator_of_made(self, routine: Routine) -> bool:
        kinds = {text_of(each.type) for each in routine.parameters}
        return any(each.name in kinds for each in self._classes if id(each) in self._made)

    def is_replaced(self, routine: Routine) -> bool:
        """Return whether the program has followed another function of this name in its place."""
        same = self._by_name[routine.name.encode()]
        is_operator, followed = routine.name.startswith("operator"), self._machine.followed
        alike = [each for each in same if not is_operator or each.cls is routine.cls is not None]
        return any(each.node.id in followed for each in alike)

    def acts(self, node: Node, depth: int = 0) -> bool:
        """Return whether code, or a function that it names, does something that a model represents."""
        if node.id not in self._acting:
            self._acting[node.id] = False
            self._acting[node.id] = _ACTS.search(_code(node)) is not None or (
                depth < _MOST_DEEP
                and any(
                    self.acts(each.node, depth + 1)
                    for word in self._words_of(node)
                    for each in self._by_name.get(word, ())
                    if each.body is not None
                )
            )
        return self._acting[node.id]

    def _words_of(self, node: Node) -> frozenset[bytes]:
        if node.id not in self._words:
            found = _CALLED.findall(_code(node))
            self._words[node.id] = frozenset(one or other for one, other in found)
        return self._words[node.id]


def _code(node: Node) -> bytes:
    body = node.child_by_field_name("body")
    return (body.text if body is not None else node.text) or b""
