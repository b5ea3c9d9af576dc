"""Interprets callback groups that are left out of the executor of their node."""

from __future__ import annotations

import re
from collections.abc import Iterable

from dineros.sources.cpp.parsing import Source
from dineros.sources.cpp.values import Const, Items, Made, Obj, Port, Value, options, shown
from dineros.sources.facts import ALONE, NO_SPIN, PERHAPS_ALONE, UNSPUN, Entity, NodeFact

ADDED = "one that gets it: "
"""Begins the executor of a node that an executor gets which is not known to spin."""
LATE = "after another spin: "
"""Begins the executor of a node that spins only after another spin of the main function."""
OTHER = "another one"
"""An executor of its own that is not read."""
_NAME = re.compile(r"(?:this->)?\w+")
_PLAIN = (
    rb"\bNAME\s*(?:\.|->)\s*(?:add_node|add_callback_group|remove_node|remove_callback_group|cancel|reset)\b"
    rb"|Executor(?:::(?:SharedPtr|UniquePtr))?>?[\s&*]+(?:\w+\s*,\s*)*NAME\b|\bNAME\s*=\s*[^;]*Executor"
)
"""Uses of an executor in which it does not spin."""
_KINDS = {"Reentrant": "reentrant", "MutuallyExclusive": "exclusive"}
_ENDS = re.compile(rb"\b(?:cancel|thread|async|signal|sigaction)\s*[({]|std::j?thread|NodeThread")
"""Code that may end a spin, or that runs at the same time."""
_STOPS = re.compile(rb"\bshutdown\s*\(")
_GETS = re.compile(rb"\badd_callback_group\b")
"""Code that gives a group to an executor."""
_GETS_ALL = re.compile(rb"\b(for_each_callback_group|get_callback_groups)\b")
"""Code that may give every group of a node to an executor."""
_WAITS = re.compile(rb"WaitSet|wait_?set", re.IGNORECASE)
"""Code that takes what arrives from a wait set, without any executor."""


def read_group(entity: Entity, args: list[Value]) -> None:
    """Record the kind of a group, and whether it goes with its node."""
    path = args[0].path if args and isinstance(args[0], Made) else shown(args[0] if args else None)
    entity.details["kind"] = _KINDS.get(path.rpartition("::")[2], f"open: {path}")
    if len(args) > 1 and isinstance(args[1], Const) and args[1].value is False:
        entity.details.setdefault("executor", ALONE)


def take_group(value: Value | None, nodes: Iterable[NodeFact], executor: str) -> None:
    """Record that an executor gets a group; if it is not known, it may be each of some nodes.

    Parameters
    ----------
    value : Value or None
        The group.
    nodes : iterable of NodeFact
        The nodes of the program.
    executor : str
        The expression for the executor in the code.
    """
    found = [each.entity for each in options(value) if isinstance(each, Port)]
    is_certain = len(found) == 1 and len(options(value)) == 1 and _NAME.fullmatch(executor) is not None
    if not is_certain:
        found += [each for node in nodes for each in node.of("groups")]
    for each in found:
        if is_certain and each.details.get("executor") == ALONE:
            each.details |= {"executor": UNSPUN, "executor_name": executor.removeprefix("this->")}
        elif each.details.get("executor") in (ALONE, UNSPUN):
            each.details["executor"] = OTHER


def join(nodes: Iterable[Obj], executor: str) -> None:
    """Record that an executor gets nodes."""
    for each in nodes:
        if each.node is not None and not each.node.executor and _NAME.fullmatch(executor) is not None:
            each.node.executor = ADDED + executor.removeprefix("this->")


def runs_in_turn(held: Items) -> None:
    """Record that an executor runs the groups that it has, now and then."""
    for each in held.values:
        if isinstance(each, Port) and each.entity.details.get("executor") == UNSPUN:
            each.entity.details["executor"] = OTHER


def _is_only_filled(name: bytes, texts: Iterable[bytes]) -> bool:
    """Return whether code does nothing with an executor but create it, give it nodes, and cancel it."""
    plain = re.compile(_PLAIN.replace(b"NAME", re.escape(name)))
    return all(
        len(re.findall(rb"\b" + re.escape(name) + rb"\b", each)) == len(plain.findall(each)) for each in texts
    )


def doubt_groups(nodes: Iterable[NodeFact], sources: Iterable[Source]) -> None:
    """Say that a group may have an executor if code may give it to one, or a library has the node."""
    sources = list(sources)
    texts = [each.text for each in sources]
    waiting = {each.path for each in sources if _WAITS.search(each.text)}
    may_get = any(_GETS.search(each) for each in texts)
    gets_all = any(_GETS_ALL.search(each) for each in texts)
    stops = sum(len(_STOPS.findall(each)) for each in texts)
    ends = stops > 1 or any(_ENDS.search(each) for each in texts)
    for node in nodes:
        if node.executor.startswith(LATE):
            node.executor = node.executor.removeprefix(LATE) if ends else UNSPUN
            node.threads = node.threads if ends else "not spun"
        if node.executor.startswith(ADDED):
            name = node.executor.removeprefix(ADDED).encode()
            is_known = not (node.is_lent or node.lent_to) and _is_only_filled(name, texts)
            node.executor = UNSPUN if is_known else NO_SPIN
            node.threads = "not spun" if is_known else "open"
        for group in node.of("groups"):
            name = group.details.pop("executor_name", "").encode()
            if group.details.get("executor") == UNSPUN:
                if gets_all or node.is_lent or not _is_only_filled(name, texts):
                    group.details["executor"] = OTHER
            elif group.details.get("executor") == ALONE and (gets_all or group.at.file in waiting):
                group.details["executor"] = OTHER
            elif group.details.get("executor") == ALONE and (may_get or node.is_lent or node.lent_to):
                group.details["executor"] = PERHAPS_ALONE
