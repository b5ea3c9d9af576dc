"""The workspace of the case study, as its developers keep it beside the model."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from click.testing import CliRunner

from dineros.cli.main import main
from tests.case_study.conftest import WORKSPACE

ROOT = WORKSPACE.parents[1]
PACKAGES = sorted(path for path in (WORKSPACE / "src").iterdir() if (path / "setup.py").is_file())


def test_it_is_up_to_date() -> None:
    model = ROOT / "case_study/sorting.sym.xmi"
    result = CliRunner().invoke(main, ["generate", str(model), "-o", str(WORKSPACE), "--check"])
    assert (result.exit_code, result.stderr) == (0, "")


def test_handwritten_and_generated_code_pass_ruff() -> None:
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--line-length", "110"]
    done = subprocess.run(
        [*command, "--select", "E,F,W,B,UP", WORKSPACE], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


def test_types(tmp_path: Path) -> None:
    """Checked as in an editor: the packages of the workspace find each other; ROS has no types."""
    paths = [ROOT / "build/typed", *PACKAGES]
    environment = {**os.environ, "MYPYPATH": os.pathsep.join(map(str, paths))}
    command = [sys.executable, "-m", "mypy", "--strict", "--allow-untyped-calls", "--no-error-summary"]
    options = ["--namespace-packages", "--explicit-package-bases", "--follow-imports=silent"]
    options += ["--ignore-missing-imports", "--disable-error-code=import-untyped"]
    packages = [word for package in PACKAGES for word in ("-p", package.name)]
    done = subprocess.run(
        [*command, *options, "--cache-dir", str(tmp_path), *packages],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
