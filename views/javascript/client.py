"""JavaScript in the process of `server`: started when it is needed, kept, replaced when it ends."""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Sequence
from importlib.util import find_spec
from io import BufferedReader
from typing import Any

from dineros.metamodel.errors import DinerosError

SECONDS = 300.0
"""Longest time for one answer."""

HEAP = 2048
"""Most memory of JavaScript's objects in MiB; the process ends where they need more."""

MOST_ENDS = 3
"""Processes in a row that may end without an answer; then no more are started."""


class LayouterError(DinerosError):
    """JavaScript gave no answer: its process is not there, has ended, or took too long."""


class ScriptError(DinerosError):
    """A script raised an error; later requests are not affected."""


class Layouter:
    """A process that runs JavaScript, for any number of threads.

    Parameters
    ----------
    seconds : float
        Longest time for one answer; then the process is killed.
    heap : int
        Most memory of JavaScript's objects in MiB.
    """

    def __init__(self, seconds: float = SECONDS, heap: int = HEAP) -> None:
        self.seconds, self.heap = seconds, heap
        self._ends = 0
        self._reset()

    def _reset(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: socket.socket | None = None
        self._answers: BufferedReader | None = None
        self._answered = False

    @property
    def process(self) -> int | None:
        """Id of the process, while there is one."""
        process = self._process
        return process.pid if process is not None else None

    def evaluate(self, scripts: Sequence[str], function: str, *arguments: Any) -> Any:
        """Call a function of JavaScript; if it returns a promise, wait for its value.

        Parameters
        ----------
        scripts : sequence of str
            Files of `dineros.views` that are loaded before, once in a process. Those in ``static/`` are
            modules: what they export is global then, and what they import from is loaded with them.
        function : str
            An expression of JavaScript.
        *arguments
            JSON values.

        Returns
        -------
        Any
            A JSON value.

        Raises
        ------
        ScriptError
            The function raised an error.
        LayouterError
            There is no answer.
        """
        request = {"scripts": scripts, "function": function, "input": json.dumps(arguments)}
        content = json.dumps(request).encode()
        with self._lock:
            had_answered = self._answered
            try:
                found = self._ask(content)
            except _EndedError as ended:
                # One that has served may have ended since; one that was started for this request has not.
                if not had_answered:
                    raise LayouterError(str(ended)) from None
                try:
                    found = self._ask(content)
                except _EndedError as again:
                    raise LayouterError(str(again)) from None
        if "error" in found:
            raise ScriptError(found["error"])
        return found.get("value")

    def close(self) -> None:
        """Stop the process immediately; waiting threads get no answer, and no new process is started."""
        self._ends = MOST_ENDS
        process = self._process  # without the lock: it is held by who waits
        if process is not None:
            process.kill()
            process.wait()

    def _ask(self, content: bytes) -> dict[str, Any]:
        if self._connection is None:
            self._start()
        assert self._connection is not None and self._answers is not None
        try:
            self._connection.sendall(content + b"\n")
            answer = self._answers.readline()
            if not answer.endswith(b"\n"):
                raise EOFError
            found: dict[str, Any] = json.loads(answer)
        except TimeoutError:
            self._end()
            raise LayouterError(f"the layout process did not answer within {self.seconds:g} s") from None
        except (EOFError, OSError):
            self._ends += 1
            raise _EndedError(f"the layouter ended{self._end(wait=True)}") from None
        except BaseException:  # the user interrupts: the answer would be taken for that of the next request
            self._end()
            raise
        self._ends, self._answered = 0, True
        return found

    def _start(self) -> None:
        if self._ends >= MOST_ENDS:
            raise LayouterError(f"the layout process ended {self._ends} times")
        if find_spec("py_mini_racer") is None:
            raise LayouterError("mini-racer is not installed", hint="pip install 'dineros[view]'")
        ours, theirs = None, None
        try:
            ours, theirs = socket.socketpair()
            # In a session of its own: the terminal's Ctrl-C is for the command.
            self._process = subprocess.Popen(
                [sys.executable or "python3", "-P", "-m", "dineros.views.javascript.server", str(self.heap)],
                stdin=theirs.fileno(),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        except (OSError, ValueError) as error:
            if ours is not None:
                ours.close()
            reason = error.strerror if isinstance(error, OSError) and error.strerror else error
            raise LayouterError(f"the layout process cannot be started: {reason}") from None
        finally:
            if theirs is not None:
                theirs.close()
        ours.settimeout(self.seconds)
        self._connection, self._answers, self._answered = ours, ours.makefile("rb"), False

    def _end(self, *, wait: bool = False) -> str:
        """Stop the process; return its exit status if it had already ended."""
        process = self._process
        self._hang_up()
        self._process, self._answered = None, False
        if process is None:
            return ""
        if wait:  # its end of the stream has closed: it is about to be gone
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(5)
        status = process.poll()
        if status is None:
            process.kill()
            process.wait()
            return ""
        if status < 0:
            return f" ({_signal_name(-status)})"
        return f" (exit status {status})"

    def forget(self) -> None:
        """In a process that was forked off: the layouter is the parent's, and so is the stream to it.

        A thread of the parent may be reading from that stream. Closing the stream object here would wait
        forever for the lock of that thread, which does not exist here: only the descriptor is closed.
        """
        if self._process is not None:
            self._process.returncode = 0  # not ours to wait for
        if self._connection is not None:
            os.close(self._connection.detach())
        self._reset()

    def _hang_up(self) -> None:
        for end in (self._answers, self._connection):
            if end is not None:
                end.close()
        self._connection = self._answers = None


class _EndedError(Exception):
    """The process has ended."""


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


_LAYOUTER = Layouter()
evaluate = _LAYOUTER.evaluate
os.register_at_fork(after_in_child=_LAYOUTER.forget)
atexit.register(_LAYOUTER.close)
