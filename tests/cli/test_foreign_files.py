"""Files that options name: pipes and devices are refused, code of a folder takes no module's place."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use

OPTIONS = {
    "trace": ["trace", "{file}"],
    "conform": ["conform", "{model}", "{file}"],
    "tests": ["generate", "{model}", "-o", "{folder}/ws", "--tests", "{file}"],
    "handlers": ["run", "{model}", "--local", "--handlers", "{file}"],
    "rules": ["flatten", "{model}", "-o", "{folder}/flat.xmi", "--rules", "{file}"],
    "model": ["validate", "{file}"],
}
SUFFIXES = {"handlers": ".py", "rules": ".py", "model": ".xmi"}


@pytest.mark.parametrize("kind", ["pipe", "device"])
@pytest.mark.parametrize("option", OPTIONS)
def test_pipes_and_devices_are_refused(run: Run, model: Path, tmp_path: Path, option: str, kind: str) -> None:
    file = tmp_path / f"file{SUFFIXES.get(option, '.jsonl')}"
    if kind == "pipe":
        os.mkfifo(file)
    else:
        file.symlink_to("/dev/zero")
    names = {"file": file, "folder": tmp_path, "model": model}
    result = run(*(part.format(**names) for part in OPTIONS[option]))
    assert is_one_line_of_wrong_use(result, "is not a plain file")


SHADOW = """
import sys
from pathlib import Path
{load}
import colorsys  # nobody needed it so far
assert "theirs" not in vars(colorsys), colorsys.__file__
import neighbour
assert neighbour.value == 3
"""


@pytest.mark.parametrize(
    ("name", "content", "load"),
    [
        (
            "handlers.py",
            "import neighbour\ndef configure(net): pass\n",
            "from dineros.runtime.application.handler_files import load_handler_file as load",
        ),
        (
            "rules.py",
            "import neighbour\nRULES = []\n",
            "from dineros.cli.rule_files import load_rules as load",
        ),
    ],
)
def test_what_stands_beside_a_file_takes_no_module_s_place(
    tmp_path: Path, name: str, content: str, load: str
) -> None:
    (tmp_path / "colorsys.py").write_text("theirs = 1\n")
    (tmp_path / "neighbour.py").write_text(
        "import colorsys\nassert not hasattr(colorsys, 'theirs')\nvalue = 3\n"
    )
    (tmp_path / name).write_text(content)
    program = SHADOW.format(load=f"{load}\nload(Path(sys.argv[1]))")
    subprocess.run([sys.executable, "-P", "-c", program, str(tmp_path / name)], check=True)


@pytest.mark.long
def test_a_sweep_runs_no_code_of_the_current_folder(model: Path, tmp_path: Path) -> None:
    (tmp_path / "resource.py").write_text(f"open({str(tmp_path / 'MARK')!r}, 'w')\n")
    command = [sys.executable, "-P", "-m", "dineros.cli.main", "sweep", model.name]
    options = ["--vary", "Words.tokens=1", "--workers", "1", "-o", "out.csv"]
    subprocess.run([*command, *options], cwd=tmp_path, check=True)
    assert (tmp_path / "out.csv").exists()
    assert not (tmp_path / "MARK").exists()
