"""Runs work in a child process, which reports results as they are found and can be ended at any time.

A stage that never checks its budget, such as a solver or a compiler, cannot be stopped; a process can. So
work that must keep a promised limit runs in a forked process, and sends intermediate results through a pipe.

>>> def work(tell):
...     tell("half of it")
...     return 42
>>> with Apart(work) as apart:
...     said = list(apart.messages())
>>> said, apart.value()
(['half of it'], 42)
"""

from __future__ import annotations

import os
import pickle
import select
import signal
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from types import FrameType, TracebackType
from typing import Any, ClassVar, NoReturn, Self

from dineros.analysis.answers.processes import ProcessTree, die_with
from dineros.metamodel.errors import DinerosError

Tell = Callable[[object], None]
Work = Callable[[Tell], object]

PATIENCE = 0.05
"""Seconds between checks whether a silent process still runs."""
ASKED_AGAIN = 0.02
"""Seconds after which the work is asked again to end if it could not react to the first request."""
_TOLD, _RETURNED, _RAISED = "told", "returned", "raised"
_LENGTH = struct.Struct("!Q")
_CHUNK = 1 << 20


class ApartDiedError(Exception):
    """The process ended before its work did.

    Attributes
    ----------
    signal : int or None
        The signal that ended it; None: it ended without a signal.
    """

    def __init__(self, status: int) -> None:
        self.signal = -status if status < 0 else None
        cause = f"signal {-status}" if status < 0 else f"exit status {status}"
        super().__init__(f"the worker process ended early: {cause}")


class Apart:
    """Work in a child process; a context manager that leaves no process behind.

    The process is a fork: it has a copy of this process's state. Create it before threads, kernels and
    solvers run here. It ends with the thread that started it; Ctrl-C is handled by this process only.

    `work`: the work. It gets a function to report values, usable from all its threads; reported and returned
    values are pickled.
    """

    def __init__(self, work: Work) -> None:
        self._read, writing = os.pipe()
        self._bytes = bytearray()
        self._outcome: tuple[str, Any] | None = None
        self._status: int | None = None
        for stream in (sys.stdout, sys.stderr):
            stream.flush()  # else both processes would write its buffer
        parent = os.getpid()
        self.process = os.fork()
        if self.process == 0:
            _run(work, parent, self._read, writing)
        os.close(writing)
        self.tree = ProcessTree(self.process)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()
        self._wait()
        os.close(self._read)

    def fileno(self) -> int:
        """Return the descriptor that is readable when there is something new; for `ready`."""
        return self._read

    @property
    def is_over(self) -> bool:
        """Whether nothing more will be reported."""
        return self._outcome is not None or self._status is not None

    def messages(self, seconds: float | None = None) -> Iterator[Any]:
        """Yield the reported values as they arrive, until the process ends.

        `seconds`: how long to wait for the next value.
        """
        end = None if seconds is None else time.monotonic() + seconds
        yield from self._whole()  # an earlier caller may not have taken all values
        while not self.is_over:
            left = PATIENCE if end is None else max(0.0, min(PATIENCE, end - time.monotonic()))
            if ready([self], left):
                self._receive()
                yield from self._whole()
            elif end is not None and time.monotonic() >= end:
                return
            else:  # processes started by it may keep the pipe open
                self._wait(os.WNOHANG)

    def value(self) -> Any:
        """Return the result of the work, or raise its error.

        Raises
        ------
        ApartDiedError
            The process ended before its work did.
        ValueError
            The work is not over.
        """
        if self._outcome is None:
            if self._status is None:
                raise ValueError("it still runs")
            raise ApartDiedError(self._status)
        kind, value = self._outcome
        if kind == _RAISED:
            raise value
        return value

    def ask_to_end(self) -> None:
        """Raise KeyboardInterrupt in the work, once, as soon as Python code runs there."""
        if self._status is None:
            os.kill(self.process, signal.SIGTERM)

    def end(self) -> None:
        """End the process and its child processes, if it still runs; reported values can still be read."""
        if self._status is None:
            self.tree.end()

    def _wait(self, options: int = 0) -> None:
        if self._status is None:
            process, status = os.waitpid(self.process, options)
            if process:
                self._status = os.waitstatus_to_exitcode(status)

    def _receive(self) -> None:
        read = os.read(self._read, _CHUNK)
        self._bytes += read
        if not read:
            self._wait()

    def _whole(self) -> Iterator[Any]:
        """Yield the values that have arrived completely."""
        while len(self._bytes) >= _LENGTH.size:
            end = _LENGTH.size + _LENGTH.unpack_from(self._bytes)[0]
            if len(self._bytes) < end:
                return
            kind, value = pickle.loads(memoryview(self._bytes)[_LENGTH.size : end])
            del self._bytes[:end]
            if kind == _TOLD:
                yield value
            else:
                self._outcome = kind, value


