"""Reads quality of service from a number, a profile or a preset of rclpy."""

from __future__ import annotations

from typing import Any, Protocol

from dineros.sources.facts import FOREVER, is_open
from dineros.sources.language.values import (
    Const,
    Either,
    Made,
    Object,
    Open,
    Outside,
    Value,
    constant,
    is_none,
    options,
    text_of,
)
from dineros.sources.libraries.transforms import of_duration

Profile = dict[str, Any]
"""``depth``, ``reliability``, ``durability``, ``history``; each may be open.

``deadline``, ``liveliness`` and ``lease_duration`` are absent where they have their usual values.
"""

USUAL: Profile = {"depth": 10, "reliability": "reliable", "durability": "volatile"}
"""The quality of service of an integer, except its depth."""

PRESETS: dict[str, Profile] = {
    "SENSOR_DATA": {"depth": 5, "reliability": "best_effort", "durability": "volatile"},
    "SERVICES_DEFAULT": {"depth": 10, "reliability": "reliable", "durability": "volatile"},
    "PARAMETERS": {"depth": 1000, "reliability": "reliable", "durability": "volatile"},
    "PARAMETER_EVENTS": {"depth": 1000, "reliability": "reliable", "durability": "volatile"},
    "SYSTEM_DEFAULT": {"depth": 0, "reliability": "system default", "durability": "system default"},
    "ACTION_STATUS_DEFAULT": {"depth": 1, "reliability": "reliable", "durability": "transient_local"},
    "DEFAULT": {"depth": 10, "reliability": "reliable", "durability": "volatile"},
    "BEST_AVAILABLE": {"depth": 10, "reliability": "best available", "durability": "best available"},
}
"""Presets of rclpy; its own documentation has them."""

_WORDS = {
    "reliability": ("BEST_EFFORT", "RELIABLE", "SYSTEM_DEFAULT", "BEST_AVAILABLE"),
    "durability": ("TRANSIENT_LOCAL", "VOLATILE", "SYSTEM_DEFAULT", "BEST_AVAILABLE"),
    "history": ("KEEP_LAST", "KEEP_ALL", "SYSTEM_DEFAULT"),
}


TIMED = {"deadline": "deadline", "liveliness": "liveliness", "lease_duration": "liveliness_lease_duration"}
"""Members of a profile with times, in seconds, and how liveliness is asserted, by their names in rclpy."""


class Reader(Protocol):
    """Reads attributes that a program has set."""

    def read(self, holder: Value, name: str) -> Value | None:
        """Return an attribute of an object."""

    def preset(self, path: str) -> Made | None:
        """Return the members of a preset that were set; None: none."""


def profile_of(value: Value | None, reader: Reader) -> Profile:
    """Return the quality of service of a value; unknown parts are open.

    Parameters
    ----------
    value : Value or None
        The value in the code.
    reader : Reader
        Reads what the program has set.
    """
    if value is None or is_none(value):
        return dict.fromkeys(USUAL, "open: none given")
    if isinstance(value, Either):
        found = [profile_of(each, reader) for each in value.options if not is_none(each)]
        timed = dict.fromkeys(key for each in found for key in each if key in TIMED)
        return {
            **{key: one_value([each.get(key, "open") for each in found]) for key in USUAL},
            **{key: one_value([each.get(key, "usual") for each in found]) for key in timed},
        }
    if isinstance(value, Const):
        if isinstance(value.value, int) and not isinstance(value.value, bool):
            return _from({**USUAL, "depth": value.value}, value)
        return dict.fromkeys(USUAL, "open")
    if isinstance(value, Outside):
        preset = _preset(value.path)
        if preset is None:
            return dict.fromkeys(USUAL, f"open: {value.path}")
        changed = reader.preset(value.path)
        return dict(preset) if changed is None else _changed(dict(preset), changed, reader)
    if isinstance(value, Object):
        value = value.made
    if isinstance(value, Made):
        return _made(value, reader)
    if isinstance(value, Open):
        return dict.fromkeys(USUAL, f"open: {value.text}")
    return dict.fromkeys(USUAL, "open")


def _from(profile: Profile, value: Const) -> Profile:
    return {**profile, "qos_from": value.origin} if value.is_setting else profile


def _preset(path: str) -> Profile | None:
    name = path.removesuffix(".value").split(".")[-1]
    name = name.removeprefix("qos_profile_").upper()
    return PRESETS.get(name) if path.startswith("rclpy") else None


