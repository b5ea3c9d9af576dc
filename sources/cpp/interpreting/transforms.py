"""Interprets lookups of transforms in a buffer of tf2, which may wait."""

from __future__ import annotations

from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.values import Const, Made, Open, Seconds, Value, constant
from dineros.sources.cpp.waiting import is_repeated_until_true
from dineros.sources.facts import TRANSFORM

BUFFER = "tf2_ros::Buffer"
_MOST_WITHOUT = {"lookupTransform": (3, 5), "canTransform": (3, 5), "transform": (2, 3)}
"""By method: how many arguments come before the time-out."""


def look_up(machine: Statements, call: Call, buffer: Made) -> Value | None:
    """Record that a lookup waits; None: it does not.

    A buffer waits only if it knows that another thread fills it: a listener with a thread of its own says so,
    or the program (``setUsingDedicatedThread``). Without one, a lookup fails at once.
    """
    if call.last == "setUsingDedicatedThread":
        machine.set_member(buffer, "fills", call.args[0] if call.args else Open("?"))
        return Const(None)
    if call.last not in _MOST_WITHOUT:
        return None
    limits = [call.args[at] for at in _MOST_WITHOUT[call.last] if at < len(call.args)]
    given = [each for each in limits if isinstance(each, Seconds) and each.value > 0]
    if given and constant(buffer.fields.get("fills")) is True:
        words = f"time-out {given[-1].value:g} s"
        machine.does("wait", TRANSFORM, call.node, call.frame, words, timeout=given[-1].value)
    elif call.last == "canTransform" and not given and is_repeated_until_true(call.node):
        words = "polled, without time-out"
        machine.does("wait", TRANSFORM, call.node, call.frame, words).is_repeated = True
    return None
