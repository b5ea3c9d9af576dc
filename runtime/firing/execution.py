"""Firing: running the handlers of a transition, committing, and handling failures.

A firing changes the marking only when it commits. While a long handler runs, the firing is *in flight*: its
tokens are reserved. It commits only if the transition is still allowed then (clause, read and inhibitor arcs,
priorities). Otherwise it is withdrawn, and retried when the transition is enabled again.
"""

from __future__ import annotations

import inspect
import logging
from collections.abc import Awaitable, Callable, Mapping, Sequence
from random import Random
from time import monotonic
from types import MappingProxyType
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.runtime.firing.cancels import CancelRequest
from dineros.runtime.firing.choosing import Chooser
from dineros.runtime.firing.departures import Departures
from dineros.runtime.firing.durations import Durations
from dineros.runtime.firing.flights import Flight, Flights
from dineros.runtime.firing.handlers import Firing, Handler, Handlers
from dineros.runtime.firing.observing import FiringObserver, shown
from dineros.runtime.firing.policies import Aside, Halt, Policy, Retry
from dineros.runtime.firing.results import checked_result, missing_data
from dineros.runtime.firing.selection import named_copies
from dineros.runtime.firing.timing import Timing
from dineros.runtime.journal.kept import Json, Memory
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.passing import Tokens
from dineros.runtime.nets.tokens import copy_data
from dineros.runtime.scheduling.loop import Loop
from dineros.runtime.scheduling.watchdog import GivenUpError
from dineros.runtime.scheduling.workers import Workers

LOG = logging.getLogger("dineros.runtime")


class HandlerTimeoutError(DinerosError):
    """A handler exceeded its time-out."""