def _made(value: Made, reader: Reader) -> Profile:
    last = value.path.split(".")[-1]
    if last in ("get_from_short_key",) and value.args and isinstance(value.args[0], Const):
        found = PRESETS.get(str(value.args[0].value).upper())
        return dict(found) if found else dict.fromkeys(USUAL, "open")
    if last in ("deepcopy", "copy") and value.args:
        base = profile_of(value.args[0], reader)
    elif last == "QoSProfile" and value.path.startswith("rclpy"):
        base = {"depth": 0, "reliability": "reliable", "durability": "volatile"}
        for name in ("depth", "reliability", "durability", "history"):
            if name in value.keys:
                base[name] = word(name, value.keys[name])
        for name, given in TIMED.items():
            _set(base, name, value.keys.get(given))
        if value.args:
            base = dict.fromkeys(USUAL, "open")
    else:
        return dict.fromkeys(USUAL, f"open: {value.path}")
    return _changed(base, value, reader)


def _changed(base: Profile, value: Made, reader: Reader) -> Profile:
    """Return a profile with the members that a program sets."""
    for name in ("depth", "reliability", "durability", "history"):
        given, slot = reader.read(value, name), value.slots.get(name)
        if given is not None and slot is not None and not slot.is_off:
            said = word(name, given)
            base[name] = one_value([base.get(name, "keep_last"), said]) if slot.is_perhaps else said
    for name, attribute in TIMED.items():
        given, slot = reader.read(value, attribute), value.slots.get(attribute)
        if given is not None and slot is not None and not slot.is_off:
            before = base.get(name, "usual")
            _set(base, name, given)
            if slot.is_perhaps and base.get(name, "usual") != before:
                base[name] = one_value([before, base.get(name, "usual")])
    if base.get("history") == "keep_last":
        del base["history"]
    return base


def _set(profile: Profile, name: str, value: Value | None) -> None:
    """Set a member with a time; usual values are left out."""
    profile.pop(name, None)
    if value is None:
        return
    if isinstance(value, Either):
        found: list[Any] = []
        for each in options(value):
            one: Profile = {}
            _set(one, name, each)
            found.append(one.get(name, "usual"))
        if any(each != "usual" for each in found):
            profile[name] = one_value(found)
    elif name == "liveliness":
        number = constant(value)
        path = value.path.upper() if isinstance(value, Outside) else str(number or "").upper()
        if number == _MANUAL or path.endswith("MANUAL_BY_TOPIC"):
            profile[name] = "manual_by_topic"
        elif not path.endswith(("AUTOMATIC", "SYSTEM_DEFAULT", "BEST_AVAILABLE")) and number not in (0, 1):
            profile[name] = text_of_open(value)
    elif not (isinstance(value, Outside) and value.path.upper().endswith("INFINITE")):
        seconds = of_duration(value)
        if seconds is None:
            profile[name] = text_of_open(value)
        elif 0 < seconds < FOREVER:
            profile[name] = seconds


_MANUAL = 3
"""The number of the policy of manual liveliness."""


def word(kind: str, value: Value) -> Any:
    """Return the value of a policy in lower case: ``best_effort``; depth as a number."""
    if isinstance(value, Either):
        return one_value([word(kind, each) for each in options(value)])
    if kind == "depth":
        number = constant(value)
        return number if isinstance(number, int) and not isinstance(number, bool) else text_of_open(value)
    number = constant(value)
    if isinstance(number, int) and not isinstance(number, bool):
        path = _NUMBERS[kind].get(number, "")
    else:
        path = value.path if isinstance(value, Outside) else str(number or "")
    found = next((each for each in _WORDS[kind] if path.upper().endswith(each)), None)
    if found is None:
        return text_of_open(value)
    return (
        found.lower()
        if found not in ("SYSTEM_DEFAULT", "BEST_AVAILABLE")
        else found.lower().replace("_", " ")
    )


_NUMBERS = {
    "reliability": {0: "SYSTEM_DEFAULT", 1: "RELIABLE", 2: "BEST_EFFORT"},
    "durability": {0: "SYSTEM_DEFAULT", 1: "TRANSIENT_LOCAL", 2: "VOLATILE"},
    "history": {0: "SYSTEM_DEFAULT", 1: "KEEP_LAST", 2: "KEEP_ALL"},
}
"""Numbers of policies, as parameters hold them."""


def number_of(path: str) -> int | None:
    """Return the number of a policy by its name in rclpy; None: another name.

    Examples
    --------
    >>> number_of("rclpy.qos.ReliabilityPolicy.BEST_EFFORT")
    2
    """
    kind, _, name = (
        path.removeprefix("rclpy.qos.").removeprefix("QoS").removesuffix(".value").partition("Policy.")
    )
    known = _NUMBERS.get(kind.lower(), {}) if path.startswith("rclpy.qos.") else {}
    return next((number for number, each in known.items() if each == name), None)


def text_of_open(value: Value) -> str:
    """Return a value that is not a policy as open."""
    text = text_of(value)
    return text if is_open(text) else f"open: {text}"


def one_value(values: list[Any]) -> Any:
    """Return the one value of several, if they agree."""
    if values and all(value == values[0] for value in values):
        return values[0]
    return "open: " + " or ".join(str(value).removeprefix("open: ") for value in values)
