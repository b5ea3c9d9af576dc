"""Starts the processes of an application, restarts processes that fail, and ends all of them.

The policy is that of OTP's supervisors. A process that ends with status 0 is done. A process that fails is
restarted after a delay that doubles each time, unless it failed too often within a time window (Erlang/OTP
design principles, "Supervisor Behaviour"). A process that cannot start (status 2) is tried three times.
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
from dineros.runtime.application.gate import SharedGate, new_gate
from dineros.runtime.application.line import new_line
from dineros.runtime.application.log_files import last_line, open_log, rotate
from dineros.runtime.nodes.health import RESTARTS

CANNOT_START = 2
"""Exit status of a process that cannot start, for example because of wrong handlers or parameters."""

_LONGEST = 1.0
_LONGEST_BLIND = 0.05
_PARENT_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl(2)
_SYSTEM = ctypes.CDLL(None)
"""Loaded before any thread exists: loading takes a lock, which would stay locked after a fork."""
_Event = Literal["started", "restarted", "ended", "failed", "stopped"]
_ENDINGS = ((signal.SIGINT, 6.0), (signal.SIGTERM, 3.0), (signal.SIGKILL, 3.0))


class SupervisionError(DinerosError):
    """A process of the application cannot be started, or fails repeatedly."""


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
        Additional arguments of each later start.
    environment : mapping of str to str
        The complete environment of the process.
    log : Path
        Log file for the output of the process; appended to, and rotated, see `log_files`.
    folder : Path or None
        The working folder.
    is_last : bool
        Whether it ends only after the others, for example because it provides their environment.
    connect : callable, optional
        Called with this side's end of a private line to each started process, see `new_line`.
    starts_together : bool
        Whether it is a node that begins its work only when all such nodes are ready, see `gate`.
    """

    name: str
    command: Sequence[str]
    environment: Mapping[str, str]
    log: Path
    resume: Sequence[str] = ()
    folder: Path | None = None
    is_last: bool = False
    connect: Callable[[socket.socket], None] | None = None
    starts_together: bool = False


@dataclass(frozen=True)
class RestartPolicy:
    """When a failed process is restarted.

    Attributes
    ----------
    restarts : int
        Maximum number of restarts within `window` seconds; after one more failure, the supervisor gives up.
    tries : int
        Maximum number of successive starts of a process that ends with `CANNOT_START` each time.
    window : float
        Seconds.
    delay : float
        Seconds before the first restart; doubled for each further restart within the window.
    """

    restarts: int = 5
    tries: int = 3
    window: float = 60.0
    delay: float = 0.25


