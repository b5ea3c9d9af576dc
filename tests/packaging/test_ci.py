"""``.ci/run`` on machines made up of a few commands: which Pythons it tests with."""

import shutil
from pathlib import Path

import pytest

from tests.packaging.conftest import Machine

ROOT = Path(__file__).resolve().parents[2]
TEST = "make --no-print-directory -C . thorough"
AGAIN = "PYTEST_ARGS=--last-failed --last-failed-no-failures none -n 0"


@pytest.fixture
def script(machine: Machine) -> Path:
    """A project of its own, whose `make` makes a .venv with Python 3.11 and writes down what it was asked."""
    for name in ["mkdir", "cp", "ln", "mktemp", "ls", "grep"]:
        (machine.bin / name).symlink_to(shutil.which(name) or "")
    project = machine.home / "checkouts/project"
    (project / ".ci").mkdir(parents=True)
    (machine.home / "checkouts/shared").mkdir()
    machine.python("venv-python", "3.11")
    venv = f"mkdir -p .venv/bin; cp {machine.bin}/venv-python .venv/bin/python"
    beside = '[ "${3:-.}" = . ] || ls -d "$3/../shared"'
    machine.command("make", f'echo "make $* (CI=$CI)" >>{machine.home}/calls; {venv}; {beside}')
    machine.command("git", f'echo "git $1 $2 $3" >>{machine.home}/calls; mkdir -p "$4"')
    return Path(shutil.copy(ROOT / ".ci/run", project / ".ci/run"))


def test_both_pythons_are_tested_where_both_are_there(machine: Machine, script: Path) -> None:
    machine.python("python3.12", "3.12")
    (machine.home / "temporary").mkdir()
    done = machine.run(script, TMPDIR=f"{machine.home}/temporary")
    assert done.returncode == 0, done.stderr
    assert machine.calls[:3] == ["make install (CI=1)", f"{TEST} (CI=1)", "git clone --quiet ."]
    assert machine.calls[3].startswith(f"make --no-print-directory -C {machine.home}/temporary/")
    assert machine.calls[3].endswith("/dineros PYTHON=python3.12 LINT=no test (CI=1)")
    assert len(machine.calls) == 4
    assert list((machine.home / "temporary").iterdir()) == [], "the clone is removed"
    assert (script.parents[1] / ".venv").exists(), "the first .venv is not"
    assert (machine.home / "checkouts/shared").exists(), "the link to it is"


def test_a_stand_in_of_pyenv_is_not_a_python(machine: Machine, script: Path) -> None:
    machine.command("python3.12", "echo 'pyenv: python3.12: command not found' >&2; exit 127")
    done = machine.run(script)
    assert done.returncode == 0, done.stderr
    assert machine.calls == ["make install (CI=1)", f"{TEST} (CI=1)"]
    assert done.stdout == "Not tested with Python 3.12: not on this machine\n"


def test_one_that_pyenv_keeps_is_found(machine: Machine, script: Path) -> None:
    machine.command("python3.12", "exit 127")
    kept = machine.home / ".pyenv/versions/3.12.1/bin"
    kept.mkdir(parents=True)
    machine.python("kept", "3.12")
    (machine.bin / "kept").rename(kept / "python3.12")
    assert machine.run(script).returncode == 0
    assert machine.calls[-1].endswith(f"/dineros PYTHON={kept}/python3.12 LINT=no test (CI=1)")


@pytest.mark.parametrize("failing", ["*-C?.?thorough", "*PYTHON*"])
def test_a_failure_of_either_is_one(machine: Machine, script: Path, failing: str) -> None:
    machine.python("python3.12", "3.12")
    make = (machine.bin / "make").read_text()
    (machine.bin / "make").write_text(f'{make}case "$*" in {failing}) exit 2;; esac\n')
    assert machine.run(script).returncode == 2


@pytest.mark.parametrize(
    ("failures", "tries", "status"), [(0, 1, 2), (1, 2, 0), (3, 2, 0), (4, 1, 2)], ids=["lint", "1", "3", "4"]
)
def test_a_second_try(machine: Machine, script: Path, failures: int, tries: int, status: int) -> None:
    """What fails with others next to it is tried alone; what fails in earnest fails again, or in numbers."""
    make = (machine.bin / "make").read_text()
    noted = "\n".join(["{", *[f'  "tests/test_{number}.py::test": true,' for number in range(failures)], "}"])
    failed = script.parents[1] / ".pytest_cache/v/cache/lastfailed"
    failed.parent.mkdir(parents=True)
    failed.write_text("{\n}")  # of a run before this one
    note = f"printf '%s' '{noted}' >{failed}" if failures else "true"
    (machine.bin / "make").write_text(f'{make}case "$*" in *-C?.?thorough) {note}; exit 2;; esac\n')
    assert machine.run(script).returncode == status
    assert machine.calls[1:] == [f"{TEST} (CI=1)", f"{TEST} {AGAIN} (CI=1)"][:tries]


def test_what_fails_alone_fails(machine: Machine, script: Path) -> None:
    make = (machine.bin / "make").read_text()
    failed = script.parents[1] / ".pytest_cache/v/cache/lastfailed"
    failed.parent.mkdir(parents=True)
    note = f"printf '%s' '  \"test\": true' >{failed}"
    (machine.bin / "make").write_text(f'{make}case "$*" in *-C?.?thorough*) {note}; exit 2;; esac\n')
    assert machine.run(script).returncode == 2
    assert len(machine.calls) == 3
