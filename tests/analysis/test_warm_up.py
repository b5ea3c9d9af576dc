"""The warm-up compiles every kernel that is called, as it is called."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

from dineros import analysis
from dineros.analysis.explicit.layout import layout
from dineros.analysis.explicit.search import LARGEST_SPECIAL_WIDTH
from dineros.analysis.warm_up import PARTS, rings

ROOM = Path(analysis.__file__).resolve().parent

RUN = """
import json, sys
from importlib import import_module
from numba.core import event
from numba.core.dispatcher import Dispatcher
from dineros.analysis.warm_up import PARTS

for part in PARTS.values():
    part()
kernels = {}
for module in json.loads(sys.argv[1]):
    for name, value in vars(import_module(module)).items():
        if isinstance(value, Dispatcher) and value.py_func.__module__ == module:
            kernels[f"{module}.{name}"] = len(value.overloads)
print(json.dumps(kernels))
"""


def kernel_modules() -> list[str]:
    files = sorted(ROOM.glob("**/kernels/*.py"))
    return [
        ".".join(["dineros.analysis", *file.relative_to(ROOM).with_suffix("").parts])
        for file in files
        if file.stem != "__init__"
    ]


def called_from_python() -> set[str]:
    """Return the names, such as ``....kernels.force.centre``, that other modules than kernels' use."""
    found = set()
    for file in ROOM.rglob("*.py"):
        is_kernel = file.parent.name == "kernels"
        tree = ast.parse(file.read_bytes())
        modules = {}
        for node in ast.walk(tree):
            if is_kernel and isinstance(node, ast.FunctionDef) and not node.decorator_list:
                # A plain function beside kernels is Python too.
                module = ".".join(["dineros.analysis", *file.relative_to(ROOM).with_suffix("").parts])
                found |= {f"{module}.{name.id}" for name in ast.walk(node) if isinstance(name, ast.Name)}
            if is_kernel or not isinstance(node, ast.ImportFrom) or ".kernels" not in (node.module or ""):
                continue
            for alias in node.names:
                found.add(f"{node.module}.{alias.name}")
                modules[alias.asname or alias.name] = f"{node.module}.{alias.name}"
        found |= {
            f"{modules[node.value.id]}.{node.attr}"
            for node in ast.walk(tree)
            if isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and node.value.id in modules
        }
    return found


@pytest.fixture(scope="module")
def compiled() -> dict[str, int]:
    command = [sys.executable, "-c", RUN, json.dumps(kernel_modules())]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    counts: dict[str, int] = json.loads(run.stdout)
    return counts


@pytest.mark.long
def test_every_kernel_that_python_calls_is_compiled(compiled: dict[str, int]) -> None:
    called = called_from_python() & compiled.keys()
    assert len(called) > 25
    assert [name for name in sorted(called) if compiled[name] == 0] == []


@pytest.mark.long
def test_each_is_compiled_once_but_for_the_width_of_markings(compiled: dict[str, int]) -> None:
    widths = LARGEST_SPECIAL_WIDTH + 1
    several = {name.rpartition(".kernels.")[2]: count for name, count in compiled.items() if count > 1}
    assert several.keys() <= {
        "expansion.expand",
        "descent.descend",
        "markings.rebuild",
        "markings.insert_all",
    }
    assert set(several.values()) <= {widths}


def test_searches_are_as_wide_as_kernels_are_special() -> None:
    words = [layout(rings(part.args[0])).words for name, part in PARTS.items() if hasattr(part, "args")]
    assert sorted(words)[:LARGEST_SPECIAL_WIDTH] == list(range(1, LARGEST_SPECIAL_WIDTH + 1))
    assert max(words) > LARGEST_SPECIAL_WIDTH
