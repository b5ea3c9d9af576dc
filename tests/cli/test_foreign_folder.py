"""A folder from somebody else: what stands in it takes no module's place, in any process of any command."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from dineros.generators.workspace.building import missing_tools

SHADOWS = [
    *("resource", "json", "numpy", "logging", "sitecustomize", "usercustomize", "random", "socket", "signal"),
    *("multiprocessing", "encodings", "click", "lxml", "lark", "jinja2", "yaml", "numba", "scipy", "pyarrow"),
    *("matplotlib", "uvicorn", "graphviz", "py_mini_racer", "rclpy", "dineros"),
]

COMMANDS = {
    "validate": ["validate {model}"],
    "check": ["check {model}"],
    "search": ["find {model} --marking Noted>=1 -o witness.jsonl", "trace witness.jsonl -o trace.html"],
    "sweep": ["sweep {model} --vary Words.tokens=1,2 --workers 2 -o out.csv"],
    "generate": ["generate {model} -o workspace"],
    "simulate": [
        "run {model} --simulate --seed 1 --timeout 5 --trace run",
        "conform {model} run",
        "trace run -o run.svg",
    ],
    "local": ["run {model} --local --timeout 0.5"],
    "ros": ["run {model} --timeout 120 --until Words>=3&Noted<1 --reach memory"],
    "convert": ["convert {model} -o model.svg"],
}


@pytest.mark.long
@pytest.mark.parametrize("name", COMMANDS)
def test_modules_of_the_current_folder_are_not_imported(model: Path, tmp_path: Path, name: str) -> None:
    if name == "ros" and missing_tools():
        pytest.skip(f"without {', '.join(missing_tools())}")
    mark = tmp_path / "MARK"
    for shadow in SHADOWS:
        (tmp_path / f"{shadow}.py").write_text(f"open({str(mark)!r}, 'a').write({shadow!r} + ' ')\n")
    for command in COMMANDS[name]:
        words = command.format(model=model.name).split()
        done = subprocess.run(
            [Path(sys.executable).with_name("dineros"), *words],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert done.returncode in (0, 1), done.stderr
        assert not mark.exists(), f"{command}: {mark.read_text()}"
