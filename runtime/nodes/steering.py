"""The interface to control a node: its status, its enabled transitions, its signals, and pausing it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any, Protocol

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError
from dineros.runtime.nodes.core import NOT_ACTIVE, Core
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.snapshot import enabled, snapshot

PATIENCE = 0.5
"""Seconds for a node to report its state; a handler may prevent that."""


class SteeringError(DinerosError):
    """A request could not be fulfilled; nothing has changed."""


@dataclass(frozen=True)
class Outlook:
    """The status of a node, and what it could do now.

    Attributes
    ----------
    state : str
        As in its `Status`; or ``starting``: its process does not respond yet; or ``silent``: it no longer
        responds.
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
    """A node that can be controlled, in this or another process."""

    def look(self) -> Outlook:
        """Return its outlook; quickly, even while a handler blocks it."""

    def set_signals(self, values: Mapping[str, SignalSetting], source: str) -> None:
        """Set input signals at once, by id; if that raises a `DinerosError`, none is set."""

    def pause(self, reason: str) -> None:
        """Stop firing until `proceed`; tokens and signals still arrive."""

    def proceed(self) -> None:
        """Continue firing; raises `SteeringError` if the state of a managed node does not let it fire."""


class SteeredNet:
    """A net of this process; from any thread, but only one thread may call `look`.

    Parameters
    ----------
    net : Net
        The net.
    may_fire : callable, optional
        Returns whether the node's external state lets it fire, in addition to the lifecycle of its model.
    """

    def __init__(self, net: Net, may_fire: Callable[[], bool] = lambda: True) -> None:
        self._net = net
        self.set_signals, self.pause = net.set_signals, net.halt
        self._may_fire = may_fire
        self._asked: Future[tuple[dict[str, Any], list[str]]] | None = None
        self._seen: tuple[dict[str, Any] | None, list[str] | None] = (None, None)
        signals = net.structure.ports.signals
        self._values = {signal.id: signal.values for signal in signals if signal.values}

    def look(self) -> Outlook:
        """Return its outlook; for a busy node, with the last known signals and transitions."""
        status = self._net.status
        if status.state == "blocked":
            return Outlook(status.state, status.reason)
        core = self._net.core
        if not core.loop.is_running:  # it is stepped by its owner, or has ended
            self._asked, self._seen = None, core.loop.call(lambda: _choices(core))
            return Outlook(status.state, status.reason, *self._seen, self._values)
        if self._asked is None:  # else it is still to answer: nothing piles up in its loop
            self._asked = core.loop.ask(lambda: _choices(core))
        with contextlib.suppress(TimeoutError):
            self._seen, self._asked = self._asked.result(PATIENCE), None
        return Outlook(status.state, status.reason, *self._seen, self._values)

    def proceed(self) -> None:
        """Continue firing.

        Raises
        ------
        SteeringError
            It is a managed node that is not active.
        """
        if self._net.core.rests or not self._may_fire():
            raise SteeringError(NOT_ACTIVE, hint="activate it")
        self._net.proceed()


def _choices(core: Core) -> tuple[dict[str, Any], list[str]]:
    """Return the signals of a node, and what could fire; on its thread, without copies of its tokens."""
    return dict(snapshot(core).signals), list(enabled(core))
