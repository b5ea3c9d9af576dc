"""Handlers: the developers' code that runs when a transition fires, and the objects that it gets.

A handler gets a `Firing`: copies of the tokens, without access to the marking or the structure. Its result is
checked before it is used.
"""

from __future__ import annotations

import inspect
import threading
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

from dineros.metamodel.errors import DinerosError, near_matches
from dineros.runtime.firing.cancels import CancelRequest
from dineros.runtime.firing.policies import Policy
from dineros.runtime.journal.kept import Memory
from dineros.runtime.nets.tokens import Token

Result = Any
"""The result of a handler: None, a mapping of fields to values, or a result of `Firing.give`."""

HandlerFunction = Callable[["Firing"], "Result | Awaitable[Result]"]


class HandlerError(DinerosError):
    """A handler cannot be registered, or no handler has this name."""


@dataclass(frozen=True)
class Given:
    """Data for the tokens of some output places; made by `Firing.give`."""

    places: Mapping[str, Mapping[str, object] | Sequence[Mapping[str, object]]]


class Firing:
    """A firing as a handler sees it.

    Attributes
    ----------
    transition : str
        Id of the transition in the model.
    instance : int or None
        Number of the server instance it belongs to, from 1.
    id : str
        Its id in the running net, such as ``Pick[2].TPick``.
    inputs : mapping of str to tuple of Token
        Copies of the tokens that it takes or reads, by the place's id in the model.
    outputs : mapping of str to int
        Number of tokens that it puts on each place.
    data : dict
        A copy of the data passed to the outputs: handlers change it in place; the next handler sees the
        change.
    memory : Memory
        Values that the node's handlers keep, also over restarts: ``firing.memory["picked"] = 3``.
    cancel : CancelRequest
        Whether the goal that it works on is to be canceled.
    """

    __slots__ = ("_status", "cancel", "data", "id", "inputs", "instance", "memory", "outputs", "transition")

    def __init__(
        self,
        transition: str,
        instance: int | None,
        id: str,
        inputs: Mapping[str, tuple[Token, ...]],
        outputs: Mapping[str, int],
        data: dict[str, Any],
        status: list[bool],
        memory: Memory | None = None,
        cancel: CancelRequest | None = None,
    ) -> None:
        self.transition = transition
        self.instance = instance
        self.id = id
        self.inputs = MappingProxyType(dict(inputs))
        self.outputs = MappingProxyType(dict(outputs))
        self.data = data
        self._status = status
        self.memory = Memory() if memory is None else memory
        self.cancel = CancelRequest() if cancel is None else cancel

    @property
    def still_enabled(self) -> bool:
        """Whether the firing could commit now; if not, a long handler may stop early."""
        return self._status[0]

    def give(self, places: Mapping[str, Mapping[str, object] | Sequence[Mapping[str, object]]]) -> Given:
        """Return data for single output places, for the handler to return.

        Parameters
        ----------
        places : mapping
            Place -> fields for all its tokens, or a list with the fields of each token. Fields that are not
            given keep the value in `data`; places that are not given get the same tokens as without this
            method.
        """
        return Given(dict(places))

    def __repr__(self) -> str:
        return f"<Firing {self.id}>"


@dataclass(frozen=True, eq=False)
class Handler:
    """A registered handler.

    Attributes
    ----------
    transition : str
        As registered: a transition of the model, or of one server instance.
    name : str
        Unique at its transition.
    function : callable
        The developers' function.
    priority : int
        Higher runs first; among equals, the one registered first.
    thread : bool
        Whether it runs on its own thread while the rest of the node continues.
    timeout : float, optional
        Maximum run time, in seconds.
    parallel : int
        Maximum number of firings of the transition in flight, as far as this handler limits it.
    policy : Policy, optional
        Policy for a failure; by default the policy of the net.
    budget : float, optional
        Declared maximum run time, in seconds: a longer run causes a warning, but no failure.
    """

    transition: str
    name: str
    function: HandlerFunction
    priority: int = 0
    thread: bool = False
    timeout: float | None = None
    parallel: int = 1
    policy: Policy | None = None
    budget: float | None = None

    @cached_property
    def is_asynchronous(self) -> bool:
        """Whether the function is ``async``."""
        # An object with an asynchronous `__call__` is asynchronous too.
        of_class = getattr(type(self.function), "__call__", None)  # noqa: B004
        return inspect.iscoroutinefunction(self.function) or inspect.iscoroutinefunction(of_class)


class Handlers:
    """The handlers of a net. Any thread may change them; a change takes effect at the next firing.

    Parameters
    ----------
    targets : callable
        Returns the numbers of the transitions that have a name.
    size : int
        Number of transitions.
    """

    def __init__(self, targets: Callable[[str], tuple[int, ...]], size: int) -> None:
        self._targets = targets
        self._lock = threading.Lock()
        self._registered: list[Handler] = []
        self._sequences: list[tuple[Handler, ...]] = [()] * size

    def of(self, transition: int) -> tuple[Handler, ...]:
        """Return the handlers of a transition in the order in which they run."""
        return self._sequences[transition]

    def all(self) -> tuple[Handler, ...]:
        """Return all handlers, in the order they were registered."""
        return tuple(self._registered)

    def add(self, handler: Handler, *, is_replacing: bool = False) -> None:
        """Register a handler.

        Raises
        ------
        HandlerError
            The transition has a handler of this name and it is not to be replaced; or a number is out of
            range.
        UnknownElementError
            There is no such transition.
        """
        self._targets(handler.transition)
        if not callable(handler.function):
            raise HandlerError(f"the handler {handler.name!r} is not a function", element=handler.transition)
        seconds = [each for each in (handler.timeout, handler.budget) if each is not None]
        if handler.parallel < 1 or any(each <= 0 for each in seconds):
            raise HandlerError(
                f"the handler {handler.name!r} has no time or no firing to run in", element=handler.transition
            )
        with self._lock:
            for position, known in enumerate(self._registered):
                if (known.transition, known.name) == (handler.transition, handler.name):
                    if not is_replacing:
                        raise HandlerError(
                            f"{handler.transition} has a handler {handler.name!r} already",
                            element=handler.transition,
                            hint="give it another name=, or pass replace=True",
                        )
                    self._registered[position] = handler
                    break
            else:
                self._registered.append(handler)
            self._arrange(handler.transition)

    def remove(self, transition: str, name: str) -> None:
        """Remove a handler from a transition.

        Raises
        ------
        HandlerError
            There is no such handler.
        """
        with self._lock:
            self._registered.remove(self._find(transition, name))
            self._arrange(transition)

    def set_priority(self, transition: str, name: str, priority: int) -> None:
        """Change the priority of a handler.

        Raises
        ------
        HandlerError
            There is no such handler.
        """
        with self._lock:
            known = self._find(transition, name)
            self._registered[self._registered.index(known)] = replace(known, priority=priority)
            self._arrange(transition)

    def _find(self, transition: str, name: str) -> Handler:
        for handler in self._registered:
            if (handler.transition, handler.name) == (transition, name):
                return handler
        names = [handler.name for handler in self._registered if handler.transition == transition]
        raise HandlerError(
            f"{transition} has no handler {name!r}", element=transition, hint=near_matches(name, names)
        )

    def _arrange(self, name: str) -> None:
        for transition in self._targets(name):
            own = [handler for handler in self._registered if transition in self._targets(handler.transition)]
            self._sequences[transition] = tuple(sorted(own, key=lambda handler: -handler.priority))
