"""Fixes of violations by commands, if the modeller has no choice to make.

The text of a constraint describes its fix; this module has those fixes that can be applied by a button.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints import Violation
from dineros.metamodel.editing.commands import Command, Delete, Place, Set, Value
from dineros.metamodel.editing.handles import Handles
from dineros.metamodel.errors import counted


@dataclass(frozen=True)
class Fix:
    """Commands that fix a violation."""

    label: str
    commands: tuple[Command, ...]


def fix_of(violation: Violation, handles: Handles) -> Fix | None:
    """Return the fix of a violation; None: the modeller has to choose."""
    make = _FIXES.get(violation.constraint)
    handle = handles.of(violation.element)
    return None if make is None or handle is None else make(violation.element, handle, handles)


_Make = Callable[[Any, str, Handles], Fix | None]


def _set(feature: str, value: Value, words: str) -> _Make:
    """Set a feature to a value; None means its default, or no object."""
    return lambda _, handle, __: Fix(words, (Set(handle, feature, value),))


def _delete(_: EObject, handle: str, __: Handles) -> Fix:
    return Fix("delete it", (Delete((handle,)),))


def _turn_around(arc: pn.Arc, handle: str, handles: Handles) -> Fix | None:
    """Turn an arc, so that it leads from the place to the transition."""
    source, target = handles.of(arc.source), handles.of(arc.target)
    if source is None or target is None:
        return None
    return Fix("turn it around", (Set(handle, "source", target), Set(handle, "target", source)))


def _one_arc(arc: pn.Arc, handle: str, handles: Handles) -> Fix | None:
    """Add the weights of two normal arcs; of other arcs, keep the heavier one."""
    others = [
        each
        for each in (arc.page.arcs if arc.page is not None else ())
        if (each.source, each.target, each.kind) == (arc.source, arc.target, arc.kind) and each is not arc
    ]
    first = handles.of(others[0]) if others else None
    if first is None:
        return None
    is_normal = arc.kind == pn.ArcKind.normal
    weight = arc.weight + others[0].weight if is_normal else max(arc.weight, others[0].weight)
    return Fix(f"one arc of the weight {weight}", (Set(first, "weight", weight), Delete((handle,))))


def _to_page_of_ends(arc: pn.Arc, handle: str, handles: Handles) -> Fix | None:
    page = arc.source.page
    owner = None if page is None else handles.of(page)
    return None if owner is None else Fix("move it there", (Place(handle, owner, "arcs"),))


def _more_capacity(place: sym.Place, handle: str, _: Handles) -> Fix:
    return Fix(f"a capacity of {place.tokens}", (Set(handle, "capacity", place.tokens),))


def _more_in_hand(port: sym.SubscriberPort, handle: str, _: Handles) -> Fix:
    return Fix(f"{port.place.tokens} in hand", (Set(handle, "inHand", port.place.tokens),))


def _more_tokens(place: sym.Place, handle: str, _: Handles) -> Fix:
    count = len(place.balloons)
    return Fix(counted(count, "token"), (Set(handle, "tokens", count),))


def _later(lifecycle: sym.Lifecycle, handle: str, _: Handles) -> Fix:
    step = lifecycle.configureStep + 1
    return Fix(f"activate it in step {step}", (Set(handle, "activateStep", step),))


_FIXES: dict[str, _Make] = {
    "arc-weight": _set("weight", 1, "a weight of 1"),
    "arc-not-doubled": _one_arc,
    "arc-on-page-of-its-ends": _to_page_of_ends,
    "read-or-inhibitor-arc-from-place": _turn_around,
    "tokens-not-negative": _set("tokens", 0, "0 tokens"),
    "capacity-positive": _set("capacity", None, "no capacity"),
    "capacity-holds-tokens": _more_capacity,
    "balloons-are-tokens": _more_tokens,
    "threads-positive": _set("threads", 1, "1 thread"),
    "threads-need-multi": _set("executor", "multi", "the executor multi"),
    "timer-used": _set("timer", None, "no timer"),
    "callback-group-has-effect": _set("group", None, "no group"),
    "client-group-has-effect": _set("group", None, "no group"),
    "goal-client-group-has-effect": _set("group", None, "no group"),
    "timed-transition-has-interval": _set("kind", "discrete", "the kind discrete"),
    "configured-before-active": _later,
    "port-limit": _set("limit", None, "the limit by default"),
    "dispatcher-limit": _set("limit", None, "the limit by default"),
    "dispatcher-subscribes": _delete,
    "dispatcher-once": _delete,
    "in-hand-positive": _set("inHand", None, "any number in hand"),
    "in-hand-or-capacity": _set("inHand", None, "the capacity alone"),
    "in-hand-holds-tokens": _more_in_hand,
    "service-instances": _set("instances", None, "one for each client"),
    "request-depth-positive": _set("depth", None, "the depth by default"),
    "outstanding-positive": _set("outstanding", None, "as many requests under way as by default"),
    "outstanding-goals-positive": _set("outstanding", None, "as many goals under way as by default"),
    "timeout-positive": _set("timeout", None, "no time-out"),
    "timed-out-has-timeout": _set("timedOut", None, "no place for time-outs"),
    "action-slots": _set("instances", None, "one for each client"),
    "feedback-depth-positive": _set("depth", None, "the depth by default"),
    "mapped-once": _delete,
    "signal-used": _delete,
}
"""By the name of the constraint."""
