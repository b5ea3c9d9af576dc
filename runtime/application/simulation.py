"""All nodes of an application in one process: stepped in simulated time, or on threads in real time.

When stepped, one thread makes one move at a time, of a node or of a message, drawn with the seed. Simulated
time passes with each move, and jumps ahead when there is nothing left to do. The same seed gives the same
run, as long as all handlers run on that thread.
"""

from __future__ import annotations

import math
import random
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Literal

from dineros.metamodel import rtm
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.lifecycles.start_order import in_order
from dineros.runtime.channels.local import LocalNetwork
from dineros.runtime.firing.policies import Policy
from dineros.runtime.journal.recording import Recorder
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.node import Node
from dineros.runtime.nodes.runner import PATIENCE, SETTLING
from dineros.runtime.scheduling.threads import join
from dineros.runtime.scheduling.timers import Timers

Outcome = Literal["reached", "idle", "timeout"]
"""Why a stepped run ended: the condition holds, nothing more can happen, or the time is over."""

STEP_TIME = 0.001
"""Simulated seconds that a move takes, unless a transition has to fire before."""
MOST_AT_ONCE = 10_000
"""Maximum number of successive moves that take no time."""
LONGEST_WAIT = 0.05
"""Seconds of real time between two checks whether a paced run is to end."""


