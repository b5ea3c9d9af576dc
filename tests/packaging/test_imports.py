"""Imports run one way: between rooms, between the folders of a room, and among modules; for types too."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import networkx as nx
import pytest

ROOT = Path(__file__).resolve().parents[2]

ROOMS = {
    "metamodel": set(),
    "transformations": {"metamodel"},
    "analysis": {"metamodel", "transformations"},
    "generators": {"metamodel", "transformations"},
    "runtime": {"metamodel"},
    "sources": {"metamodel"},
    "observation": {"metamodel", "transformations", "analysis", "runtime", "sources"},
    "views": {"metamodel", "analysis", "runtime", "observation"},
    "cli": {
        *("metamodel", "transformations", "analysis", "generators", "runtime", "sources", "observation"),
        "views",
    },
}
"""Which other rooms each room may import; the table of CONTRIBUTING.md."""

FOLDERS = {
    "metamodel": [
        "errors",
        "grammars",
        "json_text",
        "limits",
        "message_ids",
        "ros_names",
        "base",
        *("pn", "sym", "rtm", "pnm", "trace", "generate"),
        "elements",
        "calls",
        "callbacks",
        "lifecycles",
        "matching",
        "times",
        "value_ranges",
        "token_data",
        "positions",
        "colours",
        "clauses",
        "build",
        "files",
        "token_types",
        "guards",
        "records",
        "settings",
        "constraints",
        "editing",
    ],
    "metamodel/files": [
        *(
            "reading",
            "locking",
            "remarks",
            "xml",
            "atomic",
            "confined",
            "whole_folders",
            "watching",
            "exact",
            "schema",
            "toml",
        ),
        *("pnml", "tina", "romeo", "net_formats", "xmi", "programs"),
    ],
    "metamodel/constraints": ["index", "wording", "constraint", "circles", "families", "listing"],
    "generators": ["templates", "application", "workspace"],
    "transformations": ["language", "rules", "flattening", "pictures"],
    "analysis": [
        "answers",
        "nets",
        "walks",
        "reductions",
        "explicit",
        "symbolic",
        "covering",
        "logic",
        "parts",
        "proofs",
        "model",
        "witnesses",
        "acceptance",
        "timed",
        "tina",
        "properties",
        "portfolio",
        "callbacks",
        "questions",
        "latencies",
        "timed_runs",
        "bounds",
        "requirements",
        "checks",
        "timed_checks",
        "suggestions",
        "consequences",
        "evidence",
        "conformance",
        "sweeps",
        "warm_up",
    ],
    "runtime": [
        "connections",
        "scheduling",
        "nets",
        "journal",
        "firing",
        "channels",
        "nodes",
        "application",
        "bridges",
        "ros",
        "typed_handlers",
    ],
    "runtime/ros": [
        "process",
        "conversion",
        "channels",
        "control",
        "metrics",
        "diagnostics",
        "overview",
        "logs",
        "running",
        "managed",
        "node_main",
        "bringup",
        "wheels",
    ],
    "sources": [
        *(
            "folders",
            "unknown_ends",
            "cmake",
            "packages",
            "interfaces",
            "places",
            "variables",
            "facts",
            "resolving",
            "branches",
            "keeping",
            "alternatives",
            "left_out",
            "reading_limits",
            "language",
            "libraries",
            "launch",
            "cpp",
        ),
        *("ros_imports", "programs", "reading"),
    ],
    "sources/programs": ["executables", "callbacks", "running"],
    "sources/launch": [
        *(
            "yaml_text",
            "parameters",
            "python_text",
            "substitutions",
            "started",
            "description",
            "containers",
            "markup",
        ),
        *("reading", "vendors"),
    ],
    "sources/cpp": [
        *(
            "parsing",
            "declarators",
            "tables",
            "macros",
            "entries",
            "index",
            "values",
            "operations",
            "quality",
            "durations",
            "reaching",
            "following",
            "remaining",
        ),
        *("keeping", "binding", "waiting", "interpreting"),
        *("making", "left_out", "calling", "replaced", "programs"),
    ],
    "sources/cpp/calling": ["ports", "spinning", "doing"],
    "sources/cpp/interpreting": [
        *(
            "parameters",
            "naming",
            "groups",
            "holders",
            "lists",
            "deferring",
            "notified",
            "formatting",
            "generated",
            "loading",
            "transforms",
        ),
    ],
    "sources/cpp/following": [
        *(
            "answers",
            "ways",
            "fitting",
            "endings",
            "machine",
            "statics",
            "operators",
            "expressions",
            "assigning",
            "routines",
            "calls",
        ),
        *("fields", "loops", "choices", "constructing", "statements"),
    ],
    "sources/language": [
        *(
            "endings",
            "modules",
            "keeping",
            "order",
            "values",
            "fields",
            "attributes",
            "activities",
            "inner",
            "machine",
            "computing",
            "expressions",
            "importing",
        ),
        *("conditions", "assigning", "running", "instances", "calls"),
    ],
    "sources/language/computing": ["constants", "plain", "operations", "gathering", "names"],
    "sources/language/fields": ["messages", "responses"],
    "sources/language/running": [
        "pacing",
        "matching",
        "asking",
        "progress",
        "polling",
        "carrying",
        "decorating",
        "loops",
        "statements",
    ],
    "sources/libraries/executing": ["unset", "late", "placing", "executors"],
    "observation": [
        *(
            "systems",
            "recordings",
            "tracing",
            "graph",
            "importing",
            "findings",
            "differences",
            "explaining",
            "measuring",
            "narrowing",
        ),
    ],
    "cli": [
        *("failures", "options", "console", "searching", "supervising"),
        *("models", "observing", "coding", "rule_files", "outputs", "quick_start"),
        *("analysing", "running", "presentation", "recordings", "questions"),
        *("commands", "main"),
    ],
    "views": [
        *("policy", "pages", "javascript"),
        *("nets", "traces", "reports", "exports", "serving", "live", "editing"),
    ],
    "views/nets": ["contents", "placement", "differences", "drawing"],
    "analysis/logic": ["language", "automata", "verdicts", "kernels", "graphs", "ltl", "ctl"],
}
"""What stands in a room or in a folder, in order: folders, and modules. Each imports only those before it."""

MOST_MODULES = 15
"""In a folder; more are hard to keep in view."""

PLACES = (*ROOMS, "benchmarks", "case_study", "docs", "examples", "tests", "tools")
"""Where code stands that is written by hand."""


@cache
def modules() -> dict[str, Path]:
    """Return every module of the rooms, without the leading ``dineros.``, and its file."""
    found = {}
    for room in ROOMS:
        for file in sorted((ROOT / room).rglob("*.py")):
            parts = file.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def imported(file: Path) -> Iterator[str]:
    """Yield the modules of ours that a file imports: at its head, inside functions, or for types only."""
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            house, _, module = name.partition(".")
            if house == "dineros":
                yield module if module in modules() else module.rpartition(".")[0]


@cache
def imports() -> list[tuple[str, str]]:
    return [(module, other) for module, file in modules().items() for other in imported(file)]


@pytest.mark.long
def test_rooms_import_only_what_they_may() -> None:
    between = {(module.split(".")[0], other.split(".")[0]) for module, other in imports()}
    wrong = {(room, other) for room, other in between if room != other and other not in ROOMS[room]}
    assert wrong == set()


@pytest.mark.parametrize("place", FOLDERS)
def test_everything_has_its_place_in_the_order(place: str) -> None:
    folders = [file.parent.name for file in (ROOT / place).glob("*/__init__.py")]
    found = [file.stem for file in (ROOT / place).glob("*.py") if file.name != "__init__.py"]
    assert sorted(folders + found) == sorted(FOLDERS[place])


@pytest.mark.parametrize("place", FOLDERS)
def test_folders_import_only_folders_before_them(place: str) -> None:
    above = place.replace("/", ".") + "."
    inside = [
        (module, module.removeprefix(above).split(".")[0], other, other.removeprefix(above).split(".")[0])
        for module, other in imports()
        if module.startswith(above) and other.startswith(above)
    ]
    order = {folder: height for height, folder in enumerate(FOLDERS[place])}
    wrong = [
        f"{module} imports {other}"
        for module, folder, other, folder_of_other in inside
        if order[folder_of_other] > order[folder]
    ]
    assert inside and wrong == []


@pytest.mark.parametrize("room", ROOMS)
def test_no_module_imports_itself_through_others(room: str) -> None:
    inside = [(one, other) for one, other in imports() if one.split(".")[0] == other.split(".")[0] == room]
    circles = nx.strongly_connected_components(nx.DiGraph(inside))
    assert [sorted(circle) for circle in circles if len(circle) > 1] == []


def test_folders_are_small() -> None:
    """Everywhere, in tests and in the pages' code, too; a package's own names are not a module in it."""
    files = [file for place in PLACES for kind in ("*.py", "*.js") for file in (ROOT / place).rglob(kind)]
    sizes = Counter(file.parent for file in files if file.name != "__init__.py")
    assert len(sizes) > 100
    assert {str(folder.relative_to(ROOT)) for folder, size in sizes.items() if size > MOST_MODULES} == set()
