"""Workers on this machine: processes that count points, are supervised, and end with the sweep."""

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
"""Maximum number of attempts for a point whose process is killed."""


class PointTimeoutError(Exception):
    """A point exceeded its time-out."""


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
        """Return the answer to the job that was begun.

        Raises
        ------
        PointDiedError
            The process was killed.
        PointTimeoutError
            It exceeded the time-out.
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
        """End the process with its point; the next point starts a new process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
        if self._pipe is not None:
            self._pipe.close()
            self._pipe = None

    def end(self) -> None:
        """End the process from another thread; the waiting thread notices that it has died."""
        process = self._process
        if process is not None:
            process.kill()

    def _running(self) -> Connection:
        if self._pipe is not None and self._process is not None and self._process.poll() is None:
            return self._pipe
        self.kill()
        self._pipe, there = Pipe()
        with there:
            # Not a module run by ``-m``: objects of its classes could not be unpickled elsewhere.
            code = f"from dineros.analysis.sweeps.point import main; main({os.getpid()}, {there.fileno()})"
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", code],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                # Threads of a linear algebra library do not survive a fork.
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
                pass_fds=[there.fileno()],
                process_group=0,  # Ctrl-C is handled by the sweep, which ends its processes
            )
        return self._pipe


class PointProcesses:
    """One process for each thread that requests points at the same time."""

    def __init__(self) -> None:
        self._idle: queue.LifoQueue[PointProcess] = queue.LifoQueue()
        self._all: list[PointProcess] = []
        self._first = threading.Lock()
        self._warm = False
        self._busy: dict[PointProcess, str] = {}
        self._ended: set[str] = set()
        self.closed = False

    def count(self, job: Job) -> Figures:
        """Count a point, and retry if its process is killed; errors are returned in the figures.

        Raises
        ------
        SweepError
            The engines cannot be loaded.
        """
        figures: Figures = self.answer(job)
        return figures

    def answer(self, job: Job | Part) -> Any:
        """Return the answer to a job, or the reason why there is none; raises like `count`."""
        cause, work = "", job.work if isinstance(job, Part) else ""
        for _ in range(ATTEMPTS):
            if self.closed or work in self._ended:
                break
            process = self._take()
            self._busy[process] = work
            try:
                self._start(process, job)
                if work in self._ended:  # ended before there was a process
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
        """End the parts of a work, from another thread; later parts do not begin."""
        self._ended.add(work)
        for process, busy_with in list(self._busy.items()):
            if busy_with == work:
                process.end()

    def _start(self, process: PointProcess, job: Job | Part) -> None:
        if self._warm:
            process.start(job)
            return
        with self._first:  # so that kernels are compiled only once
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
        """End all processes; running points fail. Call it again while threads wait for a process."""
        self.closed = True
        for process in self._all:
            process.end()

    def reap(self) -> None:
        """Remove all processes, when no thread waits for one any more."""
        for process in self._all:
            process.kill()


def local_figures(jobs: Iterable[Job], workers: int) -> Generator[tuple[Job, Figures], None, None]:
    """Count points in processes of this machine; yield each when it is done.

    Parameters
    ----------
    jobs : iterable of Job
        The points.
    workers : int
        Number of points counted in parallel.

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
                processes.close()  # repeatedly: a thread may be starting a process at this moment
            processes.reap()
