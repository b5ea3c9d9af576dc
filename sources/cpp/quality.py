"""Reads quality of service in rclcpp: numbers, presets, and chained calls."""

from __future__ import annotations

from dineros.sources.cpp.values import Const, Either, Made, Open, Value, constant, is_quality, shown
from dineros.sources.facts import FOREVER, is_open
from dineros.sources.libraries.quality import USUAL, Profile, one_value

SYSTEM: Profile = {"depth": 0, "reliability": "system default", "durability": "system default"}
PRESETS: dict[str, Profile] = {
    "SensorDataQoS": {"depth": 5, "reliability": "best_effort", "durability": "volatile"},
    "rmw_qos_profile_sensor_data": {"depth": 5, "reliability": "best_effort", "durability": "volatile"},
    "ServicesQoS": USUAL,
    "rmw_qos_profile_services_default": USUAL,
    "rmw_qos_profile_default": USUAL,
    "ParametersQoS": {**USUAL, "depth": 1000},
    "ParameterEventsQoS": {**USUAL, "depth": 1000},
    "ClockQoS": {"depth": 1, "reliability": "best_effort", "durability": "volatile"},
    "RosoutQoS": {"depth": 1000, "reliability": "reliable", "durability": "transient_local"},
    "SystemDefaultsQoS": SYSTEM,
    "rmw_qos_profile_system_default": SYSTEM,
    "DynamicBroadcasterQoS": {**USUAL, "depth": 100},
    "StaticBroadcasterQoS": {**USUAL, "depth": 1, "durability": "transient_local"},
}
"""Presets; the documentation of rclcpp, rmw and tf2_ros has them."""
CHAINED = {
    *("keep_last", "keep_all", "reliable", "best_effort", "reliability", "durability", "transient_local"),
    *(
        "durability_volatile",
        "deadline",
        "lifespan",
        "liveliness",
        "history",
        "avoid_ros_namespace_conventions",
    ),
    *("liveliness_lease_duration", "best_available", "reliability_best_available"),
    "durability_best_available",
}
"""Methods of a profile that return it."""
RMW_PROFILE = "rmw_qos_profile_t"
"""The structure of a profile in C."""
_OF_RMW = ("history", "depth", "reliability", "durability", "deadline", "lifespan", "liveliness")
"""Its first members, in their order."""
TIMED = ("deadline", "lease_duration")
"""Members of a profile in seconds; absent: without bound."""
_OPEN: Profile = dict.fromkeys(USUAL, "open")


def profile(value: Value | None) -> Profile:
    """Return the quality of service of a value; unknown parts are open."""
    if isinstance(value, Either):
        found = [profile(each) for each in value.options]
        keys = dict.fromkeys(
            [*USUAL, *(key for each in found for key in each if key in (*TIMED, "liveliness"))]
        )
        return {key: one_value([each.get(key, "usual") for each in found]) for key in keys}
    if isinstance(value, Const) and isinstance(value.value, int) and not isinstance(value.value, bool):
        return {**USUAL, "depth": value.value}
    if isinstance(value, Made):
        return _of(value)
    if isinstance(value, Open):
        return dict.fromkeys(USUAL, f"open: {value.text}")
    return dict(_OPEN)


def _of(value: Made) -> Profile:
    found = _base_of(value)
    if not is_quality(value):
        return found
    for key, each in value.fields.items():  # members that are set afterwards
        if key == "depth":
            found[key] = profile(each)["depth"]
        elif key in TIMED or (key == "liveliness" and not isinstance(each, Const)):
            _set(found, key, each)
        elif key == "liveliness":
            found[key] = each.value  # type: ignore[attr-defined]
        elif key in USUAL:
            is_word = isinstance(each, Const) and isinstance(each.value, str)
            found[key] = each.value if is_word else _word(each)  # type: ignore[attr-defined]
    if "history" in value.fields:
        return _with_history(found, value.fields["history"])
    return found


def _base_of(value: Made) -> Profile:
    """Return the quality that a profile is made with."""
    last = value.path.rpartition("::")[2]
    if last in PRESETS:
        found = dict(PRESETS[last])
        # What presets of `rclcpp` get says only how much is kept.
        return _kept(found, value.args[0]) if value.args else found
    if last == "QoS" and value.args:
        others = profile(value.args[1]) if len(value.args) > 1 else USUAL
        return _kept(dict(others), value.args[0])
    return _made_of(value)


