"""What those see and do who steer a node: how it is, what it could do now, its signals, and pausing it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any, Protocol

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError
from dineros.runtime.nodes.core import NOT_ACTIVE
from dineros.runtime.nodes.inspection import outlook
from dineros.runtime.nodes.net import Net

PATIENCE = 0.5
"""Seconds that a node has to show what it is in; a handler may keep it from that."""


class SteeringError(DinerosError):
    """Something that was asked for and cannot be had; nothing has changed."""


@dataclass(frozen=True)
class Outlook:
    """How a node is, and what it could do now.

    Attributes
    ----------
    state : str
        That of its `Status`; or ``starting``: its process does not answer yet; or ``silent``: it does not
        answer any more.
    reason : str or None
        Why it does not run.
    signals : mapping of str to bool or str, or None
        Values of its signals; None: it cannot tell now.
    enabled : sequence of str or None
        Transitions that its net allows to fire; None: it cannot tell now.
    values : mapping of str to sequence of str
        The names of the values of each signal that has some.
    """

    state: str
    reason: str | None = None
    signals: Mapping[str, Any] | None = None
    enabled: Sequence[str] | None = None
    values: Mapping[str, Sequence[str]] = field(default_factory=dict)


class Steerable(Protocol):
    """A node that can be steered, wherever its process is."""

    def look(self) -> Outlook:
        """Return how it is; soon, also where a handler blocks it."""

    def set_signals(self, values: Mapping[str, SignalSetting], source: str) -> None:
        """Set input signals at once, by id; none is set where that raises a `DinerosError`."""

    def pause(self, reason: str) -> None:
        """Fire nothing more until `proceed`; tokens and signals still arrive."""

    def proceed(self) -> None:
        """Fire again; raises a `SteeringError` where the state of a managed node does not let it fire."""


class SteeredNet:
    """A net of this process; from any thread, but that one thread alone may `look`.

    Parameters
    ----------
    net : Net
        The net.
    may_fire : callable, optional
        Whether the state that others gave the node lets it fire, besides that of its model's lifecycle.
    """

    def __init__(self, net: Net, may_fire: Callable[[], bool] = lambda: True) -> None:
        self._net = net
        self._may_fire = may_fire
        self._asked: Future[tuple[dict[str, Any], list[str]]] | None = None
        self._seen: tuple[dict[str, Any] | None, list[str] | None] = (None, None)
        signals = net.structure.ports.signals
        self._values = {signal.id: signal.values for signal in signals if signal.values}

    def look(self) -> Outlook:
        """Return how it is; of a node that is busy, signals and transitions as they were last seen."""
        status = self._net.status
        if status.state == "blocked":
            return Outlook(status.state, status.reason)
        core = self._net.core
        if not core.loop.is_running:  # somebody steps it, or it has ended
            self._asked, self._seen = None, core.loop.call(lambda: outlook(core))
            return Outlook(status.state, status.reason, *self._seen, self._values)
        if self._asked is None:  # else it is still to answer: nothing piles up in its loop
            self._asked = core.loop.ask(lambda: outlook(core))
        with contextlib.suppress(TimeoutError):
            self._seen, self._asked = self._asked.result(PATIENCE), None
        return Outlook(status.state, status.reason, *self._seen, self._values)

    def set_signals(self, values: Mapping[str, SignalSetting], source: str) -> None:
        """Set input signals at once, by id or name."""
        self._net.set_signals(values, source)

    def pause(self, reason: str) -> None:
        """Fire nothing more until `proceed`."""
        self._net.halt(reason)

    def proceed(self) -> None:
        """Fire again.

        Raises
        ------
        SteeringError
            It is a managed node that is not active.
        """
        if self._net.core.rests or not self._may_fire():
            raise SteeringError(NOT_ACTIVE, hint="activate it")
        self._net.proceed()
