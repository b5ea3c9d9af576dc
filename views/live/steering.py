"""Steering a run from its live page: what its nodes could do now, signals, and pausing a node."""

from __future__ import annotations

import json
import logging
import threading
from collections.abc import Callable, Mapping
from typing import Any

from dineros.metamodel.errors import DinerosError, without_middle
from dineros.metamodel.json_text import decode_json
from dineros.runtime.nodes.core import NOT_ACTIVE
from dineros.runtime.nodes.net import Net

LOG = logging.getLogger("dineros.views.live")

LONGEST_MESSAGE = 4096
"""Characters of what a page may say at once."""

INTERVAL = 0.25
"""Seconds between two looks at the nodes."""

PAUSED = "paused on the live page"
"""Why a node is halted that somebody has paused."""

_FIELDS = {"signal": {"node", "signal", "value"}, "pause": {"node"}, "proceed": {"node"}}


class SteeringError(DinerosError):
    """Something that a page asked for and cannot have; nothing has changed."""


class Steering:
    """The nodes of a run in this process, for those who watch it.

    It looks at them on a thread of its own: a handler that blocks a node keeps that from being seen, and
    nothing else waits.
    """

    def __init__(self) -> None:
        self._nets: Mapping[str, Net] = {}
        self._ending = threading.Event()
        self._tell: Callable[[str], None] | None = None
        self._thread: threading.Thread | None = None

    def take(self, nets: Mapping[str, Net]) -> None:
        """Steer these nodes from now on, by id; none where the run has ended."""
        self._nets = dict(nets)

    def begin(self, tell: Callable[[str], None]) -> None:
        """Tell of the nodes whenever they are in another state, from a thread."""
        self._tell = tell
        self._thread = threading.Thread(target=self._watch, name="dineros steering", daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Tell no more; does not wait for a node that is blocked."""
        self._ending.set()
        self._tell = None

    def nodes(self) -> list[dict[str, Any]]:
        """Return how each node is.

        Returns
        -------
        list of dict
            ``node``, ``state`` and ``reason``; and but for a node that is blocked ``signals``: values by id,
            and ``enabled``: transitions that its net allows to fire.
        """
        found = []
        for node, net in self._nets.items():
            status = net.status
            said: dict[str, Any] = {"node": node, "state": status.state, "reason": status.reason}
            if status.state != "blocked":
                state = net.inspect()
                said |= {"signals": dict(state.signals), "enabled": list(state.enabled)}
            found.append(said)
        return found

    def hear(self, text: str | bytes) -> str | None:
        """Do what a page asks; return a message that says why not, where it cannot be done.

        Nothing that a page says raises anything: others listen on the same thread.
        """
        try:
            self._do(decode_json(text, limit=LONGEST_MESSAGE))
        except DinerosError as error:
            return _refusal(error)
        except Exception as error:  # a mistake of ours must not end the stream
            LOG.error("steering failed: %s: %s", type(error).__name__, error)
            return _refusal(SteeringError(f"unexpected {type(error).__name__}", hint="please report it"))
        return None

    def _do(self, said: object) -> None:
        ask = said.get("ask") if isinstance(said, dict) else None
        fields = _FIELDS.get(ask) if isinstance(ask, str) else None
        if not isinstance(said, dict) or fields is None or set(said) != fields | {"ask"}:
            raise SteeringError("a page asks for signal, pause or proceed, and says of which node")
        net = self._nets.get(said["node"]) if isinstance(said["node"], str) else None
        if net is None:
            raise SteeringError("no such node runs here")
        if ask == "signal":
            if not isinstance(said["signal"], str):
                raise SteeringError("a signal is named by a text")
            net.set_signals({said["signal"]: said["value"]}, source="live page")
        elif ask == "pause":
            net.halt(PAUSED)
        elif net.status.reason == NOT_ACTIVE:
            raise SteeringError(NOT_ACTIVE, hint="activate it")
        else:
            net.proceed()

    def _watch(self) -> None:
        known = None
        while not self._ending.wait(INTERVAL):
            try:
                message = json.dumps({"type": "nodes", "nodes": self.nodes()}, ensure_ascii=False)
            except Exception as error:  # a node that has just ended
                LOG.debug("a node was not seen: %s", error)
                continue
            tell = self._tell
            if message != known and tell is not None:
                known = message
                tell(message)


def _refusal(error: DinerosError) -> str:
    reason = without_middle(f"{error.message} ({error.hint})" if error.hint else error.message)
    return json.dumps({"type": "refused", "reason": reason}, ensure_ascii=False)
