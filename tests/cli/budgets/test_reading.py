"""Files that ask for much are read within limits by each command: it ends in one line, and writes nothing."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from tests.support.broken.small import system as small_system
from tests.support.programs.processes import run_apart

MIB = 1 << 20
SECONDS = 2
#: A process that starts on a busy machine, and is ended within ten per cent of its time.
PATIENCE = 60.0

CONVERT = ("convert", "FILE", "-o", "OUT/net.pnml")
VIEW = ("view", "FILE", "-o", "OUT/net.html")
OF_NETS = [("validate", "FILE"), CONVERT, VIEW, ("view", "FILE")]
OF_SYSTEMS = [
    ("validate", "FILE"),
    ("convert", "FILE", "-o", "OUT/net.xmi"),
    ("flatten", "FILE", "-o", "OUT/net.pnm"),
    ("split", "FILE", "-o", "OUT/parts"),
    ("generate", "FILE", "-o", "OUT/workspace"),
    ("view", "FILE", "-o", "OUT/net.html"),
    ("edit", "FILE", "--no-browser"),
]


@pytest.fixture(scope="module")
def large_net(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a net of TINA of 3 MB: a chain of places and transitions."""
    path = tmp_path_factory.mktemp("large") / "chain.net"
    path.write_text("".join(f"tr t{n} p{n} -> p{n + 1}\n" for n in range(120_000)), encoding="ascii")
    return path


@pytest.fixture(scope="module")
def large_system(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a system model of 12 MB: a node net with very many places."""
    path = tmp_path_factory.mktemp("large") / "large.sym.xmi"
    save(small_system().net, path)
    text = path.read_text(encoding="utf-8")
    begin, name = text.index("<objects "), "large"
    places = "".join(f'<objects xsi:type="sym:Place" id="{name}{n}"/>\n' for n in range(250_000))
    path.write_text(text[:begin] + places + text[begin:], encoding="utf-8")
    return path


def ends_early(folder: Path, command: tuple[str, ...], file: Path, *limits: str, why: str) -> None:
    """Run a command on a file; assert that it ends with one line, in time, and has written nothing."""
    folder.mkdir(exist_ok=True)
    words = [word.replace("FILE", str(file)).replace("OUT", str(folder)) for word in command]
    began = time.monotonic()
    ended = run_apart(*words, *limits)
    assert (ended.exit_code, ended.stdout) == (3, ""), ended
    assert ended.stderr.count("\n") == 1 and f"{why} ran out" in ended.stderr, ended
    assert time.monotonic() - began < PATIENCE
    assert list(folder.iterdir()) == []
    assert [each.name for each in file.parent.iterdir()] == [file.name]


@pytest.mark.long
@pytest.mark.parametrize("command", OF_NETS, ids=lambda words: " ".join(words[:1] + words[2:3]))
def test_a_large_net_takes_no_longer_than_its_time(
    tmp_path: Path, large_net: Path, command: tuple[str, ...]
) -> None:
    ends_early(tmp_path / "out", command, large_net, "--timeout", str(SECONDS), why="time")


@pytest.mark.long
@pytest.mark.parametrize("command", OF_SYSTEMS, ids=lambda words: words[0])
def test_a_large_system_takes_no_longer_than_its_time(
    tmp_path: Path, large_system: Path, command: tuple[str, ...]
) -> None:
    ends_early(tmp_path / "out", command, large_system, "--timeout", str(SECONDS), why="time")


@pytest.mark.long
def test_a_trace_of_a_large_model_takes_no_longer_than_its_time(tmp_path: Path, large_system: Path) -> None:
    small = tmp_path / "small.sym.xmi"
    save(small_system().net, small)
    assert (
        run_apart("run", small, "--simulate", "--timeout", "1", "--trace", tmp_path / "traces").exit_code == 0
    )
    trace = next(iter(sorted((tmp_path / "traces").glob("*.jsonl"))))
    command = ("trace", str(trace), "--model", "FILE")
    ends_early(tmp_path / "out", command, large_system, "--timeout", str(SECONDS), why="time")


@pytest.mark.long
@pytest.mark.parametrize("command", [CONVERT, ("view", "FILE")], ids=lambda words: words[0])
def test_a_large_net_takes_no_more_than_its_memory(
    tmp_path: Path, large_net: Path, command: tuple[str, ...]
) -> None:
    ends_early(tmp_path / "out", command, large_net, "--memory", "330M", why="memory")


def test_a_small_file_is_read_as_ever(tmp_path: Path) -> None:
    small = tmp_path / "small.sym.xmi"
    save(small_system().net, small)
    ended = run_apart("convert", small, "-o", tmp_path / "small.pnml", "--timeout", "60", "--memory", "1G")
    assert (ended.exit_code, ended.stderr) == (0, "") and (tmp_path / "small.pnml").stat().st_size > 0
