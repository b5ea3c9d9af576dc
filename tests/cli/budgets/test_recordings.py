"""Recordings are read within limits by each command that takes one."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel.files import save
from tests.observation.recordings.test_bombs import ENDLESS, MIB, PACK, chunk, database, filled, mcap
from tests.support.broken.small import system as small_system
from tests.support.programs.processes import run_apart

COMMANDS = [
    ("import", "--bag", "BAG", "-o", "OUT"),
    ("diff", "MODEL", "--bag", "BAG"),
    ("conform", "MODEL", "--bag", "BAG"),
    ("narrow", "MODEL", "--bag", "BAG"),
]
of_each_command = pytest.mark.parametrize("command", COMMANDS, ids=lambda words: words[0])


def _said(folder: Path, command: tuple[str, ...], bag: Path, *limits: str) -> str:
    """Return what a command says that ends without an answer and writes nothing."""
    model = folder / "model.sym.xmi"
    save(small_system().net, model)
    names = {"BAG": bag, "MODEL": model, "OUT": folder / "out.sym.xmi"}
    before = sorted(folder.iterdir())
    ended = run_apart(*(str(names.get(word, word)) for word in command), *limits)
    assert ended.exit_code == 3, ended
    assert "Traceback" not in ended.stderr
    assert sorted(folder.iterdir()) == before
    return ended.stdout + ended.stderr


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of 23 kB that unpacks to 700 MiB."""
    content = filled(700 * MIB)
    path = tmp_path_factory.mktemp("packed") / "a.mcap"
    return mcap(path, chunk(len(content), "zstd", PACK["zstd"](content)))


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording with so many messages that reading them takes some seconds."""
    row = f"INSERT INTO messages {ENDLESS} x, 1, x * 1000000, X'0001000000' FROM c LIMIT 6000000"
    return database(tmp_path_factory.mktemp("long") / "a.db3", row)


@pytest.mark.long
@of_each_command
def test_a_recording_takes_no_more_than_its_memory(
    tmp_path: Path, packed: Path, command: tuple[str, ...]
) -> None:
    limits = ("--limit", "unpacking=1000000", "--memory", "330M")
    assert "memory ran out" in _said(tmp_path, command, packed, *limits)


@pytest.mark.long
@of_each_command
def test_a_recording_takes_no_longer_than_its_time(
    tmp_path: Path, long: Path, command: tuple[str, ...]
) -> None:
    assert "time ran out" in _said(tmp_path, command, long, "--timeout", "1")
