"""Supervision of real processes."""

from __future__ import annotations

import ctypes
import errno
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest

from dineros.runtime.application.log_files import last_line, rotate
from dineros.runtime.application.supervisor import (
    ProcessEvent,
    ProcessPlan,
    RestartPolicy,
    SupervisionError,
    Supervisor,
)

QUICK = RestartPolicy(restarts=2, window=60, delay=0.01)


def plan(folder: Path, program: str, name: str = "node") -> ProcessPlan:
    return ProcessPlan(
        name,
        [sys.executable, "-c", program],
        dict(os.environ),
        folder / f"{name}.log",
        resume=["--resume"],
        folder=folder,
    )


def poll_until_done(supervisor: Supervisor, seconds: float = 20) -> None:
    deadline = time.monotonic() + seconds
    while supervisor.poll():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def is_there(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def test_what_the_others_work_in_ends_last(tmp_path: Path) -> None:
    slow = "import signal, time; signal.signal(signal.SIGINT, lambda *_: (time.sleep(0.5), exit())); "
    events: list[ProcessEvent] = []
    world = replace(plan(tmp_path, "import time; time.sleep(60)", "world"), is_last=True)
    node = plan(tmp_path, f"{slow}open('ready', 'w'); time.sleep(60)")
    with Supervisor([world, node], QUICK, events.append):
        while not (tmp_path / "ready").exists():
            time.sleep(0.01)
    assert [event.name for event in events if event.event == "stopped"] == ["node", "world"]


def test_a_process_that_ends_by_itself_is_not_started_again(tmp_path: Path) -> None:
    events: list[ProcessEvent] = []
    with Supervisor([plan(tmp_path, "print('done')")], QUICK, events.append) as supervisor:
        poll_until_done(supervisor)
    assert [event.event for event in events] == ["started", "ended"]
    assert (tmp_path / "node.log").read_text() == "done\n"


def test_a_process_that_is_killed_is_started_again_with_the_arguments_to_resume(tmp_path: Path) -> None:
    program = "import sys, time; sys.exit(0) if '--resume' in sys.argv else time.sleep(60)"
    events: list[ProcessEvent] = []
    with Supervisor([plan(tmp_path, program)], QUICK, events.append) as supervisor:
        os.kill(supervisor.processes["node"], signal.SIGKILL)
        poll_until_done(supervisor)
    assert [(event.event, event.status) for event in events] == [
        ("started", None),
        ("failed", -signal.SIGKILL),
        ("restarted", None),
        ("ended", 0),
    ]


def test_a_process_that_fails_too_often_ends_the_application(tmp_path: Path) -> None:
    plans = [
        plan(tmp_path, "import time; time.sleep(60)", "good"),
        plan(tmp_path, "raise SystemExit(3)", "bad"),
    ]
    events: list[ProcessEvent] = []
    with (
        pytest.raises(
            SupervisionError, match=r"bad failed 3 times within 60 s, the last time with exit status 3"
        ),
        Supervisor(plans, QUICK, events.append) as supervisor,
    ):
        good = supervisor.processes["good"]
        poll_until_done(supervisor)
    assert not is_there(good)
    assert [event.event for event in events if event.name == "good"] == ["started", "stopped"]


def test_a_process_that_cannot_start_is_tried_three_times_and_its_error_is_told(tmp_path: Path) -> None:
    """Each time the last line that it has printed is told; older lines of the log are not."""
    program = (
        "import sys, time; print(f'no such hand\\n  at all: {time.time()}', file=sys.stderr); sys.exit(2)"
    )
    events: list[ProcessEvent] = []
    supervisor = Supervisor([plan(tmp_path, program)], RestartPolicy(delay=0.01), events.append)
    with (
        pytest.raises(
            SupervisionError, match=r"node could not be started in 3 attempts: at all: \d.* \(its output is"
        ),
        supervisor,
    ):
        poll_until_done(supervisor)
    assert [event.event for event in events] == [
        "started",
        "failed",
        "restarted",
        "failed",
        "restarted",
        "failed",
    ]
    assert len({event.said for event in events if event.event == "failed"}) == 3
    assert supervisor.restarts == 2


def test_pauses_grow(tmp_path: Path) -> None:
    events: list[ProcessEvent] = []
    supervisor = Supervisor([plan(tmp_path, "raise SystemExit(2)")], RestartPolicy(delay=0.2), events.append)
    with pytest.raises(SupervisionError), supervisor:
        poll_until_done(supervisor)
    times = [event.time for event in events]
    assert times[2] - times[1] >= 0.2
    assert times[4] - times[3] >= 0.4


def test_stopping_kills_what_ignores_every_other_signal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "dineros.runtime.application.supervisor._ENDINGS",
        ((signal.SIGINT, 0.2), (signal.SIGTERM, 0.2), (signal.SIGKILL, 5.0)),
    )
    program = (
        "import signal, time, pathlib\n"
        "for number in (signal.SIGINT, signal.SIGTERM): signal.signal(number, signal.SIG_IGN)\n"
        "pathlib.Path('ready').touch()\n"
        "time.sleep(60)\n"
    )
    events: list[ProcessEvent] = []
    with Supervisor([plan(tmp_path, program)], QUICK, events.append) as supervisor:
        deadline = time.monotonic() + 20
        while not (tmp_path / "ready").exists():
            assert time.monotonic() < deadline
            time.sleep(0.01)
        process = supervisor.processes["node"]
    assert not is_there(process)
    assert events[-1].status == -signal.SIGKILL


