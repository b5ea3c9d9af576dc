"""Lets the supervisor control a node of this process, over the line that the process inherited.

=============================================  ==================================================
the supervisor sends                           the node responds
=============================================  ==================================================
``{"number", "ask": "look"}``                  ``{"number", "outlook": {...}}``, an `Outlook`
``{"number", "ask": "set", values, source}``   ``{"number"}``, or ``{"number", "refused", "hint"}``
``{"number", "ask": "pause", "reason"}``       the same
``{"number", "ask": "proceed"}``               the same
=============================================  ==================================================
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from dataclasses import asdict
from typing import Any

from dineros.metamodel.errors import DinerosError, without_middle
from dineros.runtime.application.line import LOG, Line, LineError
from dineros.runtime.nodes.core import NOT_ACTIVE
from dineros.runtime.nodes.steering import Outlook, Steerable, SteeringError
from dineros.runtime.scheduling.threads import join

LEAVING = 1.0
"""Seconds for a response under way when the node ends."""


@contextlib.contextmanager
def steered_over(line: Line | None, find: Callable[[], Steerable | None]) -> Iterator[None]:
    """Let the supervisor control a node within the block; does nothing without a line.

    Parameters
    ----------
    line : Line or None
        To the supervisor; it is closed at the end.
    find : callable
        Returns the node; None while a managed node is not configured.
    """
    if line is None:
        yield
        return
    thread = threading.Thread(target=_serve, args=(line, find), name="dineros steering", daemon=True)
    thread.start()
    try:
        yield
    finally:
        line.hang_up()
        join(thread, LEAVING)


def _serve(line: Line, find: Callable[[], Steerable | None]) -> None:
    """Respond until the supervisor has closed the line. The node itself never waits for this thread."""
    try:
        while (said := line.receive()) is not None:
            number, answer = said.get("number"), _answer(said, find())
            try:
                line.say({"number": number, **answer}, waits=True)
            except LineError:  # very many transitions are enabled: it can be paused all the same
                few = {**answer.get("outlook", {}), "signals": None, "enabled": None, "values": {}}
                line.say({"number": number, "outlook": few}, waits=True)
    except OSError:
        pass  # the line was closed
    except Exception as error:  # a node continues without being controlled
        LOG.warning("pages can no longer control this node: %s", error)
    finally:
        line.close()


def _answer(said: dict[str, Any], node: Steerable | None) -> dict[str, Any]:
    try:
        match said:
            case {"ask": "look"}:
                outlook = Outlook("halted", NOT_ACTIVE) if node is None else node.look()
                return {"outlook": asdict(outlook)}
            case _ if node is None:
                raise SteeringError(NOT_ACTIVE, hint="activate it")
            case {"ask": "set", "values": dict(values), "source": str(source)}:
                node.set_signals(values, source)
            case {"ask": "pause", "reason": str(reason)}:
                node.pause(reason)
            case {"ask": "proceed"}:
                node.proceed()
            case _:
                raise SteeringError("nodes do not support this request")
    except DinerosError as error:
        return {"refused": without_middle(error.message), "hint": error.hint}
    return {}
