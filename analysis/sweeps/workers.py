"""Workers on this machine: processes that count points, watched, started again, and ended with the sweep."""

from __future__ import annotations

import os
import queue
import subprocess
import sys
import threading
from collections.abc import Generator, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed, wait
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

from dineros.analysis.sweeps.parts import Part
from dineros.analysis.sweeps.point import Figures, Job, PointDiedError, unanswered

ATTEMPTS = 3
"""How often a point is tried whose process is killed."""


class PointTimeoutError(Exception):
    """A point took longer than it may."""


class PointProcess:
    """A process that counts one point at a time; see `dineros.analysis.sweeps.point`."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._pipe: Connection | None = None

    def start(self, job: Job | Part) -> None:
        """Begin to count a point, or to answer a part; wait until the engines are loaded or compiled.

        Raises
        ------
        PointDiedError
            The process was killed.
        SweepError
            The engines cannot be loaded.
        """
        pipe = self._running()
        try:
            pipe.send(job)
        except OSError as error:
            raise PointDiedError("it ended") from error
        self.answer(None)

    def answer(self, timeout: float | None) -> Any:
        """Return what was answered to the job that was begun.

        Raises
        ------
        PointDiedError
            The process was killed.
        PointTimeoutError
            It took longer than it may.
        """
        assert self._process is not None
        assert self._pipe is not None
        if not self._pipe.poll(timeout):
            raise PointTimeoutError
        try:
            answer = self._pipe.recv()
        except (EOFError, OSError):
            raise PointDiedError.of(self._process.wait()) from None
        if isinstance(answer, Exception):
            raise answer
        return answer

    def kill(self) -> None:
        """End the process, and the point in it; the next point starts a new one."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
        if self._pipe is not None:
            self._pipe.close()
            self._pipe = None

    def end(self) -> None:
        """End the process from another thread; the one that waits for it finds it dead."""
        process = self._process
        if process is not None:
            process.kill()

    def _running(self) -> Connection:
        if self._pipe is not None and self._process is not None and self._process.poll() is None:
            return self._pipe
        self.kill()
        self._pipe, there = Pipe()
        with there:
            # No module of its own: what such a one makes, no other process could read.
            code = f"from dineros.analysis.sweeps.point import main; main({os.getpid()}, {there.fileno()})"
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", code],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                # Threads of a linear algebra library would not survive a fork.
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
                pass_fds=[there.fileno()],
                process_group=0,  # Ctrl-C is for the sweep, which ends its processes
            )
        return self._pipe


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
        figures: Figures = self.answer(job)
        return figures

    def answer(self, job: Job | Part) -> Any:
        """Return what is answered to a job, or why it has no answer; raises as `count`."""
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
                return unanswered(job, f"timeout after {job.timeout:g} s", seconds=job.timeout)
            finally:
                del self._busy[process]
                self._idle.put(process)
        return unanswered(job, f"its process died {ATTEMPTS} times: {cause}")

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
    with ThreadPoolExecutor(max(1, workers), "sweep") as threads:
        counted = {threads.submit(processes.count, job): job for job in jobs}
        try:
            for figures in as_completed(counted):
                yield counted[figures], figures.result()
        finally:
            for figures in counted:
                figures.cancel()
            while wait(counted, 0.2).not_done:
                processes.close()  # again and again: a thread may be starting one just now
            processes.reap()
