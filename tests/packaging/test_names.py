"""A type name is defined once in a room, so that a search for it finds one meaning."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

import pytest

from tests.packaging.test_imports import ROOMS

ROOT = Path(__file__).resolve().parents[2]

GENERATED = tuple(f"metamodel/{package}/" for package in ("pn", "sym", "rtm", "pnm", "trace"))
"""Folders of generated classes: their names are those of the metamodels."""

STILL_TWICE = {
    "metamodel": frozenset(
        (
            "Comparison",
            "Constant",
            "Declaration",
            "Document",
            "Moves",
            "Not",
            "Record",
            "Signal",
            "Start",
            "Step",
        )
    ),
    "analysis": frozenset(
        (
            "Arcs",
            "Asked",
            "Behaviour",
            "Bound",
            "Comparison",
            "Deadlock",
            "Enabled",
            "Fault",
            "Figures",
            "Goals",
            "Known",
            "Linear",
            "Marking",
            "Markings",
            "NetTables",
            "Outcome",
            "Progress",
            "Property",
            "Question",
            "Queue",
            "Search",
            "Step",
            "Together",
            "Waiting",
            "Walks",
            "Work",
        )
    ),
    "sources": frozenset(
        (
            "Const",
            "Either",
            "Expressions",
            "Frame",
            "Items",
            "Library",
            "Machine",
            "Made",
            "Maker",
            "Open",
            "Port",
            "Statements",
            "TooLong",
            "Value",
        )
    ),
}
"""Names that several modules of a room define until somebody renames them. The list only gets shorter."""


def types_of(source: str) -> set[str]:
    """Return the classes and aliases of types that the top level of a module defines."""
    found: set[str] = set()
    for node in ast.parse(source).body:
        if isinstance(node, ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.AnnAssign) and ast.unparse(node.annotation).endswith("TypeAlias"):
            found.add(ast.unparse(node.target))
    return found


def defined_twice(folder: Path, root: Path) -> dict[str, list[str]]:
    """Return names of types that several modules of a folder define, with these modules."""
    places: dict[str, list[str]] = defaultdict(list)
    for path in sorted(folder.rglob("*.py")):
        name = path.relative_to(root).as_posix()
        if not name.startswith(GENERATED):
            for each in types_of(path.read_text(encoding="utf-8")):
                places[each].append(name)
    return {name: modules for name, modules in places.items() if len(modules) > 1}


@pytest.mark.parametrize("room", ROOMS)
def test_a_type_name_is_defined_once_in_a_room(room: str) -> None:
    twice = defined_twice(ROOT / room, ROOT)
    allowed = STILL_TWICE.get(room, frozenset())
    new = {name: modules for name, modules in twice.items() if name not in allowed}
    assert not new, "give these types a name of their own"
    assert allowed <= twice.keys(), "these names are defined once now: remove them from STILL_TWICE"


def test_a_name_that_two_modules_define_is_found(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    (tmp_path / "one.py").write_text("class Found: ...\nclass Once: ...\ndef f():\n    class Inside: ...\n")
    (tmp_path / "inner" / "two.py").write_text("Found: TypeAlias = int\nclass Inside: ...\n")
    assert defined_twice(tmp_path, tmp_path) == {"Found": ["inner/two.py", "one.py"]}
