"""The parts of a net at run time, for its runner; developers use a `Net`."""

from __future__ import annotations

import copy
import logging
import random
import threading
import time
from collections.abc import Callable, Mapping

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError, FeatureValueError
from dineros.metamodel.lifecycles.states import STATE_AFTER, STATES_BEFORE
from dineros.metamodel.lifecycles.states import State as LifecycleState
from dineros.runtime.channels.arrivals import Arrivals
from dineros.runtime.channels.exchange import Exchange
from dineros.runtime.firing.acceptance import Acceptance
from dineros.runtime.firing.cancels import CancelRequest
from dineros.runtime.firing.execution import Execution
from dineros.runtime.firing.handlers import Handlers
from dineros.runtime.firing.policies import Policy
from dineros.runtime.journal.saved import ChannelState, SavedState
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.names import Names
from dineros.runtime.nets.signals import Signal
from dineros.runtime.nets.sources import Source
from dineros.runtime.nets.staleness import Expectation, Expectations
from dineros.runtime.nets.structure import Structure
from dineros.runtime.nets.tokens import Token
from dineros.runtime.nodes.observers import Observers
from dineros.runtime.nodes.responses import Responses
from dineros.runtime.nodes.status import State, Status
from dineros.runtime.scheduling.loop import Loop

LOG = logging.getLogger("dineros.runtime")
KEPT_ERRORS = 100


NOT_ACTIVE = "the managed node is not active"
"""Reason of the halt of a managed node whose state does not let it fire."""


