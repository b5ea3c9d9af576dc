"""The runner of a net: its transport, its recorder, and the loop that drives it.

The loop runs on its own thread (`start`, `stop`, or a ``with`` block). Or the caller drives the node by
`open`, `step` and `close`, as tests and simulations do; then the same seed gives the same run.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import Self

from dineros.metamodel.errors import DinerosError
from dineros.runtime.channels.transport import Transport
from dineros.runtime.journal.recording import Recorder
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nodes.core import Core
from dineros.runtime.nodes.receiver import NodeReceiver
from dineros.runtime.scheduling.threads import join
from dineros.runtime.scheduling.watchdog import GivenUpError

LOG = logging.getLogger("dineros.runtime")
SETTLING = 1.5
"""Seconds for running handlers and messages under way when a node's process is to end."""

QUIET = 0.1
"""Idle time in seconds after which a node counts as settled."""

PATIENCE = 2.0
"""Seconds for a handler to return when its node is to end; then its firing is released."""


class Runner:
    """Runs the core of a net, with a transport and a recorder.

    Parameters
    ----------
    core : Core
        It belongs to this runner from now on.
    transport, recorder, resume, run, request_timeout
        As for `Node`.

    Attributes
    ----------
    exchange : Exchange
        The ports of the node.
    receiver : NodeReceiver
        Receives what the transport delivers.

    Raises
    ------
    DinerosError
        The net runs already, or does not fit the state from which it is to continue.
    """

    def __init__(
        self,
        core: Core,
        transport: Transport | None = None,
        recorder: Recorder | None = None,
        *,
        resume: SavedState | None = None,
        run: str = "",
        request_timeout: float | None = None,
    ) -> None:
        self._id = core.structure.ports.node
        self._core = core
        self._transport = transport
        self._recorder = recorder
        self._is_resumed = resume is not None
        self.exchange, self._arrivals = core.attach(run, request_timeout, resume)
        self.receiver = NodeReceiver(core, self.exchange, self._arrivals)
        self._loop = core.loop
        self._execution = core.execution
        self._thread: threading.Thread | None = None
        self._is_open = False
        self._is_ending = False

    @property
    def ended_by(self) -> str | None:
        """Why it has stopped running; None: it runs, or has not begun."""
        return self._core.ended_by

    @property
    def failure(self) -> BaseException | None:
        """Error that ended the loop before `stop`, for example of a recorder that cannot write."""
        return self._core.failure

    @property
    def is_running(self) -> bool:
        """Whether its own thread is running."""
        return self._thread is not None and self._thread.is_alive()

    # Lifetime.

    def open(self) -> None:
        """Record the start and join the channels; then `step` drives the node.

        If this fails, the node is closed again.
        """
        core = self._core
        if self._recorder is not None:
            self._recorder.open(core.structure.ports, self.checkpoint)
            core.observers.record_with(self._recorder.record)
        state = self.checkpoint()
        core.observers.emit(
            "start",
            marking=state["marking"],
            signals=state["signals"],
            resumed=self._is_resumed,
            seed=core.seed,
        )
        self._is_open, self._core.ended_by = True, None
        with self._loop:
            core.expectations.begin()
        if self._transport is not None:
            try:
                self._join(self._transport)
            except BaseException:
                self.close("failure")
                raise

    def _join(self, transport: Transport) -> None:
        transport.open(self._core.structure.ports, self.receiver)
        self.exchange.traffic.join(transport)
        self._execution.departures.check_by(self.exchange.traffic.checks, self._core.structure)
        self.exchange.begin()
        if self._is_resumed:
            # Messages sent but not recorded before the node was killed precede all messages that arrive now:
            # they are
            # sent and recorded first, so that the records are in the order of events.
            with self._loop:
                self.exchange.depart()
        if transport.has_timers:
            self._execution.timing.leave_ticks()
            transport.start_timers()

    def step(self) -> bool:
        """Handle arrivals, begin at most one firing, send what is due; return whether there was work."""
        with self._loop:
            return self.turn()

    def turn(self) -> bool:
        """Like `step`, on the thread that has adopted the loop.

        It does not lock the loop, so that other threads can end the node while a handler blocks it.
        """
        try:
            return self._step()
        except Exception as error:  # later steps must not depend on an unrecorded one
            self._fail(error)
            raise

    def _step(self) -> bool:
        did = self._loop.run_actions()
        if self._execution.fire_one():
            did = True
        if self.exchange.depart():
            did = True
        if self._core.engine.opened and self._arrivals.let_in():
            did = True
        if self._execution.in_flight:
            self._execution.in_flight.refresh(self._core.engine)
        return did

    def hold_departures(self) -> None:
        """Disable automatic sending: a test calls `send_one` when its next step is to send."""
        with self._loop:
            self.exchange.hold_departures()

    def send_one(self, channel: str, place: str) -> None:
        """Send the oldest token of a place to a channel, after `hold_departures`.

        Raises
        ------
        DinerosError
            The place has no departure, or the transport failed.
        """
        with self._loop:
            self.exchange.send_one(channel, place)

    def lose_cancel(self, channel: str, place: str) -> None:
        """Drop the oldest cancel request of a place, after `hold_departures`."""
        with self._loop:
            self.exchange.lose_cancel(channel, place)

    def run_until_idle(self, limit: int = 1_000_000) -> int:
        """Step until there is nothing left to do; return the number of steps.

        Raises
        ------
        DinerosError
            There is still work after `limit` steps.
        """
        for steps in range(limit):
            if not self.step():
                return steps
        raise DinerosError(f"the node {self._id} is not idle after {limit} steps")

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until there is something to do, or for `timeout` seconds; return whether there is."""
        return self._loop.wait(timeout)

    def close(self, reason: str = "stopped") -> None:
        """Leave the channels, release firings in flight, record the end; a second call does nothing."""
        if not self._is_open:
            return
        self._is_open = False
        self._core.ended_by = self._core.ended_by or reason
        try:
            if self._transport is not None:
                self._transport.close()
        finally:
            with self._loop:
                self._core.expectations.end()
                self._execution.close()
            try:
                if self._core.failure is None:
                    self._core.observers.emit("stop", reason=reason)
                self._core.observers.status_changed()
            finally:
                self._core.observers.record_with(None)
                if self._recorder is not None:
                    self._recorder.close()

    def start(self) -> None:
        """Run the node on its own thread; opens it first if needed."""
        if not self._is_open:
            self.open()
        self._is_ending = False
        self._thread = threading.Thread(target=self._run, name=f"dineros {self._id}", daemon=True)
        self._loop.begin()
        self._thread.start()

    def _run(self) -> None:
        step, loop = self._step, self._loop
        loop.adopt()
        try:
            while not self._is_ending:
                if not step():
                    loop.wait()
        except GivenUpError:
            pass
        except BaseException as error:
            self._fail(error)
        finally:
            loop.abandon()

    def _fail(self, error: BaseException) -> None:
        # The text of a DinerosError suffices: a full disk, for example, is not a fault of the program.
        trace = None if isinstance(error, DinerosError) else error
        LOG.critical("the node %s ends: %s", self._id, error, exc_info=trace)
        self._core.failure = error
        self._core.ended_by = f"{type(error).__name__}: {error}"
        self._execution.halt(f"the node has ended: {error}")

    def settle(self, seconds: float) -> bool:
        """Begin no new firing, and wait for firings in flight and arriving messages; from another thread.

        Unfinished work is not lost: a node that continues begins the firings again and gets the messages
        again.

        Parameters
        ----------
        seconds : float
            Maximum waiting time.

        Returns
        -------
        bool
            Whether there is nothing left to do.
        """
        execution, loop = self._execution, self._loop
        loop.post(lambda: execution.halt("the node is to end", logging.DEBUG))
        end = time.monotonic() + seconds
        quiet_since: float | None = None
        while (now := time.monotonic()) < end and self._core.failure is None:
            is_quiet = execution.halted is not None and not execution.in_flight and not loop.has_actions
            quiet_since = (quiet_since or now) if is_quiet else None
            if quiet_since is not None and now - quiet_since >= QUIET:
                return True
            time.sleep(0.01)
        return False

    def end(self) -> None:
        """Let the thread end after its current step; `stop` waits for that."""
        self._is_ending = True
        self._loop.post(lambda: None)

    def stop(self, reason: str = "stopped", patience: float = PATIENCE) -> None:
        """End the thread after its current step, and close the node.

        Parameters
        ----------
        reason : str
            Reason, for the record.
        patience : float
            Seconds for a handler to return; then its firing is released and its result is ignored.

        Raises
        ------
        DinerosError
            The thread does not end, although no handler is running.
        BaseException
            The error that ended the loop before.
        """
        self.end()
        if self._thread is not None and self._thread is not threading.current_thread():
            self.await_end(self.join, patience)
            self._thread = None
        self.close(reason)
        if self._core.failure is not None:
            raise self._core.failure

    def await_end(self, join: Callable[[float], bool], patience: float = PATIENCE) -> bool:
        """Wait until the thread of the node has ended; abandon it if a handler does not return.

        Parameters
        ----------
        join : callable
            Waits for the thread for this number of seconds; returns whether it has ended.
        patience : float
            Seconds for a handler to return.

        Returns
        -------
        bool
            Whether the thread has ended; False: only a handler still runs on it, which no longer affects the
            node.

        Raises
        ------
        DinerosError
            It does not end, although no handler is running.
        """
        if join(patience):
            return True
        for _ in range(50):
            if self._execution.give_up_blocking(patience):
                self._loop.abandon()
                return False
            if join(0.1):
                return True
        raise DinerosError(f"the node {self._id} does not end", hint="its transport or its disk may hang")

    def join(self, timeout: float | None = None) -> bool:
        """Wait until the thread has ended because of a failure; return whether it has."""
        join(self._thread, timeout)
        return not self.is_running

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()

    def checkpoint(self) -> SavedState:
        """Return the state needed to continue from here; on the node's thread, or while it is stopped."""
        return self._core.save(self.exchange.save())
