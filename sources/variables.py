"""Attributes of objects that decide what callbacks do: their values, and who sets and tests them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from dineros.sources.places import Place

Known = tuple[object, ...]
"""A value of a variable, as `dineros.sources.branches` has them."""


@dataclass(eq=False)
class Variable:
    """An attribute of an object that has few values in the whole program: a flag, mode, handle or None."""

    name: str
    """Of the attribute."""
    at: Place
    """Where it gets its first value."""
    first: Known = ()
    """Its value when the callbacks begin to run."""
    values: tuple[Known, ...] = ()
    """All values that it may have."""
    sets: list[Use] = field(default_factory=list)
    tests: list[Use] = field(default_factory=list)
    """`sets`, `tests`: where callbacks set it, and where they test it."""

    def to_json(self) -> dict[str, Any]:
        """Return the variable in the schema of the facts."""
        return {
            "name": self.name,
            "at": str(self.at),
            "first": shown(self.first),
            "values": [shown(each) for each in self.values],
            "sets": once(each.to_json() for each in self.sets),
            "tests": once(each.to_json() for each in self.tests),
        }


@dataclass(frozen=True)
class Use:
    """A line of a callback that sets a variable to one of some values, or tests it."""

    callback: str
    """Name of the callback."""
    at: Place
    """The line."""
    values: tuple[Known, ...] | None = None
    """The values that it may set; None: any value, or a test."""

    def to_json(self) -> dict[str, Any]:
        """Return the use in the schema of the facts."""
        found: dict[str, Any] = {"callback": self.callback, "at": str(self.at)}
        if self.values is not None:
            found["values"] = [shown(each) for each in self.values]
        return found


def shown(value: Known) -> object:
    """Return a value of a variable as the facts show it: a constant as JSON has it, others in words.

    Examples
    --------
    >>> shown(("const", "bool", True)), shown(("outside", "nav.Mode.IDLE")), shown(("some",))
    (True, 'nav.Mode.IDLE', 'something')
    """
    match value:
        case ("const", _, constant):
            return constant
        case ("some",):
            return "something"
        case ("other",):
            return "another"
    return ".".join(str(each) for each in value[1:])


def once(shown: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return what to show, without duplicates: a helper that is called twice is shown once."""
    found: list[dict[str, Any]] = []
    for each in shown:
        if each not in found:
            found.append(each)
    return found
