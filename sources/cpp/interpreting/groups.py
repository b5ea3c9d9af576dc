"""Interprets callback groups that are left out of the executor of their node."""

from __future__ import annotations

import re
from collections.abc import Iterable

from dineros.sources.cpp.parsing import Source
from dineros.sources.cpp.values import Const, Made, Port, Value, options, shown
from dineros.sources.facts import Entity, NodeFact

ALONE = "none"
"""The executor of a group that does not go with its node, and that no executor gets."""
PERHAPS_ALONE = "none that is known"
"""The same, where other code may give it to an executor."""
OTHER = "another one"
"""An executor of its own that is not read."""
_KINDS = {"Reentrant": "reentrant", "MutuallyExclusive": "exclusive"}
_GETS = re.compile(rb"\badd_callback_group\b")
"""Code that gives a group to an executor."""
_GETS_ALL = re.compile(rb"\b(for_each_callback_group|get_callback_groups)\b")
"""Code that may give every group of a node to an executor."""


def read_group(entity: Entity, args: list[Value]) -> None:
    """Record the kind of a group, and whether it goes with its node."""
    path = args[0].path if args and isinstance(args[0], Made) else shown(args[0] if args else None)
    entity.details["kind"] = _KINDS.get(path.rpartition("::")[2], f"open: {path}")
    if len(args) > 1 and isinstance(args[1], Const) and args[1].value is False:
        entity.details.setdefault("executor", ALONE)


def take_group(value: Value | None, nodes: Iterable[NodeFact]) -> None:
    """Record that an executor gets a group; if it is not known, it may be each of some nodes."""
    found = [each.entity for each in options(value) if isinstance(each, Port)]
    if len(found) != 1 or len(options(value)) != 1:
        found += [each for node in nodes for each in node.of("groups")]
    for each in found:
        if each.details.get("executor") == ALONE:
            each.details["executor"] = OTHER


def doubt_groups(nodes: Iterable[NodeFact], sources: Iterable[Source]) -> None:
    """Say that a group may have an executor if code may give it to one, or a library has the node."""
    texts = [each.text for each in sources]
    may_get = any(_GETS.search(each) for each in texts)
    gets_all = any(_GETS_ALL.search(each) for each in texts)
    for node in nodes:
        for group in node.of("groups"):
            if group.details.get("executor") == ALONE and gets_all:
                group.details["executor"] = OTHER
            elif group.details.get("executor") == ALONE and (may_get or node.is_lent or node.lent_to):
                group.details["executor"] = PERHAPS_ALONE
