"""The set-up scripts that the wheels of ROS 2 lack."""

from __future__ import annotations

import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.runtime.ros.wheels import SETUPS, prefix_of_wheels, write_setups

SHELLS = [shell for shell in ("sh", "bash", "zsh") if shutil.which(shell)]


@pytest.fixture
def prefix(tmp_path: Path) -> Path:
    folder = tmp_path / 'it\'s $HOME, a "prefix"'
    folder.mkdir()
    (folder / "pyvenv.cfg").touch()
    return folder


def sourced(shell: str, script: Path, **variables: str) -> dict[str, str]:
    """Return the environment after sourcing a script twice, where errors and unset variables are fatal."""
    done = subprocess.run(
        [shell, "-euc", '. "$1"; . "$1"; env -0', shell, str(script)],
        env={"PATH": "/usr/bin:/bin", **variables},
        check=True,
        capture_output=True,
        text=True,
    )
    assert done.stderr == ""
    return dict(entry.split("=", 1) for entry in done.stdout.split("\0") if entry)


@pytest.mark.parametrize("shell", SHELLS)
def test_each_shell_gets_what_colcon_needs(prefix: Path, shell: str) -> None:
    write_setups(prefix)
    found = sourced(shell, prefix / f"setup.{shell}", AMENT_PREFIX_PATH="/other")
    assert found["PATH"] == f"{prefix}/bin:/usr/bin:/bin"
    assert found["AMENT_PREFIX_PATH"] == f"{prefix}:/other"
    assert found["CMAKE_PREFIX_PATH"] == found["VIRTUAL_ENV"] == str(prefix)
    libraries = sorted(map(str, Path(sysconfig.get_path("purelib")).glob("ros_*.libs")))
    assert found["LD_LIBRARY_PATH"].split(":") == [f"{prefix}/lib", *libraries]
    assert [found[f"ROS_{name}"] for name in ("DISTRO", "VERSION", "PYTHON_VERSION")] == ["jazzy", "2", "3"]
    assert not any("dineros" in name for name in found)


def test_all_scripts_are_written_once(prefix: Path) -> None:
    assert write_setups(prefix) == prefix / "setup.sh"
    written = {path.name: path.stat().st_ino for path in prefix.glob("*setup.*")}
    assert sorted(written) == sorted(SETUPS)
    write_setups(prefix)
    assert {path.name: path.stat().st_ino for path in prefix.glob("*setup.*")} == written
    (prefix / "pyvenv.cfg").unlink()
    assert "VIRTUAL_ENV" not in sourced("sh", write_setups(prefix))


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(DinerosError, match="cannot be written"):
        write_setups(tmp_path / "absent")


@pytest.mark.skipif(prefix_of_wheels() is None, reason="ROS 2 came in another way")
def test_the_module_prints_the_script_of_this_environment() -> None:
    command = [sys.executable, "-P", "-m", "dineros.runtime.ros.wheels"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert done.stdout == f"{sys.prefix}/setup.sh\n"
    assert sourced("sh", Path(done.stdout.strip()))["AMENT_PREFIX_PATH"] == sys.prefix
