"""The scheduler: methods run one after the other, each with its share of the budget.

A plan defines the order, the conditions and the shares. It is data, so that it can be read as a table. All
code that divides time among methods of deciding, or among questions, uses this module.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from dineros.analysis.answers.budget import Budget, BudgetExceededError

Item = TypeVar("Item")
Record = TypeVar("Record")


@dataclass(frozen=True, kw_only=True)
class Share:
    """The limits of a stage, as parts of the rest of a budget.

    Attributes
    ----------
    time, memory : float
        Parts of the remaining time, and of the memory.
    most_seconds : float, optional
        Maximum time.
    seconds_if_unlimited : float, optional
        Maximum time if the budget has no limit of time.
    most_bytes, most_states : int, optional
        Maximum memory, and maximum number of markings.
    if_more_bytes : int
        The stage is used only if the budget has more memory than this.
    """

    time: float = 1.0
    memory: float = 1.0
    most_seconds: float | None = None
    seconds_if_unlimited: float | None = None
    most_bytes: int | None = None
    most_states: int | None = None
    if_more_bytes: int = 0

    def share(self, budget: Budget) -> Budget:
        """Return the share of a budget, with its clock running."""
        own = budget.share(self.time, self.memory, most_bytes=self.most_bytes, most_states=self.most_states)
        if self.most_seconds is not None:
            own = own.at_most(self.most_seconds)
        return own if self.seconds_if_unlimited is None else own.unless_limited(self.seconds_if_unlimited)


@dataclass(frozen=True)
class PlanEntry(Share, ABC, Generic[Record]):
    """An entry of a plan: something that works on a record, and its limits."""

    @abstractmethod
    def applies(self, record: Record) -> bool:
        """Return whether it is used, depending on the facts in the record."""

    @abstractmethod
    def run(self, record: Record, budget: Budget) -> None:
        """Add facts to the record.

        Raises
        ------
        BudgetExceededError
            The share was not sufficient.
        """


@dataclass(frozen=True)
class Stage(PlanEntry[Record]):
    """An entry that calls a function with the record and the budget.

    Examples
    --------
    >>> def halve(found: dict, budget: Budget) -> None:
    ...     found["half"] = found["whole"] / 2
    >>> plan = [Stage(halve, time=0.2), Stage(dict.clear, when=lambda found: found["whole"] == 0)]
    >>> run_stages({"whole": 6}, plan, Budget(seconds=10))
    {'whole': 6, 'half': 3.0}
    """

    method: Callable[[Record, Budget], object]
    when: Callable[[Record], bool] | None = None
    """Returns whether it is used; always by default."""
    name: str = field(default="", kw_only=True)
    """Shown to the user when the stage begins."""

    def applies(self, record: Record) -> bool:
        """Ask `when`."""
        return self.when is None or self.when(record)

    def run(self, record: Record, budget: Budget) -> None:
        """Call the function."""
        if self.name:
            budget.stage(self.name)
        self.method(record, budget)


def _never(record: object) -> bool:
    return False


def run_stages(
    record: Record,
    plan: Iterable[PlanEntry[Record]],
    budget: Budget,
    is_done: Callable[[Record], bool] = _never,
    *,
    given_up: tuple[type[Exception], ...] = (BudgetExceededError,),
) -> Record:
    """Run the entries of a plan until the record is complete or the time is over; the first one always runs.

    Parameters
    ----------
    is_done : callable
        Returns whether the record answers all questions.
    given_up : tuple of type
        Errors of an entry after which the next entry is used; other errors end the plan.

    Returns
    -------
    Record
        The record itself.
    """
    budget = budget.begun()
    for entry in plan:
        if is_done(record):
            break
        if (entry.if_more_bytes and budget.memory <= entry.if_more_bytes) or not entry.applies(record):
            continue
        with suppress(*given_up):
            entry.run(record, entry.share(budget))
        if budget.is_over:
            break
    return record


@dataclass(frozen=True)
class Attempt(Share, Generic[Item]):
    """A way to a result, and its limits: it returns None if it has none."""

    work: Callable[[Budget], Item | None]


def first_result(attempts: Iterable[Attempt[Item]], budget: Budget) -> Item | None:
    """Return the result of the first attempt that has one, or None.

    Raises
    ------
    BudgetExceededError
        An attempt raised it.
    """
    budget = budget.begun()
    for attempt in attempts:
        found = attempt.work(attempt.share(budget))
        if found is not None:
            return found
    return None


def fairly(
    items: Sequence[Item], budget: Budget, *, factor: float = 1.0, memory: float = 1.0, kept: int = 0
) -> Iterator[tuple[Item, Budget]]:
    """Divide the remaining time among items: time that an item does not use is available to the others.

    Parameters
    ----------
    factor : float
        Multiple of its fair share that an item may use.
    memory : float
        Part of the memory for each item.
    kept : int
        Number of further shares, for work after the items.

    Yields
    ------
    tuple
        An item and its budget, which may be over.
    """
    budget, count = budget.begun(), len(items) + kept
    for number, item in enumerate(items):
        yield item, budget.share(min(1.0, factor / (count - number)), memory)
