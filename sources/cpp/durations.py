"""Durations in C++: units, and the constructors of ``std::chrono`` and ``rclcpp``."""

from __future__ import annotations

import re

from dineros.sources.cpp.values import Const, Either, Open, Seconds, Value, one_of
from dineros.sources.facts import FOREVER

UNITS = {
    **{"hours": 3600.0, "minutes": 60.0, "seconds": 1.0, "milliseconds": 1e-3, "microseconds": 1e-6},
    **{"nanoseconds": 1e-9, "h": 3600.0, "min": 60.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    **{"milli": 1e-3, "micro": 1e-6, "nano": 1e-9},
}
"""Seconds of units of durations."""


def duration(path: str, template: str, args: list[Value]) -> Value | None:
    """Return the duration that a constructor creates; None: it creates something else."""
    last = path.rpartition("::")[2]
    if not args:
        is_longest = last == "max" and ("chrono::" in path or path.endswith("Duration::max"))
        return Seconds(FOREVER) if is_longest else None
    value = args[0]
    if last in ("duration_cast", "to_chrono") or (isinstance(value, Seconds) and last in UNITS):
        return value
    if last in UNITS and "chrono" in path:
        return _times(value, UNITS[last])
    if last == "duration" and "chrono" in path:
        found = [UNITS[each] for each in re.findall(r"\w+", template) if each in UNITS]
        return value if isinstance(value, Seconds) else _times(value, found[0] if found else 1.0)
    if path in ("rclcpp::Duration::from_seconds", "Duration::from_seconds", "tf2::durationFromSec"):
        return _times(value, 1.0)
    if path == "rclcpp::Duration::from_nanoseconds":
        return _times(value, 1e-9)
    if path == "rclcpp::Duration":
        if isinstance(value, Seconds):
            return value
        rest = args[1].value if len(args) > 1 and isinstance(args[1], Const) else 0
        found_seconds = _times(value, 1.0 if len(args) > 1 else 1e-9)
        if isinstance(found_seconds, Seconds) and isinstance(rest, (int, float)):
            return Seconds(found_seconds.value + rest * 1e-9)
        return found_seconds
    return None


def _times(value: Value, unit: float) -> Value:
    if isinstance(value, Either):
        return one_of([_times(each, unit) for each in value.options])
    if isinstance(value, Const) and isinstance(value.value, (int, float)):
        return Seconds(float(value.value) * unit)
    return value if isinstance(value, Open) else Open("a duration")
