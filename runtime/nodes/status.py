"""The status of a node: available at once from any thread, even while a handler blocks the node."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Literal

from dineros.runtime.scheduling.watchdog import Blocked

State = Literal["running", "halted", "blocked", "failed", "ended", "crashed"]
"""``halted``: fires nothing until `proceed`; ``blocked``: a handler blocks the thread of the node;
``failed``: its loop ended with an error; ``ended``: it was stopped; ``crashed``: its process has ended, as
reported by its supervisor.
"""


@dataclass(frozen=True)
class ErrorReport:
    """A firing that failed; the marking is unchanged.

    Attributes
    ----------
    time : float
        Seconds since the epoch.
    transition, handler : str or None
        The transition and the handler that failed.
    error : str
        The error, as text.
    policy : str or None
        The policy that was applied.
    """

    time: float
    transition: str | None
    handler: str | None
    error: str
    policy: str | None


@dataclass(frozen=True)
class Status:
    """The status of a node.

    Attributes
    ----------
    node : str
        Its id.
    time : float
        Time of this status, in seconds since the epoch.
    state : {"running", "halted", "blocked", "failed", "ended", "crashed"}
    reason : str or None
        Why it does not run.
    error : ErrorReport or None
        The last failure of a firing.
    blocked : Blocked or None
        The handler that blocks it, with its position in the code.
    failures : int
        Number of failed firings.
    """

    node: str
    time: float
    state: State
    reason: str | None = None
    error: ErrorReport | None = None
    blocked: Blocked | None = None
    failures: int = 0

    def json(self) -> str:
        """Return it as JSON for the topic ``~/state``; ASCII without NUL, at which ROS would cut the text."""
        return json.dumps(asdict(self))
