"""Importing modules of faulty rules."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType
from typing import TypeAlias

import pytest

from dineros.transformations.language.errors import RuleError

Faults: TypeAlias = dict[str, tuple[str, str, str]]
"""By name: source, part of the message, part of the hint; the faulty line ends with ``#!``."""

HEADER = """
from dineros.metamodel import pn, pnm, sym
from dineros.transformations.language.creation import Copy, ForAll, Fragment, New, image
from dineros.transformations.language.expressions import Path, Text
from dineros.transformations.language.functions import ancestor, count, either, first, number, position
from dineros.transformations.rules.notation import OverflowQueue, SHEET, arc, inhibit, place, transition
from dineros.transformations.language.patterns import Absent, Context, Index, Made, Node
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules.services import S3, S4
from dineros.transformations.rules.topics import T1, T2, T3
"""

RULE = """
class Watchdog(Rule):
    channel = Node(sym.TopicChannel)
    port = Node(sym.PublisherPort, channel=channel)
    source = Node(pn.Place, of=port.place)
    {}
    lhs = [channel, port, source]
    rhs = [*lhs]
"""
"""A rule with room for a faulty line."""


def import_rules(path: Path) -> ModuleType:
    """Import a module of rules from a file."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def check(fault: tuple[str, str, str], path: Path) -> None:
    """Import a faulty module: it must fail with the message, the hint, the file and the line."""
    source, message, hint = fault
    path.write_text(HEADER + source, encoding="utf-8")
    (line,) = (number for number, text in enumerate(path.read_text().splitlines(), 1) if text.endswith("#!"))

    with pytest.raises(RuleError) as caught:
        import_rules(path)

    error = caught.value
    assert message in error.message
    assert hint in (error.hint or "")
    assert error.location is not None
    assert (error.location.file, error.location.line) == (str(path), line), str(error)
    assert "\n" not in str(error)
