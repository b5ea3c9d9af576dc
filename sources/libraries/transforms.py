"""Waits for transforms: methods of a buffer of tf2 in Python, with a time-out.

The buffer asks itself until the transform is there; a subscription of the listener stores transforms.
"""

from __future__ import annotations

from dineros.sources.language.values import Made, Value, constant

BUFFERS = ("tf2_ros.Buffer", "tf2_ros.buffer.Buffer", "tf2_ros.BufferInterface")
_TIMEOUT = {
    "lookup_transform": 3,
    "lookup_transform_full": 5,
    "can_transform": 3,
    "can_transform_full": 5,
    "transform": 2,
}
"""Position of the time-out, by method."""
_NANOSECONDS = 1e-9


def timeout_of(method: str, call: Made) -> Value | float | None:
    """Return the time-out of a lookup: seconds, an unknown value, or None if it does not wait.

    Parameters
    ----------
    method : str
        Name of the method.
    call : Made
        Its arguments.
    """
    if method not in _TIMEOUT:
        return None
    given = call.argument(_TIMEOUT[method], "timeout")
    known = of_duration(given)
    return given if known is None else known or None


def of_duration(value: Value | None) -> float | None:
    """Return the seconds of a duration of rclpy; None: unknown."""
    if not isinstance(value, Made) or not value.path.endswith("Duration"):
        return None
    parts = [value.keys.get("seconds"), value.keys.get("nanoseconds")]
    values = [0 if each is None else constant(each) for each in parts]
    if not all(isinstance(each, (int, float)) for each in values):
        return None
    return float(values[0] + values[1] * _NANOSECONDS)
