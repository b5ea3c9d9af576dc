"""Who watches a run sleeps while nothing happens, and wakes when something does."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from dineros.cli.running import watching
from dineros.cli.running.watching import Options, Running, Wanted, watch
from dineros.metamodel.files import watching as files
from dineros.metamodel.records import Fire, Record, encode_record
from dineros.runtime.application.observer import FolderObserver
from dineros.runtime.application.supervisor import ProcessPlan, RestartPolicy, Supervisor

HOUR = 3600.0

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere, files are looked at all the time")


class Counting(FolderObserver):
    """Counts the looks, and says when the first one is over."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.looks = 0
        self.has_looked = threading.Event()

    def look(self) -> list[Record]:
        found = super().look()
        self.looks += 1
        self.has_looked.set()
        return found


class Idle:
    """Something that runs and never ends."""

    descriptors: tuple[int, ...] = ()
    longest = HOUR

    def poll(self) -> bool:
        return True


def wanted(folder: Path, until: watching.Condition | None = None, timeout: float | None = None) -> Wanted:
    return Wanted(until, folder, None, Options(timeout=timeout))


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let nobody look because time has passed."""
    monkeypatch.setattr(files, "LONGEST", HOUR)
    monkeypatch.setattr("dineros.runtime.application.supervisor._LONGEST", HOUR)


@pytest.fixture
def beside() -> Iterator[Callable[[Callable[[], object]], None]]:
    """Do something on another thread, which is waited for."""
    threads: list[threading.Thread] = []

    def start(action: Callable[[], object]) -> None:
        threads.append(threading.Thread(target=action))
        threads[-1].start()

    yield start
    for thread in threads:
        thread.join()


@pytest.mark.usefixtures("patient")
def test_nothing_is_looked_at_while_nothing_happens(tmp_path: Path) -> None:
    observer = Counting(tmp_path)
    assert watch(wanted(tmp_path, timeout=0.5), observer, Idle()) == "timeout"
    assert observer.looks <= 3  # at the beginning and at the end, where the clock's ticks are coarse


@pytest.mark.usefixtures("patient")
def test_a_record_that_is_written_wakes_who_waits_for_it(
    tmp_path: Path, beside: Callable[[Callable[[], object]], None]
) -> None:
    observer = Counting(tmp_path)

    def write() -> None:
        observer.has_looked.wait()
        with (tmp_path / "arm.jsonl").open("ab") as file:
            for number in (1, 2, 3):
                record = Fire(sequence=number, node="arm", transition="T", change={"Done": 1})
                file.write(encode_record(record).encode() + b"\n")
                file.flush()

    beside(write)
    done = wanted(tmp_path, until=lambda marking, signals: marking.get("Done") == 3)
    assert watch(done, observer, Idle()) == "reached"


@pytest.mark.usefixtures("patient")
def test_what_is_more_than_a_batch_is_taken_in_without_sleep(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dineros.runtime.application.observer.BATCH", 1)
    fired = (Fire(sequence=each, node="arm", transition="T", change={"Done": 1}) for each in range(10_000))
    text = "".join(encode_record(record) + "\n" for record in fired)
    assert len(text) > 3 << 18  # more than three pieces
    (tmp_path / "arm.jsonl").write_text(text)
    observer = Counting(tmp_path)
    done = wanted(tmp_path, until=lambda marking, signals: marking.get("Done") == 10_000)
    assert watch(done, observer, Idle()) == "reached"
    assert observer.looks > 3
    (tmp_path / "second.jsonl").write_text(text)
    assert watching.observe_all(done, observer)
    assert observer.marking["Done"] == 20_000


@pytest.mark.usefixtures("patient")
def test_a_process_that_ends_wakes_who_waits_for_it(tmp_path: Path) -> None:
    """The end of one process and the restart of another that failed, both within an hour's sleep."""
    before = len(list(Path("/proc/self/fd").iterdir()))
    again = "import sys; sys.exit('--resume' not in sys.argv)"
    plans = [
        ProcessPlan(
            name, [sys.executable, "-c", program], dict(os.environ), tmp_path / "logs" / name, ["--resume"]
        )
        for name, program in (("quick", "pass"), ("failing", again))
    ]
    with Supervisor(plans, RestartPolicy(delay=0.01)) as supervisor:
        running: Running = supervisor
        assert watch(wanted(tmp_path), Counting(tmp_path), running) == "ended"
    assert supervisor.restarts == 1
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def test_a_folder_that_comes_later_is_watched_from_then_on(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with files.FolderWatch(folder) as changes:
        assert (changes.descriptors, changes.longest) == ([], files.LONGEST_BLIND)
        folder.mkdir()
        changes.forget()
        assert not files.wait_readable(changes.descriptors, 0)
        (folder / "arm.jsonl").write_text("{")
        (descriptor,) = changes.descriptors
        assert files.wait_readable(changes.descriptors, HOUR) == {descriptor}
        changes.forget()
        assert not files.wait_readable(changes.descriptors, 0)
    assert changes.descriptors == []


def test_traces_that_nobody_waits_for_are_read_calmly(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, beside: Callable[[Callable[[], object]], None]
) -> None:
    """A trace that is written without a pause does not keep the supervisor busy."""
    monkeypatch.setattr(watching, "CALM_PERIOD", HOUR)
    observer, has_ended = Counting(tmp_path), threading.Event()

    def write() -> None:
        while not has_ended.is_set():
            (tmp_path / "arm.jsonl").write_text("")
            time.sleep(0.001)

    beside(write)
    try:
        assert watch(wanted(tmp_path, timeout=0.5), observer, Idle()) == "timeout"
    finally:
        has_ended.set()
    assert observer.looks <= 3


class Dying:
    """Is interrupted in its destructor, where an exception comes to nobody."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.usefixtures("patient")
def test_an_interrupt_at_a_bad_moment_ends_the_run(tmp_path: Path) -> None:
    """Also where nothing else would wake who watches for an hour."""
    long = wanted(tmp_path)
    dying = [Dying()]

    class Losing(Idle):
        def poll(self) -> bool:
            dying.clear()
            return True

    former = signal.signal(signal.SIGINT, long.interrupt)
    try:
        assert watch(long, FolderObserver(tmp_path), Losing()) == "interrupted"
    finally:
        signal.signal(signal.SIGINT, former)
