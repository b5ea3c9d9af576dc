"""Nothing is left in shared memory when the last process has ended; nothing is taken from living ones."""

from __future__ import annotations

import fcntl
import json
import mmap
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from dineros.runtime.ros.process.memory import remove_abandoned
from tests.runtime.ros.conftest import PATIENCE, Process, Ros
from tests.runtime.ros.process.shared_memory import FOLDER, Belongings, listing, used_by

EXPECTED = {"expected_subscribers.Letters": 1, "signals.Open": True}
TRACING = "lttng-ust-wait-"
KINDS = [
    r"fastrtps_[0-9a-f]{16}",
    r"fastrtps_[0-9a-f]{16}_el",
    r"fastrtps_port\d+",
    r"fastrtps_port\d+_el",
    r"fastrtps_port\d+_sl",
    r"sem\.fastrtps_port\d+_mutex",
    r"lttng-ust-wait-\d+",
]
SEGMENT = "fastrtps_0123456789abcdef"
PORT = "fastrtps_port7410"


@pytest.fixture
def belongings(ros: Ros) -> Belongings:
    return Belongings(int(ros.environment["ROS_DOMAIN_ID"]))


def one_after_the_other(ros: Ros, house: Process, office: Process) -> list[Process]:
    office.interrupt()
    return [house]


def together(ros: Ros, house: Process, office: Process) -> list[Process]:
    return [house, office]


def one_is_killed(ros: Ros, house: Process, office: Process) -> list[Process]:
    kill(ros, house)
    return [office]


def one_is_restarted(ros: Ros, house: Process, office: Process) -> list[Process]:
    kill(ros, house)
    again = ros.node("house", {"resume": True})
    ros.wait(lambda: len(ros.records("house", "start")) == 2, "the second start")
    return [again, office]


def kill(ros: Ros, process: Process) -> None:
    process.popen.kill()
    process.popen.wait(PATIENCE)
    ros.processes.remove(process)


@pytest.mark.long
@pytest.mark.parametrize("end", [one_after_the_other, together, one_is_killed, one_is_restarted])
def test_nothing_is_left(
    ros: Ros, belongings: Belongings, end: Callable[[Ros, Process, Process], list[Process]]
) -> None:
    house = ros.node("house")
    office = ros.node("office", EXPECTED)
    ros.wait(lambda: len(ros.fired("house", "TRead")) == 3, "reading three letters")
    belongings.look(house.popen.pid, office.popen.pid)
    for kind in KINDS:
        assert any(re.fullmatch(kind, name) for name in belongings.names), kind
    last = end(ros, house, office)
    belongings.look(*(process.popen.pid for process in last))
    for process in last:
        process.popen.send_signal(signal.SIGINT)
    assert [process.popen.wait(PATIENCE) for process in last] == [0] * len(last)
    # A process has LTTng's files mapped to its very end, so that it cannot remove them itself.
    assert {name for name in belongings.left() if not name.startswith(TRACING)} == set()
    remove_abandoned()
    assert belongings.left() == set()


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_dineros_run_leaves_nothing(
    ros: Ros, workspace: Path, belongings: Belongings, number: signal.Signals
) -> None:
    """Whether it is ended by Ctrl-C or by SIGTERM, and although a node was killed and started again."""
    command: list[str | Path] = ["-m", "dineros.cli.main", "run", workspace, "--reach", "memory"]
    command += ["--trace", ros.folder / "run"]
    run = ros.start("run", *command, "--domain", ros.environment["ROS_DOMAIN_ID"], "--timeout", str(PATIENCE))

    def starts(node: str) -> list[int]:
        """Return the processes of a node that have recorded their start."""
        trace, log = ros.folder / f"run/{node}.jsonl", ros.folder / "run/supervisor.log.jsonl"
        events = map(json.loads, log.read_text().splitlines() if log.exists() else [])
        processes = [event["process"] for event in events if (event["name"], event["status"]) == (node, None)]
        return processes[: trace.read_text().count('"event":"start"') if trace.exists() else 0]

    nodes = ("office", "house", "desk", "scale")
    ros.wait(lambda: all(map(starts, nodes)), "the start of all nodes")
    belongings.look(*(starts(node)[0] for node in nodes))
    os.kill(starts("scale")[0], signal.SIGKILL)
    ros.wait(lambda: len(starts("scale")) == 2, "the second start")
    belongings.look(*(starts(node)[-1] for node in nodes))
    run.popen.send_signal(number)
    run.popen.wait(PATIENCE)
    assert not any(Path(f"/proc/{process}").exists() for node in nodes for process in starts(node))
    assert belongings.left() == set()