class SimulatedClock:
    """A clock whose time is set explicitly."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        """Return the seconds since the start."""
        return self.now


class LocalApplication:
    """The nodes of a system model, joined in this process.

    Parameters
    ----------
    models : iterable of rtm.RuntimeModel
        One per node.
    seed : int, optional
        Seed of all choices: the selections of the nodes, and the next move in `run`.
    policy : Policy, optional
        Policy for failed firings; by default the node halts.
    recorder : callable, optional
        Returns the recorder of a node, by its id.
    resume : mapping of str to SavedState
        Saved states from which nodes continue, by id.
    simulated_time : bool
        Whether `run` steps the application in simulated time; False: `start` runs it on threads.
    request_timeout : float, optional
        Seconds after which clients send a request again.

    Attributes
    ----------
    nets : dict of str to Net
        By the node's id; register handlers here, before or after `open`.
    nodes : dict of str to Node
        By id.
    network : LocalNetwork
        The channels.
    """

    def __init__(
        self,
        models: Iterable[rtm.RuntimeModel],
        *,
        seed: int | None = None,
        policy: Policy | None = None,
        recorder: Callable[[str], Recorder] | None = None,
        resume: Mapping[str, SavedState] | None = None,
        simulated_time: bool = True,
        request_timeout: float | None = None,
    ) -> None:
        self.seed = random.SystemRandom().getrandbits(32) if seed is None else seed
        self._random = random.Random(self.seed)
        self._simulated = SimulatedClock() if simulated_time else None
        self.clock: Callable[[], float] = self._simulated or time.monotonic
        self.network = LocalNetwork(self._random.getrandbits(32))
        self.nets: dict[str, Net] = {}
        self.nodes: dict[str, Node] = {}
        self._timers = Timers(self.clock)
        self._moves_at_once = 0
        self._ticks: list[tuple[float, Callable[[float], object]]] = []
        self._threads: list[threading.Thread] = []
        self._ending = threading.Event()
        for model in models:
            net = Net(model, seed=self._random.getrandbits(32), policy=policy, clock=self.clock)
            if net.id in self.nets:
                raise DinerosError(f"two runtime models are for the node {net.id!r}")
            if simulated_time:
                net.draw_times(random.Random(f"{self.seed} {net.id}"))
            self.nets[net.id] = net
            self.nodes[net.id] = Node(
                net,
                self.network.transport(),
                recorder(net.id) if recorder is not None else None,
                resume=(resume or {}).get(net.id),
                request_timeout=request_timeout,
            )

    def every(self, seconds: float, action: Callable[[float], object]) -> None:
        """Call an action repeatedly, such as a simulator's step; it gets the seconds passed."""
        self._ticks.append((seconds, action))

    def count(self, node: str, place: str) -> int:
        """Return the number of tokens on a place of a node."""
        return self.nets[node].count(place)

    # Stepping.

    def open(self) -> None:
        """Join all nodes to their channels before any node sends; if one fails, all are closed."""
        try:
            for node in self.nodes.values():
                node.open()
            self._bring_up()
        except BaseException:
            self.close("failure")
            raise
        if self._simulated is not None:
            for seconds, action in self._ticks:
                self._tick(seconds, action)

    def _bring_up(self) -> None:
        """Configure and activate the managed nodes in the start order, like their manager, before any move.

        A node that continues from a saved state keeps its lifecycle state.
        """
        steps = [
            (number, label, net)
            for net in self.nets.values()
            if net.state == "unconfigured"
            for label, number in net.core.structure.ports.start_steps.items()
        ]
        for _, label, net in sorted(steps, key=lambda step: in_order(step[:2])):
            net.change_state(label)

    def _tick(self, seconds: float, action: Callable[[float], object]) -> None:
        def again() -> None:
            action(seconds)
            self._timers.call_later(seconds, again)

        self._timers.call_later(seconds, again)

    def step(self) -> bool:
        """Make one move of a node or a message; False: there is none now."""
        movers: list[Callable[[], bool]] = [node.step for node in self.nodes.values()]
        movers.append(self.network.step)
        while movers:
            if movers.pop(int(self._random.random() * len(movers)))():
                return True
        return False

    def run(
        self,
        until: Callable[[LocalApplication], bool],
        timeout: float | None = None,
        speed: float | None = None,
    ) -> Outcome:
        """Step the application, which must be open, until a condition holds.

        Parameters
        ----------
        until : callable
            The condition; checked after each move.
        timeout : float, optional
            Seconds of simulated time.
        speed : float, optional
            Maximum simulated seconds per second of real time; by default unlimited.
        """
        if self._simulated is None:
            raise DinerosError("the application runs in real time", hint="use start() and wait_for()")
        clock = self._simulated
        end = None if timeout is None else clock.now + timeout
        begun, really = clock.now, time.monotonic()
        while not until(self):
            if end is not None and clock.now >= end:
                return "timeout"
            if self.step():
                self._pass_step(clock)
            elif not self._let_time_pass(end):
                return "idle"
            if speed is not None:
                self._wait(until, really + (clock.now - begun) / speed)
            self._timers.run_due()
        return "reached"

    def _pass_step(self, clock: SimulatedClock) -> None:
        """Let time pass for a move, but not beyond the time by which a transition has to fire.

        Moves that take no time could continue forever. After many of them, time passes nevertheless.
        """
        deadlines = [each for net in self.nets.values() if (each := net.deadline) is not None]
        latest = min(deadlines, default=math.inf)
        if latest <= clock.now and self._moves_at_once < MOST_AT_ONCE:
            self._moves_at_once += 1
            return
        self._moves_at_once = 0
        clock.now = clock.now + STEP_TIME if latest <= clock.now else min(clock.now + STEP_TIME, latest)

    def _wait(self, until: Callable[[LocalApplication], bool], moment: float) -> None:
        """Wait until a time on the real clock, or until a condition holds."""
        while (left := moment - time.monotonic()) > 0 and not until(self):
            time.sleep(min(left, LONGEST_WAIT))

    def _let_time_pass(self, end: float | None) -> bool:
        """Advance the time to the next event; False: there is no event."""
        assert self._simulated is not None
        states = [net.inspect() for net in self.nets.values()]
        if any(state.in_flight or (state.outliving and state.halted is None) for state in states):
            started = time.monotonic()
            time.sleep(STEP_TIME)  # handlers on other threads take real time
            self._simulated.now += time.monotonic() - started
            return True
        times = [net.next_timer for net in self.nets.values()] + [self._timers.next_time, end]
        due = min((each for each in times if each is not None), default=None)
        if due is None:
            return False
        self._simulated.now = max(self._simulated.now, due)
        return True

    def close(self, reason: str = "stopped") -> None:
        """Close all nodes."""
        for node in self.nodes.values():
            node.close(reason)

    # On threads.

    def start(self) -> None:
        """Run each node on its own thread, in real time."""
        if self._simulated is not None:
            raise DinerosError("the application runs in simulated time", hint="use run()")
        self.open()
        try:
            self.network.start()
            for node in self.nodes.values():
                node.start()
            self._ending.clear()
            for seconds, action in self._ticks:
                thread = threading.Thread(
                    target=self._beat, args=(seconds, action), name="dineros simulator", daemon=True
                )
                thread.start()
                self._threads.append(thread)
        except BaseException:  # also on an interrupt, the nodes that run already are ended
            self.stop()
            raise

    def _beat(self, seconds: float, action: Callable[[float], object]) -> None:
        last = time.monotonic()
        while not self._ending.wait(seconds):
            now = time.monotonic()
            action(now - last)
            last = now

    def stop(self, reason: str = "stopped") -> None:
        """Stop simulators, nodes and channels, in this order."""
        self._ending.set()
        deadline = time.monotonic() + SETTLING
        for node in self.nodes.values():  # first no node begins anything new, then all end
            node.net.halt("the application is to end")
        while time.monotonic() < deadline and any(net.core.execution.in_flight for net in self.nets.values()):
            time.sleep(STEP_TIME)
        for node in self.nodes.values():
            node.end()
        end = time.monotonic() + PATIENCE  # for all nodes together
        for thread in self._threads:
            join(thread, max(0.0, end - time.monotonic()))
        self._threads.clear()
        failures = []
        for node in self.nodes.values():
            try:
                node.stop(reason, max(0.0, end - time.monotonic()))
            except Exception as error:
                failures.append(error)
        self.network.stop()
        if failures:
            raise failures[0]

    def __enter__(self) -> LocalApplication:
        """Open the application in simulated time, or start it in real time."""
        if self._simulated is not None:
            self.open()
        else:
            self.start()
        return self

    def __exit__(self, *exception: object) -> None:
        if self._simulated is not None:
            self.close()
        else:
            self.stop()
