"""The workspace of the case study, as its developers keep it next to the model."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

from case_study.generate import main as generate_workspace
from dineros.cli.main import main
from dineros.generators import read_manifest
from dineros.generators.workspace.manifest import PLACE, hash_of
from dineros.runtime.ros.process.environment import ros_environment
from tests.case_study.conftest import ROOT, WORKSPACE, documented_commands, in_fresh_shell
from tests.support.type_checker import strict_mypy

PACKAGES = sorted(path for path in (WORKSPACE / "src").iterdir() if (path / "setup.py").is_file())


def test_it_is_up_to_date() -> None:
    model = ROOT / "case_study/sorting.sym.xmi"
    result = CliRunner().invoke(main, ["generate", str(model), "-o", str(WORKSPACE), "--check"])
    assert (result.exit_code, result.stderr) == (0, "")


@pytest.fixture
def clone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The workspace as it is in the repository, without what is generated."""
    manifest = read_manifest(WORKSPACE)
    assert manifest is not None and len(manifest.generated) == 113
    for path in [PLACE, *manifest.developer]:
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(WORKSPACE / path, tmp_path / path)
    monkeypatch.setattr("case_study.generate.WORKSPACE", tmp_path)
    return tmp_path


def test_what_is_not_kept_is_made_as_the_manifest_says(clone: Path) -> None:
    before = (clone / PLACE).read_bytes()
    assert generate_workspace() == 0
    assert (clone / PLACE).read_bytes() == before
    manifest = read_manifest(clone)
    assert manifest is not None
    for path, hash in manifest.generated.items():
        assert hash_of((clone / path).read_bytes()) == hash
    assert generate_workspace() == 0


def test_nothing_is_made_that_the_manifest_does_not_say(
    clone: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whoever changes a template changes the manifest, too."""
    manifest = (clone / PLACE).read_text(encoding="utf-8")
    text, number = re.subn(r'(runner\.py": ")\w{8}', r"\g<1>00000000", manifest)
    assert number == 1
    (clone / PLACE).write_text(text, encoding="utf-8")
    assert generate_workspace() == 1
    assert capsys.readouterr().err.endswith("generators make now (make regenerate)\n")
    assert not (clone / "src/sorting_interfaces").exists()
    assert generate_workspace(anew=True) == 0
    assert (clone / PLACE).read_text(encoding="utf-8") == manifest


def test_handwritten_and_generated_code_pass_ruff() -> None:
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--line-length", "110"]
    done = subprocess.run(
        [*command, "--select", "E,F,W,B,UP", WORKSPACE], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.long
def test_types_as_its_developers_check_them(tmp_path: Path) -> None:
    """With what `make install` leaves, in the workspace's folder, without any configuration."""
    shutil.copytree(WORKSPACE / "src", tmp_path / "src", ignore=shutil.ignore_patterns("__pycache__"))
    packages = [f"src/{path.name}/{path.name}" for path in PACKAGES]
    assert len(packages) == 8
    assert strict_mypy(tmp_path, *packages) == "Success: no issues found in 43 source files\n"
    # A whole package: its set-up, tests and launch files as well.
    for package in ("sorting_controller", "sorting_bringup"):
        assert strict_mypy(tmp_path, f"src/{package}").startswith("Success: ")
    handlers = tmp_path / "src/sorting_controller/sorting_controller/handlers.py"
    with handlers.open("a", encoding="utf-8") as file:
        file.write("\n\ndef slip(firing: firings.TReportLFiring) -> firings.Outcome:\n")
        file.write('    return {"pickSucces": True}\n')
    said = strict_mypy(tmp_path, "src/sorting_controller/sorting_controller")
    assert 'handlers.py:27: error: Incompatible return value type (got "dict[str, bool]"' in said
    assert said.endswith("Found 1 error in 1 file (checked 6 source files)\n")


def test_what_handlers_need_is_declared() -> None:
    """The executor and the sensorics import the cell, of a package that nobody generated."""
    for name in ("executor", "sensorics"):
        package = ElementTree.parse(WORKSPACE / f"src/sorting_{name}/package.xml").getroot()
        assert "sorting_cell" in [each.text for each in package.iterfind("exec_depend")]


@pytest.mark.long
def test_colcon_builds_and_tests_it_as_its_readme_says(
    workspace: Path, tmp_path: Path, ros_domain: int
) -> None:
    installed = workspace / "install"
    for package in (*(path.name for path in PACKAGES), "sorting_interfaces"):
        share = installed / package / "share"
        assert (share / package / "package.xml").is_file()
        assert (share / "ament_index/resource_index/packages" / package).is_file()
    assert (installed / "sorting_executor/lib/sorting_executor/executor").is_file()
    assert (installed / "sorting_bringup/share/sorting_bringup/launch/sorting.launch.py").is_file()
    assert len([*(installed / "sorting_executor").rglob("node.rtm.xmi")]) == 1

    guide = (ROOT / "docs/generators.md").read_text(encoding="utf-8")
    assert all(f"\n{line}\n" in guide for line in documented_commands())
    commands = [line for line in documented_commands() if line != "colcon build"]
    assert "colcon test && colcon test-result --verbose" in commands
    variables = ros_environment(tmp_path, ros_domain, "memory", {})
    done = in_fresh_shell(commands, workspace, **variables)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.endswith("Summary: 29 tests, 0 errors, 0 failures, 0 skipped\n")
    assert "WARNING" not in done.stderr
