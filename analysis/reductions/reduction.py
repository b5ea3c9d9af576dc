"""Reduction of a net to a smaller one with the same answer (paper, Algorithm 4); traces are translated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import comb, prod

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.nets.compiled import CompiledNet, NetError
from dineros.analysis.reductions.agglomerations import PostAgglomeration, PreAgglomeration
from dineros.analysis.reductions.components import IndependentComponent, UnreadableTransition
from dineros.analysis.reductions.inhibitors import ComplementaryInhibitor, ImpliedInhibitor
from dineros.analysis.reductions.merges import ChainOfPlaces, LoopOfPlaces
from dineros.analysis.reductions.net import Marking, MutableNet
from dineros.analysis.reductions.places import ConstantPlace, ImpliedPlace, ParallelPlace
from dineros.analysis.reductions.rule import PlaceEquation, Property, Question, Rule, Step
from dineros.analysis.reductions.sources import InexhaustiblePlace
from dineros.analysis.reductions.transitions import (
    ComposedTransition,
    DeadTransition,
    DuplicateTransition,
    ExcludedTransition,
    IdentityTransition,
)

#: All rules in the order in which they are tried: rules that only remove come before those that add elements.
RULES: tuple[Rule, ...] = (
    DeadTransition(),
    UnreadableTransition(),
    ConstantPlace(),
    IndependentComponent(),
    IdentityTransition(),
    DuplicateTransition(),
    ComplementaryInhibitor(),
    ParallelPlace(),
    InexhaustiblePlace(),
    ChainOfPlaces(),
    LoopOfPlaces(),
    PostAgglomeration(),
    PreAgglomeration(),
    ComposedTransition(),
    ExcludedTransition(),
    ImpliedInhibitor(),
    ImpliedPlace(),
)

#: Rules that only remove transitions that can never fire, which changes no marking and no other firing.
PROOFS_OF_DEATH: tuple[Rule, ...] = (DeadTransition(), UnreadableTransition(), ExcludedTransition())


class ReductionError(NetError):
    """An invalid question: an unknown property, place or transition."""


@dataclass(frozen=True)
class Reduction:
    """A reduced net, with the steps of its reduction.

    Attributes
    ----------
    question : Question
        The question whose answer every step preserves.
    steps : tuple of Step
        The applications of rules, in order.
    """

    original: CompiledNet
    net: CompiledNet
    question: Question
    steps: tuple[Step, ...]

    @cached_property
    def preserves(self) -> frozenset[Property]:
        """Properties preserved by all steps, at least those requested."""
        return frozenset(Property).intersection(*(step.preserves for step in self.steps))

    @cached_property
    def kept_places(self) -> tuple[str, ...]:
        """Places of the reduced net that are places of the original one, with the same meaning."""
        return tuple(place for place in self.net.places if place in self._original_places)

    @cached_property
    def count_factor(self) -> int:
        """Number of markings of the original net for each one of the reduced net.

        Raises
        ------
        ReductionError
            The steps do not preserve `Property.STATE_SPACE_SIZE`.
        """
        self._require(Property.STATE_SPACE_SIZE)
        return self.marking_factor

    @property
    def marking_factor(self) -> int:
        """The part of `weight` that does not depend on the marking: removed independent components.

        Raises
        ------
        ReductionError
            The steps do not preserve `Property.MARKINGS`.
        """
        self._require(Property.MARKINGS)
        return prod(step.factor for step in self.steps)

    @property
    def deadlock_factor(self) -> int:
        """Number of deadlocks of the original net for each one of the reduced net, if all this is preserved.

        Raises
        ------
        ReductionError
            The steps do not preserve `Property.MARKINGS` and `Property.DEADLOCKS`.
        """
        self._require(Property.MARKINGS, Property.DEADLOCKS)
        return prod(step.dead_ends for step in self.steps)

    @cached_property
    def merged(self) -> Mapping[str, int]:
        """Places of the reduced net that represent several original ones, which share the tokens; how many.

        Raises
        ------
        ReductionError
            The steps do not preserve `Property.MARKINGS`.
        """
        self._require(Property.MARKINGS)
        merged: dict[str, int] = {}
        for step in self.steps:
            _merge(merged, step)
        return merged

    def weight(self, marking: Mapping[str, int]) -> int:
        """Return the number of original markings that a reachable marking of the reduced net represents.

        Raises
        ------
        ReductionError
            The steps do not preserve `Property.MARKINGS`.
        """
        ways = prod(ways_to_share(marking[place], number) for place, number in self.merged.items())
        return ways * self.marking_factor

    @property
    def equations(self) -> tuple[PlaceEquation, ...]:
        """Equations that give the tokens of removed places, to be evaluated from last to first."""
        return tuple(step.equation for step in self.steps if step.equation is not None)

    def expand(self, trace: Sequence[str], *, until_deadlock: bool = False) -> list[str]:
        """Translate a firing sequence of the reduced net to one of the original net.

        Kept places pass through the same markings, up to stuttering, if `Property.KEPT_PLACES` or, for
        observed ones, `Property.LTL_WITHOUT_NEXT` is preserved. The result has been replayed.

        Parameters
        ----------
        trace
            Names of the transitions of a firing sequence of the reduced net.
        until_deadlock
            Whether the sequence leads to a deadlock; then so does the result, if `Property.DEADLOCKS` is
            preserved.

        Raises
        ------
        NetError
            The trace is not a firing sequence of the reduced net.
        """
        net = MutableNet.of(self.net)
        result = list(trace)
        replay(net, result)
        for step in reversed(self.steps):
            net.apply(step.change.inverse())
            result = step.lift(net, result, until_deadlock)
        marking = replay(net, result)
        if until_deadlock and Property.DEADLOCKS in self.preserves:
            assert not any(net.is_enabled(t, marking) for t in net.transitions), (
                "an expanded deadlock enables a transition"
            )
        return result

    @cached_property
    def _original_places(self) -> frozenset[str]:
        return frozenset(self.original.places)

    def _require(self, *properties: Property) -> None:
        if not self.preserves.issuperset(properties):
            raise ReductionError("this reduction does not preserve the number of markings")


def ways_to_share(tokens: int, places: int) -> int:
    """Number of ways to distribute tokens among places."""
    return comb(tokens + places - 1, places - 1)


def _merge(merged: dict[str, int], step: Step) -> None:
    """Update how many places each merged one represents after a step."""
    removed = [merged.pop(place, 1) for place in step.change.removed_places]
    if step.is_split:
        (place,) = step.change.added_places
        merged[place] = sum(removed)


def replay(net: MutableNet, trace: Iterable[str]) -> Marking:
    """Return the marking after a firing sequence.

    Raises
    ------
    NetError
        If a transition is unknown or not enabled when it is to fire.
    """
    marking = dict(net.places)
    for t in trace:
        if t not in net.transitions:
            raise NetError(f"unknown transition {t!r}")
        net.fire(t, marking)
    return marking


def reduce(
    net: CompiledNet,
    preserve: Iterable[Property | str],
    *,
    observed_places: Iterable[str] = (),
    observed_transitions: Iterable[str] = (),
    rules: Sequence[Rule] = RULES,
    budget: Budget = UNLIMITED,
) -> Reduction:
    """Apply reduction rules until no rule applies, or the time is over.

    Parameters
    ----------
    preserve
        Properties to preserve (`Property`, or its text). Only rules that preserve all of them are applied.
    observed_places, observed_transitions
        Elements that must not change. A formula about the enabling of a transition observes the places around
        it.
    rules
        The rules, in the order in which they are tried.
    budget
        Limit of its time; when it is over, the net reduced so far is returned.

    Returns
    -------
    Reduction
        The same for the same input, independent of the hash seed, if the time is sufficient.

    Raises
    ------
    ReductionError
        A property, place or transition is unknown.

    Examples
    --------
    >>> from dineros.analysis.nets.compiled import CompiledNet
    >>> start = ("start", {"wait": 1}, {"run": 1, "copy": 1})
    >>> end = ("end", {"run": 1, "copy": 1})
    >>> net = CompiledNet.build({"wait": 1, "run": 0, "copy": 0}, [start, end])
    >>> reduction = reduce(net, {"state_space_size"})
    >>> reduction.net.places, [str(equation) for equation in reduction.equations]
    (('wait', 'copy'), ['run = 0 + copy'])
    """
    question, budget = _question(net, preserve, observed_places, observed_transitions), budget.begun()
    current = MutableNet.of(net)
    steps: list[Step] = []
    merged: dict[str, int] = {}
    usable = [rule for rule in rules if question.preserve <= rule.preserves]
    cheap, costly = ([rule for rule in usable if rule.is_costly is flag] for flag in (False, True))
    while True:
        while sum(_exhaust(rule, current, question, steps, merged, budget) for rule in cheap):
            pass
        if not any(_exhaust(rule, current, question, steps, merged, budget) for rule in costly):
            break
    return Reduction(net, current.compile(), question, tuple(steps))


def _exhaust(
    rule: Rule, net: MutableNet, question: Question, steps: list[Step], merged: dict[str, int], budget: Budget
) -> int:
    """Apply one rule everywhere in one pass, while there is time; return the number of applications."""
    before = len(steps)
    if budget.left == 0:
        return 0
    for offered in rule.steps(net, question):
        step = offered
        if not step.is_split and not merged.keys().isdisjoint(step.change.removed_places):
            # The number of ways to distribute its tokens depends on the marking, which is lost.
            step = replace(step, preserves=step.preserves - {Property.MARKINGS})
        if question.preserve <= step.preserves:
            net.apply(step.change)
            steps.append(step)
            _merge(merged, step)
            if budget.is_over:
                break
    return len(steps) - before


def _question(
    net: CompiledNet, preserve: Iterable[Property | str], places: Iterable[str], transitions: Iterable[str]
) -> Question:
    try:
        asked = frozenset(Property(item) for item in preserve)
    except ValueError as error:
        known = ", ".join(Property)
        raise ReductionError(f"{error}; the properties are {known}") from None
    question = Question(asked, frozenset(places), frozenset(transitions))
    for kind, names, all_names in (
        ("place", question.observed_places, net.places),
        ("transition", question.observed_transitions, net.transitions),
    ):
        unknown = sorted(names.difference(all_names))
        if unknown:
            raise ReductionError(f"unknown {kind} {unknown[0]!r}")
    return question
