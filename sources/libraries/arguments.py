"""Arguments of calls that create entities: types, and names, of which there may be several."""

from __future__ import annotations

from dineros.sources.facts import OPEN
from dineros.sources.language.values import Const, Either, Outside, Value, options, text_of

MOST_NAMES = 8
"""Names of which one entity may have one."""


def alternatives(name: Value | None) -> list[Const]:
    """Return the names that an entity may have, if there are several and all are known."""
    found = [each for each in options(name) if isinstance(each, Const) and isinstance(each.value, str)]
    return found if 1 < len(found) == len(options(name)) <= MOST_NAMES else []


_KINDS = {
    **dict.fromkeys(("publishers", "subscriptions"), "msg"),
    **dict.fromkeys(("services", "clients"), "srv"),
    **dict.fromkeys(("action_servers", "action_clients"), "action"),
}


def type_of(value: Value | None, entity: str = "") -> str:
    """Return the ROS type of a class: ``std_msgs/msg/String``; open if it has none or is unknown.

    If there are several, the one that fits the kind of the entity is used: after `import *`, a name may be
    of any such module.
    """
    if isinstance(value, Either):
        found = [type_of(each) for each in value.options]
        fitting = [each for each in found if f"/{_KINDS.get(entity, '')}/" in each]
        is_star = all(isinstance(each, Outside) and each.is_star for each in value.options)
        if is_star and fitting:
            return fitting[0] if len(fitting) == 1 else f"open: {' or '.join(fitting)}"
        return f"open: {' or '.join(found)}"
    if isinstance(value, Outside):
        parts = value.path.split(".")
        for kind in ("msg", "srv", "action"):
            if kind in parts[1:-1]:
                index = parts.index(kind, 1)
                package = "/".join(parts[:index])
                return f"{package}/{kind}/{parts[-1]}"
        return f"open: {value.path}"
    text = text_of(value)
    return text if text.startswith(OPEN) else f"open: {text}"