def _kept(found: Profile, given: Value) -> Profile:
    """Return a profile whose history is given by a number, ``KeepLast``, or ``QoSInitialization``."""
    last = given.path.rpartition("::")[2] if isinstance(given, Made) else ""
    if last == "QoSInitialization" and isinstance(given, Made) and len(given.args) > 1:
        return _with_history({**found, "depth": profile(given.args[1])["depth"]}, given.args[0])
    said = profile(given)
    found = {**found, "depth": said["depth"]}
    return {**found, "history": said["history"]} if "history" in said else found


def _with_history(found: Profile, history: Value) -> Profile:
    """Return a profile with another policy of its history."""
    path = history.path if isinstance(history, Made) else shown(history)
    if path.lower().replace("_", "").endswith("keepall"):
        return {**found, "depth": 0, "history": "keep_all"}
    return found


def _made_of(value: Value) -> Profile:
    if isinstance(value, Made):
        last = value.path.rpartition("::")[2]
        if last in ("KeepLast", "QoSInitialization", "from_rmw", "get_rmw_qos_profile") and value.args:
            return profile(value.args[-1] if last == "QoSInitialization" else value.args[0])
        if last == "KeepAll":
            return {**USUAL, "depth": 0, "history": "keep_all"}
        return dict.fromkeys(USUAL, f"open: {value.path}")
    return dict(_OPEN)


def changed(value: Value | None, method: str, args: list[Value]) -> Made:
    """Return a profile after a chained call."""
    found = profile(value)
    if method == "keep_last" and args:
        found["depth"] = profile(args[0])["depth"]
    elif method == "keep_all":
        found |= {"depth": 0, "history": "keep_all"}
    elif method in ("reliable", "best_effort"):
        found["reliability"] = method
    elif method == "transient_local":
        found["durability"] = method
    elif method == "durability_volatile":
        found["durability"] = "volatile"
    elif method in ("reliability", "durability"):
        found[method] = _word(args[0] if args else None)
    elif method == "history" and args:
        found = _with_history(found, args[0])
    elif method in ("best_available", "reliability_best_available"):
        found["reliability"] = "best available"
    if method in ("best_available", "durability_best_available"):
        found["durability"] = "best available"
    if method in ("deadline", "liveliness", "liveliness_lease_duration") and args:
        _set(found, method.removeprefix("liveliness_"), args[0])
    if method == "keep_last":
        found.pop("history", None)
    fields: dict[str, Value] = {key: Const(each) for key, each in found.items()}
    return Made("rclcpp::QoS", fields=fields)


def _set(found: Profile, key: str, value: Value) -> None:
    """Set a deadline or a lease, in seconds, or how liveliness is asserted; usual values are left out."""
    found.pop(key, None)
    if key == "liveliness":
        path = (value.path if isinstance(value, Made) else shown(value)).upper().replace("_", "")
        if path.endswith("MANUALBYTOPIC"):
            found[key] = "manual_by_topic"
        elif not path.endswith(("AUTOMATIC", "SYSTEMDEFAULT", "BESTAVAILABLE")):
            found[key] = f"open: {shown(value).removeprefix('open: ')}"
        return
    seconds = constant(value)
    if not isinstance(seconds, (int, float)):
        is_endless = isinstance(value, Made) and value.path.upper().endswith(("INFINITE", "DEFAULT"))
        if not is_endless:
            text = value.value if isinstance(value, Const) else shown(value)  # open already, or not
            found[key] = text if is_open(text) else f"open: {text}"
    elif 0 < seconds < FOREVER:
        found[key] = float(seconds)


def of_rmw(values: list[Value]) -> dict[str, Value]:
    """Return the members of an ``rmw_qos_profile_t`` that a list in braces gives.

    Examples
    --------
    >>> of_rmw([Made("RMW_QOS_POLICY_HISTORY_KEEP_LAST"), Const(5)])["depth"]
    Const(value=5)
    """
    found: dict[str, Value] = {}
    for name, each in zip(_OF_RMW, values, strict=False):
        is_named = isinstance(each, Made) and each.path.startswith(".") and each.args
        found |= {each.path[1:]: each.args[0]} if is_named else {name: each}  # type: ignore[attr-defined]
    return found


def with_member(value: Made, name: str, given: Value) -> Made:
    """Return a profile after ``profile.depth = ...``."""
    return Made(value.path, value.args, {**value.fields, name: given}, node=value.node)


def _word(value: Value | None) -> str:
    path = value.path if isinstance(value, Made) else shown(value)
    for word in (
        "best_effort",
        "reliable",
        "transient_local",
        "volatile",
        "system_default",
        "best_available",
    ):
        if (
            path.lower()
            .replace("besteffort", "best_effort")
            .replace("transientlocal", "transient_local")
            .endswith(word)
        ):
            return word.replace("_default", " default").replace("_available", " available")
    return f"open: {path}"
