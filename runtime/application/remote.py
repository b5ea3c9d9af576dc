"""On the side of a supervisor: a node whose process is another one, for those who steer it.

Nobody waits for what a process does not say: a node shows what it said last, and what it is asked for is
given up after a while.
"""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Mapping
from concurrent.futures import Future
from typing import Any

from dineros.metamodel.clauses import SignalSetting
from dineros.runtime.application.line import LOG, Line, LineError
from dineros.runtime.application.supervisor import ProcessEvent, status_text
from dineros.runtime.nodes.steering import Outlook, SteeringError

PATIENCE = 2.0
"""Seconds that a node has to answer."""

STARTING = Outlook("starting")
SILENT = Outlook("silent", "its process does not answer")


class RemoteNode:
    """A node in a process that is started, and started again; from any thread.

    Parameters
    ----------
    name : str
        Its name, for the log.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._lock = threading.Lock()
        self._connection: _Connection | None = None
        self._outlook = STARTING
        self._look: tuple[Future[dict[str, Any]], float] | None = None
        self._overdue: Future[dict[str, Any]] | None = None

    def connect(self, end: socket.socket) -> None:
        """Speak with a new process of the node from now on; nothing that its former one was in counts."""
        self._change(_Connection(self._name, end), STARTING)

    def tell(self, event: ProcessEvent) -> None:
        """Hear from the supervisor how the node's process ended."""
        if event.event == "failed":
            said = f": {event.said}" if event.said else ""
            self._change(None, Outlook("crashed", f"{status_text(event.status)}{said}"))
        elif event.event in ("ended", "stopped"):
            self._change(None, Outlook("ended", status_text(event.status)))

    def close(self) -> None:
        """Speak with nobody any more."""
        self._change(None, Outlook("ended"))

    def _change(self, connection: _Connection | None, outlook: Outlook) -> None:
        with self._lock:
            former, self._connection = self._connection, connection
            self._outlook, self._look, self._overdue = outlook, None, None
        if former is not None:
            former.hang_up()

    def look(self) -> Outlook:
        """Return how the node was when it was asked last, and ask it again; at once."""
        with self._lock:
            connection, asked = self._connection, self._look
            if connection is None:
                return self._outlook
            if asked is not None:
                future, since = asked
                if future.done():
                    self._look = None
                    self._outlook = SILENT if future.exception() else _outlook(future.result())
                elif time.monotonic() - since > PATIENCE and self._outlook is not STARTING:
                    self._outlook = SILENT
            if self._look is None and not connection.is_over:
                self._look = connection.ask({"ask": "look"}), time.monotonic()
            return SILENT if connection.is_over else self._outlook

    def set_signals(self, values: Mapping[str, SignalSetting], source: str) -> None:
        """Set input signals at once, by id or name.

        Raises
        ------
        SteeringError
            The node refuses, or does not answer; it may still do it then.
        """
        self._do({"ask": "set", "values": dict(values), "source": source})

    def pause(self, reason: str) -> None:
        """Fire nothing more until `proceed`; raises as `set_signals` does."""
        self._do({"ask": "pause", "reason": reason})

    def proceed(self) -> None:
        """Fire again; raises as `set_signals` does."""
        self._do({"ask": "proceed"})

    def _do(self, said: dict[str, Any]) -> None:
        with self._lock:
            connection, state = self._connection, self._outlook.state
            if connection is None or state == STARTING.state:
                raise SteeringError(f"the process of {self._name} is {state}")
            if self._overdue is not None and not self._overdue.done():
                raise SteeringError(f"{self._name} has not answered yet what it was asked before")
            future = connection.ask(said)
        try:
            answer = future.result(PATIENCE)
        except TimeoutError:
            self._overdue = future
            raise SteeringError(f"{self._name} does not answer", hint="it may still do it") from None
        if "refused" in answer:
            hint = answer.get("hint")
            raise SteeringError(str(answer["refused"]), hint=hint if isinstance(hint, str) else None)


class _Connection:
    """What is said with one process; a thread listens to it until that has gone."""

    def __init__(self, name: str, end: socket.socket) -> None:
        self._name = name
        self._line = Line(end)
        self._lock = threading.Lock()
        self._number = 0
        self._waiting: dict[int, Future[dict[str, Any]]] = {}
        self.is_over = False
        threading.Thread(target=self._listen, name=f"dineros steering {name}", daemon=True).start()

    def ask(self, said: Mapping[str, Any]) -> Future[dict[str, Any]]:
        """Ask something; never waits."""
        future: Future[dict[str, Any]] = Future()
        with self._lock:
            if self.is_over:
                future.set_exception(_gone(self._name))
                return future
            self._number += 1
            self._waiting[self._number] = future
            try:
                self._line.say({"number": self._number, **said}, waits=False)
            except (LineError, OSError):  # it has not listened for long, or is gone
                self._line.hang_up()  # so that the future gets its error
        return future

    def hang_up(self) -> None:
        """Listen no more."""
        with self._lock:
            if not self.is_over:
                self._line.hang_up()

    def _listen(self) -> None:
        try:
            while (said := self._line.receive()) is not None:
                number = said.get("number")
                with self._lock:
                    future = self._waiting.pop(number, None) if isinstance(number, int) else None
                if future is None:
                    raise LineError("an answer to nothing")
                if not _is_answer(said):
                    future.set_exception(_gone(self._name))
                    raise LineError("no answer")
                future.set_result(said)
        except LineError as error:
            LOG.warning("%s can no longer be steered: its process says %s", self._name, error.message)
        finally:
            with self._lock:
                self.is_over = True
                self._line.close()
                waiting, self._waiting = self._waiting, {}
            for future in waiting.values():
                future.set_exception(_gone(self._name))


def _gone(name: str) -> SteeringError:
    return SteeringError(f"the process of {name} does not answer any more")


def _is_answer(said: Mapping[str, Any]) -> bool:
    """Tell whether an answer is of the form that `dineros.runtime.application.steered` gives it."""
    match said.get("outlook", {"state": ""}):
        case {"state": str(), **others}:
            reason, signals, enabled = (others.get(name) for name in ("reason", "signals", "enabled"))
            values = others.get("values", {})
        case _:
            return False
    return (
        (reason is None or isinstance(reason, str))
        and (
            signals is None
            or (isinstance(signals, dict) and all(isinstance(each, (bool, str)) for each in signals.values()))
        )
        and (
            enabled is None or (isinstance(enabled, list) and all(isinstance(each, str) for each in enabled))
        )
        and isinstance(values, dict)
        and all(
            isinstance(names, list) and all(isinstance(each, str) for each in names)
            for names in values.values()
        )
    )


def _outlook(said: Mapping[str, Any]) -> Outlook:
    """Return the outlook of an answer; without one, the node has too much to tell."""
    found = said.get("outlook")
    if not isinstance(found, dict):
        return Outlook("silent", str(said.get("refused", "it says nothing")))
    values = found.get("values", {})
    return Outlook(found["state"], found.get("reason"), found.get("signals"), found.get("enabled"), values)