def ready(some: Sequence[Apart], seconds: float | None = None) -> list[Apart]:
    """Return those that have something to read or have ended; wait for the first one for this time."""
    return list(select.select(some, [], [], seconds)[0])


def is_end(error: BaseException) -> bool:
    """Return whether an error of work in a child process is the effect of a request to end.

    An interrupt within a callback from C, or while a class is created, raises another error afterwards.
    """
    return isinstance(error, KeyboardInterrupt) or (_Teller.has_asked and not isinstance(error, DinerosError))


class _Teller:
    """Writes complete messages to the pipe, one at a time, even if the work is asked to end."""

    has_asked: ClassVar[bool] = False
    """Whether the work of this process was asked to end, and has got the interrupt."""

    def __init__(self, pipe: int) -> None:
        self._pipe, self._turn = pipe, threading.Lock()
        self._is_writing = self._is_asked = self._has_raised = False
        _Teller.has_asked = False  # reset the value inherited by the fork

    def tell(self, value: object) -> None:
        self.write(_TOLD, value)

    def write(self, kind: str, value: object) -> None:
        text = pickle.dumps((kind, value), pickle.HIGHEST_PROTOCOL)
        is_main = threading.current_thread() is threading.main_thread()
        if is_main:
            self._is_writing = True
        try:
            with self._turn:
                rest = memoryview(_LENGTH.pack(len(text)) + text)
                while rest:
                    rest = rest[os.write(self._pipe, rest) :]
        finally:
            if is_main:
                self._is_writing = False
        if is_main and self._is_asked:
            self._end()

    def asked(self, _: int, __: FrameType | None) -> None:
        """End the work; the handler of SIGTERM."""
        self._is_asked = True
        if not self._is_writing:
            self._end()

    def _end(self) -> None:
        if not self._has_raised:
            self._has_raised = _Teller.has_asked = True
            raise KeyboardInterrupt

    def lost(self, lost: sys.UnraisableHookArgs) -> None:
        """Raise the interrupt again if it was lost in a callback from C, which does not propagate it.

        This is the hook `sys.unraisablehook`; other lost errors are shown as usual, except after a request to
        end: an object whose creation the interrupt ended cannot be destroyed.
        """
        if not (self._has_raised and issubclass(lost.exc_type, KeyboardInterrupt)):
            if not self._is_asked:
                sys.__unraisablehook__(lost)
            return
        self._has_raised = False
        again = threading.Timer(ASKED_AGAIN, os.kill, (os.getpid(), signal.SIGTERM))
        again.daemon = True
        again.start()


def _run(work: Work, parent: int, reading: int, writing: int) -> NoReturn:
    """Do the work in the new process."""
    try:
        die_with(parent)
        os.close(reading)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        teller = _Teller(writing)
        signal.signal(signal.SIGTERM, teller.asked)
        sys.unraisablehook = teller.lost
        try:
            kind, value = _RETURNED, work(teller.tell)
        except BaseException as error:
            kind, value = _RAISED, KeyboardInterrupt() if is_end(error) else _tellable(error)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        try:
            teller.write(kind, value)
        except Exception as error:  # the value cannot be pickled
            teller.write(
                _RAISED, RuntimeError(f"{type(value).__name__} cannot be sent to another process: {error}")
            )
    finally:
        os._exit(0)


def _tellable(error: BaseException) -> BaseException:
    """Return an error, or an equivalent one if it cannot be pickled."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
