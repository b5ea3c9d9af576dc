"""Options of the command line, as ``argparse`` reads them: their defaults, or what a launch file gives."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.sources.language.machine import Machine
from dineros.sources.language.values import (
    NONE,
    Const,
    Items,
    Made,
    Mapping,
    Open,
    Value,
    constant,
    is_none,
    text_of,
)

PARSER = "argparse.ArgumentParser"
_FLAGS = {"store_true": False, "store_false": True}
"""Actions of flags, with what the option is without an argument."""
_KEPT = "the options"


def call_parser(
    machine: Machine, parser: Made, name: str, args: list[Value], keys: dict[str, Value], given: Sequence[str]
) -> Value | None:
    """Call a method of a parser; None: it does nothing to its options.

    An option has the default of the program, as a setting that can be changed.

    Parameters
    ----------
    machine : Machine
        The interpreter.
    name : str
        The method.
    args, keys : list of Value, dict of str to Value
        Its arguments.
    given : sequence of str
        Arguments that a launch file gives to the program.
    """
    if name in ("add_argument_group", "add_mutually_exclusive_group"):
        return parser
    if name == "add_argument":
        known = _options(machine, parser)
        option = _option(args, keys)
        if option is None or machine.activity.loops:
            known.is_open = True
        else:
            dest, value = option
            known.items[dest] = Open(f"option {dest}") if machine.activity.conditional else value
            known.rest.append(Items([Const(dest), Const(_kind(keys)), *args]))
        return Open("an option")
    if name == "set_defaults":
        for dest, value in keys.items():
            _options(machine, parser).items[dest] = _setting(value, dest)
        return NONE
    if name in ("parse_args", "parse_known_args"):
        found = Made("argparse.Namespace", [], {}, parser.at)
        for dest, value in _values(_options(machine, parser), args, keys, given).items():
            machine.write_slot(found, dest, value)
        return found if name == "parse_args" else Items([found, Open("other arguments")], kind="tuple")
    if name in ("add_subparsers", "add_parser"):
        _options(machine, parser).is_open = True
    return None


def _options(machine: Machine, parser: Made) -> Mapping:
    """Return the values of the options of a parser, by name; `rest` has the text of each."""
    slot = parser.slots.get(_KEPT)
    if slot is None:
        machine.write_slot(parser, _KEPT, Mapping())
        slot = parser.slots[_KEPT]
    assert isinstance(slot.current, Mapping)
    return slot.current


def _option(args: list[Value], keys: dict[str, Value]) -> tuple[str, Value] | None:
    """Return the name of an option and its value without arguments; None: the program computes the name."""
    names = [constant(each) for each in args]
    if not names or not all(isinstance(each, str) and each for each in names):
        return None
    long = next((each for each in names if each.startswith("--")), names[0])
    dest = constant(keys.get("dest")) or long.lstrip("-").replace("-", "_")
    action, default = constant(keys.get("action")), keys.get("default")
    if not isinstance(dest, str):
        return None
    if default is None and action in _FLAGS:
        return dest, Const(_FLAGS[action], f"option {dest}")
    is_asked = not long.startswith("-") and constant(keys.get("nargs")) not in ("?", "*")
    if is_asked or constant(keys.get("required")) is True or action not in (None, "store", *_FLAGS):
        return dest, Open(f"option {dest}")
    return dest, _setting(default if default is not None else NONE, dest)


def _kind(keys: dict[str, Value]) -> str:
    """Return what an argument does with an option: sets a flag, gives a text, or something else."""
    action = constant(keys.get("action")) or "store"
    is_text = action == "store" and {"type", "nargs", "const"}.isdisjoint(keys)
    return action if action in _FLAGS else "text" if is_text else "other"


def _setting(value: Value, dest: str) -> Value:
    if isinstance(value, Const):
        return Const(value.value, f"option {dest}")
    return Open(f"option {dest}") if is_none(value) else value


def _values(
    known: Mapping, args: list[Value], keys: dict[str, Value], given: Sequence[str]
) -> dict[str, Value]:
    """Return the values of options; those that arguments may change in another way are open."""
    wanted = args[0] if args else keys.get("args")
    values = dict(known.items)
    if isinstance(wanted, Items) and not wanted.is_open:
        given = [text_of(each) for each in wanted.items]
    if not given:
        return values
    written: dict[str, tuple[str, str]] = {}
    for each in known.rest:
        if isinstance(each, Items):
            first, second, *names = each.items
            written |= {text_of(name): (text_of(first), text_of(second)) for name in names}
    words = list(given)
    while words:
        word, has_value, value = words.pop(0).partition("=")
        dest, kind = written.get(word, ("", "other"))
        if kind == "other":
            return {dest: Open(f"option {dest}") for dest in values}
        if kind == "text" and (has_value or words):
            values[dest] = Const(value if has_value else words.pop(0), f"option {dest}")
        elif kind in _FLAGS:
            values[dest] = Const(kind == "store_true", f"option {dest}")
    return values
