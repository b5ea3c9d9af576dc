"""Finds what a whole program shares: locks and signals of global and static variables."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.sources.cpp.following.machine import Machine
from dineros.sources.cpp.values import Frame, Made, Obj, Value

if TYPE_CHECKING:
    from tree_sitter import Node

MUTEXES = ("mutex", "shared_mutex", "timed_mutex")
SIGNALS = ("condition_variable", "condition_variable_any", "semaphore", "latch", "barrier", "promise")
"""A signal on which one callback waits, and that another one sets."""


def is_kept(value: Value | None) -> bool:
    """Return whether a static variable keeps a value, as a later run must find the same object."""
    if isinstance(value, Obj):
        return value.node is None
    return isinstance(value, Made) and value.path.endswith((*MUTEXES, *SIGNALS))


def global_lock(name: str, frame: Frame, machine: Machine) -> Value | None:
    """Return the lock or signal that a global variable or a static member is; None: it is something else."""
    full = machine.find_global(name, frame)
    if full is None:
        return None
    if full not in machine.statics:
        for each in machine.index.variables[full.rpartition("::")[2]]:
            kind = _declared(each.node) if each.full == full else None
            path = machine.type_text(kind, Frame(each.path, full.rpartition("::")[0])) if kind else ""
            if path.endswith((*MUTEXES, *SIGNALS)):
                machine.statics[full] = Made(path, node=kind)
                break
    return machine.statics.get(full)


def _declared(declarator: Node) -> Node | None:
    """Return the type of a variable; None: it is a pointer or a reference."""
    inner = declarator.child_by_field_name("declarator")
    if declarator.type != "init_declarator" or inner is None:
        inner = declarator
    if inner.type.startswith(("pointer", "reference")) or declarator.parent is None:
        return None
    return declarator.parent.child_by_field_name("type")