@dataclass(frozen=True)
class ProcessEvent:
    """A change of a process.

    Attributes
    ----------
    time : float
        Seconds since the epoch.
    name : str
        The node's name.
    event : {"started", "restarted", "ended", "failed", "stopped"}
        ``ended``: with status 0; ``failed``: with another status; ``stopped``: by the supervisor.
    process : int
        Its process id.
    status : int or None
        Its exit status, or minus the number of the signal that ended it.
    said : str
        The last line that it printed, if it failed.
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
    """Size of the log when the process was started; None if the log was rotated since then."""
    vain_starts: int = 0
    """Number of successive failures to start."""
    restarts: int = 0
    sign: int = -1
    """Descriptor, readable once the process has ended; -1: there is none, or the system has no such thing."""

    def gone(self) -> None:
        """Record that the process has ended."""
        self.process = None
        if self.sign >= 0:
            os.close(self.sign)
            self.sign = -1


_USUAL = RestartPolicy()


class Supervisor:
    """Runs the processes of an application; a context manager, so that no process is left.

    Parameters
    ----------
    plans : sequence of ProcessPlan
        The processes, started in this order.
    policy : RestartPolicy
        When a failed process is restarted.
    on_event : callable
        Called at every start and end of a process.
    logs : Path, optional
        Folder in which the processes write further log files (``*.log``); these are rotated, too.
    """

    def __init__(
        self,
        plans: Sequence[ProcessPlan],
        policy: RestartPolicy = _USUAL,
        on_event: Callable[[ProcessEvent], None] = lambda event: None,
        logs: Path | None = None,
    ) -> None:
        self._children = [_Child(plan) for plan in plans]
        self._policy = policy
        self._on_event = on_event
        self._logs = logs

    def __enter__(self) -> Supervisor:
        try:
            with new_gate() as gate:
                for child in self._children:
                    together = gate if child.plan.starts_together else SharedGate()
                    self._start(child, "started", together)
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
        """Number of restarts."""
        return sum(child.restarts for child in self._children)

    @property
    def descriptors(self) -> list[int]:
        """Descriptors that become readable when a process has ended and `poll` is to be called."""
        return [child.sign for child in self._children if child.sign >= 0]

    @property
    def longest(self) -> float:
        """Seconds after which `poll` is to be called even if no descriptor is readable."""
        found = [_LONGEST]
        for child in self._children:
            if child.start_at is not None:
                found.append(child.start_at - time.monotonic())
            elif child.process is not None and child.sign < 0:  # without a descriptor
                found.append(_LONGEST_BLIND)
        return max(0.0, min(found))

    def poll(self) -> bool:
        """Check the processes; call it according to `descriptors` and `longest`.

        Returns
        -------
        bool
            Whether any process runs or will be restarted.

        Raises
        ------
        SupervisionError
            A process failed too often, or cannot start.
        """
        now = time.monotonic()
        for log in self._logs.glob("*.log") if self._logs is not None else ():
            rotate(log)
        for child in self._children:
            if rotate(child.plan.log):
                child.log_start = None
            if child.process is not None and child.process.poll() is not None:
                self._ended(child, now)
            elif child.start_at is not None and now >= child.start_at:
                self._start(child, "restarted", SharedGate())
        return not all(child.is_done for child in self._children)

    def stop(self) -> None:
        """End all processes: interrupt them, then terminate, then kill those that remain.

        Ctrl-C during this only shortens the waiting times: no process is left.
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

    def _start(self, child: _Child, event: Literal["started", "restarted"], gate: SharedGate) -> None:
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
                        "PYTHONUNBUFFERED": "1",  # else the error that ends a process is not the last line
                        **plan.environment,
                        **line,
                        **gate.environment,
                        RESTARTS: str(child.restarts + (event == "restarted")),
                    },
                    pass_fds=[*gate.descriptors, *(int(number) for number in line.values())],
                    cwd=plan.folder,
                    start_new_session=True,  # Ctrl-C reaches only the supervisor; it ends them in order
                    # If there are threads, code between fork and exec must not wait for a lock of another
                    # thread: this makes three system calls. Hooks of `os.register_at_fork` run there, too.
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
            failed = f"could not be started in {child.vain_starts} attempts"
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
        said = last_line(child.plan.log, child.log_start) if status == CANNOT_START else ""
        self._tell(child, "stopped", status, said)
        child.gone()

    def _tell(self, child: _Child, event: _Event, status: int | None = None, said: str = "") -> None:
        assert child.process is not None
        self._on_event(ProcessEvent(time.time(), child.plan.name, event, child.process.pid, status, said))


def status_text(status: int | None) -> str:
    """Return how a process ended, as text for users.

    Examples
    --------
    >>> status_text(2), status_text(-9)
    ('exit status 2', 'signal SIGKILL')
    """
    if status is not None and status < 0:
        return f"signal {signal.Signals(-status).name}"
    return f"exit status {status}"


def _send(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    """Send a signal to a process and its children."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, number)


def _die_with(supervisor: int) -> None:
    """Have the system end this process when the supervisor ends for any reason."""
    _SYSTEM.prctl(_PARENT_DEATH_SIGNAL, signal.SIGTERM)
    if os.getppid() != supervisor:  # the supervisor was killed before; nothing else would end this process
        os._exit(1)
    signal.signal(signal.SIGINT, signal.default_int_handler)
