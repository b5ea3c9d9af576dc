"""How a node is, in short: told from any thread at once, also while a handler blocks the node."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Literal

from dineros.runtime.scheduling.watchdog import Blocked

State = Literal["running", "halted", "blocked", "failed", "ended", "crashed"]
"""``halted``: fires nothing until it is told to proceed; ``blocked``: a handler keeps it from all else;
``failed``: its loop has ended by an error; ``ended``: it was told to end; ``crashed``: its process is gone,
as its supervisor tells.
"""


@dataclass(frozen=True)
class ErrorReport:
    """A firing that failed and changed nothing.

    Attributes
    ----------
    time : float
        Seconds since the epoch.
    transition, handler : str or None
        Where.
    error : str
        What happened.
    policy : str or None
        What was done about it.
    """

    time: float
    transition: str | None
    handler: str | None
    error: str
    policy: str | None


@dataclass(frozen=True)
class Status:
    """How a node is.

    Attributes
    ----------
    node : str
        Its id.
    time : float
        When it was told, in seconds since the epoch.
    state : {"running", "halted", "blocked", "failed", "ended", "crashed"}
    reason : str or None
        Why it does not run.
    error : ErrorReport or None
        The last failure of a firing.
    blocked : Blocked or None
        The handler that blocks it, and where that is.
    failures : int
        How many firings have failed.
    """

    node: str
    time: float
    state: State
    reason: str | None = None
    error: ErrorReport | None = None
    blocked: Blocked | None = None
    failures: int = 0

    def json(self) -> str:
        """Return it as JSON, as the topic ``~/state`` carries it; ASCII without NUL, which ROS would cut."""
        return json.dumps(asdict(self))
