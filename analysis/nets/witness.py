"""Witnesses: sequences of transitions, replayed by the firing rule before they are returned."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from dineros.analysis.nets.compiled import CompiledNet


class WitnessError(AssertionError):
    """The net cannot fire a sequence of transitions: an engine has an error."""


class FiringRows:
    """The firing rule on plain lists: for single firings an order of magnitude faster than that of the net.

    Attributes
    ----------
    needs : list
        For each transition, the places from which it takes or reads, each with the tokens that it needs.
    """

    def __init__(self, net: CompiledNet) -> None:
        self.needs = [net.pre.row(t) for t in range(len(net.transitions))]
        self._inhibitors = [net.inhibitor.row(t) for t in range(len(net.transitions))]
        self._changes = [list(change.items()) for change in net.delta]

    def enabled(self, marking: Sequence[int]) -> Iterator[int]:
        """Yield the transitions that a marking enables."""
        for transition, needs in enumerate(self.needs):
            for place, weight in needs:
                if marking[place] < weight:
                    break
            else:
                for place, weight in self._inhibitors[transition]:
                    if marking[place] >= weight:
                        break
                else:
                    yield transition

    def fire(self, transition: int, marking: list[int]) -> bool:
        """Fire a transition and change the marking, if it is enabled; return whether it is."""
        for place, weight in self.needs[transition]:
            if marking[place] < weight:
                return False
        for place, weight in self._inhibitors[transition]:
            if marking[place] >= weight:
                return False
        for place, tokens in self._changes[transition]:
            marking[place] += tokens
        return True


def moves(net: CompiledNet, marking: Sequence[int]) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Yield the transitions that a marking enables, each with the marking after it."""
    rows = net.once(FiringRows)
    for transition in rows.enabled(marking):
        after = list(marking)
        rows.fire(transition, after)
        yield transition, tuple(after)


def replay(net: CompiledNet, trace: Iterable[int]) -> list[list[int]]:
    """Fire a sequence of transitions from the initial marking.

    Returns
    -------
    list of list of int
        All markings of the run, the initial one first.

    Raises
    ------
    WitnessError
        A transition is not enabled when it is to fire.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 2})])
    >>> replay(net, [0])
    [[1, 0], [0, 2]]
    """
    markings = [[int(tokens) for tokens in net.initial]]
    for step, transition in enumerate(trace):
        if not net.is_enabled(transition, markings[-1]):
            raise WitnessError(f"step {step}: transition {net.transitions[transition]!r} is not enabled")
        markings.append(net.fire(transition, markings[-1]))
    return markings


def last_marking(net: CompiledNet, trace: Iterable[int]) -> list[int]:
    """Return the last marking of a run; faster than `replay`, which returns all of them.

    Raises
    ------
    WitnessError
        A transition is not enabled when it is to fire.
    """
    marking: list[int] = net.initial.tolist()
    for step, transition in enumerate(trace):
        if not net.is_enabled(transition, marking):
            raise WitnessError(f"step {step}: transition {net.transitions[transition]!r} is not enabled")
        for place, tokens in net.delta[transition].items():
            marking[place] += tokens
    return marking


def can_fire(net: CompiledNet, trace: Iterable[int], marking: Sequence[int]) -> bool:
    """Return whether transitions can fire from a marking, one after the other."""
    for transition in trace:
        if not net.is_enabled(transition, marking):
            return False
        marking = net.fire(transition, marking)
    return True


def way_to(came: Sequence[tuple[int, int]], number: int) -> tuple[int, ...]:
    """Return the firings to a marking, given for each marking its predecessor and the transition fired.

    The first marking has number 0.
    """
    way = []
    while number > 0:
        number, fired = came[number]
        way.append(fired)
    return tuple(reversed(way))


def ending_with_one_of(net: CompiledNet, trace: Iterable[int], transitions: Iterable[int]) -> tuple[int, ...]:
    """Return a sequence followed by the first of some transitions that is enabled at its end.

    Raises
    ------
    WitnessError
        A transition is not enabled when it is to fire, or none of those at the end is.
    """
    way = tuple(trace)
    marking = replay(net, way)[-1]
    last = next((t for t in transitions if net.is_enabled(t, marking)), None)
    if last is None:
        raise WitnessError("none of the transitions that should end it is enabled")
    return (*way, last)
