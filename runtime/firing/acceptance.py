"""Acceptance of goals by functions of the developers, if the model lets an action server refuse goals."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from types import MappingProxyType
from typing import TypeAlias, TypeVar

from dineros.metamodel.errors import near_matches
from dineros.runtime.firing.handlers import HandlerError
from dineros.runtime.firing.observing import FiringObserver
from dineros.runtime.nets.ports import ActionServerPort, Data

LOG = logging.getLogger("dineros.runtime")

Judge: TypeAlias = Callable[[Data], object]
J = TypeVar("J", bound=Judge)


class Acceptance:
    """Decides which goals a node's action servers accept.

    Parameters
    ----------
    ports : sequence of ActionServerPort
        The action servers.
    observer : FiringObserver
        Receives the errors of the functions, and watches them; they run on the node's thread.
    """

    def __init__(self, ports: Sequence[ActionServerPort], observer: FiringObserver) -> None:
        self._ports = {port.channel: port for port in ports}
        self._judges: dict[str, Judge] = {}
        self._watchdog = observer.watchdog
        self._observer = observer

    def register(self, action: str, judge: Judge) -> None:
        """Register a function that decides about the goals of an action.

        Raises
        ------
        HandlerError
            The node serves no such action, or the model does not let it refuse goals.
        """
        if action not in self._ports:
            raise HandlerError(
                f"the node serves no action {action!r}",
                element=action,
                hint=near_matches(action, list(self._ports)),
            )
        if not self._ports[action].may_reject:
            raise HandlerError(
                f"the server of action {action} must not reject goals",
                element=action,
                hint="set mayReject of its port, so that the checks include rejected goals",
            )
        self._judges[action] = judge

    def accepts(self, action: str, goal: Data) -> bool:
        """Return whether a goal is accepted; if the function fails, it is refused and the error recorded."""
        judge = self._judges.get(action)
        if judge is None:
            return True
        name = f"{getattr(judge, '__name__', 'a function')}, which decides about goals of {action},"
        try:
            return bool(self._watchdog.call(judge, MappingProxyType(dict(goal)), name))
        except Exception as error:
            text = f"{name} failed: {error!r}; the goal is refused"
            LOG.exception("%s", text)
            self._observer.tell_error(text, "refuse")
            return False
