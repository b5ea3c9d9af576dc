"""Converts the branches of a callback to plain JSON and back, as far as the reader of C++ records them.

An item is a list that begins with its name. Effects are numbers: a branch and a condition refer to the same
effect as the callback.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dineros.sources.branches import (
    Answered,
    Anything,
    Attempt,
    Block,
    Branch,
    Called,
    Condition,
    Do,
    Give,
    Joined,
    Leave,
    Loop,
    Negated,
    Turns,
)
from dineros.sources.facts import Effect, Item
from dineros.sources.keeping.values import item_of, place_of, plain_place, text_of, truth_of
from dineros.sources.variables import Known

Number = Callable[[Effect], int]
"""Returns the number of an effect."""


def plain_block(block: Block, number: Number) -> list[Any]:
    """Return a block as JSON.

    Raises
    ------
    ValueError
        It has an item or a condition that only other languages have.
    """
    return [_plain_item(each, number) for each in block]


def _plain_item(item: Item, number: Number) -> list[Any]:
    def plain(block: Block) -> list[Any]:
        return plain_block(block, number)

    match item:
        case Do():
            return ["do", number(item.effect)]
        case Give():
            return ["give", item.name, _plain_known(item.value), plain_place(item.at)]
        case Branch():
            return [
                "branch",
                _plain_condition(item.condition, number),
                plain(item.then),
                plain(item.otherwise),
            ]
        case Loop():
            return ["loop", _plain_condition(item.condition, number), plain(item.body), item.is_entered]
        case Turns():
            return ["turns", [plain(each) for each in item.turns]]
        case Called():
            return ["called", plain(item.body)]
        case Attempt():
            handlers = [plain(each) for each in item.handlers]
            return ["attempt", plain(item.body), plain(item.otherwise), handlers, plain(item.last)]
        case Leave():
            return ["leave", item.way]
    raise ValueError(f"{type(item).__name__} is not kept")


def _plain_condition(condition: Condition, number: Number) -> list[Any]:
    match condition:
        case Answered():
            call = None if condition.call is None else number(condition.call)
            return [
                *("answered", plain_block(condition.before, number), condition.name, call, condition.starts),
                None if condition.at is None else plain_place(condition.at),
                sorted(map(_plain_known, condition.values), key=repr),
            ]
        case Negated():
            return ["not", _plain_condition(condition.condition, number)]
        case Joined():
            inner = [_plain_condition(each, number) for each in condition.conditions]
            return ["joined", inner, condition.is_or]
    if type(condition) is not Anything:
        raise ValueError(f"{type(condition).__name__} is not kept")
    return ["any", plain_block(condition.before, number)]


def _plain_known(value: Known | None) -> list[object] | None:
    return None if value is None else list(value)


def block_of(plain: Any, effects: list[Effect]) -> Block:
    """Return the block of JSON; `effects` has each effect at its number.

    Raises
    ------
    ValueError, KeyError, TypeError, IndexError
        It is not a result of `plain_block`.
    """
    return [_item(each, effects) for each in _list(plain)]


def _item(plain: Any, effects: list[Effect]) -> Item:
    def block(inner: Any) -> Block:
        return block_of(inner, effects)

    match _list(plain):
        case ["do", number]:
            return Do(item_of(effects, number))
        case ["give", name, value, at]:
            return Give(text_of(name), None if value is None else _known(value), place_of(at))
        case ["branch", condition, then, otherwise]:
            return Branch(_condition(condition, effects), block(then), block(otherwise))
        case ["loop", condition, body, is_entered]:
            return Loop(_condition(condition, effects), block(body), truth_of(is_entered))
        case ["turns", turns]:
            return Turns([block(each) for each in _list(turns)])
        case ["called", body]:
            return Called(block(body))
        case ["attempt", body, otherwise, handlers, last]:
            found = [block(each) for each in _list(handlers)]
            return Attempt(block(body), block(otherwise), found, block(last))
        case ["leave", way]:
            return Leave(text_of(way))
    raise ValueError("an unknown item")


def _condition(plain: Any, effects: list[Effect]) -> Condition:
    match _list(plain):
        case ["answered", before, name, call, starts, at, values]:
            return Answered(
                block_of(before, effects),
                text_of(name),
                None if call is None else item_of(effects, call),
                truth_of(starts),
                None if at is None else place_of(at),
                frozenset(map(_known, _list(values))),
            )
        case ["not", inner]:
            return Negated(_condition(inner, effects))
        case ["joined", inner, is_or]:
            found = [_condition(each, effects) for each in _list(inner)]
            return Joined(found, truth_of(is_or))
        case ["any", before]:
            return Anything(block_of(before, effects))
    raise ValueError("an unknown condition")


def _known(plain: Any) -> Known:
    for each in _list(plain):
        if each is not None and not isinstance(each, (str, int, float, bool)):
            raise TypeError
    return tuple(plain)


def _list(plain: Any) -> list[Any]:
    if not isinstance(plain, list):
        raise TypeError
    return plain