def test_ctrl_c_while_stopping_makes_it_stop_sooner(tmp_path: Path) -> None:
    """Two processes ignore what asks them to end; nobody waits for all of the nine seconds."""
    program = (
        "import signal, time, pathlib, sys\n"
        "for number in (signal.SIGINT, signal.SIGTERM): signal.signal(number, signal.SIG_IGN)\n"
        "pathlib.Path(sys.argv[0]).touch()\n"
        "time.sleep(3600)\n"
    )
    plans = [plan(tmp_path, program.replace("sys.argv[0]", repr(name)), name) for name in ("one", "two")]
    supervisor = Supervisor(plans, QUICK).__enter__()
    processes = supervisor.processes.values()
    deadline = time.monotonic() + 20
    while not all((tmp_path / name).exists() for name in ("one", "two")):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    main = threading.main_thread().ident
    assert main is not None
    impatience = [threading.Timer(at, signal.pthread_kill, (main, signal.SIGINT)) for at in (0.3, 1.5)]
    former = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        for timer in impatience:
            timer.start()
        supervisor.stop()
    finally:
        for timer in impatience:
            timer.join()
        signal.signal(signal.SIGINT, former)
    assert not any(map(is_there, processes))


def test_a_program_that_is_not_there_is_an_error_and_nothing_stays(tmp_path: Path) -> None:
    first = plan(tmp_path, "import time; time.sleep(60)", "first")
    second = ProcessPlan("second", [str(tmp_path / "nothing")], {}, tmp_path / "second.log")
    events: list[ProcessEvent] = []
    with pytest.raises(SupervisionError, match="second cannot be started"):
        Supervisor([first, second], QUICK, events.append).__enter__()
    assert [event.event for event in events] == ["started", "stopped"]


