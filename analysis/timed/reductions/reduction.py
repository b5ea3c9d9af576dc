"""Reduction of a time Petri net to a smaller one with the same runs at the same times."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.reductions import ReductionError
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.reductions.net import SmallerNet
from dineros.analysis.timed.reductions.rules import RULES, TimedRule


@dataclass(frozen=True)
class TimedStep:
    """One application of a rule.

    Attributes
    ----------
    removed : str
        The place or the transition that went.
    """

    rule: str
    removed: str


@dataclass(frozen=True)
class TimedReduction:
    """A smaller net, and how it came about.

    Attributes
    ----------
    original, net : TimedNet
        The nets before and after. They have the same runs at the same times, seen at the places and
        transitions of `net`: the same markings, and the same answers to LTL and CTL about them.
    """

    original: TimedNet
    net: TimedNet
    steps: tuple[TimedStep, ...]


def reduce_timed(net: TimedNet, observed: Iterable[str] = (), budget: Budget = UNLIMITED) -> TimedReduction:
    """Remove what never decides anything, until no rule applies any more, or time is up.

    Parameters
    ----------
    net
        The net; it may have priorities.
    observed
        Names of places and transitions that stay. A formula that asks whether a transition is enabled
        observes it and the places around it.
    budget
        Its time; if it runs out, the net is the result of the rules applied so far.

    Raises
    ------
    ReductionError
        A name is unknown.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from dineros.analysis.nets.compiled import Transition
    >>> from dineros.analysis.timed.nets import Interval
    >>> steps = [Transition("soon", {"p": 1}, {"q": 1}), Transition("late", {"p": 1}, {"r": 1})]
    >>> times = {"soon": Interval(Fraction(0), Fraction(2)), "late": Interval(Fraction(3), Fraction(4))}
    >>> made = reduce_timed(TimedNet.build({"p": 1, "q": 0, "r": 0}, steps, times), ["q"])
    >>> [f"{one.rule}: {one.removed}" for one in made.steps]
    ['Overtaken: late', 'Untested: r']
    """
    kept, budget = frozenset(observed), budget.begun()
    unknown = sorted(kept - {*net.untimed.places, *net.untimed.transitions})
    if unknown:
        raise ReductionError(f"unknown place or transition {unknown[0]!r}")
    current, steps = SmallerNet.of(net), list[TimedStep]()
    while True:
        before = len(steps)
        for name, rule in _removable(current, kept, budget):
            (current.remove_place if rule.is_place else current.remove_transition)(name)
            steps.append(TimedStep(rule.name, name))
        if len(steps) == before:
            return TimedReduction(net, current.compile() if steps else net, tuple(steps))


def _removable(net: SmallerNet, kept: frozenset[str], budget: Budget) -> Iterator[tuple[str, TimedRule]]:
    """Yield what each rule removes in turn, while there is time."""
    for rule in RULES:
        for name in () if budget.is_over else rule.removable(net, kept):
            yield name, rule
            if budget.is_over:
                break
