"""Witnesses: sequences of transitions, replayed by the plain firing rule before anyone sees them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from dineros.analysis.nets.compiled import CompiledNet


class WitnessError(AssertionError):
    """A sequence of transitions that the net cannot fire: an engine is wrong."""


def replay(net: CompiledNet, trace: Iterable[int]) -> list[list[int]]:
    """Fire a sequence of transitions from the initial marking.

    Returns
    -------
    list of list of int
        All markings on the way, the initial one first.

    Raises
    ------
    WitnessError
        If a transition is not enabled when it is its turn.

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


def way_to(came: Sequence[tuple[int, int]], number: int) -> tuple[int, ...]:
    """Return the firings to a marking, of which it is known, as of all, from which one it came, and by what.

    Number 0 is the first marking.
    """
    way = []
    while number > 0:
        number, fired = came[number]
        way.append(fired)
    return tuple(reversed(way))


def ending_with_one_of(net: CompiledNet, trace: Iterable[int], transitions: Iterable[int]) -> tuple[int, ...]:
    """Return a sequence with the first of some transitions at its end that is enabled there.

    Raises
    ------
    WitnessError
        If a transition is not enabled when it is its turn, or none of those at the end.
    """
    way = tuple(trace)
    marking = replay(net, way)[-1]
    last = next((t for t in transitions if net.is_enabled(t, marking)), None)
    if last is None:
        raise WitnessError("none of the transitions that should end it is enabled")
    return (*way, last)
