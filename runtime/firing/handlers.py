"""Handlers: the developers' code that runs when a transition fires, and what it gets to see.

A handler gets a `Firing`: copies of the tokens and nothing that leads to the marking or the structure. What
it returns is checked before it counts.
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
"""What a handler returns: None, a mapping of fields to values, or what `Firing.give` made."""

HandlerFunction = Callable[["Firing"], "Result | Awaitable[Result]"]


class HandlerError(DinerosError):
    """A handler cannot be registered, or there is none of this name."""


@dataclass(frozen=True)
class Given:
    """Data of the tokens of some output places; made by `Firing.give`."""

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
        Copies of the tokens it takes, and of those its read arcs see, by the place's id in the model.
    outputs : mapping of str to int
        How many tokens it puts on each place.
    data : dict
        A copy of the data that continues to the outputs: handlers change it in place, the next one sees it.
    memory : Memory
        What the handlers of the node keep, also over restarts: ``firing.memory["picked"] = 3``.
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
        """Whether the firing could commit now; a long handler may stop early where it could not."""
        return self._status[0]

    def give(self, places: Mapping[str, Mapping[str, object] | Sequence[Mapping[str, object]]]) -> Given:
        """Return data for single output places, for the handler to return.

        Parameters
        ----------
        places : mapping
            Place -> fields for all its tokens, or a list with the fields of each. Fields that are not named
            keep the value in `data`; places that are not named get what they would get without this.
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
        Whether it runs on a thread of its own while the rest of the node continues.
    timeout : float, optional
        Seconds it may take.
    parallel : int
        How many firings of the transition may be in flight at a time, as far as this handler goes.
    policy : Policy, optional
        What becomes of a failure; by default what the net says.
    budget : float, optional
        Seconds that it declares to take at most: longer is a warning, and no failure.
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
    """The handlers of a net. May be changed from any thread; a change counts from the next firing on.

    Parameters
    ----------
    targets : callable
        Returns the numbers of the transitions that a name stands for.
    size : int
        How many transitions there are.
    """

    def __init__(self, targets: Callable[[str], tuple[int, ...]], size: int) -> None:
        self._targets = targets
        self._lock = threading.Lock()
        self._registered: list[Handler] = []
        self._sequences: list[tuple[Handler, ...]] = [()] * size

    def of(self, transition: int) -> tuple[Handler, ...]:
        """Return the handlers of a transition in the order they run."""
        return self._sequences[transition]

    def all(self) -> tuple[Handler, ...]:
        """Return all handlers, in the order they were registered."""
        return tuple(self._registered)

    def add(self, handler: Handler, *, is_replacing: bool = False) -> None:
        """Register a handler.

        Raises
        ------
        HandlerError
            The transition has a handler of this name already, and it is not to be replaced; or a number is
            out of range.
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
                            hint="give it another name=, or say replace=True",
                        )
                    self._registered[position] = handler
                    break
            else:
                self._registered.append(handler)
            self._arrange(handler.transition)

    def remove(self, transition: str, name: str) -> None:
        """Take a handler off a transition.

        Raises
        ------
        HandlerError
            There is no such handler.
        """
        with self._lock:
            self._registered.remove(self._find(transition, name))
            self._arrange(transition)

    def set_priority(self, transition: str, name: str, priority: int) -> None:
        """Let a handler run earlier or later.

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
