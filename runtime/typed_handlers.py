"""Types of a node's handlers, shared by the modules ``firings`` of generated packages.

A generated module declares the fields of the node's tokens, and the places that each transition takes from
and puts to. A type checker then knows the argument of a handler and its possible results.
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
    """A firing: `dineros.runtime.firing.handlers.Firing`, typed for one transition."""

    @property
    def transition(self) -> str:
        """Id of the transition in the model."""

    @property
    def instance(self) -> int | None:
        """Number of the server instance it belongs to, from 1."""

    @property
    def data(self) -> Data_co:
        """A copy of the data passed to the outputs; change it in place."""

    @property
    def inputs(self) -> Inputs_co:
        """Copies of the tokens that it takes or reads, by place."""

    @property
    def still_enabled(self) -> bool:
        """Whether the firing could commit now; if not, a long handler may stop early."""

    @property
    def memory(self) -> Memory:
        """Values that the node's handlers keep, also over restarts."""

    @property
    def cancel(self) -> CancelRequest:
        """Whether the goal of an action that it works on is to be canceled."""

    def give(self, places: Outputs_contra, /) -> Given:
        """Return data for single output places; the others get the same tokens as without this method."""


Some = TypeVar("Some")
Whole = TypeVar("Whole")
GivenData: TypeAlias = Some | Whole | Sequence[Some | Whole]
"""Some or all fields, for all tokens of a place or for each of them."""

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
