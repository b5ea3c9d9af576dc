"""Starting the processes of an application, restarting those that die, and ending all of them.

The policy is that of OTP's supervisors: a process that ends by itself with status 0 is done; one that fails
is started again after a delay that doubles, unless it failed too often within a while (Erlang/OTP design
principles, "Supervisor Behaviour"). One that says that it cannot start, by status 2, is tried three times.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Literal

from dineros.metamodel.errors import DinerosError
from dineros.runtime.application.line import new_line
from dineros.runtime.application.log_files import last_line, open_log, rotate
from dineros.runtime.nodes.health import RESTARTS

CANNOT_START = 2
"""Exit status by which a process says that it cannot start: its handlers or parameters are wrong, say."""

_LONGEST = 1.0
_LONGEST_BLIND = 0.05
_PARENT_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl(2)
_SYSTEM = ctypes.CDLL(None)
"""Loaded before any thread is there: to load it takes a lock, which nobody would give back after a fork."""
_Event = Literal["started", "restarted", "ended", "failed", "stopped"]
_ENDINGS = ((signal.SIGINT, 6.0), (signal.SIGTERM, 3.0), (signal.SIGKILL, 3.0))


class SupervisionError(DinerosError):
    """A process of the application cannot be started, or fails again and again."""


@dataclass(frozen=True)
class ProcessPlan:
    """How a process of the application is started.

    Attributes
    ----------
    name : str
        The node's name.
    command : sequence of str
        Program and arguments of the first start.
    resume : sequence of str
        Further arguments of every later start.
    environment : mapping of str to str
        All of the process's environment.
    log : Path
        Takes what the process prints; appended to, and rotated, see `log_files`.
    folder : Path or None
        The working folder.
    is_last : bool
        Whether it ends only when the others have: what they work in, say.
    connect : callable, optional
        Gets our end of a private line to each process that is started, see `new_line`.
    """

    name: str
    command: Sequence[str]
    environment: Mapping[str, str]
    log: Path
    resume: Sequence[str] = ()
    folder: Path | None = None
    is_last: bool = False
    connect: Callable[[socket.socket], None] | None = None


@dataclass(frozen=True)
class RestartPolicy:
    """When a process that failed is started again.

    Attributes
    ----------
    restarts : int
        So many restarts within `window` seconds are made; one more failure gives up.
    tries : int
        How often in all a process is started that ends with `CANNOT_START` each time.
    window : float
        Seconds.
    delay : float
        Seconds before the first restart; doubled for each that follows within the window.
    """

    restarts: int = 5
    tries: int = 3
    window: float = 60.0
    delay: float = 0.25


@dataclass(frozen=True)
class ProcessEvent:
    """Something that happened to a process.

    Attributes
    ----------
    time : float
        Seconds since the epoch.
    name : str
        The node's name.
    event : {"started", "restarted", "ended", "failed", "stopped"}
        ``ended``: by itself, status 0; ``failed``: any other end; ``stopped``: by the supervisor.
    process : int
        Its id in the system.
    status : int or None
        How it ended: an exit status, or minus the number of a signal.
    said : str
        The last line that it printed, where it failed.
    """

    time: float
    name: str
    event: _Event
    process: int
    status: int | None = None
    said: str = ""


@dataclass
class _Child:
    plan: ProcessPlan
    process: subprocess.Popen[bytes] | None = None
    failures: list[float] = field(default_factory=list)
    start_at: float | None = None
    is_done: bool = False
    log_start: int | None = 0
    """Size of the log when the process was started; None if the log was rotated since."""
    vain_starts: int = 0
    """How often it could not start, in a row."""
    restarts: int = 0
    sign: int = -1
    """Readable once the process has ended; -1: there is none, or the system has no such thing."""

    def gone(self) -> None:
        """Note that the process has ended."""
        self.process = None
        if self.sign >= 0:
            os.close(self.sign)
            self.sign = -1


class Supervisor:
    """Runs the processes of an application; use it as a context manager, so that none is left.

    Parameters
    ----------
    plans : sequence of ProcessPlan
        The processes, started in this order.
    policy : RestartPolicy
        When one that failed is started again.
    on_event : callable
        Told of every start and end.
    """

    def __init__(
        self,
        plans: Sequence[ProcessPlan],
        policy: RestartPolicy = RestartPolicy(),
        on_event: Callable[[ProcessEvent], None] = lambda event: None,
    ) -> None:
        self._children = [_Child(plan) for plan in plans]
        self._policy = policy
        self._on_event = on_event

    def __enter__(self) -> Supervisor:
        try:
            for child in self._children:
                self._start(child, "started")
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()

    @property
    def processes(self) -> dict[str, int]:
        """Ids of the processes that run, by name."""
        return {child.plan.name: child.process.pid for child in self._children if child.process is not None}

    @property
    def restarts(self) -> int:
        """How often processes were started again."""
        return sum(child.restarts for child in self._children)

    @property
    def descriptors(self) -> list[int]:
        """Descriptors that are readable once a process has ended and is to be looked after."""
        return [child.sign for child in self._children if child.sign >= 0]

    @property
    def longest(self) -> float:
        """Seconds after which to look after the processes although no descriptor is readable."""
        found = [_LONGEST]
        for child in self._children:
            if child.start_at is not None:
                found.append(child.start_at - time.monotonic())
            elif child.process is not None and child.sign < 0:  # the system cannot tell
                found.append(_LONGEST_BLIND)
        return max(0.0, min(found))

    def poll(self) -> bool:
        """Look after the processes; call it when `descriptors` or `longest` say so.

        Returns
        -------
        bool
            Whether any process runs or will be started again.

        Raises
        ------
        SupervisionError
            A process failed too often, or cannot start.
        """
        now = time.monotonic()
        for child in self._children:
            if rotate(child.plan.log):
                child.log_start = None
            if child.process is not None and child.process.poll() is not None:
                self._ended(child, now)
            elif child.start_at is not None and now >= child.start_at:
                self._start(child, "restarted")
        return not all(child.is_done for child in self._children)

    def stop(self) -> None:
        """End all processes: interrupt them, then terminate, then kill those that stay.

        Ctrl-C meanwhile only cuts the patience with which that is done: no process is left.
        """
        for child in self._children:
            child.start_at, child.is_done = None, True
        for is_last in (False, True):
            self._end([child for child in self._children if child.plan.is_last is is_last])

    def _end(self, children: Sequence[_Child]) -> None:
        for number, patience in _ENDINGS:
            running = [child for child in children if child.process is not None]
            for child in running:
                assert child.process is not None
                _send(child.process, number)
            deadline = time.monotonic() + patience
            with contextlib.suppress(KeyboardInterrupt):
                for child in running:
                    self._wait(child, deadline)
            if all(child.process is None for child in children):
                return

    def _start(self, child: _Child, event: Literal["started", "restarted"]) -> None:
        plan = child.plan
        command = [*plan.command, *(plan.resume if event == "restarted" else ())]
        plan.log.parent.mkdir(parents=True, exist_ok=True)
        try:
            with (
                os.fdopen(open_log(plan.log), "ab") as log,
                new_line(plan.connect) as line,
            ):
                child.log_start = os.fstat(log.fileno()).st_size
                child.process = subprocess.Popen(
                    command,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    env={
                        **plan.environment,
                        **line,
                        RESTARTS: str(child.restarts + (event == "restarted")),
                    },
                    pass_fds=[int(number) for number in line.values()],
                    cwd=plan.folder,
                    start_new_session=True,  # Ctrl-C comes to us alone, and we end them in order
                    # With threads, what runs between fork and exec must not wait for a lock that another one
                    # has: this makes three system calls. Hooks of `os.register_at_fork` run there, too.
                    preexec_fn=partial(_die_with, os.getpid()) if sys.platform == "linux" else None,  # noqa: PLW1509
                )
        except OSError as error:
            raise SupervisionError(f"{plan.name} cannot be started: {error}") from error
        if sys.platform == "linux":
            with contextlib.suppress(OSError):
                child.sign = os.pidfd_open(child.process.pid)
        child.start_at = None
        child.restarts += event == "restarted"
        self._tell(child, event)

    def _ended(self, child: _Child, now: float) -> None:
        assert child.process is not None
        status = child.process.returncode
        said = "" if status == 0 else last_line(child.plan.log, child.log_start)
        self._tell(child, "ended" if status == 0 else "failed", status, said)
        child.gone()
        if status == 0:
            child.is_done = True
            return
        child.failures = [moment for moment in child.failures if now - moment < self._policy.window]
        child.failures.append(now)
        child.vain_starts = child.vain_starts + 1 if status == CANNOT_START else 0
        failed = ""
        if child.vain_starts >= self._policy.tries:
            failed = f"cannot start, tried {child.vain_starts} times"
        elif len(child.failures) > self._policy.restarts:
            times = f"{len(child.failures)} times within {self._policy.window:.0f} s"
            failed = f"failed {times}, the last time with {status_text(status)}"
        if failed:
            child.is_done = True
            raise SupervisionError(
                f"{child.plan.name} {failed}{': ' if said else ''}{said}",
                hint=f"its output is in {child.plan.log}",
            )
        child.start_at = now + self._policy.delay * 2 ** (len(child.failures) - 1)

    def _wait(self, child: _Child, deadline: float) -> None:
        assert child.process is not None
        try:
            status = child.process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            return
        self._tell(child, "stopped", status)
        child.gone()

    def _tell(self, child: _Child, event: _Event, status: int | None = None, said: str = "") -> None:
        assert child.process is not None
        self._on_event(ProcessEvent(time.time(), child.plan.name, event, child.process.pid, status, said))


def status_text(status: int | None) -> str:
    """Return how a process ended, for people.

    Examples
    --------
    >>> status_text(2), status_text(-9)
    ('exit status 2', 'signal SIGKILL')
    """
    if status is not None and status < 0:
        return f"signal {signal.Signals(-status).name}"
    return f"exit status {status}"


def _send(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    """Signal a process and the children it may have."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, number)


def _die_with(supervisor: int) -> None:
    """Have the system end this process when the supervisor is gone, however that ended."""
    _SYSTEM.prctl(_PARENT_DEATH_SIGNAL, signal.SIGTERM)
    if os.getppid() != supervisor:  # it was killed before: nobody would end this process any more
        os._exit(1)
    signal.signal(signal.SIGINT, signal.default_int_handler)
