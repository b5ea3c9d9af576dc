"""The locks name everything that is installed, exactly; a file with another hash is refused."""

import hashlib
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tools.lock import SHADOWS_LARK, commands

ROOT = Path(__file__).resolve().parents[2]
SETTINGS: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LOCKS = ["build", "development", "maintenance"]
MACHINES = [
    {"python_version": version[:4], "python_full_version": version, "platform_machine": machine,
     "sys_platform": "linux", "platform_system": "Linux", "platform_python_implementation": "CPython"}
    for version in ("3.11.0", "3.12.1") for machine in ("x86_64", "aarch64")
]  # fmt: skip


def locked(name: str) -> dict[str, tuple[str, Marker | None, list[str]]]:
    """From each distribution in a lock to its version, for which machines, and its hashes."""
    text = (ROOT / f"requirements/{name}.txt").read_text(encoding="utf-8").replace("\\\n", "")
    found: dict[str, tuple[str, Marker | None, list[str]]] = {}
    for line in text.splitlines():
        if not line.startswith("#"):
            wanted, *hashes = line.split(" --hash=")
            requirement = Requirement(wanted)
            (version,) = requirement.specifier
            assert version.operator == "==", line
            found[canonicalize_name(requirement.name)] = (version.version, requirement.marker, hashes)
    return found


@pytest.mark.parametrize("name", LOCKS)
def test_each_line_has_one_version_and_hashes(name: str) -> None:
    lines = locked(name)
    assert lines
    for distribution, (_, _, hashes) in lines.items():
        assert hashes, distribution
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", each.strip()) for each in hashes), distribution


@pytest.mark.parametrize("name", LOCKS)
def test_nothing_says_where_files_come_from(name: str) -> None:
    text = (ROOT / f"requirements/{name}.txt").read_text(encoding="utf-8")
    assert not re.search(r"://|^\s*-[^-]|--(?!hash=)", text, re.MULTILINE)


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: " ".join(list(machine.values())[1:3]))
def test_what_the_project_asks_for_is_locked(machine: dict[str, str]) -> None:
    """A dependency that is new in pyproject.toml, or another version of one, needs `make lock`."""
    lock = locked("development")
    extras = SETTINGS["project"]["optional-dependencies"].values()
    for text in [*SETTINGS["project"]["dependencies"], *(each for extra in extras for each in extra)]:
        wanted = Requirement(text)
        if wanted.name == "dineros" or (wanted.marker and not wanted.marker.evaluate(machine)):
            continue
        version, marker, _ = lock[canonicalize_name(wanted.name)]
        assert wanted.specifier.contains(version, prereleases=True), text
        assert marker is None or marker.evaluate(machine), text


def test_what_builds_is_locked() -> None:
    build = locked("build")
    for text in ["pip", *SETTINGS["build-system"]["requires"]]:
        wanted = Requirement(text)
        assert wanted.specifier.contains(build[wanted.name][0])
    assert build["setuptools"] == locked("development")["setuptools"], "one would replace the other"


def test_old_lark_is_not_installed() -> None:
    """It writes over the files of lark, whichever comes last."""
    development = locked("development")
    assert SHADOWS_LARK not in development
    assert "lark" in development
    for command in commands("uv", "build.in", upgrade=False).values():
        assert command[command.index("--no-emit-package") + 1] == SHADOWS_LARK


def test_versions_change_when_asked_only() -> None:
    assert not any("--upgrade" in command for command in commands("uv", "build.in", upgrade=False).values())
    assert all("--upgrade" in command for command in commands("uv", "build.in", upgrade=True).values())


def test_a_file_with_another_hash_is_refused(tmp_path: Path) -> None:
    """The mechanism of tools/install, with a distribution made here."""
    wheel = tmp_path / "harmless-1.0-py3-none-any.whl"
    info = "harmless-1.0.dist-info"
    with ZipFile(wheel, "w") as archive:
        archive.writestr("harmless.py", "")
        archive.writestr(f"{info}/METADATA", "Metadata-Version: 2.1\nName: harmless\nVersion: 1.0\n")
        archive.writestr(f"{info}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        archive.writestr(f"{info}/RECORD", "")
    lock = tmp_path / "lock.txt"
    lock.write_text(f"harmless==1.0 --hash=sha256:{hashlib.sha256(wheel.read_bytes()).hexdigest()}\n")
    script = (ROOT / "tools/install").read_text()
    (options,) = set(re.findall(r"install (--require-hashes --no-deps)", script))
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--no-index"]
    command = [*pip, "--find-links", tmp_path, "--dry-run", *options.split(), "--requirement", lock]
    assert subprocess.run(command, check=False, capture_output=True, timeout=60).returncode == 0
    with ZipFile(wheel, "a") as archive:
        archive.writestr("harmful.py", "")
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "THESE PACKAGES DO NOT MATCH THE HASHES" in done.stderr
