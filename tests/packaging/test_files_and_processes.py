"""Habits that keep strangers' files out, looked for in all code: opening files, starting processes."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("metamodel", "transformations", "analysis", "generators", "runtime", "sources", "views", "cli")

OTHERWISE_OPENED = {
    "analysis/nets/kernel_cache.py": "our own sources; a temporary file in a folder of our own",
    "analysis/answers/processes.py": "/proc, where no plain file is",
    "analysis/nets/memory.py": "/proc and /sys, where no plain file is",
    "analysis/sweeps/grid.py": "a temporary folder of our own",
    "analysis/tina/questions.py": "a temporary folder of our own",
    "cli/presentation/pictures.py": "a temporary file of our own",
    "cli/failures.py": "/dev/null",
    "metamodel/grammars.py": "our grammars",
    "metamodel/editing/journal.py": "the folder of a journal, to wait for the disk",
    "metamodel/files/atomic.py": "this is how files are written",
    "metamodel/files/confined.py": "this is how folders are opened",
    "metamodel/files/locking.py": "a folder is locked, which is not a file",
    "metamodel/files/reading.py": "this is how files are opened",
    "metamodel/files/whole_folders.py": "a folder of our own is locked, which is not a file",
    "metamodel/generate.py": "our own code",
    "runtime/ros/process/domains.py": "empty files that are locks; links are not followed",
    "runtime/ros/process/memory.py": "shared memory; links are not followed",
    "runtime/ros/wheels.py": "files of the installed ROS 2",
    "views/serving/addresses.py": "the state of the user, readable for nobody else",
    "views/editing/description.py": "our metamodels",
    "views/javascript/modules.py": "our scripts",
    "views/javascript/server.py": "our scripts",
    "views/pages.py": "our scripts and styles",
}
"""Files that do not use `dineros.metamodel.files` for what they open, and what that is."""

_METHODS = {"read_text", "read_bytes", "write_text", "write_bytes"}
_FUNCTIONS = {"os.open", "io.open", "tempfile.mkstemp", "tempfile.NamedTemporaryFile", "open", "mkstemp"}
_MODE = re.compile(r"[rwxa][bt+]*")


def modules() -> Iterator[tuple[str, ast.Module]]:
    """Yield all modules of the rooms."""
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            yield path.relative_to(ROOT).as_posix(), ast.parse(path.read_bytes())


def opens(call: ast.Call) -> bool:
    """Tell whether a call opens a file in a way of its own."""
    name = ast.unparse(call.func)
    if name in _FUNCTIONS:
        return True
    if not isinstance(call.func, ast.Attribute):
        return False
    if call.func.attr in _METHODS:
        return True
    mode = call.args[0] if call.args else None
    return call.func.attr == "open" and (
        (isinstance(mode, ast.Constant) and _MODE.fullmatch(str(mode.value)) is not None)
        or any(keyword.arg in ("encoding", "mode") for keyword in call.keywords)
    )


@pytest.mark.long
def test_files_are_opened_in_one_way() -> None:
    found = {
        path
        for path, module in modules()
        if any(isinstance(node, ast.Call) and opens(node) for node in ast.walk(module))
    }
    # What is new here is opened with open_plain, read_bytes, read_text, read_pieces, write_atomically or in a
    # ConfinedFolder; what is gone is struck off the list.
    assert found == set(OTHERWISE_OPENED)


def test_ways_of_opening_are_found() -> None:
    for text in (
        "open('a')",
        "path.open('rb')",
        "p.read_text()",
        "os.open(p, 0)",
        "p.open(encoding='ascii')",
    ):
        call = ast.parse(text, mode="eval").body
        assert isinstance(call, ast.Call)
        assert opens(call), text
    for text in (
        "node.open()",
        "recorder.open(ports, checkpoint)",
        "read_text(path)",
        "web.open('http://a')",
    ):
        call = ast.parse(text, mode="eval").body
        assert isinstance(call, ast.Call)
        assert not opens(call), text


def test_started_interpreters_do_not_look_into_the_current_folder() -> None:
    """``python -m`` puts the current folder before Python's own modules, ``python -P -m`` does not."""
    places = [*ROOMS, "tools", "docs/hooks", "benchmarks", "case_study"]
    starts = [
        (path.relative_to(ROOT).as_posix(), line.strip())
        for place in places
        for pattern in ("*.py", "*.j2", "*.sh")
        for path in sorted((ROOT / place).rglob(pattern))
        for line in path.read_text(encoding="utf-8").splitlines()
        if re.search(r"""sys\.executable,\s*["']-|python3? -m""", line) and not line.lstrip().startswith("#")
    ]
    assert len(starts) >= 6
    wrong = [(path, line) for path, line in starts if "sys.executable" in line and '"-P"' not in line]
    assert wrong == []