class Execution:
    """Fires the transitions of an engine, one at a time.

    Parameters
    ----------
    engine, handlers, loop, random
        The engine, the handlers, the loop, and what draws the next transition.
    observer : FiringObserver
        Receives the events.
    policy : Policy
        Policy for a failure if the handler has none of its own.
    cancel_of : callable
        Returns the cancel request of the goal that a transition works on; None: it belongs to no goal.

    Attributes
    ----------
    policy : Policy
        Policy for a failure if the handler has none of its own.
    halted : str or None
        Why the node is halted; None: it is not.
    in_flight : Flights
        Firings whose handlers run on other threads or on the event loop.
    watchdog : Watchdog
        Watches the handlers on the node's thread.
    departures : Departures
        Refuses tokens that cannot be sent.
    timing : Timing
        Determines which transitions may fire now.
    chooser : Chooser
        Chooses the next transition, by the developers' selection if there is one.
    durations : Durations
        Run times of the handlers.
    firings : int
        Number of committed firings.
    kept : dict
        Values that handlers keep over restarts: name -> JSON value.
    """

    def __init__(
        self,
        engine: Engine,
        handlers: Handlers,
        loop: Loop,
        random: Random,
        observer: FiringObserver,
        policy: Policy,
        cancel_of: Callable[[int], CancelRequest | None],
    ) -> None:
        self.engine = engine
        self.handlers = handlers
        self.policy = policy
        self.halted: str | None = None
        self.in_flight = Flights()
        self.watchdog = observer.watchdog
        self.firings = 0
        self.kept: dict[str, Any] = {}
        self._cancel_of = cancel_of
        self._loop = loop
        self._observer = observer
        self._workers = Workers()
        self.timing = Timing(engine.structure, loop, observer.struck)
        self.chooser = Chooser(random, self.timing, self.watchdog)
        self.departures = Departures()
        self.durations = Durations(engine.structure.transitions)
        # Transition -> the tokens of its last failure and how often it failed with them.
        self._failures: dict[int, tuple[frozenset[int], int]] = {}

    def fire_one(self) -> bool:
        """Begin at most one firing; return whether one began."""
        engine, chooser = self.engine, self.chooser
        if self.halted is not None:
            chooser.pass_time(engine)
            return False
        try:
            chosen = chooser.choose(engine)
        except (KeyboardInterrupt, GivenUpError):
            raise
        except BaseException as error:
            if chooser.selection is None:
                raise
            self._selection_failed(error)
            return False
        if chosen is None:
            return False
        transition, taken = chosen
        if (
            taken is not None
            or self._observer.is_observing
            or self.handlers.of(transition)
            or transition in self.departures.transitions
        ):
            self._begin(transition, engine.would_take(transition) if taken is None else taken)
        else:
            engine.fire(transition)
            self.firings += 1
            if self.timing:
                self.timing.began(transition)
                self.timing.observe(engine)
        return True

    def _selection_failed(self, error: BaseException) -> None:
        self.chooser.failures += 1
        attempt, policy = self.chooser.failures, self.policy
        if isinstance(policy, Aside):  # a selection has no tokens to put aside
            policy = Retry(attempts=1 << 31)
        elif isinstance(policy, Retry) and attempt >= policy.attempts:
            policy = Halt()
        name, text = getattr(self.chooser.selection, "__name__", "selection"), shown(error)
        LOG.error("the selection %s failed; policy: %s", name, policy.name, exc_info=error)
        self._observer.tell_error(text, policy.name, handler=name, attempt=attempt)
        if isinstance(policy, Halt):
            self.halt(f"the selection failed: {text}")
            return
        self.chooser.is_paused = True
        self._loop.timers.call_later(policy.delay_after(min(attempt, 60)), self._resume_selection)

    def _resume_selection(self) -> None:
        self.chooser.is_paused = False

    def _begin(self, transition: int, taken: Tokens) -> None:
        """Run the handlers of a transition and commit, or leave the firing in flight."""
        engine, started = self.engine, self._loop.clock()
        if self.timing:
            self.timing.began(transition)
        handlers = self.handlers.of(transition)
        data = engine.passing.passed_on(transition, taken)
        if not handlers:
            made = engine.made(transition, taken, data)
            if (error := self.departures.refused(made)) is not None:
                self._fail(transition, taken, None, error)
                return
            self._commit(transition, taken, made, (), started)
            return
        structure, status = engine.structure, [True]
        firing = Firing(
            structure.transition_names[transition],
            structure.instances[transition],
            structure.transitions[transition],
            named_copies(engine, [*taken, *engine.would_read(transition)]),
            {structure.place_names[place]: weight for place, weight in structure.outputs[transition]},
            copy_data(data),
            status,
            Memory(self.kept),
            self._cancel_of(transition),
        )
        self._go_on(Flight(transition, taken, handlers, firing, data, started, status))

    def _go_on(self, flight: Flight) -> None:
        """Run the remaining handlers up to one that runs elsewhere; commit after the last handler."""
        while flight.position < len(flight.handlers):
            handler = flight.handlers[flight.position]
            if handler.is_asynchronous or handler.thread or handler.timeout is not None:
                self._send_off(flight, handler)
                return
            id, begun = self.engine.structure.transitions[flight.transition], monotonic()
            try:
                result = self.watchdog.call(handler.function, flight.firing, handler.name, id)
            except KeyboardInterrupt:
                self._end(flight)
                raise
            except GivenUpError:
                raise
            except BaseException as error:
                self.durations.note(flight.transition, handler, monotonic() - begun)
                self._end(flight, handler, error)
                return
            if result is not None and inspect.isawaitable(result):
                self._send_off(flight, handler, result)
                return
            self.durations.note(flight.transition, handler, monotonic() - begun)
            if not self._accept(flight, handler, result):
                return
        self._finish(flight)

    def _accept(self, flight: Flight, handler: Handler, result: object) -> bool:
        """Check the data and result of a handler; False: they were wrong, and the firing has failed."""
        try:
            data, given = checked_result(self.engine, flight, result)
        except Exception as error:
            self._end(flight, handler, error)
            return False
        flight.data, flight.given = data, given
        flight.firing.data = copy_data(data)
        flight.position += 1
        return True

    # Handlers on other threads or on the event loop.

    def _send_off(self, flight: Flight, handler: Handler, awaitable: Awaitable[Any] | None = None) -> None:
        if not flight.is_reserved:
            self.in_flight.add(self.engine, flight)
        firing, function = flight.firing, handler.function
        flight.sent = monotonic()

        def done(result: Any, error: BaseException | None) -> None:
            self._loop.post(lambda: self._returned(flight, handler, result, error))

        async def wait_for(some: Awaitable[Any]) -> Any:
            return await some

        if awaitable is not None:
            flight.cancel = self._workers.start_coroutine(lambda: wait_for(awaitable), done)
        elif handler.is_asynchronous:
            flight.cancel = self._workers.start_coroutine(lambda: function(firing), done)
        else:
            flight.cancel = self._workers.start_thread(lambda: function(firing), handler.name, done)
        if handler.timeout is not None:
            error = HandlerTimeoutError(f"took longer than {handler.timeout:g} s")
            flight.timer = self._loop.timers.call_later(
                handler.timeout, lambda: self._give_up(flight, handler, error)
            )

    def _returned(
        self, flight: Flight, handler: Handler, result: object, error: BaseException | None
    ) -> None:
        """Continue a firing whose handler has returned or failed; on the node's thread."""
        if flight.is_over:  # too late: the result is ignored
            if inspect.iscoroutine(result):
                result.close()
            self.in_flight.outlived(self.engine, flight)
            return
        flight.timer.cancel()
        if error is None and inspect.isawaitable(result):  # a function on a thread returned a coroutine
            self._send_off(flight, handler, result)
            return
        self.durations.note(flight.transition, handler, monotonic() - flight.sent)
        if error is not None:
            self._end(flight, handler, error)
        elif self._accept(flight, handler, result):
            self._go_on(flight)

    def _give_up(self, flight: Flight, handler: Handler, error: DinerosError) -> None:
        """Let a firing fail while its handler still runs; its transition waits for the handler's end."""
        self.durations.note(flight.transition, handler, monotonic() - flight.sent)
        self.in_flight.outlive(self.engine, flight)
        flight.cancel()
        self._end(flight, handler, error)

    def give_up(self) -> list[str]:
        """Release all firings in flight, and return their transitions.

        Results of their handlers are ignored from now on.
        """
        given_up = []
        for flight in list(self.in_flight):
            id, handler = (
                self.engine.structure.transitions[flight.transition],
                flight.handlers[flight.position],
            )
            self.in_flight.outlive(self.engine, flight)
            flight.cancel()
            self._end(flight)
            self._tell_released(id, handler.name, "released by hand")
            given_up.append(id)
        return given_up

    def give_up_blocking(self, seconds: float) -> bool:
        """Abandon the handler that keeps the node's thread from ending; False: there is none.

        Called from another thread. If it returns True, the node's thread does nothing more.
        """
        call = self.watchdog.give_up()
        if call is None:
            return False
        self._tell_released(*call, f"did not return within {seconds:g} s when the node was stopped")
        return True

    def _tell_released(self, id: str | None, handler: str, error: str) -> None:
        LOG.error("%s: the handler %s: %s; its firing is released", id, handler, error)
        self._observer.tell_error(error, transition=id, handler=handler)

    # How a firing ends.

    def _finish(self, flight: Flight) -> None:
        engine, transition = self.engine, flight.transition
        was_reserved = flight.is_reserved
        self._end(flight)
        if was_reserved and not engine.is_allowed(transition):
            id, handler = engine.structure.transitions[transition], flight.handlers[-1].name
            self._observer.tell_error("withdrawn", "retry", transition=id, handler=handler)
            return
        made = engine.made(transition, flight.taken, flight.data, flight.given)
        error = missing_data(engine, transition, flight.given) or self.departures.refused(made)
        if error is not None:
            self._fail(transition, flight.taken, flight.handlers[-1], error)
            return
        kept = flight.firing.memory.changes
        self._commit(transition, flight.taken, made, flight.handlers, flight.started, kept)

    def _commit(
        self,
        transition: int,
        taken: Tokens,
        made: Tokens,
        handlers: Sequence[Handler],
        started: float,
        kept: Mapping[str, Json] = MappingProxyType({}),
    ) -> None:
        self.engine.commit(taken, made)
        if self.timing:
            self.timing.observe(self.engine)
        for name, value in kept.items():
            if value is None:
                self.kept.pop(name, None)
            else:
                self.kept[name] = value
        self.firings += 1
        self._failures.pop(transition, None)
        if not self._observer.is_observing:
            return
        places = self.engine.structure.places
        change = {places[place]: -len(tokens) for place, tokens in taken}
        for place, tokens in made:
            change[places[place]] = change.get(places[place], 0) + len(tokens)
        self._observer.emit(
            "fire",
            transition=self.engine.structure.transitions[transition],
            change={place: number for place, number in change.items() if number},
            taken={places[place]: [token.id for token in tokens] for place, tokens in taken},
            made={places[place]: [[token.id, token.data] for token in tokens] for place, tokens in made},
            handlers=[handler.name for handler in handlers],
            duration=self._loop.clock() - started,
            **({"kept": dict(kept)} if kept else {}),
        )

    def _end(
        self, flight: Flight, handler: Handler | None = None, error: BaseException | None = None
    ) -> None:
        """Release the reservation of a firing, if it has one, and let it fail if there is an error."""
        flight.is_over = True
        flight.status[0] = False
        flight.timer.cancel()
        if flight.is_reserved:
            self.in_flight.remove(self.engine, flight)
        if error is not None:
            self._fail(flight.transition, flight.taken, handler, error)

    def _fail(self, transition: int, taken: Tokens, handler: Handler | None, error: BaseException) -> None:
        """Leave the marking unchanged and apply the policy."""
        id = self.engine.structure.transitions[transition]
        tokens = frozenset(token.id for _, tokens in taken for token in tokens)
        known, attempt = self._failures.get(transition, (tokens, 0))
        attempt = attempt + 1 if known == tokens else 1
        self._failures[transition] = (tokens, attempt)
        name = handler.name if handler is not None else None
        policy = (handler.policy if handler is not None else None) or self.policy
        if isinstance(policy, Retry) and attempt >= policy.attempts:
            policy = policy.then
        if isinstance(policy, Aside) and not taken:
            policy = Halt()  # no tokens to put aside
        text = shown(error)
        failed = f"the handler {name}" if handler is not None else "the firing"
        LOG.error("%s: %s failed; policy: %s", id, failed, policy.name, exc_info=error)
        self._observer.tell_error(text, policy.name, transition=id, handler=name, attempt=attempt)
        if isinstance(policy, Retry):
            self.engine.hold(transition)
            self._loop.timers.call_later(policy.delay_after(attempt), lambda: self.engine.unhold(transition))
        elif isinstance(policy, Aside):
            del self._failures[transition]
            self._put_aside(transition, taken)
        else:
            self.halt(f"{failed} of {id} failed: {text}")

    def _put_aside(self, transition: int, taken: Tokens) -> None:
        structure = self.engine.structure
        self.engine.aside.put(transition, taken)
        self._observer.emit(
            "aside",
            transition=structure.transitions[transition],
            tokens={structure.places[place]: [token.id for token in tokens] for place, tokens in taken},
        )

    def release(self, transitions: Sequence[int]) -> None:
        """Let transitions take the tokens again that were put aside for them."""
        structure = self.engine.structure
        for transition in transitions:
            released = self.engine.aside.release(transition)
            if released:
                self._observer.emit(
                    "release",
                    transition=structure.transitions[transition],
                    tokens={structure.places[place]: sorted(ids) for place, ids in released.items()},
                )

    def halt(self, reason: str, level: int = logging.ERROR) -> None:
        """Stop firing until `proceed`; the reason is logged at a level of `logging`."""
        if self.halted is None:
            LOG.log(level, "the node halts: %s", reason)
            self.halted = reason
            self._observer.status_changed()

    def proceed(self) -> None:
        """Continue firing after a halt."""
        self.halted = None
        self._failures.clear()
        self.chooser.failures = 0
        self._observer.status_changed()

    def close(self) -> None:
        """Release all firings in flight; their handlers are cancelled if that is possible."""
        for flight in list(self.in_flight):
            flight.cancel()
            self._end(flight)
        self._workers.close()
        self.watchdog.close()