def test_processes_end_when_their_supervisor_is_killed(tmp_path: Path) -> None:
    import subprocess

    program = (
        "import os, sys, time\n"
        "from pathlib import Path\n"
        "from dineros.runtime.application.supervisor import ProcessPlan, Supervisor\n"
        "plan = ProcessPlan('node', [sys.executable, '-c', 'import time; time.sleep(60)'], dict(os.environ),"
        " Path('node.log'))\n"
        "with Supervisor([plan]) as supervisor:\n"
        "    print(supervisor.processes['node'], flush=True)\n"
        "    time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, cwd=tmp_path) as parent:
        assert parent.stdout is not None
        process = int(parent.stdout.readline())
        parent.kill()
    deadline = time.monotonic() + 10
    while is_there(process) and "Z" not in Path(f"/proc/{process}/stat").read_text().split()[2]:
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_process_whose_supervisor_is_gone_before_it_begins_ends_at_once() -> None:
    """The system tells only of ends that come later: it looks whether its parent is still that one."""
    for parent, status in (("os.getppid()", 7), ("os.getppid() + 1", 1)):
        program = (
            "import os\n"
            "from dineros.runtime.application.supervisor import _die_with\n"
            f"_die_with({parent})\n"
            "os._exit(7)\n"
        )
        done = subprocess.run([sys.executable, "-P", "-c", program], check=False, timeout=60)
        assert done.returncode == status


def test_what_a_process_prints_comes_before_the_error_that_ends_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PYTHONUNBUFFERED", raising=False)
    program = "print('working')\nraise RuntimeError('too bad')"
    policy = RestartPolicy(restarts=0, window=60, delay=0.01)
    with (
        pytest.raises(SupervisionError, match="RuntimeError: too bad"),
        Supervisor([plan(tmp_path, program)], policy) as supervisor,
    ):
        poll_until_done(supervisor)


def test_the_log_of_a_process_has_a_limited_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process prints without end: its log and the older part stay small, and the last lines are there.

    No line is missing between the two, where the file system can cut off the head of a file. The process
    itself waits until its log is small again, so that the outcome is the same on a busy machine.
    """
    monkeypatch.setattr("dineros.runtime.application.log_files.rotate.__defaults__", (100_000,))
    program = (
        "import os, sys, time\n"
        "end = time.monotonic() + 300\n"
        "for n in range(400_000):\n"
        "    print('line', n, flush=n % 1000 == 0)\n"
        "    while n % 1000 == 0 and os.fstat(1).st_size > 200_000:\n"
        "        if time.monotonic() > end: sys.exit('the log was never shortened')\n"
        "        time.sleep(0.001)\n"
        "sys.exit('too bad')"
    )
    policy = RestartPolicy(restarts=0, window=60, delay=0.01)
    largest = 0
    with (
        pytest.raises(SupervisionError, match="too bad"),
        Supervisor([plan(tmp_path, program)], policy) as supervisor,
    ):
        while supervisor.poll():
            largest = max(largest, *(path.stat().st_size for path in tmp_path.glob("node.log*")))
            time.sleep(0.005)
    older = tmp_path / "node.log.1"
    assert older.stat().st_size <= 100_000
    assert largest < 300_000, "of 5 million bytes that are printed"
    _, *whole, last = older.read_text().splitlines()  # the first may be cut
    assert all(line.startswith("line ") for line in whole)
    assert f"line {last[5:]}".startswith(last), "it may end within a line that is just printed"
    if can_cut(tmp_path / "any"):
        _, *lines, end = (older.read_text() + (tmp_path / "node.log").read_text()).splitlines()
        assert lines == [f"line {n}" for n in range(400_000 - len(lines), 400_000)]
        assert end == "too bad"
    assert sorted(path.name for path in tmp_path.glob("node*")) == ["node.log", "node.log.1"]


def test_other_logs_of_a_process_have_a_limited_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """ROS writes what a node logs a second time, into a file that has a name of its own at every start."""
    monkeypatch.setattr("dineros.runtime.application.log_files.rotate.__defaults__", (100_000,))
    logs = tmp_path / "ros_log"
    logs.mkdir()
    program = (
        "import os, time\n"
        f"log = open({str(logs / 'python_1.log')!r}, 'a')\n"
        "end = time.monotonic() + 300\n"
        "for n in range(40_000):\n"
        "    print('line', n, file=log, flush=n % 1000 == 0)\n"
        "    while n % 1000 == 0 and os.fstat(log.fileno()).st_size > 200_000:\n"
        "        if time.monotonic() > end: raise SystemExit('the log was never shortened')\n"
        "        time.sleep(0.001)\n"
    )
    with Supervisor([plan(tmp_path, program)], QUICK, logs=logs) as supervisor:
        while supervisor.poll():
            time.sleep(0.005)
    assert sorted(path.name for path in logs.iterdir()) == ["python_1.log", "python_1.log.1"]
    assert sum(path.stat().st_size for path in logs.iterdir()) < 300_000


@pytest.mark.parametrize(
    ("older", "log"), [("older\nline\ntoo", " bad\n"), ("older\ntoo bad\n", ""), ("older\n", "too bad\n")]
)
def test_the_last_line_of_a_process_may_be_in_both_parts_of_its_log(
    tmp_path: Path, older: str, log: str
) -> None:
    path = tmp_path / "node.log"
    path.write_text(log)
    path.with_name("node.log.1").write_text(older)
    assert last_line(path, None) == "too bad"
    assert last_line(path, 0) == log.strip(), "a process that began after the rotation did not print the rest"


@pytest.mark.parametrize(
    ("number", "is_rotated"), [(errno.EINTR, False), (errno.ENOMEM, False), (errno.EOPNOTSUPP, True)]
)
def test_a_log_is_not_emptied_if_its_head_cannot_be_cut_off_now(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, is_rotated: bool
) -> None:
    def refuses(*_: int) -> int:
        ctypes.set_errno(number)
        return -1

    monkeypatch.setattr("dineros.runtime.application.log_files._fallocate", refuses)
    log = tmp_path / "node.log"
    log.write_text("line\n" * 10_000)
    assert rotate(log, 20_000) == is_rotated
    assert log.stat().st_size == (0 if is_rotated else 50_000)


def can_cut(path: Path) -> bool:
    """Tell whether the file system removes the head of a file, by a log that is rotated and keeps a rest."""
    path.write_text("line\n" * 20_000)
    assert rotate(path, 50_000)
    rest = path.stat().st_size
    path.unlink()
    path.with_name(f"{path.name}.1").unlink()
    return rest > 0


def test_a_log_is_cut_at_a_block_without_a_gap(tmp_path: Path) -> None:
    if not can_cut(tmp_path / "any"):
        pytest.skip("this file system cannot remove the head of a file")
    path, text = tmp_path / "node.log", "".join(f"line {n}\n" for n in range(20_000))
    path.write_text(text)
    with path.open("a") as writer:
        assert rotate(path, 50_000)
        writer.write("the end")
    kept = (tmp_path / "node.log.1").read_text() + path.read_text()
    assert f"{text}the end".endswith(kept) and kept.startswith("line ")
    assert 50_000 - 10 < len(kept) < 50_000 + 2 * os.statvfs(path).f_bsize


def test_a_log_that_is_a_link_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "other").write_text("x" * 1000)
    (tmp_path / "node.log").symlink_to(tmp_path / "other")
    assert not rotate(tmp_path / "node.log", 10)
    (tmp_path / "node.log").unlink()
    (tmp_path / "node.log").write_text("first\n" + "y" * 1000)
    (tmp_path / "node.log.1").symlink_to(tmp_path / "other")
    assert rotate(tmp_path / "node.log", 10)
    assert (tmp_path / "other").read_text() == "x" * 1000
    assert (tmp_path / "node.log").read_text() == ""
    assert not rotate(tmp_path / "missing.log", 10)


@pytest.mark.parametrize(("status", "said"), [(2, "no such interface"), (0, ""), (1, "")])
def test_a_process_that_cannot_start_says_why_also_while_it_is_stopped(
    tmp_path: Path, status: int, said: str
) -> None:
    program = (
        "import pathlib, signal, sys, time\n"
        f"signal.signal(signal.SIGINT, lambda *_: (print('no such interface'), sys.exit({status})))\n"
        "pathlib.Path('ready').touch()\n"
        "time.sleep(60)\n"
    )
    events: list[ProcessEvent] = []
    with Supervisor([plan(tmp_path, program)], QUICK, events.append):
        deadline = time.monotonic() + 20
        while not (tmp_path / "ready").exists():
            assert time.monotonic() < deadline
            time.sleep(0.01)
    assert (events[-1].event, events[-1].status, events[-1].said) == ("stopped", status, said)
