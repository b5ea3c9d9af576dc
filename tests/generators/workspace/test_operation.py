"""What keeps a workspace running: a unit of systemd and a Containerfile, on request."""

from __future__ import annotations

import configparser
import json
import re
import shutil
import subprocess
from pathlib import Path

from dineros.generators import Options, generate
from tests.support.systems.talker import talker

UNIT = "src/greeting_bringup/systemd/greeting_bringup.service"


def made(folder: Path, **options: bool | None) -> Path:
    generate(talker(), folder, Options(source="greeting.sym.xmi", **options))  # type: ignore[arg-type]
    return folder


def test_they_are_there_when_asked_for_and_remembered(tmp_path: Path) -> None:
    places = [tmp_path / UNIT, tmp_path / "Containerfile"]
    made(tmp_path)
    assert [place.exists() for place in places] == [False, False]
    assert "systemd" not in (tmp_path / "src/greeting_bringup/setup.py").read_text()
    made(tmp_path, systemd=True, container=True)
    assert [place.exists() for place in places] == [True, True]
    made(tmp_path)
    assert [place.exists() for place in places] == [True, True]
    made(tmp_path, systemd=False, container=False)
    assert [place.exists() for place in places] == [False, False]


def test_the_unit_is_one_and_starts_the_runner(tmp_path: Path) -> None:
    """What it says to the shell is run, with stand-ins for what it sources and starts."""
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read_string((made(tmp_path, systemd=True) / UNIT).read_text())
    command = re.fullmatch(r"/bin/sh -c '(.*)'", unit["Service"]["ExecStart"])
    assert command
    (tmp_path / "setup.sh").write_text("set_up=yes\n")
    script = command[1].replace("/opt/greeting_bringup/local_setup.sh", str(tmp_path / "setup.sh"))
    environment = {
        "DINEROS_SETUP": str(tmp_path / "setup.sh"),
        "DINEROS_PYTHON": "echo",
        "PATH": "/usr/bin:/bin",
    }
    done = subprocess.run(
        ["/bin/sh", "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == "-P -m greeting_bringup.runner --journal %S/greeting_bringup\n"
    setup = (tmp_path / "src/greeting_bringup/setup.py").read_text()
    assert 'files("systemd/*.service")' in setup
    if verify := shutil.which("systemd-analyze"):
        done = subprocess.run(
            [verify, "verify", tmp_path / UNIT], capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, "")


def test_what_the_container_copies_and_starts_is_there(tmp_path: Path) -> None:
    text = (made(tmp_path, container=True) / "Containerfile").read_text()
    copied = re.findall(r"^COPY (\S+) \S+$", text, re.MULTILINE)
    assert copied == ["wheel[s]", "src"]  # a pattern that may match nothing
    assert (tmp_path / "src").is_dir()
    for script in re.findall(r"^RUN ((?:.*\\\n)*.*)$", text, re.MULTILINE):
        subprocess.run(["sh", "-n", "-c", script], check=True)
    (start,) = re.findall(r"^ENTRYPOINT (.*)$", text, re.MULTILINE)
    shell, option, script, name = json.loads(start)
    assert (shell, option, name) == ("/bin/sh", "-c", "runner")
    assert script.endswith('exec /opt/dineros/bin/python -P -m greeting_bringup.runner "$@"')
    assert (tmp_path / "src/greeting_bringup/greeting_bringup/runner.py").is_file()
