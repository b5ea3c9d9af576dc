"""A node that runs on ROS 2: its net fires on the thread that runs the ROS callbacks.

So this thread can react to a message without waking up another thread.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

from dineros.runtime.journal.recording import Recorder
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.node import Node
from dineros.runtime.nodes.runner import SETTLING
from dineros.runtime.nodes.steering import SteeredNet
from dineros.runtime.ros.channels.transport import RclpyTransport
from dineros.runtime.ros.control import Control
from dineros.runtime.ros.diagnostics import Diagnostics
from dineros.runtime.ros.process.session import Session

SLICE = 0.002
"""Maximum time in seconds that a busy net works before ROS callbacks run."""


class RosNode:
    """A net as a ROS node.

    Parameters
    ----------
    net : Net
        The net.
    recorder : Recorder, optional
        Without one, there are no records.
    resume : SavedState, optional
        Saved state from which the node continues.
    run : str
        Part of the ids of messages, see `Node`.
    arguments : sequence of str
        Arguments for ROS: ``["--ros-args", "-r", "__ns:=/cell", "-p", "signals.Red:=true"]``.
    domain : int, optional
        The ROS domain; by default that of the environment.
    session : Session, optional
        The ROS node to use, not started yet; by default one with the name and namespace in the model.

    Attributes
    ----------
    steered : SteeredNet
        Controls the net.

    Raises
    ------
    RosError
        ROS 2 is not available, or refuses a name or an argument.
    """

    def __init__(
        self,
        net: Net,
        recorder: Recorder | None = None,
        *,
        resume: SavedState | None = None,
        run: str = "",
        arguments: Sequence[str] = (),
        domain: int | None = None,
        session: Session | None = None,
    ) -> None:
        core = net.core
        ports = core.structure.ports
        self.net = net
        self.session = session or Session(
            ports.name,
            ports.namespace,
            arguments=arguments,
            executor=ports.executor,
            threads=ports.threads,
            domain=domain,
        )
        self.node = Node(
            net,
            RclpyTransport(
                self.session, _last_seen(resume) if resume else None, announces=recorder is not None
            ),
            recorder,
            resume=resume,
            run=run,
        )
        self._loop = core.loop
        self._is_adopted = False
        self.diagnostics = Diagnostics(self.session.node, net)
        self.control = Control(self.session.node, net, self.diagnostics.said)
        # If the model has a lifecycle, the net itself knows the states in which it fires.
        self.steered = SteeredNet(net, lambda: ports.is_managed or self.control.is_active)

    @property
    def failure(self) -> BaseException | None:
        """Error that ended the node before `stop`."""
        return self.session.failure

    def open(self) -> None:
        """Join the channels; the thread that runs the session's callbacks calls `work` between them."""
        self._loop.wake_by(self._wake)
        try:
            self.control.open()
            self.diagnostics.open()
            self.node.open()  # last: from then on, messages arrive
        except BaseException:
            self.close("failure")
            raise
        self._loop.begin()

    def work(self) -> float | None:
        """Let the net do its work; return the seconds until its next timer."""
        if not self._is_adopted:
            self._loop.adopt()
            self._is_adopted = True
        turn, end = self.node.turn, time.monotonic() + SLICE
        while turn():
            if time.monotonic() > end:
                return 0.0
        return self._loop.steady_timers.seconds_left  # simulated time advances by a message, which wakes it

    def close(self, reason: str = "stopped") -> None:
        """Leave the channels and record the end; the session continues."""
        self._loop.abandon()
        self._loop.wake_by(None)
        try:
            self.node.close(reason)
        finally:
            self.control.close()
            self.diagnostics.close()

    def _wake(self) -> None:
        """Let actions of other threads run at once, not only after the next ROS callback."""
        if not self.session.is_own_thread:
            self.session.wake()

    def start(self) -> None:
        """Join the channels and run on its own thread."""
        try:
            self.open()
        except BaseException:
            self.session.close()
            raise
        self.session.start(self.work)

    def stop(self, reason: str = "stopped") -> None:
        """End the thread, leave the channels, record the end, destroy the ROS node."""
        self.await_end()
        try:
            self.close(reason)
        finally:
            self.session.close()

    def await_end(self) -> None:
        """Wait for firings in flight, then for the thread; the firing of a stuck handler is released.

        Raises
        ------
        DinerosError
            It does not end, although no handler runs.
        """
        if not self.session.join(0):
            self.node.settle(SETTLING)
        self.session.end()
        if not self.node.await_end(self.session.join):
            self.session.cut_off()

    def join(self, timeout: float | None = None) -> bool:
        """Wait until the node has ended; return whether it has."""
        return self.session.join(timeout)

    def __enter__(self) -> RosNode:
        self.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()


def _last_seen(checkpoint: SavedState) -> dict[str, dict[str, int]]:
    """Return, for each subscriber and sender, the greatest number received."""
    found = {port: dict(senders) for port, senders in checkpoint["seen"].items()}
    for port, senders in checkpoint.get("seen_apart", {}).items():
        for sender, ranges in senders.items():
            known = found.setdefault(port, {})
            known[sender] = max(known.get(sender, 0), *(last for _, last in ranges))
    return found
