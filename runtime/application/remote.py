"""A node in another process, controlled by its supervisor.

No caller waits for the process: a node shows its last known outlook, and a request is given up after a
time-out.
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
"""Seconds for a node to respond."""

STARTING = Outlook("starting")
SILENT = Outlook("silent", "its process does not answer")


class RemoteNode:
    """A node in a process that may be restarted; usable from any thread.

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
        """Use a new process of the node from now on; the state of the former process is discarded."""
        self._change(_Connection(self._name, end), STARTING)

    def tell(self, event: ProcessEvent) -> None:
        """Take over from the supervisor how the node's process ended."""
        if event.event == "failed":
            said = f": {event.said}" if event.said else ""
            self._change(None, Outlook("crashed", f"{status_text(event.status)}{said}"))
        elif event.event in ("ended", "stopped"):
            self._change(None, Outlook("ended", status_text(event.status)))

    def close(self) -> None:
        """Close the connection."""
        self._change(None, Outlook("ended"))

    def _change(self, connection: _Connection | None, outlook: Outlook) -> None:
        with self._lock:
            former, self._connection = self._connection, connection
            self._outlook, self._look, self._overdue = outlook, None, None
        if former is not None:
            former.hang_up()

    def look(self) -> Outlook:
        """Return the last known outlook of the node, and request a new one; returns at once."""
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
            The node refuses, or does not respond; in that case it may still set them.
        """
        self._do({"ask": "set", "values": dict(values), "source": source})

    def pause(self, reason: str) -> None:
        """Stop firing until `proceed`; raises like `set_signals`."""
        self._do({"ask": "pause", "reason": reason})

    def proceed(self) -> None:
        """Continue firing; raises like `set_signals`."""
        self._do({"ask": "proceed"})

    def _do(self, said: dict[str, Any]) -> None:
        with self._lock:
            connection, state = self._connection, self._outlook.state
            if connection is None or state == STARTING.state:
                raise SteeringError(f"the process of {self._name} is {state}")
            if self._overdue is not None and not self._overdue.done():
                raise SteeringError(f"{self._name} has not answered the previous request yet")
            future = connection.ask(said)
        try:
            answer = future.result(PATIENCE)
        except TimeoutError:
            self._overdue = future
            raise SteeringError(f"{self._name} does not answer", hint="it may still carry it out") from None
        if "refused" in answer:
            hint = answer.get("hint")
            raise SteeringError(str(answer["refused"]), hint=hint if isinstance(hint, str) else None)


class _Connection:
    """The messages with one process; a thread receives them until the process ends."""

    def __init__(self, name: str, end: socket.socket) -> None:
        self._name = name
        self._line = Line(end)
        self._lock = threading.Lock()
        self._number = 0
        self._waiting: dict[int, Future[dict[str, Any]]] = {}
        self.is_over = False
        threading.Thread(target=self._listen, name=f"dineros steering {name}", daemon=True).start()

    def ask(self, said: Mapping[str, Any]) -> Future[dict[str, Any]]:
        """Send a request; never waits."""
        future: Future[dict[str, Any]] = Future()
        with self._lock:
            if self.is_over:
                future.set_exception(_gone(self._name))
                return future
            self._number += 1
            self._waiting[self._number] = future
            try:
                self._line.say({"number": self._number, **said}, waits=False)
            except (LineError, OSError):  # it does not read for a while, or has ended
                self._line.hang_up()  # so that the future gets its error
        return future

    def hang_up(self) -> None:
        """Stop receiving."""
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
                    raise LineError("an answer without a request")
                if not _is_answer(said):
                    future.set_exception(_gone(self._name))
                    raise LineError("no answer")
                future.set_result(said)
        except LineError as error:
            LOG.warning("%s can no longer be controlled: its process reports %s", self._name, error.message)
        finally:
            with self._lock:
                self.is_over = True
                self._line.close()
                waiting, self._waiting = self._waiting, {}
            for future in waiting.values():
                future.set_exception(_gone(self._name))


def _gone(name: str) -> SteeringError:
    return SteeringError(f"the process of {name} no longer answers")


def _is_answer(said: Mapping[str, Any]) -> bool:
    """Return whether a response has the form that `dineros.runtime.application.steered` gives it."""
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
    """Return the outlook in a response; without one, the outlook was too large to send."""
    found = said.get("outlook")
    if not isinstance(found, dict):
        return Outlook("silent", str(said.get("refused", "it gives no reason")))
    values = found.get("values", {})
    return Outlook(found["state"], found.get("reason"), found.get("signals"), found.get("enabled"), values)
