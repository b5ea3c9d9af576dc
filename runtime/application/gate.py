"""A gate through which the nodes of an application pass together, once all of them are ready.

A node that publishes as soon as it is ready would fill the histories of nodes that still start: these do not
take messages yet. So each node waits at the gate until no other node of the same start is missing.

The gate is a pipe that all these processes inherit. A process closes its writing end when it is ready; the
system closes that end if the process ends. The reading end reports that no writing end is left. So the
supervisor does nothing, and a process that fails holds up no other one. A process that is restarted has no
gate.
"""

from __future__ import annotations

import contextlib
import os
import select
import stat
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from dineros.runtime.application.line import LOG

GATE = "DINEROS_GATE"
"""Environment variable: the descriptors of the gate's reading end and writing end, separated by a comma."""

_STEP = 0.05


class Gate:
    """The gate in the process of a node.

    Parameters
    ----------
    reading, writing : int
        The descriptors of the two ends; they belong to the gate from now on.
    """

    def __init__(self, reading: int, writing: int) -> None:
        self._ends = [reading, writing]

    def leave(self) -> None:
        """Let the other nodes begin without this one."""
        while self._ends:
            os.close(self._ends.pop())

    def wait(self, limit: float, is_over: Callable[[], bool]) -> bool:
        """Wait until all other nodes are ready or have ended; return whether that happened.

        Parameters
        ----------
        limit : float
            Maximum number of seconds.
        is_over : callable
            Returns whether to stop waiting, for example because the node is to end.
        """
        if not self._ends:
            return True
        os.close(self._ends.pop())
        try:
            poll = select.poll()
            poll.register(self._ends[0], 0)  # POLLHUP, when no writing end is left, is always reported
            end = time.monotonic() + limit
            while not is_over() and time.monotonic() < end:
                if poll.poll(1000 * _STEP):
                    return True
            return False
        finally:
            self.leave()


@dataclass
class SharedGate:
    """The gate as the supervisor passes it to the processes that it starts together.

    Attributes
    ----------
    descriptors : sequence of int
        File descriptors of both ends of the pipe, which a process inherits; none without a gate.
    environment : dict of str to str
        Additions to the environment of a process.
    """

    descriptors: Sequence[int] = ()
    environment: dict[str, str] = field(default_factory=dict)


@contextlib.contextmanager
def new_gate() -> Iterator[SharedGate]:
    """Create a gate for the processes that are started within the block."""
    try:
        reading, writing = os.pipe()
    except OSError:  # without free descriptors, the start of a process fails with a better message
        yield SharedGate()
        return
    try:
        yield SharedGate((reading, writing), {GATE: f"{reading},{writing}"})
    finally:
        os.close(reading)
        os.close(writing)


def inherited_gate() -> Gate | None:
    """Take the gate that the supervisor gave this process; child processes do not inherit it."""
    given = os.environ.pop(GATE, "")
    if not given:
        return None
    try:
        reading, writing = (int(number) for number in given.split(","))
        for number in (reading, writing):
            if not stat.S_ISFIFO(os.fstat(number).st_mode):  # another file, which stays open
                raise ValueError(given)
            os.set_inheritable(number, False)
    except (ValueError, OverflowError, OSError):
        LOG.warning("%s does not name a pipe: this node does not wait for the others", GATE)
        return None
    return Gate(reading, writing)
