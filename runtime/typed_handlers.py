"""Types of the handlers of one node: what the modules ``firings`` of generated packages have in common.

A generated module says which fields the tokens of its node have, and which places each transition takes from
and puts to; a type checker then knows what a handler gets and what it may return.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from typing import Any, Generic, NamedTuple, Protocol, TypeAlias, TypedDict, TypeVar

from dineros.runtime.firing.cancels import CancelRequest
from dineros.runtime.firing.handlers import Given, Handler
from dineros.runtime.firing.policies import Policy
from dineros.runtime.journal.kept import Memory

Data_co = TypeVar("Data_co", covariant=True)
Inputs_co = TypeVar("Inputs_co", covariant=True)
Outputs_contra = TypeVar("Outputs_contra", contravariant=True)
Fires = TypeVar("Fires")
Outcome = TypeVar("Outcome")


class InputToken(NamedTuple, Generic[Data_co]):
    """A token that a transition takes or reads."""

    id: int
    data: Data_co


class TypedFiring(Protocol[Data_co, Inputs_co, Outputs_contra]):
    """A transition fires: `dineros.runtime.firing.handlers.Firing`, for one transition."""

    @property
    def transition(self) -> str:
        """Id of the transition in the model."""

    @property
    def instance(self) -> int | None:
        """Number of the server instance it belongs to, from 1."""

    @property
    def data(self) -> Data_co:
        """A copy of the data that continues; change it in place."""

    @property
    def inputs(self) -> Inputs_co:
        """Copies of the tokens it takes, and of those its read arcs see, by place."""

    @property
    def still_enabled(self) -> bool:
        """Whether it could commit now; a long handler may stop early where it could not."""

    @property
    def memory(self) -> Memory:
        """What the handlers of the node keep, also over restarts."""

    @property
    def cancel(self) -> CancelRequest:
        """Whether the goal of an action that it works on is to be canceled."""

    def give(self, places: Outputs_contra, /) -> Given:
        """Return data for single output places; those not named get what they would get anyway."""


Some = TypeVar("Some")
Whole = TypeVar("Whole")
GivenData: TypeAlias = Some | Whole | Sequence[Some | Whole]
"""Some fields, or the whole data, for all tokens of a place, or for each of them."""

Function: TypeAlias = Callable[[Fires], Outcome | Awaitable[Outcome]]
Decorator: TypeAlias = Callable[[Function[Fires, Outcome]], Function[Fires, Outcome]]


class HandlerOptions(TypedDict, total=False):
    """How a handler runs; see `dineros.runtime.firing.handlers.Handler`."""

    name: str
    priority: int
    thread: bool
    timeout: float
    parallel: int
    policy: Policy
    budget: float


def registering(handlers: list[Handler], transition: str, options: HandlerOptions) -> Callable[[Any], Any]:
    """Return a decorator that adds a handler of a transition to a list; its name is the function's."""

    def decorate(function: Any) -> Any:
        known: dict[str, Any] = {"name": function.__name__, **options}
        handlers.append(Handler(transition=transition, function=function, **known))
        return function

    return decorate
