"""``tools/check-browser`` and ``tools/browser-packages`` on machines with few commands."""

import json
import shutil
from pathlib import Path

import pytest

from tests.packaging.conftest import Machine

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def script(machine: Machine) -> Path:
    """A project of its own, whose `npm` makes the tools and writes down what it was asked."""
    for name in ["cmp", "cp", "mkdir"]:
        (machine.bin / name).symlink_to(shutil.which(name) or "")
    project = machine.home / "project"
    (project / "tools").mkdir(parents=True)
    (project / "package-lock.json").write_text("{}")
    made = "mkdir -p node_modules/.bin"
    for tool in ("biome", "tsc"):
        machine.command(f"made-{tool}", f'echo "{tool} $*" >>{machine.home}/calls')
        made += f"; cp {machine.bin}/made-{tool} node_modules/.bin/{tool}"
    machine.command("npm", f'echo "npm $1" >>{machine.home}/calls; {made}')
    for name in ["browser-packages", "check-browser"]:
        shutil.copy(ROOT / "tools" / name, project / "tools" / name)
    return project / "tools/check-browser"


def test_packages_are_installed_when_the_lock_has_changed(machine: Machine, script: Path) -> None:
    checks = ["biome check --error-on-warnings", "tsc "]
    for _ in range(2):
        assert machine.run(script).returncode == 0
    assert machine.calls == ["npm ci", *checks, *checks]
    (script.parents[1] / "package-lock.json").write_text("{ }")
    assert machine.run(script, "--write").returncode == 0
    assert machine.calls[5:] == ["npm ci", "biome check --error-on-warnings --write", "tsc "]


def test_what_is_wrong_fails(machine: Machine, script: Path) -> None:
    machine.command("made-tsc", "echo wrong; exit 2")
    done = machine.run(script)
    assert (done.returncode, done.stdout) == (2, "wrong\n")


@pytest.mark.parametrize(
    ("npm", "reason"),
    [(None, "npm is not there"), ("exit 1", "npm cannot install what package-lock.json names")],
)
def test_without_packages_one_line_says_so(
    machine: Machine, script: Path, npm: str | None, reason: str
) -> None:
    (machine.bin / "npm").unlink()
    if npm:
        machine.command("npm", npm)
    done = machine.run(script)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"  left out: {reason}\n", "")
    assert machine.run(script, CI="1").returncode == 1


def test_the_lock_names_hashes_and_no_hosts() -> None:
    lock = json.loads((ROOT / "package-lock.json").read_text(encoding="utf-8"))
    packages = [package for path, package in lock["packages"].items() if path]
    assert packages
    assert all("integrity" in package and "resolved" not in package for package in packages)
    own = json.loads((ROOT / "package.json").read_text(encoding="utf-8"))
    assert lock["packages"][""]["devDependencies"] == own["devDependencies"]
    assert "dependencies" not in own, "what ships needs nothing of npm's"
