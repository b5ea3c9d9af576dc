"""Controls a run from its live page: enabled transitions of nodes, signals, and pausing a node."""

from __future__ import annotations

import json
import logging
import threading
from collections.abc import Callable, Mapping
from typing import Any

from dineros.metamodel.errors import DinerosError, without_middle
from dineros.metamodel.json_text import decode_json
from dineros.runtime.nodes.steering import Steerable, SteeringError

LOG = logging.getLogger("dineros.views.live")

LONGEST_MESSAGE = 4096
"""Limit of the characters of a message from a page."""

INTERVAL = 0.25
"""Seconds between two inspections of the nodes."""

PAUSED = "paused on the live page"
"""The reason of a halt by a page."""

_FIELDS = {"signal": {"node", "signal", "value"}, "pause": {"node"}, "proceed": {"node"}}


class Steering:
    """The nodes of a run, in this process or in others, for live pages.

    It inspects them on a separate thread while a page is open: a handler that blocks a node delays only its
    own inspection.
    """

    def __init__(self) -> None:
        self._nodes: Mapping[str, Steerable] = {}
        self._ending = threading.Event()
        self._is_watched = threading.Event()
        self._tell: Callable[[str], None] | None = None
        self._thread: threading.Thread | None = None

    def take(self, nodes: Mapping[str, Steerable]) -> None:
        """Control these nodes from now on, by id; none if the run has ended."""
        self._nodes = dict(nodes)

    def begin(self, tell: Callable[[str], None]) -> None:
        """Report changed states of the nodes from a thread."""
        self._tell = tell
        self._thread = threading.Thread(target=self._watch, name="dineros steering", daemon=True)
        self._thread.start()

    def watched(self, is_watched: bool) -> None:
        """Inspect the nodes while there is an observer."""
        if is_watched:
            self._is_watched.set()
        elif not self._ending.is_set():
            self._is_watched.clear()

    def end(self) -> None:
        """Stop reporting; does not wait for a blocked node."""
        self._ending.set()
        self._is_watched.set()
        self._tell = None

    def nodes(self) -> list[dict[str, Any]]:
        """Return the state of each node.

        Returns
        -------
        list of dict
            ``node``, ``state`` and ``reason``; and but for a node that cannot tell ``signals``: values by id,
            ``values``: the names that each signal with values can have, and ``enabled``: transitions that its
            net allows to fire.
        """
        found = []
        for node, steered in self._nodes.items():
            seen = steered.look()
            said: dict[str, Any] = {"node": node, "state": seen.state, "reason": seen.reason}
            if seen.signals is not None and seen.enabled is not None:
                said |= {"signals": dict(seen.signals), "enabled": list(seen.enabled)}
                if seen.values:
                    said["values"] = {signal: list(names) for signal, names in seen.values.items()}
            found.append(said)
        return found

    def hear(self, text: str | bytes) -> str | None:
        """Carry out the request of a page; if it is not possible, return a message with the reason.

        A node of another process has a few seconds to answer. Messages from pages never raise an exception.
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
            raise SteeringError("a request must be signal, pause or proceed, and must name a node")
        node = self._nodes.get(said["node"]) if isinstance(said["node"], str) else None
        if node is None:
            raise SteeringError("this node does not run here")
        if ask == "signal":
            if not isinstance(said["signal"], str):
                raise SteeringError("the name of a signal must be a string")
            node.set_signals({said["signal"]: said["value"]}, source="live page")
        elif ask == "pause":
            node.pause(PAUSED)
        else:
            node.proceed()

    def _watch(self) -> None:
        known = None
        while True:
            self._is_watched.wait()
            if self._ending.wait(INTERVAL):
                return
            try:
                message = json.dumps({"type": "nodes", "nodes": self.nodes()}, ensure_ascii=False)
            except Exception as error:  # a node that has just ended
                LOG.debug("a node could not be inspected: %s", error)
                continue
            tell = self._tell
            if message != known and tell is not None:
                known = message
                tell(message)


def _refusal(error: DinerosError) -> str:
    reason = without_middle(f"{error.message} ({error.hint})" if error.hint else error.message)
    return json.dumps({"type": "refused", "reason": reason}, ensure_ascii=False)
