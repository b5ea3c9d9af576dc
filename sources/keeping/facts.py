"""Converts facts to plain JSON and back: nodes with all objects to which they refer, each object once."""

from __future__ import annotations

from typing import Any

from dineros.sources.facts import CallbackFact, Effect, Entity, NodeFact
from dineros.sources.keeping.branches import block_of, plain_block
from dineros.sources.keeping.values import (
    item_of,
    number_of,
    place_of,
    plain_place,
    text_of,
    truth_of,
    value_of,
)

_TEXTS = ("cls", "name", "namespace", "base", "executor", "program", "home", "started", "plugin")


class _Plain:
    """Numbers the objects that nodes refer to, and writes each once."""

    def __init__(self) -> None:
        self.entities: list[Any] = []
        self.callbacks: list[Any] = []
        self.effects: list[Any] = []
        self._seen: dict[int, int] = {}
        self._kept: list[object] = []

    def entity(self, found: Entity | None) -> int | None:
        if found is None:
            return None
        if id(found) not in self._seen:
            self._number(found, self.entities)
            plain = self.entities[self._seen[id(found)]] = {}
            plain |= {
                "kind": found.kind,
                "port": found.port,
                "at": plain_place(found.at),
                "name": found.name,
                "type": found.type,
                "details": list(found.details.items()),
                "callbacks": [[role, self.callback(each)] for role, each in found.callbacks.items()],
                "enabled": found.is_enabled,
                "group": self.entity(found.group),
                "order": found.order,
            }
        return self._seen[id(found)]

    def callback(self, found: CallbackFact | None) -> int | None:
        if found is None:
            return None
        if found.answers:
            raise ValueError("the only answers of a callback are not kept")
        if id(found) not in self._seen:
            self._number(found, self.callbacks)
            plain = self.callbacks[self._seen[id(found)]] = {}
            plain |= {
                "name": found.name,
                "kind": found.kind,
                "at": plain_place(found.at),
                "effects": [self._effect(each) for each in found.effects],
                "body": None if found.body is None else plain_block(found.body, self._effect),
                "flags": [found.is_async, found.is_open, found.is_apart],
            }
        return self._seen[id(found)]

    def _effect(self, found: Effect) -> int:
        if found.path or found.sends or found.given:
            raise ValueError("calls that lead to an effect, and fields of messages, are not kept")
        if id(found) not in self._seen:
            self._number(found, self.effects)
            at = self._seen[id(found)]
            self.effects[at] = [
                *(found.do, found.what, plain_place(found.at), found.when, found.how),
                *(self.entity(found.entity), self.callback(found.then), found.timeout, list(found.holding)),
                *(found.is_repeated, found.order),
            ]
        return self._seen[id(found)]

    def _number(self, found: object, into: list[Any]) -> None:
        self._seen[id(found)] = len(into)
        self._kept.append(found)
        into.append(None)


def to_plain(nodes: list[NodeFact]) -> dict[str, Any]:
    """Return nodes as JSON.

    Raises
    ------
    ValueError
        They refer to an object that JSON cannot represent.
    """
    plain = _Plain()
    shown = [
        {
            **{key: getattr(node, key) for key in _TEXTS},
            "at": plain_place(node.at),
            "threads": node.threads,
            "managed": node.managed,
            "pool": node.pool,
            "spun": node.spun,
            "also_in": node.also_in,
            "others": [[plain_place(at), words] for at, words in node.others],
            "remappings": list(node.remappings.items()),
            "entities": [plain.entity(each) for each in node.entities],
            "callbacks": [plain.callback(each) for each in node.callbacks],
        }
        for node in nodes
    ]
    return {
        "nodes": [{**each, "remappings": [list(pair) for pair in each["remappings"]]} for each in shown],
        "entities": [
            {**each, "details": [list(pair) for pair in each["details"]]} for each in plain.entities
        ],
        "callbacks": plain.callbacks,
        "effects": plain.effects,
    }


def from_plain(plain: Any) -> list[NodeFact]:
    """Return the nodes of JSON.

    Raises
    ------
    ValueError, KeyError, TypeError, IndexError
        It is not a result of `to_plain`.
    """
    entities = [
        Entity(text_of(each["kind"]), text_of(each["port"]), place_of(each["at"]))
        for each in plain["entities"]
    ]
    callbacks = [
        CallbackFact(text_of(each["name"]), text_of(each["kind"]), place_of(each["at"]))
        for each in plain["callbacks"]
    ]
    for entity, said in zip(entities, plain["entities"], strict=True):
        entity.name, entity.type = text_of(said["name"]), text_of(said["type"])
        entity.details = {text_of(key): value_of(value) for key, value in said["details"]}
        entity.callbacks = {text_of(role): item_of(callbacks, each) for role, each in said["callbacks"]}
        entity.is_enabled = truth_of(said["enabled"])
        entity.group = None if said["group"] is None else item_of(entities, said["group"])
        entity.order = number_of(said["order"])
    effects = [_effect(each, entities, callbacks) for each in plain["effects"]]
    for callback, said in zip(callbacks, plain["callbacks"], strict=True):
        callback.is_async, callback.is_open, callback.is_apart = map(truth_of, said["flags"])
        callback.effects = [item_of(effects, each) for each in said["effects"]]
        callback.body = None if said["body"] is None else block_of(said["body"], effects)
    return [_node(each, entities, callbacks) for each in plain["nodes"]]


def _node(said: Any, entities: list[Entity], callbacks: list[CallbackFact]) -> NodeFact:
    node = NodeFact(text_of(said["cls"]), place_of(said["at"]))
    for key in _TEXTS:
        setattr(node, key, text_of(said[key]))
    threads = said["threads"]
    node.threads = threads if isinstance(threads, str) else number_of(threads)
    node.managed, node.pool = truth_of(said["managed"]), number_of(said["pool"])
    node.spun = number_of(said["spun"])
    node.others = [(place_of(at), text_of(words)) for at, words in said["others"]]
    node.also_in = [text_of(each) for each in said["also_in"]]
    node.remappings = {text_of(key): text_of(value) for key, value in said["remappings"]}
    node.entities = [item_of(entities, each) for each in said["entities"]]
    node.callbacks = [item_of(callbacks, each) for each in said["callbacks"]]
    return node


def _effect(said: Any, entities: list[Entity], callbacks: list[CallbackFact]) -> Effect:
    do, what, at, when, how, entity, then, timeout, holding, is_repeated, order = said
    if timeout is not None and (isinstance(timeout, bool) or not isinstance(timeout, (int, float))):
        raise TypeError
    return Effect(
        *(text_of(do), text_of(what), place_of(at), text_of(when), text_of(how)),
        entity=None if entity is None else item_of(entities, entity),
        then=None if then is None else item_of(callbacks, then),
        timeout=timeout,
        holding=tuple(text_of(each) for each in holding),
        is_repeated=truth_of(is_repeated),
        order=number_of(order),
    )