class Core:
    """Engine, handlers, loop and observers of one net.

    Attributes
    ----------
    observers : Observers
        Receives the events.
    acceptance : Acceptance
        Decides which goals are accepted.
    exchange : Exchange or None
        The ports of the node, if it has a runner.
    arrivals : Arrivals or None
        Messages that wait for room on their places, if it has a runner.
    heard : dict of int to float
        When each signal was last set by its source, by the net's clock.
    ended_by : str or None
        Why it has stopped running; None: it runs, or has not begun.
    failure : BaseException or None
        Error that ended it unexpectedly, for example of a recorder that cannot write.
    """

    def __init__(
        self,
        structure: Structure,
        seed: int,
        policy: Policy,
        clock: Callable[[], float],
        steady: Callable[[], float] | None = None,
    ) -> None:
        self.structure = structure
        self.seed = seed
        self.names = Names(structure)
        self.loop = Loop(clock, steady)
        self.handlers = Handlers(self.names.transitions, len(structure.transitions))
        self.engine = Engine(structure)
        self.observers = Observers(structure.ports.node)
        self.execution = Execution(
            self.engine,
            self.handlers,
            self.loop,
            random.Random(seed),
            self.observers,
            policy,
            self._cancel_of,
        )
        self.acceptance = Acceptance(structure.ports.action_servers, self.observers)
        self.expectations = Expectations(
            self.loop,
            structure.signals,
            lambda values: self.set_signals(values, "stale", is_heard=False),
            self.observers.tell_error,
            lambda reason: self.execution.halt(reason, logging.ERROR),
        )
        self.sources: tuple[Source, ...] = ()
        self.heard: dict[int, float] = {}
        self.arrivals: Arrivals | None = None
        self.exchange: Exchange | None = None
        self.state: LifecycleState = "unconfigured" if structure.ports.is_managed else "active"
        self.ended_by: str | None = None
        self.failure: BaseException | None = None
        self._sources_lock = threading.Lock()

    def attach(
        self, run: str, request_timeout: float | None, resume: SavedState | None
    ) -> tuple[Exchange, Arrivals]:
        """Make the ports of the node, once, and continue from a saved state if there is one.

        Raises
        ------
        DinerosError
            The net has ports already, or does not fit the saved state.
        """
        if self.exchange is not None:
            id = self.structure.ports.node
            raise DinerosError(f"the net of {id} already has a node", hint="load the net again")
        if resume is not None:
            self.restore(resume)
        exchange = Exchange(
            self.engine,
            self.loop,
            self.observers,
            self.acceptance.accepts,
            run=run,
            request_timeout=request_timeout,
        )
        if resume is not None:
            exchange.restore(resume)
        arrivals = Arrivals(exchange, self.engine, self.loop)
        self.exchange, self.arrivals = exchange, arrivals
        self.obey_state()
        return exchange, arrivals

    def _cancel_of(self, transition: int) -> CancelRequest | None:
        return None if self.exchange is None else self.exchange.actions.cancel_of(transition)

    # Observing.

    def measure_responses(self) -> None:
        """Measure the response times of callbacks from now on."""
        ports = self.structure.ports
        if self.observers.responses is not None or not ports.callbacks:
            return
        subscribers = {port.place: port for port in ports.subscribers}

        def waited(place: str) -> float:
            port = subscribers.get(place)
            return 0.0 if self.arrivals is None or port is None else self.arrivals.waited(port)

        self.observers.measure(Responses(ports, self.loop.clock, waited))

    def status(self) -> Status:
        """Return the status of the node; from any thread, even while a handler blocks the node."""
        blocked, halted = self.execution.watchdog.blocked, self.execution.halted
        errors, failures = self.observers.errors, self.observers.failures
        error = errors[-1] if errors else None
        state: State = "running"
        reason = None
        if self.ended_by is not None:
            reason = self.ended_by
            state = "ended" if self.failure is None else "failed"
        elif blocked is not None:
            state, reason = "blocked", f"{blocked} has not returned"
        elif halted is not None:
            state, reason = "halted", halted
        return Status(self.structure.ports.node, time.time(), state, reason, error, blocked, failures)

    # Lifecycle of a managed node.

    def change_state(self, label: str) -> None:
        """Do as `Net.change_state` says; on the thread of the node."""
        ports = self.structure.ports
        if not ports.is_managed or self.state not in STATES_BEFORE[label]:
            what = f"is {self.state}" if ports.is_managed else "has no lifecycle"
            raise DinerosError(f"the node {ports.node} {what}: it cannot {label}")
        self.state = STATE_AFTER[label]
        self.observers.emit("lifecycle", label=label, state=self.state, change={})
        self.obey_state()

    @property
    def rests(self) -> bool:
        """Whether it is a managed node whose state does not let it fire."""
        ports = self.structure.ports
        works = ("active",) if ports.pauses else ("inactive", "active")
        return ports.is_managed and self.state not in works

    def obey_state(self) -> None:
        """Fire and publish only if the state of a managed node allows it."""
        if not self.structure.ports.is_managed:
            return
        if self.exchange is not None:
            self.exchange.obey(self.state)
        if self.rests:
            self.execution.halt(NOT_ACTIVE, logging.DEBUG)
        elif self.execution.halted == NOT_ACTIVE:
            self.execution.proceed()

    # State.

    def set_signals(self, values: Mapping[int, SignalSetting], source: str, *, is_heard: bool = True) -> None:
        """Set signals at once: a listener of the first one sees all; on the node's thread."""
        changed = [number for number, value in values.items() if self.engine.set_signal(number, value)]
        if is_heard:
            now = self.loop.clock()
            for number in values:
                self.heard[number] = now
                self.expectations.heard(number)
        for number in changed:
            self.observers.emit(
                "signal", signal=self.structure.signals[number], value=values[number], source=source
            )

    def signal(self, name: str) -> Signal:
        """Do as `Net.signal` says."""
        number = self.names.signal(name)
        port = self.structure.ports.signals[number]

        def write(value: SignalSetting, source: str) -> None:
            self.loop.submit(lambda: self.set_signals({number: value}, source))

        def expect(expectation: Expectation | None) -> None:
            if expectation is not None:
                expectation.require(port.values)
            self.loop.submit(lambda: self.expectations.expect(number, expectation))

        return Signal(port, lambda: self.engine.signals[number], write, expect)

    def submit_signals(self, values: Mapping[str, SignalSetting], source: str) -> None:
        """Do as `Net.set_signals` says."""
        numbered = {}
        for name, value in values.items():
            number = self.names.signal(name)
            self.structure.ports.signals[number].require(value)
            numbered[number] = value
        self.loop.submit(lambda: self.set_signals(numbered, source))

    def new_source(self, name: str) -> Source:
        """Return the counters of a bridge; inspections show them from now on; from any thread."""
        source = Source(name, lambda text: self.loop.submit(lambda: self.observers.tell_error(text)))
        with self._sources_lock:
            self.sources = (*self.sources, source)
        return source

    def remove_source(self, source: Source) -> None:
        """Stop showing these counters."""
        with self._sources_lock:
            self.sources = tuple(known for known in self.sources if known is not source)

    def save(self, channels: ChannelState) -> SavedState:
        """Return a checkpoint of the net, with the given state of the channels."""
        engine, structure = self.engine, self.structure
        saved: SavedState = {
            "marking": {
                id: [[token.id, token.data] for token in tokens]
                for place, id in enumerate(structure.places)
                if (tokens := engine.tokens(place))
            },
            "signals": dict(zip(structure.signals, engine.signals, strict=True)),
            "next_token": engine.next_token,
            "kept": copy.deepcopy(self.execution.kept),
            "aside": {
                structure.transitions[transition]: {
                    structure.places[place]: sorted(ids) for place, ids in by_place.items()
                }
                for transition, by_place in engine.aside.tokens().items()
            },
            **channels,  # type: ignore[typeddict-item]  # without the lifecycle
        }
        if structure.ports.is_managed:
            saved["lifecycle"] = self.state
        return saved

    def restore(self, checkpoint: SavedState) -> None:
        """Restore marking and signals from a checkpoint.

        Raises
        ------
        DinerosError
            They do not fit the model.
        """
        structure, names = self.structure, self.names
        marking: list[list[Token]] = [[] for _ in structure.places]
        for id, tokens in checkpoint["marking"].items():
            place = names.place(id)
            for number, data in tokens:
                try:
                    marking[place].append(
                        Token(int(str(number)), self.engine.passing.checkers[place].complete(data))
                    )
                except FeatureValueError as error:
                    raise DinerosError(
                        f"token {number} on {id!r} does not fit the model: {error}",
                        hint="start the node again",
                    ) from error
        if structure.ports.is_managed:
            self.state = checkpoint.get("lifecycle", self.state)
        signals = list(structure.initial_signals)
        for id, value in checkpoint["signals"].items():
            number = names.signal(id)
            structure.ports.signals[number].require(value)
            signals[number] = value
        self.engine = Engine(structure, marking, signals, checkpoint["next_token"])
        self.execution.engine = self.engine
        self.execution.kept = copy.deepcopy(checkpoint.get("kept", {}))
        for id, by_place in checkpoint["aside"].items():
            (transition,) = names.transitions(id)
            self.engine.aside.put(
                transition,
                [
                    (place, [token for token in self.engine.tokens(place) if token.id in ids])
                    for place, ids in ((names.place(id), ids) for id, ids in by_place.items())
                ],
            )
