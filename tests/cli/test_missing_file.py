"""A missing model file is reported before engines, formats and metamodels are imported."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("numba", "numpy", "pyecore", "lxml")
PROGRAM = f"""
import sys
from dineros.cli.main import main
try:
    main.main(sys.argv[1:], standalone_mode=True)
finally:
    print([name for name in {HEAVY!r} if name in sys.modules])
"""


@pytest.mark.parametrize(
    ("command", "line"),
    [
        (["check", "none.xmi"], "none.xmi: cannot be read: No such file or directory (check the name)"),
        (["statespace", "none.net"], "none.net: cannot be read: No such file or directory (check the name)"),
        (["check", "none.xm"], "none.xm: '.xm' is not a suffix of a model file (did you mean"),
    ],
)
def test_a_missing_file_costs_no_import(command: list[str], line: str) -> None:
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM, *command], check=False, capture_output=True, text=True, timeout=60
    )
    assert run.returncode == 2
    assert run.stderr.startswith(line)
    assert run.stdout == "[]\n"
