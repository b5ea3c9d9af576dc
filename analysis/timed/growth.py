"""Tokens that grow forever in a time Petri net: a loop of firings that can be repeated at the same times.

Whether a time Petri net is bounded is undecidable, so this is a sufficient condition. A firing sequence leads
from a class to one with more tokens, the same enabled transitions and the same firing times. If further
tokens of the same kind enable and disable nothing on the way, the loop continues forever.

References
----------
B. Berthomieu, M. Diaz, *Modeling and verification of time dependent systems using time Petri nets*, IEEE TSE
17(3), 1991, sect. III (sufficient conditions).
"""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.plain_classes import PlainClass, classes_along, enabled_in

MOST_FIRINGS = 200
"""Later firings of a sequence are ignored."""
MOST_WEIGHT = 50
"""A net with arcs of a larger weight is not analysed."""


def growing_loop(net: TimedNet, trace: Sequence[int]) -> Pumping | None:
    """Return a loop in a firing sequence that makes tokens grow forever; None if it shows none.

    The sequence is examined up to `MOST_FIRINGS`. Nets with priorities are not analysed, since linear classes
    do not represent them.
    """
    trace = trace[:MOST_FIRINGS]
    weights = [w for table in (net.untimed.pre, net.untimed.inhibitor) for w in table.weight.tolist()]
    most = max(weights, default=0)
    if net.has_priorities or most > MOST_WEIGHT:
        return None
    classes = list(classes_along(net, trace))
    alike: dict[object, list[int]] = {}
    for end, last in enumerate(classes):
        starts = alike.setdefault((last.enabled, last.matrix), [])
        for start in reversed(starts):
            first = classes[start]
            if _grows(first, last):
                loop = tuple(trace[start:end])
                more = [b - a for a, b in zip(first.marking, last.marking, strict=True)]
                if _repeats(net, classes[start : end + 1], loop, more, most + 1):
                    grown = tuple(place for place, tokens in enumerate(more) if tokens)
                    return Pumping(prefix=tuple(trace[:start]), suffix=loop, places=grown)
        starts.append(end)
    return None


def _grows(first: PlainClass, last: PlainClass) -> bool:
    pairs = list(zip(first.marking, last.marking, strict=True))
    return first.marking != last.marking and all(a <= b for a, b in pairs)


def _repeats(
    net: TimedNet, classes: Sequence[PlainClass], loop: Sequence[int], more: Sequence[int], rounds: int
) -> bool:
    """Whether further rounds enable and disable the same; later, no arc distinguishes rounds."""
    for here, fired in zip(classes, loop, strict=False):
        between = list(here.marking)
        for place, weight in net.take.row(fired):
            between[place] -= weight
        for marking in (here.marking, between):
            expected = enabled_in(net, marking)
            for number in range(1, rounds + 1):
                grown = [a + number * b for a, b in zip(marking, more, strict=True)]
                if enabled_in(net, grown) != expected:
                    return False
    return True
