"""Converts the branches of a callback to plain JSON and back, as far as the reader of C++ records them.

An item is a list that begins with its name. Effects are numbers: a branch and a condition refer to the same
effect as the callback.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
from dineros.sources.facts import Effect, Item, Known, Place

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
            return ["give", item.name, _plain_known(item.value), _plain_place(item.at)]
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
                None if condition.at is None else _plain_place(condition.at),
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


def _plain_place(place: Place) -> list[Any]:
    return [place.file, place.line]


def block_of(plain: Any, effects: Sequence[Effect]) -> Block:
    """Return the block of JSON; `effects` has each effect at its number.

    Raises
    ------
    ValueError, KeyError, TypeError, IndexError
        It is not a result of `plain_block`.
    """
    return [_item(each, effects) for each in _checked(plain, list)]


def _item(plain: Any, effects: Sequence[Effect]) -> Item:
    def block(inner: Any) -> Block:
        return block_of(inner, effects)

    match _checked(plain, list):
        case ["do", number]:
            return Do(_effect(number, effects))
        case ["give", name, value, at]:
            return Give(_checked(name, str), None if value is None else _known(value), _place(at))
        case ["branch", condition, then, otherwise]:
            return Branch(_condition(condition, effects), block(then), block(otherwise))
        case ["loop", condition, body, is_entered]:
            return Loop(_condition(condition, effects), block(body), _checked(is_entered, bool))
        case ["turns", turns]:
            return Turns([block(each) for each in _checked(turns, list)])
        case ["called", body]:
            return Called(block(body))
        case ["attempt", body, otherwise, handlers, last]:
            found = [block(each) for each in _checked(handlers, list)]
            return Attempt(block(body), block(otherwise), found, block(last))
        case ["leave", way]:
            return Leave(_checked(way, str))
    raise ValueError("an unknown item")


def _condition(plain: Any, effects: Sequence[Effect]) -> Condition:
    match _checked(plain, list):
        case ["answered", before, name, call, starts, at, values]:
            return Answered(
                block_of(before, effects),
                _checked(name, str),
                None if call is None else _effect(call, effects),
                _checked(starts, bool),
                None if at is None else _place(at),
                frozenset(map(_known, _checked(values, list))),
            )
        case ["not", inner]:
            return Negated(_condition(inner, effects))
        case ["joined", inner, is_or]:
            found = [_condition(each, effects) for each in _checked(inner, list)]
            return Joined(found, _checked(is_or, bool))
        case ["any", before]:
            return Anything(block_of(before, effects))
    raise ValueError("an unknown condition")


def _effect(number: Any, effects: Sequence[Effect]) -> Effect:
    if _checked(number, int) < 0:
        raise IndexError
    found: Effect = effects[number]
    return found


def _known(plain: Any) -> Known:
    for each in _checked(plain, list):
        if each is not None and not isinstance(each, (str, int, float, bool)):
            raise TypeError
    return tuple(plain)


def _place(plain: Any) -> Place:
    file, line = plain
    return Place(_checked(file, str), _checked(line, int))


def _checked(value: Any, kind: type) -> Any:
    if type(value) is not kind:
        raise TypeError
    return value
