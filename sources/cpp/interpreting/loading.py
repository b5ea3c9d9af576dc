"""Interprets loaders of ``pluginlib``: a plugin is a class of the folder, or one of several."""

from __future__ import annotations

from dineros.sources.cpp.entries import ClassInfo
from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.tables.plugins import Plugin, is_plugin
from dineros.sources.cpp.values import Const, Made, Open, Value, constant, one_of, options

_CREATES = {
    *("createSharedInstance", "createUniqueInstance", "createUnmanagedInstance", "createInstance"),
}
_MOST = 100
"""Limit of the plugins of a program that loads all declared ones."""
_FEW = 3
"""Limit of the plugins that another name which is not known may mean: of more, most are not loaded."""


def loaded(machine: Statements, call: Call) -> Value | None:
    """Return the plugin that a call of a loader creates; None: another call, or none of the folder.

    If the name is not known, each exported class with the base class of the loader is possible, if they are
    few, or if the program loads all declared classes.
    """
    on = call.on
    if call.last not in _CREATES or not isinstance(on, Made) or not on.path.endswith("ClassLoader"):
        return None
    given = options(call.args[0] if call.args else None)
    names = [constant(each) for each in given]
    found = machine.index.plugins.of(_base(machine, on, call))
    if all(isinstance(each, str) and each for each in names) and names:
        wanted = {machine.index.plugins.class_named(str(each)) for each in names}
        found = [each for each in found if any(is_plugin(each, one) for one in wanted)]
        if len(found) < len(wanted):
            return None  # the class is not in the folder
    elif found:
        is_all = any(isinstance(each, Open) and "getDeclaredClasses" in each.text for each in given)
        count = f"one of the {len(found)} plugins of the folder" if len(found) > 1 else "the plugin"
        machine.unread.append(
            f"{machine.place(call.node, call.frame)}: the name of the plugin is not known; {count} with this "
            "base class, or one from elsewhere"
        )
        if len(found) > (_MOST if is_all else _FEW):
            return None
    is_sure = len(found) == 1 and len(names) == 1 and isinstance(names[0], str)
    made: list[Value] = []
    for turn, each in enumerate(found):
        value = _created(machine, call, each, turn, is_sure)
        made += [] if value is None else [value]
    if not made:
        return None
    return one_of(made)


def _base(machine: Statements, on: Made, call: Call) -> str:
    """Return the base class of a loader: its second argument, or the argument of its template."""
    given = on.args[1] if len(on.args) > 1 else None
    if isinstance(given, Const) and isinstance(given.value, str):
        return given.value
    inner = machine.templated(on.node, call.frame)
    return machine.type_text(inner[0], call.frame) if inner else ""


def _created(machine: Statements, call: Call, plugin: Plugin, turn: int, is_sure: bool) -> Value | None:
    name, _, rest = plugin.cls.partition("<")
    cls: ClassInfo | None = machine.class_of(name.strip(), call.frame)
    if cls is None:
        return None
    types = [each.strip() for each in rest.rpartition(">")[0].split(",")] if rest else []
    machine.turns.append(turn)
    try:
        if is_sure:
            return machine.construct(cls, [], types, call.node, call.frame)
        with machine.perhaps():
            return machine.construct(cls, [], types, call.node, call.frame)
    finally:
        machine.turns.pop()
