"""ROS domains that runs on one machine share out among themselves."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.runtime.ros.process.domains import claimed_domain

OTHER = """
import sys
from dineros.runtime.ros.process.domains import claimed_domain
with claimed_domain(7) as domain:
    print(domain, flush=True)
    sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def _claims(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)


def test_no_two_processes_have_the_same_until_one_ends() -> None:
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", OTHER], text=True, **pipes) as other:  # type: ignore[call-overload]
        assert other.stdout.readline() == "7\n"
        with claimed_domain(7) as mine:
            assert mine == 8
        other.kill()
    with claimed_domain(7) as mine:
        assert mine == 7


def test_all_are_given_once_and_domain_0_never() -> None:
    blocks = [claimed_domain(99) for _ in range(101)]
    numbers = [block.__enter__() for block in blocks]
    assert numbers == [99, 100, 101, *range(1, 99)]
    with pytest.raises(DinerosError, match="every ROS domain of this machine is claimed"):
        claimed_domain().__enter__()
    for block in blocks:
        block.__exit__(None, None, None)


def test_links_of_strangers_are_not_followed(tmp_path: Path) -> None:
    aim = tmp_path / "aim"
    (tmp_path / "dineros-ros-domain-7").symlink_to(aim)
    os.mkfifo(tmp_path / "dineros-ros-domain-8")
    with claimed_domain(7) as mine:
        assert mine in (8, 9)
    assert not aim.exists()
