"""Real programs of the examples, read as source code: what `check` finds is what they do when they run."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from dineros.cli.main import main

PROGRAMS = Path(__file__).resolve().parents[3] / "examples" / "callbacks"
BLOCKS = {
    "same_group": "the default callback group",
    "own_group": "",
    "one_thread": "the only thread",
    "reentrant": "one of the 2 threads",
    "awaiting": "the default callback group",
    "awaiting_own_group": "",
    "answer_one_thread": "the only thread",
    # The program calls again only after the answer, by a flag; data of a node is not in its model, so several
    # answers can come at once there. A finding that the program cannot show.
    "answer_two_threads": "one of the 2 threads",
}


@pytest.mark.long
@pytest.mark.parametrize(("name", "needs"), BLOCKS.items())
def test_programs_block_where_their_code_says_so(tmp_path: Path, name: str, needs: str) -> None:
    folder, model = tmp_path / "src", tmp_path / "robot.sym.xmi"
    folder.mkdir()
    for each in ("battery", "spinning", name):
        shutil.copy(PROGRAMS / f"{each}.py", folder)
    command = ["import", "-q", "--source", str(folder), "-o", str(model)]
    assert CliRunner().invoke(main, command).exit_code == 0
    text = CliRunner().invoke(main, ["check", "-q", str(model)]).stdout
    found = [line for line in text.splitlines() if line.endswith("[callback-deadlock]")]
    assert len(found) == bool(needs) and all(f"needs {needs}" in line for line in found), text
