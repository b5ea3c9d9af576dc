"""The interface of reduction rules: the properties they may preserve, and the record of an application."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from typing import Any, ClassVar

from dineros.analysis.reductions.net import Arcs, Change, Marking, MutableNet


class Property(StrEnum):
    """Properties that a reduction can preserve. N is the net before and N' the net after."""

    STATE_SPACE_SIZE = "state_space_size"
    """The number of reachable markings of N is that of N' times `Step.factor`, and each can be recovered."""

    MARKINGS = "markings"
    """Each reachable marking of N' represents `Reduction.weight` markings of N, by its tokens: no two
    for the same one, all for all of them, and each can be recovered. If `DEADLOCKS` is preserved too,
    the number of deadlocks of N is that of N' times `Step.dead_ends`."""

    KEPT_PLACES = "kept_places"
    """On the places that both nets have, both reach the same markings."""

    DEADLOCKS = "deadlocks"
    """N reaches a marking in which no transition is enabled iff N' does."""

    LTL_WITHOUT_NEXT = "ltl_without_next"
    """The maximal runs of N and N' agree, up to stuttering, on the tokens of observed places and the firings
    of observed transitions, where a run that ends stays in its last marking forever. No fairness is
    assumed."""

    LIVENESS = "liveness"
    """N is live (every transition can fire again from every reachable marking) iff N' is."""

    BOUNDEDNESS = "boundedness"
    """N is bounded iff N' is."""


ALL_PROPERTIES = frozenset(Property)
#: Properties preserved if both nets have the same firing sequences.
LANGUAGE_PROPERTIES = ALL_PROPERTIES - {Property.STATE_SPACE_SIZE, Property.MARKINGS, Property.BOUNDEDNESS}


@dataclass(frozen=True)
class Question:
    """The requirements for a reduction.

    Attributes
    ----------
    preserve
        Properties that every applied rule must preserve.
    observed_places, observed_transitions
        Elements that stay in the net, with their names and their meaning.
    """

    preserve: frozenset[Property]
    observed_places: frozenset[str] = frozenset()
    observed_transitions: frozenset[str] = frozenset()

    def is_invisible(self, transition: str, arcs: Arcs) -> bool:
        """Whether a transition changes no observed element."""
        return transition not in self.observed_transitions and self.observed_places.isdisjoint(arcs.delta)


@dataclass(frozen=True)
class PlaceEquation:
    """Tokens of a removed place in every reachable marking: constant + sum of weight * tokens."""

    place: str
    weights: Mapping[str, Fraction]
    constant: Fraction

    def value(self, marking: Mapping[str, int]) -> int:
        """Tokens of the place in a marking of the others.

        Raises
        ------
        ValueError
            The marking does not satisfy the equation.
        """
        tokens = self.constant + sum(weight * marking[place] for place, weight in self.weights.items())
        if tokens.denominator != 1 or tokens < 0:
            raise ValueError(f"place {self.place!r} would hold {tokens} tokens")
        return int(tokens)

    def __str__(self) -> str:
        terms = "".join(
            f" {'-' if weight < 0 else '+'} {'' if abs(weight) == 1 else f'{abs(weight)} * '}{place}"
            for place, weight in self.weights.items()
        )
        return f"{self.place} = {self.constant}{terms}"


#: (net before the step, trace of the net after it, whether to run on to a deadlock) -> trace of the net
#: before.
Lift = Callable[[MutableNet, list[str], bool], list[str]]


def same_trace(_before: MutableNet, trace: list[str], _settle: bool) -> list[str]:
    """Lift of a rule whose reduced net has only firing sequences of the original net."""
    return trace


@dataclass(frozen=True)
class Step:
    """One application of a rule.

    Attributes
    ----------
    places, transitions : tuple of str
        Elements it is about, with their names before it.
    preserves : frozenset of Property
        Properties that this application preserves; they may be fewer than the most of its rule.
    lift : Lift
        Maps a trace back over this step.
    component : tuple of markings
        The markings of a removed independent component (each combines with each of the rest), else empty.
    dead_ends : int
        Number of these markings without a successor, if each run of the component ends in one, else 1.
    is_split : bool
        Whether `places` became one place whose tokens can be distributed among them in every way.
    """

    rule: str
    places: tuple[str, ...]
    transitions: tuple[str, ...]
    preserves: frozenset[Property]
    change: Change
    lift: Lift = field(default=same_trace, repr=False)
    equation: PlaceEquation | None = None
    component: tuple[Marking, ...] = field(default=(), repr=False)
    dead_ends: int = 1
    is_split: bool = False

    @property
    def factor(self) -> int:
        """Number of markings before for each marking after, if `STATE_SPACE_SIZE` is preserved."""
        return len(self.component) or 1

    def __str__(self) -> str:
        return f"{self.rule}: {', '.join((*self.places, *self.transitions))}"


class Rule(ABC):
    """A reduction rule: finds its applications, and declares the properties that each preserves.

    Attributes
    ----------
    preserves : frozenset of Property
        The most that any application preserves; a rule that preserves too little is not tried.
    is_costly : bool
        Whether it is tried only if no cheap rule applies.
    """

    preserves: ClassVar[frozenset[Property]]
    is_costly: ClassVar[bool] = False

    @property
    def name(self) -> str:
        """Name of the rule, as steps show it."""
        return type(self).__name__

    @abstractmethod
    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer steps one by one; whenever a step is taken, the net changes before the next one.

        A step that preserves too little for the question is not taken; then the net does not change.
        """

    def step(
        self,
        places: Iterable[str],
        transitions: Iterable[str],
        change: Change,
        preserves: Iterable[Property] | None = None,
        **more: Any,
    ) -> Step:
        """Return an application of the rule as a `Step`; by default, it preserves the most."""
        kept = self.preserves if preserves is None else frozenset(preserves)
        return Step(self.name, tuple(places), tuple(transitions), kept, change, **more)
