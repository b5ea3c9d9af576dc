"""Workers on this machine: processes that count points, watched, started again, and ended with the sweep."""

from __future__ import annotations

import json
import os
import queue
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Generator, Iterable
from contextlib import suppress
from typing import Any

from dineros.analysis.sweeps.grid import SweepError
from dineros.analysis.sweeps.parts import Part
from dineros.analysis.sweeps.point import Figures, Job

ATTEMPTS = 3
"""How often a point is tried whose process is killed."""


class PointDiedError(Exception):
    """The process of a point was killed."""


class PointTimeoutError(Exception):
    """A point took longer than it may."""


class PointProcess:
    """A process that counts one point at a time; see `dineros.analysis.sweeps.point`."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._read = b""

    def start(self, job: Job | Part) -> None:
        """Begin to count a point, or to answer a part; wait until the engines are loaded or compiled.

        Raises
        ------
        PointDiedError
            The process was killed.
        SweepError
            The engines cannot be loaded.
        """
        process = self._running()
        assert process.stdin is not None
        try:
            process.stdin.write(job.to_json().encode() + b"\n")
            process.stdin.flush()
        except OSError as error:
            raise PointDiedError("it ended") from error
        first = self._line(None)
        if "failed" in first:
            raise SweepError(
                f"the engines cannot be loaded: {first['failed']}", hint="pip install 'dineros[analysis]'"
            )

    def finish(self, timeout: float | None) -> Figures:
        """Return the figures of the point that was begun; raises as `answer`."""
        return Figures(**self.answer(timeout))

    def answer(self, timeout: float | None) -> dict[str, Any]:
        """Return what was answered to the job that was begun.

        Raises
        ------
        PointDiedError
            The process was killed.
        PointTimeoutError
            It took longer than it may.
        """
        answer = self._line(timeout)
        if "died" in answer:
            raise PointDiedError(_cause(answer["died"]))
        return answer

    def kill(self) -> None:
        """End the process, and the point in it; the next point starts a new one."""
        process, self._process, self._read = self._process, None, b""
        if process is None:
            return
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with suppress(OSError):  # what was not written yet has no reader
                    stream.close()

    def end(self) -> None:
        """End the process from another thread; the one that waits for it finds it dead."""
        process = self._process
        if process is not None:
            process.kill()

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._process.poll() is None:
            return self._process
        self.kill()
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "dineros.analysis.sweeps.point", str(os.getpid())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            # Threads of a linear algebra library would not survive a fork.
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            process_group=0,  # Ctrl-C is for the sweep, which ends its processes
        )
        return self._process

    def _line(self, timeout: float | None) -> dict[str, Any]:
        assert self._process is not None
        assert self._process.stdout is not None
        descriptor = self._process.stdout.fileno()
        end = None if timeout is None else time.monotonic() + timeout
        while b"\n" not in self._read:
            left = None if end is None else max(end - time.monotonic(), 0)
            if not select.select([descriptor], [], [], left)[0]:
                raise PointTimeoutError
            read = os.read(descriptor, 1 << 16)
            if not read:
                raise PointDiedError(_cause(self._process.wait()))
            self._read += read
        line, _, self._read = self._read.partition(b"\n")
        answer: dict[str, Any] = json.loads(line)
        return answer


def _cause(status: int) -> str:
    if status >= 0:
        return f"it ended with status {status}"
    name = signal.Signals(-status).name if -status in list(signal.Signals) else str(-status)
    return f"it was killed by {name}{', perhaps for want of memory' if -status == signal.SIGKILL else ''}"


class PointProcesses:
    """As many processes as threads ask for points at a time."""

    def __init__(self) -> None:
        self._idle: queue.LifoQueue[PointProcess] = queue.LifoQueue()
        self._all: list[PointProcess] = []
        self._first = threading.Lock()
        self._warm = False
        self._busy: dict[PointProcess, str] = {}
        self._ended: set[str] = set()
        self.closed = False

    def count(self, job: Job) -> Figures:
        """Count a point, again where its process is killed; what goes wrong stands in the figures.

        Raises
        ------
        SweepError
            The engines cannot be loaded.
        """
        return Figures(**self.answer(job))

    def answer(self, job: Job | Part) -> dict[str, Any]:
        """Return what is answered to a job, or an error; raises as `count`."""
        cause, work = "", job.work if isinstance(job, Part) else ""
        for _ in range(ATTEMPTS):
            if self.closed or work in self._ended:
                break
            process = self._take()
            self._busy[process] = work
            try:
                self._start(process, job)
                if work in self._ended:  # while there was no process to end yet
                    process.kill()
                    break
                return process.answer(job.patience if isinstance(job, Part) else job.timeout)
            except PointDiedError as died:
                cause = str(died)
                process.kill()
            except PointTimeoutError:
                process.kill()
                return {"seconds": job.timeout, "error": f"timeout after {job.timeout:g} s"}
            finally:
                del self._busy[process]
                self._idle.put(process)
        return {"error": f"its process died {ATTEMPTS} times: {cause}"}

    def end_work(self, work: str) -> None:
        """End the parts of a work, from another thread; those that come later do not begin."""
        self._ended.add(work)
        for process, busy_with in list(self._busy.items()):
            if busy_with == work:
                process.end()

    def _start(self, process: PointProcess, job: Job | Part) -> None:
        if self._warm:
            process.start(job)
            return
        with self._first:  # kernels that must be compiled are compiled once
            process.start(job)
            self._warm = True

    def _take(self) -> PointProcess:
        try:
            return self._idle.get_nowait()
        except queue.Empty:
            process = PointProcess()
            self._all.append(process)
            return process

    def close(self) -> None:
        """End all processes; points that are being counted fail. Call it again while threads wait for one."""
        self.closed = True
        for process in self._all:
            process.end()

    def reap(self) -> None:
        """Forget all processes, when no thread waits for one any more."""
        for process in self._all:
            process.kill()


def local_figures(jobs: Iterable[Job], workers: int) -> Generator[tuple[Job, Figures], None, None]:
    """Count points by processes of this machine; yield each when it is done.

    Parameters
    ----------
    jobs : iterable of Job
        The points.
    workers : int
        How many are counted at a time.

    Raises
    ------
    SweepError
        The engines cannot be loaded.
    """
    processes = PointProcesses()
    done: queue.Queue[tuple[Job, Figures] | BaseException | None] = queue.Queue()
    waiting, turn = iter(jobs), threading.Lock()

    def work() -> None:
        try:
            while not processes.closed:
                with turn:
                    job = next(waiting, None)
                if job is None:
                    break
                done.put((job, processes.count(job)))
        except BaseException as error:  # is raised in the thread of the sweep
            done.put(error)
        done.put(None)

    threads = [threading.Thread(target=work, name=f"sweep-{number}") for number in range(workers)]
    for thread in threads:
        thread.start()
    try:
        for _ in range(workers):
            while (item := done.get()) is not None:
                if isinstance(item, BaseException):
                    raise item
                yield item
    finally:
        while any(thread.is_alive() for thread in threads):
            processes.close()  # again and again: a thread may be starting one just now
            threads = [thread for thread in threads if thread.is_alive()]
            for thread in threads:
                thread.join(0.2)
        processes.reap()