@pytest.mark.long
def test_nothing_is_taken_from_living_processes(ros: Ros) -> None:
    """Others clean up all the time while nodes start, find each other and talk; then two more start."""
    program = (
        "import time\n"
        "from dineros.runtime.ros.process.memory import remove_abandoned\n"
        "while True:\n"
        "    remove_abandoned()\n"
        "    time.sleep(0.05)  # other tests have their turn as well\n"
    )
    cleaners = [ros.start(f"cleaner{number}", "-c", program) for number in (1, 2)]
    house = ros.node("house")
    office = ros.node("office", EXPECTED)
    ros.wait(lambda: len(ros.fired("house", "TRead")) == 3, "reading three letters")
    used = used_by(house.popen.pid) | used_by(office.popen.pid)
    desk, scale = ros.node("desk"), ros.node("scale")
    ros.wait(lambda: len(ros.records("desk", "response")) == 2, "two responses")
    assert used
    assert used <= listing()
    for cleaner in cleaners:
        kill(ros, cleaner)
    assert [process.interrupt() for process in (desk, scale, office, house)] == [0] * 4


@pytest.fixture
def folder() -> Iterator[Path]:
    """A folder where leases and maps are what they are in shared memory."""
    with tempfile.TemporaryDirectory(dir=FOLDER) as name:
        yield Path(name)


def make(folder: Path, *names: str) -> list[Path]:
    files = [folder / name for name in names]
    for file in files:
        file.write_bytes(bytes(32))
    return files


def test_all_kinds_that_nobody_uses_are_removed(folder: Path) -> None:
    files = make(
        folder,
        PORT,
        f"{PORT}_el",
        f"{PORT}_sl",
        SEGMENT,
        f"{SEGMENT}_el",
        "fastdds_0123456789abcdef",
        "lttng-ust-wait-6",
        "lttng-ust-wait-6-1000",
        f"sem.{PORT}_mutex",
        "sem.fastrtps_port7001_mutex",
        "fastrtps_port7002.unused",
    )
    others = make(folder, "fastrtps_port", "sem.mine", f"{SEGMENT}0", f"my_{SEGMENT}", "psm_12345678")
    assert sorted(remove_abandoned(folder)) == sorted(files)
    assert sorted(folder.iterdir()) == sorted(others)


@pytest.mark.parametrize("flags", [os.O_RDONLY, os.O_RDWR])
@pytest.mark.parametrize("is_mapped", [False, True])
def test_a_port_that_is_used_stays_with_its_guards(folder: Path, flags: int, is_mapped: bool) -> None:
    files = make(folder, PORT, f"{PORT}_el", f"{PORT}_sl", f"sem.{PORT}_mutex")
    descriptor = os.open(files[0], flags)
    if is_mapped:
        access = mmap.ACCESS_WRITE if flags == os.O_RDWR else mmap.ACCESS_READ
        memory = mmap.mmap(descriptor, 32, access=access)
        os.close(descriptor)
    assert remove_abandoned(folder) == []
    assert sorted(folder.iterdir()) == sorted(files)
    if is_mapped:
        memory.close()
    else:
        os.close(descriptor)
    assert sorted(remove_abandoned(folder)) == sorted(files)


def test_a_lock_that_is_held_stays(folder: Path) -> None:
    """The reader of a port that another process has removed has its lock."""
    files = make(folder, f"{PORT}_el", f"sem.{PORT}_mutex")
    with files[0].open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert remove_abandoned(folder) == []
    assert remove_abandoned(folder) == files


def test_a_segment_goes_when_its_owner_is_dead(folder: Path) -> None:
    """Peers that have it mapped keep what they have."""
    segment, lock = make(folder, SEGMENT, f"{SEGMENT}_el")
    with segment.open("r+b") as file, mmap.mmap(file.fileno(), 32) as peer:
        with lock.open():
            assert remove_abandoned(folder) == []
        assert remove_abandoned(folder) == [segment, lock]
        peer[0] = 1


def test_files_of_other_users_stay(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = make(folder, PORT)
    user = os.geteuid() + 1
    monkeypatch.setattr("os.geteuid", lambda: user)
    assert remove_abandoned(folder) == []
    assert list(folder.iterdir()) == files


def test_one_who_opens_a_file_gets_the_file_of_that_name(folder: Path) -> None:
    """Somebody opens a port all the time while we remove it all the time; nobody may be left with a ghost."""
    program = (
        "import os, sys, time\n"
        "path, end, opened, ghosts = sys.argv[1], time.monotonic() + 1.5, 0, 0\n"
        "while time.monotonic() < end:\n"
        "    file = os.open(path, os.O_RDWR | os.O_CREAT)\n"
        "    opened += 1\n"
        "    try:\n"
        "        ghosts += os.stat(path).st_ino != os.fstat(file).st_ino\n"
        "    except FileNotFoundError:\n"
        "        ghosts += 1\n"
        "    os.close(file)\n"
        "    time.sleep(2e-5)\n"
        "print(opened, ghosts)\n"
    )
    command = [sys.executable, "-c", program, str(folder / PORT)]
    removed = 0
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as opener:
        while opener.poll() is None:
            removed += len(remove_abandoned(folder))
        assert opener.stdout is not None
        opened, ghosts = map(int, opener.stdout.read().split())
    assert removed > 100
    assert opened > 100
    # Between finding a name and being registered as user, the opener may lose the processor; without leases
    # it is one in fifty.
    assert ghosts * 1000 <= opened


def test_no_folder_of_shared_memory(tmp_path: Path) -> None:
    assert remove_abandoned(tmp_path / "nothing") == []
