"""Interprets calls of methods of lists, queues and dictionaries."""

from __future__ import annotations

from dineros.sources.language.computing.gathering import put
from dineros.sources.language.machine import Machine
from dineros.sources.language.values import (
    NONE,
    Holder,
    Items,
    Mapping,
    Open,
    Value,
    join,
    key_of,
    of_key,
    options,
)


def of_container(
    machine: Machine, value: Value, name: str, args: list[Value], keys: dict[str, Value]
) -> Value | None:
    """Call a method of a list, a queue or a dictionary; None: it is not one of those that are followed."""
    if isinstance(value, Items):
        if name in ("append", "add", "put", "put_nowait", "appendleft", "insert", "push"):
            value.items.append(args[-1] if args else NONE)
            if machine.activity.conditional or machine.run:
                value.is_open = True
            del value.items[64:]
            return NONE
        if name in ("extend", "update"):
            for each in args:
                for option in options(each):
                    if isinstance(option, Items):
                        value.items += option.items
                        value.is_open |= option.is_open
                    else:
                        value.is_open = True
            return NONE
        if name in ("pop", "popleft", "get", "get_nowait", "popitem"):
            return join(value.items) if value.items else Open("element")
        if name == "copy":
            return Items(list(value.items), value.is_open, value.kind)
        if name in ("remove", "clear", "sort", "reverse", "discard"):
            value.is_open = True
            return NONE
    if isinstance(value, Mapping):
        if name in ("get", "pop", "setdefault"):
            key = key_of(args[0]) if args else None
            if key is not None:
                found = value.items.get(key)
                if found is not None and not value.rest:
                    return found
                if found is None and not value.rest and not value.is_open:
                    default = args[1] if len(args) > 1 else NONE
                    if name == "setdefault":
                        value.items[key] = default
                    return default
                return join([found, *value.rest, *args[1:2]]) if found or value.rest else Open("element")
            every = [*value.items.values(), *value.rest]
            return join(every) if every else Open("element")
        if name == "popitem":
            every = [*value.items.values(), *value.rest]
            return Items([Open("key"), join(every) if every else Open("element")], kind="tuple")
        if name == "items":
            pairs: list[Value] = [
                Items([of_key(key), each], kind="tuple") for key, each in value.items.items()
            ]
            pairs += [Items([Open("key"), each], kind="tuple") for each in value.rest]
            return Items(pairs, value.is_open or bool(value.rest))
        if name == "values":
            return Items([*value.items.values(), *value.rest], value.is_open or bool(value.rest))
        if name == "keys":
            return Items([of_key(key) for key in value.items], value.is_open or bool(value.rest))
        if name == "update":
            for each in args:
                if isinstance(each, Items):
                    for pair in each.items:
                        if isinstance(pair, Items) and len(pair.items) == 2:
                            put(value, *pair.items)
                    value.is_open |= each.is_open
                elif isinstance(each, Mapping):
                    value.items |= each.items
                    value.rest += each.rest
                else:
                    value.is_open = True
            value.items |= keys
            if value.holder is not None:
                for key, each in value.items.items():
                    if isinstance(key, str) and isinstance(value.holder, Holder):
                        machine.write_slot(value.holder, key, each)
            return NONE
    return None
