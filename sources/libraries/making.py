"""Creates the facts of nodes and their entities from calls of rclpy."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from typing import Any

from dineros.sources.facts import OPEN, CallbackFact, Entity, NodeFact, is_open
from dineros.sources.language.machine import Machine
from dineros.sources.language.values import (
    Const,
    Frame,
    Goal,
    Holder,
    Items,
    Made,
    Message,
    Object,
    Open,
    Outside,
    Partial,
    Port,
    Response,
    RunningNode,
    Text,
    Value,
    constant,
    is_none,
    join,
    options,
    text_of,
)
from dineros.sources.libraries.arguments import alternatives, type_of
from dineros.sources.libraries.quality import number_of, profile_of
from dineros.sources.places import Place
from dineros.sources.resolving import own_name

NO_VARIABLE = "(no variable)"
CONSTRUCTORS = ("constructor", "main", "thread", "module")
"""Code of a node that is not a callback."""


class Maker:
    """Creates facts of nodes and entities.

    `machine`: the interpreter; it has the current position.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.parameters: dict[int, dict[str, Value]] = {}
        self.given: Mapping[str, Any] = {}
        self.is_launched = False
        self.arguments: tuple[str, ...] = ()

    # -------------------------------------------------------------------------------------------------- nodes

    def node(
        self,
        name: Value | None,
        keys: dict[str, Value],
        node: ast.AST,
        frame: Frame,
        base: str,
        instance: Object | None,
    ) -> NodeFact:
        """Create a node; the same call gives the same node."""
        machine = self.machine
        key = (
            "node",
            frame.module.path,
            getattr(node, "lineno", 0),
            getattr(node, "col_offset", 0),
            *machine.trail,
        )
        known = machine.entities.get(key)
        if known is not None:
            return known.details["node"]  # type: ignore[no-any-return]
        cls, at = self._maker(frame, node, instance)
        fact = NodeFact(cls, at, text_of(name) if name is not None else "open: no name", base=base)
        namespace = keys.get("namespace")
        if not is_none(namespace):
            fact.namespace = text_of(namespace)
        fact.program, fact.home = machine.program, machine.home
        fact.managed = any(word in base.lower() for word in ("lifecycle", "managed"))
        machine.nodes.append(fact)
        machine.entities[key] = Entity("node", "", at, details={"node": fact})
        self.parameters[id(fact)] = {}
        overrides = keys.get("parameter_overrides")
        for each in getattr(overrides, "items", ()) if overrides is not None else ():
            if isinstance(each, Made) and each.args and isinstance(each.args[0], Const):
                value = each.argument(2, "value")
                if value is not None:
                    self.parameters[id(fact)][str(each.args[0].value)] = value
        return fact

    def _maker(self, frame: Frame, node: ast.AST, instance: Object | None) -> tuple[str, Place]:
        """Return the class or function that creates a node."""
        if instance is not None:
            return instance.cls.node.name, Place(instance.cls.frame.module.path, instance.cls.node.lineno)
        here: Frame | None = frame
        while here is not None and here.function is None:
            here = here.outer
        holder = here.instance if here is not None else None
        if isinstance(holder, Object) and holder.node is None:
            return holder.cls.node.name, Place(holder.cls.frame.module.path, holder.cls.node.lineno)
        if here is not None and here.function is not None:
            return here.function.name, Place(here.module.path, here.function.node.lineno)
        return frame.module.stem, self.machine.place(node, frame)

    def fact_of(self, value: Value | None) -> NodeFact | None:
        """Return the node of a value; of several, the first."""
        for each in options(value):
            if isinstance(each, RunningNode):
                return each.fact
            if isinstance(each, Object) and each.node is not None:
                return each.node
        return None

    def own_name(self, fact: NodeFact, method: str) -> Value:
        """Return what a node learns of its own name or namespace: a launch file changes it."""
        found = own_name(fact, self.given, method)
        if found is None or is_open(found):
            return Text(found or "{node}")
        return Const(found, "parameter namespace" if method == "get_namespace" else "variable")

    @staticmethod
    def behaves_like_node(instance: Object, name: str) -> bool:
        """Return whether a method is one of a node, so that a class outside of the folder is a node.

        Others than nodes have parameters, too.
        """
        if name != "declare_parameter":
            return name in CREATES
        parts = (each for cls in instance.cls.inside for each in ast.walk(cls.node))
        return any(isinstance(each, ast.Attribute) and each.attr in CREATES for each in parts)

    def implicit(self, instance: Object) -> NodeFact:
        """Return the node of an object that behaves like one, and whose base class is not in the folder."""
        if instance.node is None:
            cls, (base, *_) = instance.cls, instance.cls.outside()
            instance.node = self.node(Open("in the base class"), {}, cls.node, cls.frame, base, instance)
            instance.node.is_lent = True
        return instance.node

    def used_as_node(self, value: Value | None) -> NodeFact | None:
        """Return the node of a value that is used as a node.

        An object of a class whose base is not in the folder is a node there.
        """
        fact = self.fact_of(value)
        if fact is None:
            objects = (each for each in options(value) if isinstance(each, Object) and each.cls.outside())
            instance = next(objects, None)
            fact = None if instance is None else self.implicit(instance)
        return fact

    # --------------------------------------------------------------------------------------------- parameters

    def declare(self, fact: NodeFact, name: Value | None, default: Value | None, at: Place) -> Value:
        """Declare a parameter; return its value."""
        text = text_of(name)
        known = self.parameters[id(fact)]
        value = default if default is not None else Open(f"parameter {text}")
        if text in self.given and (self.is_launched or default is None):
            value = _given(self.given[text], text)
        elif text in known:
            value = known[text]
        value = _parameter(value, text)
        known[text] = value
        if not any(each.kind == "parameters" and each.name == text for each in fact.entities):
            shown = default.value if isinstance(default, Const) else text_of(default) if default else "open"
            shown = shown if isinstance(shown, (str, int, float, bool)) else str(shown)
            fact.entities.append(Entity("parameters", text, at, text, details={"default": shown}))
        return value

    def parameter(self, fact: NodeFact, name: Value | None, other: Value | None = None) -> Value:
        """Return the value of a parameter; `other`: its value if it is not set."""
        text = text_of(name)
        found = self.parameters[id(fact)].get(text)
        if found is None and self.is_launched and text in self.given:
            found = _given(self.given[text], text)
        if found is not None and not (isinstance(found, Open) and other is not None):
            return found
        if isinstance(other, Made):
            other = other.argument(2, "value") if other.path.endswith(".Parameter") else other
        return _parameter(other, text) if other is not None else Open(f"parameter {text}")

    # ----------------------------------------------------------------------------------------------- entities

    def entity(
        self, kind: str, fact: NodeFact, node: ast.AST, frame: Frame, extra: object = 0
    ) -> tuple[Entity, bool]:
        """Return an entity of a node, and whether it is new; the same call gives the same entity."""
        machine = self.machine
        key = (kind, id(fact), frame.module.path, node.lineno, node.col_offset, extra, *machine.trail)  # type: ignore[attr-defined]
        known = machine.entities.get(key)
        if known is not None:
            return known, False
        found = machine.entities[key] = Entity(kind, NO_VARIABLE, machine.place(node, frame))
        activity = machine.activity
        if activity.loops:
            found.details["instances"] = "in a loop"
        if activity.conditional:
            found.details["conditional"] = "in a branch"
        found.is_enabled = not activity.disabled
        if activity.fact.kind not in CONSTRUCTORS:
            found.details["created_in"] = activity.fact.name
        found.order = machine.next_order()
        fact.entities.append(found)
        return found, True

    def name(self, entity: Entity, value: Value | None) -> None:
        """Set the name of an entity."""
        entity.name = text_of(value)
        if isinstance(value, Const) and value.is_setting:
            entity.details["from_"] = value.origin

    def type(self, entity: Entity, value: Value | None) -> None:
        """Set the type of an entity."""
        entity.type = type_of(value, entity.kind)

    def quality(self, entity: Entity, value: Value | None, *, usual: bool = False) -> None:
        """Set the quality of service of an entity."""
        profile = profile_of(value if not usual else Const(10), self)
        for key, each in profile.items():
            entity.details[key] = each

    def read(self, holder: Value, name: str) -> Value | None:
        """Return an attribute that the program has set."""
        return self.machine.read_slot(holder, name) if isinstance(holder, Holder) else None

    def preset(self, path: str) -> Made | None:
        """Return the members of a preset of ``rclpy.qos`` that the program has set."""
        return self.machine.presets.get(path)

    def group(self, entity: Entity, value: Value | None, fact: NodeFact) -> None:
        """Set the callback group of an entity."""
        found = [self._group(each, fact) for each in options(value)] or [("default", None)]
        names = [name for name, _ in found]
        if len(set(names)) == 1:
            entity.details["group"], entity.group = found[0]
        else:
            entity.details["group"] = f"open: {' or '.join(names)}"

    def _group(self, value: Value, fact: NodeFact) -> tuple[str, Entity | None]:
        if is_none(value):
            return "default", None
        made = value.made if isinstance(value, Object) else value
        if not isinstance(made, Made) or not made.path.endswith("CallbackGroup"):
            return text_of(value) if not isinstance(value, (Object, Made)) else OPEN, None
        if made.path == "default CallbackGroup":
            return "default", None
        reentrant = "reentrant" if made.path.endswith("ReentrantCallbackGroup") else "exclusive"
        if isinstance(value, Object) and "entrant" not in made.path and "xclusive" not in made.path:
            reentrant = f"open: own class {value.cls.node.name}"
        name, at = (value.name, value.at) if isinstance(value, Object) else (made.name, made.at)
        if made.entity is None:
            made.entity = Entity("groups", name or "anonymous", at, details={"kind": reentrant})
        if made.entity not in fact.entities:
            if any(made.entity in other.entities for other in self.machine.nodes if other is not fact):
                made.entity.details["shared"] = True  # by several nodes
            fact.entities.append(made.entity)
        return (name or f"anonymous {reentrant} (:{at.line})"), made.entity

    def callback(
        self, entity: Entity, role: str, value: Value | None, fact: NodeFact, args: list[Value], kind: str
    ) -> CallbackFact | None:
        """Set the callback of an entity; its code is read later."""
        if is_none(value) or value is None:
            return None
        able = [each for each in options(value) if not is_none(each)]
        found = None
        names = []
        for each in able:
            found = self.machine.later(each, kind, fact, args, (id(entity), role))
            names.append(f"partial({found.name})" if isinstance(each, Partial) else found.name)
            if len(able) > 1:
                found.is_open = True
        if found is not None:
            entity.callbacks[role] = found
            entity.details[role] = names[0] if len(names) == 1 else f"open: {' or '.join(names)}"
        return found

    # --------------------------------------------------------------------------------------- methods of nodes

    def create(self, call: Made, fact: NodeFact, node: ast.AST, frame: Frame) -> Value:
        """Call a ``create_...`` method of a node, which is the path of the call."""
        if isinstance(node, ast.Call):
            self.machine.modules.reached.add((frame.module.path, node.func.end_lineno or 0))
        kind = call.path.removeprefix("create_").removeprefix("lifecycle_")
        names = alternatives(call.argument(1, "topic", "srv_name")) if kind in _NAMED else []
        if names:
            return join([self._create(kind, fact, call, node, frame, each) for each in names])
        return self._create(kind, fact, call, node, frame, None)

    def _create(
        self, kind: str, fact: NodeFact, call: Made, node: ast.AST, frame: Frame, chosen: Const | None
    ) -> Value:
        """Make an entity; `chosen` is one of the names that it may have, of which a run has one."""
        extra = 0 if chosen is None else f"named {chosen.value}"
        entity, is_new = self.entity(_KINDS[kind], fact, node, frame, extra)
        if chosen is not None:
            entity.details["conditional"] = "one of several names"
        if is_new:
            self._complete(kind, entity, fact, call, chosen)
        self._note_creation(kind, entity, node, frame)
        return Port(entity, fact)

    def _complete(self, kind: str, entity: Entity, fact: NodeFact, call: Made, chosen: Const | None) -> None:
        """Give a new entity what the arguments of its call say."""
        if kind in _NAMED:
            self.type(entity, call.argument(0, "msg_type", "srv_type"))
            self.name(entity, chosen or call.argument(1, "topic", "srv_name"))
        elif kind == "timer":
            self.period(entity, call.argument(0, "timer_period_sec"))
        if kind in _CALLBACKS:
            given: list[Value] = [Message("message", entity)] if kind == "subscription" else []
            given = [Message("request"), Response("response")] if kind == "service" else given
            callback = call.argument(_CALLBACKS[kind], "callback")
            self.callback(entity, "callback", callback, fact, given, kind.replace("_", " "))
        if kind in ("publisher", "subscription"):
            self.quality(entity, call.argument(2 if kind == "publisher" else 3, "qos_profile"))
        if call.path == "create_lifecycle_publisher":
            entity.details["managed"] = True
        if kind != "publisher":
            index = -1 if kind in _NAMED else _CALLBACKS[kind] + 1
            self.group(entity, call.argument(index, "callback_group"), fact)

    def _note_creation(self, kind: str, entity: Entity, node: ast.AST, frame: Frame) -> None:
        activity = self.machine.activity
        is_late = activity.fact.kind == "main" and activity.conditional and not activity.loops
        if activity.fact.kind not in CONSTRUCTORS or (is_late and kind == "timer"):
            do = "create_timer" if kind == "timer" else "create"
            self.machine.effect(do, entity.port if do == "create_timer" else kind, node, frame, entity=entity)

    def period(self, entity: Entity, value: Value | None) -> None:
        """Set the period of a timer, in seconds."""
        number = constant(value)
        if isinstance(number, (int, float)) and not isinstance(number, bool):
            entity.details["period"] = float(number)
        else:
            text = text_of(value)
            entity.details["period"] = text if is_open(text) else f"open: {text}"
        if isinstance(value, Const) and value.is_setting:
            entity.details["from_"] = value.origin

    def action_server(self, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame) -> Value:
        """Create an action server."""
        call = Made("ActionServer", args, keys, self.machine.place(node, frame))
        fact = self.used_as_node(call.argument(0, "node"))
        if fact is None:
            return Open("action server of an unknown node")
        entity, is_new = self.entity("action_servers", fact, node, frame)
        if is_new:
            self.type(entity, call.argument(1, "action_type"))
            self.name(entity, call.argument(2, "action_name"))
            goal = Goal("server", entity)
            for role, index, key, given in (
                ("execute", 3, "execute_callback", goal),
                ("goal", -1, "goal_callback", Open("goal request")),
                ("cancel", -1, "cancel_callback", goal),
                ("accepted", -1, "handle_accepted_callback", goal),
            ):
                self.callback(entity, role, call.argument(index, key), fact, [given], role)
            self.group(entity, call.argument(-1, "callback_group"), fact)
        return Port(entity, fact)

    def action_client(self, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame) -> Value:
        """Create an action client."""
        call = Made("ActionClient", args, keys, self.machine.place(node, frame))
        fact = self.used_as_node(call.argument(0, "node"))
        if fact is None:
            return Open("action client of an unknown node")
        entity, is_new = self.entity("action_clients", fact, node, frame)
        if is_new:
            self.type(entity, call.argument(1, "action_type"))
            self.name(entity, call.argument(2, "action_name"))
            self.group(entity, call.argument(-1, "callback_group"), fact)
        return Port(entity, fact)


def _given(value: Any, name: str) -> Value:
    """Return a parameter that a launch file gives."""
    if isinstance(value, list):
        return Items([_given(each, name) for each in value])
    return Const(value, f"parameter {name}")


def _parameter(value: Value, name: str) -> Value:
    """Return the value of a parameter: what people can set."""
    if isinstance(value, Const):
        return (
            Const(value.value, f"parameter {name}") if value.value is not None else Open(f"parameter {name}")
        )
    if isinstance(value, Outside):
        number = number_of(value.path)
        return Open(f"parameter {name}") if number is None else Const(number, f"parameter {name}")
    return value


_NAMED = ("publisher", "subscription", "service", "client")
_CALLBACKS = {"subscription": 2, "timer": 1, "service": 2, "guard_condition": 0}
"""By kind with a callback: the position of that argument."""
_KINDS = {
    "publisher": "publishers",
    "subscription": "subscriptions",
    "timer": "timers",
    "service": "services",
    "client": "clients",
    "guard_condition": "guard_conditions",
}
CREATES = frozenset(f"create_{kind}" for kind in _KINDS) | {"create_lifecycle_publisher"}
"""Methods of a node that create entities."""
