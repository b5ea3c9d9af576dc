"""Reads given facts from TOML."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from dineros.metamodel.errors import DinerosError, Location, near_matches
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.files.toml import decode_toml
from dineros.observation.importing.flows.labels import (
    Step,
)
from dineros.observation.importing.given import (
    LIFE,
    ORDERS,
    Given,
    GivenCallback,
    GivenNode,
    GivenService,
    GivenTopic,
    Span,
)

MOST_BYTES = 1 << 20
"""Limit of the bytes of a file of given facts."""


_Channel = TypeVar("_Channel", GivenTopic, GivenService)
_STEP = re.compile(r"(publish|call|send|goal|accepted|cancel|wait|result)\s+(\S+?)(?:\s*([?*]))?")
_PROPERTY = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,99}")
_SLEEP = re.compile(r"sleep\s+(\d{1,8}(?:\.\d{1,9})?)(?:\s*(\?))?")


def given_beside(model: Path) -> Path:
    """Return the path of the file of given facts for a model.

    Examples
    --------
    >>> given_beside(Path("maps/robot.sym.xmi")).as_posix()
    'maps/robot.given.toml'
    """
    return model.with_name(f"{model.name.removesuffix(model.suffix).removesuffix('.sym')}.given.toml")


def read_given(path: Path) -> Given:
    """Read the file of given facts.

    Raises
    ------
    DinerosError
        The file cannot be read, is not TOML, or contains something unknown or of the wrong kind.
    """
    return _Reading(path).given(decode_toml(read_bytes(path, MOST_BYTES), path))


class _Reading:
    """Turns tables of TOML into plain values; every error names the key."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def given(self, found: Mapping[str, Any]) -> Given:
        self._known(found, "", ("node", "topic", "service", "action", "times", "properties"))
        nodes, times = self._table(found, "node", ""), self._table(found, "times", "")
        properties = self._table(found, "properties", "")
        for name in properties:
            if not _PROPERTY.fullmatch(name):
                raise self._wrong(f"properties.{name}", "is not a name", "letters, digits and _")
        self._known(times, "times", ("latency", "takes"))
        return Given(
            {name: self._node(self._table(nodes, name, "node"), f"node.{name}") for name in nodes},
            self._channels(found, "topic", GivenTopic, ("publishers", "subscribers")),
            self._path,
            self._channels(found, "service", GivenService, ("servers", "clients")),
            self._channels(found, "action", GivenService, ()),
            self._span(times, "latency", "times"),
            self._span(times, "takes", "times"),
            {name: self._text(properties, name, "properties") for name in properties},
        )

    def _node(self, table: Mapping[str, Any], at: str) -> GivenNode:
        known = ("threads", "order", "groups", "depths", "newest", "timers", "lifecycle", "callback")
        self._known(table, at, known)
        if "order" in table:
            self._one_of(table, "order", at, ORDERS)
        groups = self._table(table, "groups", at)
        for name in groups:
            self._one_of(groups, name, f"{at}.groups", ("exclusive", "reentrant"))
        depths, timers = self._table(table, "depths", at), self._table(table, "timers", at)
        callbacks, newest = self._table(table, "callback", at), self._table(table, "newest", at)
        for name in newest:
            self._truth(newest, name, f"{at}.newest")
        life = self._texts(table, "lifecycle", at) if "lifecycle" in table else None
        for each in life or ():
            if each not in LIFE:
                raise self._wrong(f"{at}.lifecycle", f"{each!r} is not one of {', '.join(LIFE)}")
        return GivenNode(
            threads=self._number(table, "threads", at, 1, 1000) if "threads" in table else None,
            order=table.get("order"),
            groups=dict(groups),
            depths={name: self._number(depths, name, f"{at}.depths", 0, 1_000_000) for name in depths},
            newest=dict(newest),
            timers=(
                {name: self._seconds(timers, name, f"{at}.timers") for name in timers}
                if "timers" in table
                else None
            ),
            lifecycle=life,
            callbacks={
                name: self._callback(
                    self._table(callbacks, name, f"{at}.callback"), f"{at}.callback.{name}", groups
                )
                for name in callbacks
            },
        )

    def _callback(self, table: Mapping[str, Any], at: str, groups: Mapping[str, Any]) -> GivenCallback:
        known = ("does", "group", "awaits", "takes", "offset", "jitter", "measured", "outstanding")
        self._known(table, at, known)
        group = table.get("group")
        if group is not None:
            self._one_of(table, "group", at, tuple(groups), "is not a callback group of its node")
        awaits = self._truth(table, "awaits", at) if "awaits" in table else False
        takes, offset = self._span(table, "takes", at), self._span(table, "offset", at)
        jitter = self._seconds(table, "jitter", at, least=0) if "jitter" in table else None
        measured = self._text(table, "measured", at) if "measured" in table else ""
        goals = self._number(table, "outstanding", at, 1, 1000) if "outstanding" in table else None
        if "does" not in table:
            return GivenCallback(None, group, awaits, "", takes, jitter, measured, offset, outstanding=goals)
        steps: list[Step] = []
        least, most, sleeps = 0.0, 0.0, False
        for text in self._texts(table, "does", at):
            sleep = _SLEEP.fullmatch(text.strip())
            if sleep is None:
                steps.append(self._step(text, at))
                continue
            sleeps = True
            least += 0.0 if sleep[2] else float(sleep[1])
            most += float(sleep[1])
        if sleeps:  # it also works, for an unknown time, unless it is in `takes`
            end = None if takes is None or takes[1] is None else round(takes[1] + most, 9)
            takes = (round((takes[0] if takes is not None else 0.0) + least, 9), end)
        does = tuple(steps)
        return GivenCallback(does, group, awaits, "", takes, jitter, measured, offset, outstanding=goals)

    def _step(self, text: str, at: str) -> Step:
        match = _STEP.fullmatch(text.strip())
        if match is None:
            raise self._wrong(
                f"{at}.does",
                f"{text!r} is not a step",
                "write it like 'publish /map', 'call /pose ?', 'goal /go *', 'wait /scan', 'sleep 0.5'",
            )
        return Step(match[1], match[2], match[3] or "")

    def _channels(
        self, found: Mapping[str, Any], kind: str, made: Callable[..., _Channel], ends: tuple[str, ...]
    ) -> dict[str, _Channel]:
        """Return the facts given for channels of a kind: latencies, and the nodes of their ends."""
        tables, channels = self._table(found, kind, ""), dict[str, _Channel]()
        for name in tables:
            table, at = self._table(tables, name, kind), f"{kind}.{name}"
            self._known(table, at, (*ends, "latency"))
            given = {end: self._texts(table, end, at) for end in ends if end in table}
            channels[name] = made(**given, latency=self._span(table, "latency", at))
        return channels

    def _known(self, table: Mapping[str, Any], at: str, known: tuple[str, ...]) -> None:
        for key in table:
            if key not in known:
                hint = near_matches(key, known) or f"known are {', '.join(known)}"
                raise self._wrong(f"{at}.{key}".lstrip("."), "is unknown", hint)

    def _table(self, table: Mapping[str, Any], key: str, at: str) -> Mapping[str, Any]:
        found = table.get(key, {})
        if not isinstance(found, dict):
            raise self._wrong(f"{at}.{key}".lstrip("."), "is not a table")
        return found

    def _texts(self, table: Mapping[str, Any], key: str, at: str) -> tuple[str, ...]:
        found = table[key]
        if not isinstance(found, list) or not all(isinstance(each, str) for each in found):
            raise self._wrong(f"{at}.{key}", "is not a list of strings")
        return tuple(found)

    def _truth(self, table: Mapping[str, Any], key: str, at: str) -> bool:
        found = table[key]
        if not isinstance(found, bool):
            raise self._wrong(f"{at}.{key}", "is neither true nor false")
        return found

    def _number(self, table: Mapping[str, Any], key: str, at: str, least: int, most: int) -> int:
        found = table[key]
        if not isinstance(found, int) or isinstance(found, bool) or not least <= found <= most:
            raise self._wrong(f"{at}.{key}", f"is not a whole number from {least} to {most:,}")
        return found

    def _text(self, table: Mapping[str, Any], key: str, at: str) -> str:
        found = table[key]
        if not isinstance(found, str):
            raise self._wrong(f"{at}.{key}", "is not a string")
        return found

    def _seconds(self, table: Mapping[str, Any], key: str, at: str, least: float = 1e-9) -> float:
        found = table[key]
        if not isinstance(found, (int, float)) or isinstance(found, bool) or not least <= found < 1e9:
            raise self._wrong(f"{at}.{key}", f"is not a time in seconds {'above' if least else 'from'} 0")
        return float(found)

    def _span(self, table: Mapping[str, Any], key: str, at: str) -> Span | None:
        if key not in table:
            return None
        found = table[key]
        if (
            not isinstance(found, list)
            or len(found) != 2
            or not all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in found)
            or not 0 <= found[0] <= found[1] < 1e9
        ):
            raise self._wrong(f"{at}.{key}", "is not [LEAST, MOST] in seconds")
        return float(found[0]), float(found[1])

    def _one_of(
        self, table: Mapping[str, Any], key: str, at: str, known: tuple[str, ...], otherwise: str = ""
    ) -> None:
        found = table[key]
        if not isinstance(found, str) or found not in known:
            said = otherwise or f"is not one of {', '.join(known)}"
            raise self._wrong(f"{at}.{key}", f"{found!r} {said}")

    def _wrong(self, key: str, message: str, hint: str | None = None) -> DinerosError:
        return DinerosError(f"{key}: {message}", location=Location(self._path), hint=hint)
