"""The net in the API for developers: handlers, selection, signals, and its state (paper, Sect. 5.2).

A program loads a net, registers its handlers, and runs it::

    net = Net.load("runtime/feedback.rtm.xmi")

    @net.handler("TShowResult", priority=1)
    def show(firing):
        print("sorted", firing.data["color"])

    with net:
        net.wait_for(lambda state: state.count("Shown") == 3)
"""

from __future__ import annotations

import logging
import random
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from dineros.metamodel import rtm
from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError, FeatureValueError, Location, ModelFileError, with_article
from dineros.metamodel.files import load
from dineros.metamodel.lifecycles.states import State as LifecycleState
from dineros.runtime.firing.acceptance import J
from dineros.runtime.firing.handlers import Handler, HandlerFunction
from dineros.runtime.firing.policies import Halt, Policy
from dineros.runtime.firing.selection import SelectionFunction
from dineros.runtime.nets.signals import Signal
from dineros.runtime.nets.sources import Source
from dineros.runtime.nets.structure import Structure, read_structure
from dineros.runtime.nodes.core import Core
from dineros.runtime.nodes.inspection import Inspection, inspected
from dineros.runtime.nodes.observers import Change
from dineros.runtime.nodes.runner import Runner
from dineros.runtime.nodes.status import Status
from dineros.runtime.scheduling.watchdog import LIMIT

POLL = 0.05
"""Seconds after which `wait_for` checks again without a notification."""

F = TypeVar("F", bound=HandlerFunction)
S = TypeVar("S", bound="SelectionFunction | None")
C = TypeVar("C", bound="Callable[[Change], object]")


