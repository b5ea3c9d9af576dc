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
    if not isinstance(given, Made) or not given.path.endswith("Duration"):
        return given
    parts = [given.keys.get("seconds"), given.keys.get("nanoseconds")]
    values = [0 if each is None else constant(each) for each in parts]
    if not all(isinstance(each, (int, float)) for each in values):
        return given
    return float(values[0] + values[1] * _NANOSECONDS) or None
