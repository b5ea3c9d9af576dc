"""The net as developers see it: handlers, selection, signals, and what it is in (paper, Sect. 5.2).

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
from dineros.runtime.nodes.core import Change, Core
from dineros.runtime.nodes.inspection import Inspection, inspected
from dineros.runtime.nodes.runner import Runner
from dineros.runtime.nodes.status import Status
from dineros.runtime.scheduling.watchdog import LIMIT

POLL = 0.05
"""Seconds after which `wait_for` looks again where nothing was told."""

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
        Seed of the firing selection; by default another one in each run.
    policy : Policy
        What becomes of a failed firing where its handler says nothing else.
    clock : callable
        Returns seconds, for time-outs and delays.
    watchdog : float, optional
        Seconds after which a handler is named that keeps the node from all else; None: never.
    steady : callable, optional
        Returns the machine's seconds, where `clock` tells the time of a simulation that others drive, such as
        that of ``/clock``: what was lost on the way is asked for again after a pause by it.

    Attributes
    ----------
    core : Core
        What it consists of, for what runs it.

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
        """The rclpy node that the net runs in, for publishers and clients of the handlers' own.

        Raises
        ------
        DinerosError
            The net does not run on ROS.
        """
        if self._ros_node is None:
            raise DinerosError(f"the node {self.id} does not run on ROS", hint="ask for it when it does")
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
            Higher runs first; the last one's result counts.
        name : str, optional
            Unique at the transition; by default that of the function.
        thread : bool
            Whether it may take long: it runs on a thread of its own, its transition is in flight meanwhile.
            An ``async`` function always does so on an event loop.
        timeout : float, optional
            Seconds after which it has failed. A plain function runs on a thread of its own then.
        parallel : int
            How many firings of a transition may be in flight at a time.
        policy : Policy, optional
            What becomes of its failures; by default what the net says.
        budget : float, optional
            Seconds that it declares to take at most. One that takes longer is named in the node's log and its
            diagnostics, and counts all the same.
        replace : bool
            Whether it takes the place of the handler of the same name.

        Raises
        ------
        UnknownElementError
            There is no such transition.
        HandlerError
            The transition has a handler of this name already, or the function is none.
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
        """Take a handler off; from any thread.

        Raises
        ------
        HandlerError
            There is no such handler.
        """
        self.core.handlers.remove(transition, name)

    def set_priority(self, transition: str, name: str, priority: int) -> None:
        """Let a handler run earlier or later from now on; from any thread.

        Raises
        ------
        HandlerError
            There is no such handler.
        """
        self.core.handlers.set_priority(transition, name, priority)

    def selection(self, function: S) -> S:
        """Let a function decide what fires; None: uniformly at random again. Works as a decorator.

        The function gets the enabled transitions (`Candidates`) and returns one of them, one with other
        tokens (`Enabled.taking`), or None, and is asked again after the next change.
        """
        self.core.execution.chooser.selection = function
        self.core.loop.post(lambda: None)
        return function

    def accepts(self, action: str) -> Callable[[J], J]:
        """Let the decorated function decide about the goals of an action that may refuse them.

        It gets the data of a goal when it comes, on the node's thread, and returns whether it is accepted.
        One that it fails for is refused.

        Raises
        ------
        HandlerError
            The node serves no action of this id, or the model does not let it refuse goals.
        """

        def register(function: J) -> J:
            self.core.acceptance.register(action, function)
            return function

        return register

    @property
    def policy(self) -> Policy:
        """What becomes of a failed firing where its handler says nothing else."""
        return self.core.execution.policy

    @policy.setter
    def policy(self, policy: Policy) -> None:
        self.core.execution.policy = policy

    @property
    def watchdog(self) -> float | None:
        """Seconds after which a handler is named that keeps the node from all else; None: never."""
        return self.core.execution.watchdog.limit

    @watchdog.setter
    def watchdog(self, seconds: float | None) -> None:
        if seconds is not None and not 0 < seconds < float("inf"):
            raise FeatureValueError(
                f"a watchdog takes seconds above 0, not {seconds}", hint="None switches it off"
            )
        self.core.execution.watchdog.limit = seconds

    def release(self, transition: str | None = None) -> None:
        """Let a transition, or all of them, take again the tokens that were put aside after a failure.

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

        Coroutines are cancelled. Of threads, which cannot be stopped, the results count no more; the
        transition waits until its thread has ended.
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
            What it is asked for.

        Raises
        ------
        DinerosError
            It is not a managed node, or its state does not allow that.
        """
        self.core.loop.call(lambda: self.core.change_state(label))

    def halt(self, reason: str = "halted by the program") -> None:
        """Fire nothing more until `proceed`; tokens and signals still arrive."""
        self.core.loop.submit(lambda: self.core.execution.halt(reason, logging.INFO))

    def proceed(self) -> None:
        """Fire again after a halt."""
        self.core.loop.submit(self.core.execution.proceed)

    # Signals and changes.

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
            Where they come from, for the records.

        Raises
        ------
        UnknownElementError
            The node has no such signal; none is set.
        FeatureValueError
            A value is none that its signal can have; none is set.
        """
        self.core.submit_signals(values, source)

    def new_source(self, name: str) -> Source:
        """Return the counters of something that sets signals, which `inspect` shows from now on."""
        return self.core.new_source(name)

    def remove_source(self, source: Source) -> None:
        """Show it no more."""
        self.core.remove_source(source)

    def on_change(self, callback: C) -> C:
        """Have a function called after each change, on the node's thread; works as a decorator.

        The function must be quick, since the net waits for it. What it raises is logged and changes nothing.
        """
        self.core.add_callback(callback)
        return callback

    def remove_callback(self, callback: Callable[[Change], object]) -> None:
        """Call a function of `on_change` no more."""
        self.core.remove_callback(callback)

    @property
    def status(self) -> Status:
        """How the node is, in short; at once, also while a handler blocks it. From any thread."""
        return self.core.status()

    def inspect(self) -> Inspection:
        """Return what the net is in now; from any thread.

        It waits for a handler that blocks the node; `status` does not.
        """
        return self.core.loop.call(lambda: inspected(self.core))

    def count(self, place: str) -> int:
        """Return how many tokens a place holds now; much quicker than `inspect`.

        Raises
        ------
        UnknownElementError
            There is no such place.
        """
        return self.core.engine.count(self.core.names.place(place))

    def wait_for(self, condition: Callable[[Inspection], bool], timeout: float | None = None) -> Inspection:
        """Wait until a running net is in a state that fulfils a condition, and return it.

        Raises
        ------
        TimeoutError
            It did not happen within `timeout` seconds.
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
                    raise TimeoutError(f"the node {self.id} did not get there in {timeout:g} s")
                # Not every change of state is told: a firing that goes in flight changes no marking.
                changed.wait(POLL if left is None else min(left, POLL))
        finally:
            self.remove_callback(callback)

    @property
    def next_timer(self) -> float | None:
        """When a delay or time-out of the net ends, by its clock; None without one."""
        return self.core.loop.timers.next_time

    @property
    def deadline(self) -> float | None:
        """By when some transition has to fire, by the net's clock; None if none has to."""
        return self.core.execution.timing.deadline

    def draw_times(self, source: random.Random) -> None:
        """Draw uniformly from its interval when a transition fires, instead of taking the earliest time."""
        self.core.execution.timing.draws = source

    # Lifetime.

    def __enter__(self) -> Net:
        """Run the net on a thread of its own, by itself: nothing is sent or received."""
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
