"""Applies the table of idioms to calls of libraries."""

from __future__ import annotations

import ast
from collections.abc import Mapping as AnyMapping
from typing import Any

from dineros.sources.facts import Entity, NodeFact
from dineros.sources.language.values import (
    NONE,
    Const,
    Frame,
    Items,
    Made,
    Object,
    Open,
    Port,
    RunningNode,
    Value,
    constant,
    hole,
    options,
    text_of,
)
from dineros.sources.libraries.arguments import type_of
from dineros.sources.libraries.doing import Doer
from dineros.sources.libraries.idioms import Idiom, publish_at_each_tick
from dineros.sources.libraries.making import NO_VARIABLE


class Idioms:
    """Applies the table of idioms.

    Parameters
    ----------
    doer : Doer
        Records effects.
    idioms : mapping of str to Idiom
        The table, by dotted names.
    """

    def __init__(self, doer: Doer, idioms: AnyMapping[str, Idiom]) -> None:
        self.maker, self.machine = doer.maker, doer.machine
        self.table = idioms
        self._makes: dict[int, tuple[Idiom, list[Entity], NodeFact | None]] = {}
        self._kept: list[Value] = []

    def apply(self, idiom: Idiom, made: Made, node: ast.AST, frame: Frame, instance: Object | None) -> Value:
        """Call a class or function of the table; `instance` is an object whose class extends it."""
        given = {name: made.argument(index, name) for index, name in enumerate(idiom.arguments)}
        if idiom.quality:
            for name, value in idiom.quality.items():
                self.machine.write_slot(made, name, Const(value))
            made.path = "rclpy.qos.QoSProfile"
            made.args, made.keys = [], {}
            return made
        if idiom.does:
            what = _filled(str(idiom.does.get("what", "")), given)
            self.machine.effect(str(idiom.does["do"]), what, node, frame, str(idiom.does.get("how", "")))
            return Open(idiom.path)
        if idiom.node is not None:
            called = Const(idiom.node) if "{" not in idiom.node else given.get(idiom.node.strip("{}"))
            fact: NodeFact | None = self._node(idiom, called, node, frame, instance)
        else:
            fact = self.maker.used_as_node(given.get("node"))
        entities: list[Entity] = []
        if idiom.synchronizes:
            for each in self.machine.turns(given.get(idiom.synchronizes) or NONE)[0] or options(
                given.get(idiom.synchronizes)
            ):
                entities += self._makes[id(each)][1] if id(each) in self._makes else []
                fact = fact or (self._makes[id(each)][2] if id(each) in self._makes else None)
        if fact is not None:
            for number, entry in enumerate(idiom.makes):
                entities += self._entities(entry, number, fact, given, made, entities, node, frame)
        spins = given.get("spin_thread")
        for entity in entities if spins is not None and constant(spins) is not False else ():
            entity.details["thread"] = "its own"
        holder: Value = (
            RunningNode(fact) if idiom.node is not None and fact is not None and instance is None else made
        )
        self._makes[id(instance or holder)] = (idiom, entities, fact)
        self._kept.append(holder)  # so that its id stays its own
        return holder

    def _node(
        self, idiom: Idiom, name: Value | None, node: ast.AST, frame: Frame, instance: Object | None
    ) -> NodeFact:
        fact = self.maker.node(name, {}, node, frame, idiom.path, instance)
        if instance is not None:
            instance.node = fact
            self.machine.write_slot(instance, "node", RunningNode(fact))
        return fact

    def _entities(
        self,
        entry: AnyMapping[str, Any],
        number: int,
        fact: NodeFact,
        given: dict[str, Value | None],
        made: Made,
        before: list[Entity],
        node: ast.AST,
        frame: Frame,
    ) -> list[Entity]:
        if "each" in entry:
            return self._of_rows(entry, fact, given, made, node, frame)
        entity, is_new = self.maker.entity(entry["kind"], fact, node, frame, number)
        if not is_new:
            return [entity]
        entity.details["via"] = entry.get("via", "")
        if "name" in entry:
            entity.name = _filled(entry["name"], given)
        if "type" in entry:
            key = str(entry["type"])
            entity.type = type_of(given.get(key.strip("{}"))) if key.startswith("{") else key
        if entry["kind"] in ("publishers", "subscriptions"):
            value = given.get(entry.get("qos", ""))
            self.maker.quality(entity, value, usual=value is None)
            if value is None:
                entity.details |= {
                    key: entry[key] for key in ("depth", "reliability", "durability") if key in entry
                }
        if entry["kind"] == "timers":
            value = given.get(str(entry["period"]).strip("{}"))
            self.maker.period(entity, value if value is not None else Const(entry.get("usual")))
            entity.details["callback"] = entry.get("via", "open")
            if "publishes" in entry:
                publish_at_each_tick(entity, before[entry["publishes"]])
        if entry["kind"] not in ("publishers", "groups"):
            entity.details["group"] = entry.get("group", "default")
        if entry["kind"] == "action_servers":
            entity.details["execute"] = "open: in the base class"
        return [entity]

    def _of_rows(
        self,
        entry: AnyMapping[str, Any],
        fact: NodeFact,
        given: dict[str, Value | None],
        made: Made,
        node: ast.AST,
        frame: Frame,
    ) -> list[Entity]:
        found = []
        for index, row in enumerate(self.machine.turns(given.get(entry["each"]) or NONE)[0]):
            columns = (entry["attribute"], entry["name"], entry["type"])
            if not isinstance(row, Items) or len(row.items) <= max(columns):
                continue
            place: ast.AST = _row(node, index) or node
            entity, is_new = self.maker.entity(entry["kind"], fact, place, frame, index)
            if is_new:
                self.maker.name(entity, row.items[entry["name"]])
                self.maker.type(entity, row.items[entry["type"]])
                latched = constant(row.items[entry["latched"]]) if len(row.items) > entry["latched"] else None
                durability = "transient_local" if latched else "volatile" if latched is False else "open"
                entity.details |= {
                    "depth": 1,
                    "reliability": "reliable",
                    "durability": durability,
                    "via": entry.get("via", ""),
                }
                if "callback" in entry and len(row.items) > entry["callback"]:
                    self.maker.callback(
                        entity,
                        "callback",
                        row.items[entry["callback"]],
                        fact,
                        [Open("message")],
                        "subscription",
                    )
                    entity.details["group"] = "default"
            self.machine.write_slot(made, text_of(row.items[entry["attribute"]]), Port(entity, fact))
            found.append(entity)
        return found

    def method(self, value: Value, name: str, args: list[Value], node: ast.AST, frame: Frame) -> Value | None:
        """Call a method of an entity of the table; None: the table does not have the method."""
        if id(value) not in self._makes:
            return None
        idiom, entities, fact = self._makes[id(value)]
        does = idiom.methods.get(name)
        if name == "registerCallback" and idiom.synchronizes:
            does = {"callback": 0}
        if does is None:
            return None
        if "callback" in does:
            given = args[does["callback"]] if len(args) > does["callback"] else None
            messages: list[Value] = [Open("message") for _ in entities]
            if fact is not None and entities:
                found = self.maker.callback(entities[0], "callback", given, fact, messages, "subscription")
                for entity in entities[1:] if found is not None else ():
                    entity.callbacks["callback"] = found  # type: ignore[assignment]
                    entity.details["callback"] = entities[0].details["callback"]
            return NONE
        number = does.get("entity")
        at = entities[number] if isinstance(number, int) and number < len(entities) else None
        holder = getattr(value, "name", "")
        for entity in entities:
            if entity.port == NO_VARIABLE and holder:
                entity.port = holder
        effect = self.machine.effect(
            str(does["do"]),
            at.port if at else str(does.get("what", name)),
            node,
            frame,
            str(does.get("how", "")),
            at,
        )
        effect.timeout = does.get("timeout")
        return Open(name)


def _filled(template: str, given: dict[str, Value | None]) -> str:
    """Return a text of the table with the arguments of a call inserted."""
    for name, value in given.items():
        if f"{{{name}}}" in template:
            if template == f"{{{name}}}":
                return text_of(value)
            template = template.replace(f"{{{name}}}", hole(value or Open(name)))
    return template


def _row(node: ast.AST, index: int) -> ast.expr | None:
    """Return the part of a call for one row of a list."""
    for each in ast.walk(node):
        if isinstance(each, ast.List) and len(each.elts) > index:
            return each.elts[index]
    return None