class Net:
    """The net of one ROS node.

    Parameters
    ----------
    model : rtm.RuntimeModel
        The runtime model.
    seed : int, optional
        Seed of the firing selection; by default a different one in each run.
    policy : Policy
        Policy for a failed firing if its handler has none of its own.
    clock : callable
        Returns the time in seconds, for time-outs and delays.
    watchdog : float, optional
        Seconds after which a handler that blocks the node is reported; None: never.
    steady : callable, optional
        Returns the machine's time in seconds, if `clock` is the time of an external simulation such as
        ``/clock``: the delay before a lost request is sent again is measured by it.

    Attributes
    ----------
    core : Core
        The parts of the net, for its runner.

    Raises
    ------
    DinerosError
        The model cannot run.
    """

    def __init__(
        self,
        model: rtm.RuntimeModel,
        *,
        seed: int | None = None,
        policy: Policy | None = None,
        clock: Callable[[], float] = time.monotonic,
        watchdog: float | None = LIMIT,
        steady: Callable[[], float] | None = None,
    ) -> None:
        own_seed = random.SystemRandom().getrandbits(32) if seed is None else seed
        self._ros_node: Any = None
        self.core = Core(read_structure(model), own_seed, policy or Halt(), clock, steady)
        self.watchdog = watchdog

    @classmethod
    def load(
        cls,
        path: Path | str,
        *,
        seed: int | None = None,
        policy: Policy | None = None,
        clock: Callable[[], float] = time.monotonic,
        watchdog: float | None = LIMIT,
    ) -> Net:
        """Return the net of a runtime model in a file.

        Raises
        ------
        ModelFileError
            The file cannot be read, or holds no runtime model.
        DinerosError
            The model cannot run.
        """
        return cls(load_runtime_model(path), seed=seed, policy=policy, clock=clock, watchdog=watchdog)

    @property
    def id(self) -> str:
        """Id of the node net."""
        return self.core.structure.ports.node

    @property
    def seed(self) -> int:
        """Seed of the firing selection."""
        return self.core.seed

    @property
    def ros_node(self) -> Any:
        """The rclpy node of the net, for additional publishers and clients in handlers.

        Raises
        ------
        DinerosError
            The net does not run on ROS.
        """
        if self._ros_node is None:
            raise DinerosError(f"the node {self.id} does not run on ROS", hint="request it while it does")
        return self._ros_node

    @ros_node.setter
    def ros_node(self, node: Any) -> None:
        self._ros_node = node

    @property
    def structure(self) -> Structure:
        """Places, transitions and ports, as plain values."""
        return self.core.structure

    # Handlers.

    def handler(
        self,
        transition: str,
        *,
        priority: int = 0,
        name: str | None = None,
        thread: bool = False,
        timeout: float | None = None,
        parallel: int = 1,
        policy: Policy | None = None,
        budget: float | None = None,
        replace: bool = False,
    ) -> Callable[[F], F]:
        """Register the decorated function as a handler; from any thread, also while the net runs.

        Parameters
        ----------
        transition : str
            Id or name in the model, for all server instances; or the id of one of them, ``Pick[2].TPick``.
        priority : int
            Higher runs first; the result of the last handler counts.
        name : str, optional
            Unique at the transition; by default the name of the function.
        thread : bool
            Set it for a function that takes long: it runs on its own thread; the transition is in flight
            meanwhile. An ``async`` function always runs on an event loop, in flight.
        timeout : float, optional
            Seconds after which it fails. With a time-out, a plain function runs on its own thread.
        parallel : int
            Maximum number of firings of a transition in flight at the same time.
        policy : Policy, optional
            Policy for its failures; by default the policy of the net.
        budget : float, optional
            Declared maximum run time, in seconds. A longer run is reported in the node's log and its
            diagnostics; its result still counts.
        replace : bool
            Whether it replaces the handler of the same name.

        Raises
        ------
        UnknownElementError
            There is no such transition.
        HandlerError
            The transition has a handler of this name already, or `function` is not callable.
        """

        def register(function: F) -> F:
            own = name or getattr(function, "__name__", None) or type(function).__name__
            handler = Handler(transition, own, function, priority, thread, timeout, parallel, policy, budget)
            self.core.handlers.add(handler, is_replacing=replace)
            return function

        return register

    @property
    def handlers(self) -> tuple[Handler, ...]:
        """All handlers, in the order they were registered."""
        return self.core.handlers.all()

    def remove_handler(self, transition: str, name: str) -> None:
        """Remove a handler; from any thread.

        Raises
        ------
        HandlerError
            There is no such handler.
        """
        self.core.handlers.remove(transition, name)

    def set_priority(self, transition: str, name: str, priority: int) -> None:
        """Change the priority of a handler; from any thread.

        Raises
        ------
        HandlerError
            There is no such handler.
        """
        self.core.handlers.set_priority(transition, name, priority)

    def selection(self, function: S) -> S:
        """Set a function that chooses what fires; None: choose uniformly at random. Works as a decorator.

        The function gets the enabled transitions (`Candidates`). It returns one of them, one with other
        tokens (`Enabled.taking`), or None; after None it is called again after the next change.
        """
        self.core.execution.chooser.selection = function
        self.core.loop.post(lambda: None)
        return function

    def accepts(self, action: str) -> Callable[[J], J]:
        """Let the decorated function decide which goals of an action are accepted, if it may refuse goals.

        The function gets the data of an arriving goal, on the node's thread, and returns whether the goal is
        accepted. If it fails, the goal is refused.

        Raises
        ------
        HandlerError
            The node serves no action with this id, or the model does not let it refuse goals.
        """

        def register(function: J) -> J:
            self.core.acceptance.register(action, function)
            return function

        return register

    @property
    def policy(self) -> Policy:
        """Policy for a failed firing if its handler has none of its own."""
        return self.core.execution.policy

    @policy.setter
    def policy(self, policy: Policy) -> None:
        self.core.execution.policy = policy

    @property
    def watchdog(self) -> float | None:
        """Seconds after which a handler that blocks the node is reported; None: never."""
        return self.core.execution.watchdog.limit

    @watchdog.setter
    def watchdog(self, seconds: float | None) -> None:
        if seconds is not None and not 0 < seconds < float("inf"):
            raise FeatureValueError(
                f"the time of a watchdog must be above 0 s, not {seconds}", hint="None disables it"
            )
        self.core.execution.watchdog.limit = seconds

    def release(self, transition: str | None = None) -> None:
        """Let one or all transitions take the tokens again that were put aside after a failure.

        Raises
        ------
        UnknownElementError
            There is no such transition.
        """
        everything = tuple(range(len(self.core.structure.transitions)))
        numbers = everything if transition is None else self.core.names.transitions(transition)
        self.core.loop.submit(lambda: self.core.execution.release(numbers))

    def give_up(self) -> list[str]:
        """Release all firings in flight, and return their transitions; from any thread.

        Coroutines are cancelled. Threads cannot be stopped: their results are ignored, and the transition
        waits until its thread has ended.
        """
        return self.core.loop.call(self.core.execution.give_up)

    @property
    def state(self) -> LifecycleState:
        """The state of a managed node; any other node is active."""
        return self.core.state

    def change_state(self, label: str) -> None:
        """Configure, activate, deactivate, clean up or shut down a managed node; from any thread.

        Parameters
        ----------
        label : {"configure", "activate", "deactivate", "cleanup", "shutdown"}
            The requested change.

        Raises
        ------
        DinerosError
            It is not a managed node, or its state does not allow this change.
        """
        self.core.loop.call(lambda: self.core.change_state(label))

    def halt(self, reason: str = "halted by the program") -> None:
        """Stop firing until `proceed`; tokens and signals still arrive."""
        self.core.loop.submit(lambda: self.core.execution.halt(reason, logging.INFO))

    def proceed(self) -> None:
        """Continue firing after a halt."""
        self.core.loop.submit(self.core.execution.proceed)

    # Signals and observers.

    def signal(self, name: str) -> Signal:
        """Return an input signal, by id or name.

        Raises
        ------
        UnknownElementError
            The node has no such signal.
        """
        return self.core.signal(name)

    def set_signals(self, values: Mapping[str, SignalSetting], source: str = "program") -> None:
        """Set several input signals at once, so that nothing fires in between; from any thread.

        Parameters
        ----------
        values : mapping of str to bool or str
            Id or name of a signal -> its value; the name of one if the signal has values.
        source : str
            Origin of the values, for the records.

        Raises
        ------
        UnknownElementError
            The node has no such signal; none is set.
        FeatureValueError
            A signal cannot have its value; no signal is changed.
        """
        self.core.submit_signals(values, source)

    def new_source(self, name: str) -> Source:
        """Return the counters of a signal source; `inspect` shows them from now on."""
        return self.core.new_source(name)

    def remove_source(self, source: Source) -> None:
        """Stop showing these counters."""
        self.core.remove_source(source)

    def on_change(self, callback: C) -> C:
        """Call a function after each change, on the node's thread; works as a decorator.

        The function must return quickly, since the net waits for it. Its errors are logged and change
        nothing.
        """
        self.core.observers.add_callback(callback)
        return callback

    def remove_callback(self, callback: Callable[[Change], object]) -> None:
        """Stop calling a function of `on_change`."""
        self.core.observers.remove_callback(callback)

    @property
    def status(self) -> Status:
        """The status of the node; available at once from any thread, even while a handler blocks the node."""
        return self.core.status()

    def inspect(self) -> Inspection:
        """Return a snapshot of the net; from any thread.

        It waits for a handler that blocks the node; `status` does not.
        """
        return self.core.loop.call(lambda: inspected(self.core))

    def count(self, place: str) -> int:
        """Return the current number of tokens on a place; much faster than `inspect`.

        Raises
        ------
        UnknownElementError
            There is no such place.
        """
        return self.core.engine.count(self.core.names.place(place))

    def wait_for(self, condition: Callable[[Inspection], bool], timeout: float | None = None) -> Inspection:
        """Wait until the state of a running net fulfils a condition, and return that state.

        Raises
        ------
        TimeoutError
            The condition was not fulfilled within `timeout` seconds.
        """
        end = None if timeout is None else time.monotonic() + timeout
        changed = threading.Event()
        callback = self.on_change(lambda change: changed.set())
        try:
            while True:
                changed.clear()
                state = self.inspect()
                if condition(state):
                    return state
                left = None if end is None else end - time.monotonic()
                if left is not None and left <= 0:
                    raise TimeoutError(f"the node {self.id} did not reach this state in {timeout:g} s")
                # Not every change is notified: a firing that becomes in flight changes no marking.
                changed.wait(POLL if left is None else min(left, POLL))
        finally:
            self.remove_callback(callback)

    @property
    def next_timer(self) -> float | None:
        """Time when the next delay or time-out of the net ends, by its clock; None: there is none."""
        return self.core.loop.timers.next_time

    @property
    def deadline(self) -> float | None:
        """Time by which some transition has to fire, by the net's clock; None: there is no such time."""
        return self.core.execution.timing.deadline

    def draw_times(self, source: random.Random) -> None:
        """Draw firing times uniformly from the intervals, instead of taking the earliest times."""
        self.core.execution.timing.draws = source

    # Lifetime.

    def __enter__(self) -> Net:
        """Run the net on its own thread, without a transport: nothing is sent or received."""
        self._runner = Runner(self.core)
        self._runner.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._runner.stop()


def load_runtime_model(path: Path | str) -> rtm.RuntimeModel:
    """Return the runtime model in a file.

    Raises
    ------
    ModelFileError
        The file cannot be read, or holds no runtime model.
    """
    model = load(path)
    if not isinstance(model, rtm.RuntimeModel):
        raise ModelFileError(
            f"holds {with_article(type(model).__name__)}, not a runtime model",
            location=Location(path),
            hint="make the runtime models of a system model with 'dineros split'",
        )
    return model
