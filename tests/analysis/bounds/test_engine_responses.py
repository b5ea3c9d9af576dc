"""Response times of nodes of the execution `net`, and chains through them: bounds are safe."""

from __future__ import annotations

import os
from fractions import Fraction
from random import Random

from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.results import Latency
from dineros.metamodel import sym
from dineros.metamodel.elements import find
from tests.support.timed_systems.engine_chains import UNIT, Chain, Found, Stage, drawn, explored, model_of

SEEDS = 12 * int(os.environ.get("DINEROS_EXAMPLES", "1"))


def require_safe(bound: Latency, exact: Found, where: object) -> bool:
    """Return whether a bound is given, and holds for what the explorer has found."""
    unit = Fraction(str(UNIT))
    if exact.times:
        assert bound.least is not None and bound.least.value <= min(exact.times) * unit, where
    if exact.times and bound.greatest is not None:
        assert bound.greatest.value >= max(exact.times) * unit, where
    assert not (bound.is_lost is False and exact.is_lost), where
    return bound.greatest is not None


def callback_of(model: sym.SystemModel, number: int) -> sym.CallbackPage:
    return find(model, "Timer" if number < 0 else f"On{number}", sym.CallbackPage)


def test_no_bound_is_below_the_exact_value() -> None:
    asked = known = 0
    for seed in range(SEEDS):
        chain: Chain = drawn(Random(seed))
        model = model_of(chain)
        bounds = Bounds(model)
        numbers = range(-1, len(chain.stages))
        for first in numbers:
            for last in (each for each in numbers if each >= first):
                exact = explored(chain, first, last)
                if exact is None:
                    continue
                ends = callback_of(model, first), callback_of(model, last)
                bound = bounds.response(ends[0]) if first == last else bounds.between(*ends)
                asked += 1
                known += require_safe(bound, exact, (seed, first, last, chain))
                for number, topic in enumerate(model.channels):
                    assert isinstance(topic, sym.TopicChannel)
                    (reader,) = topic.subscribers
                    is_safe = bounds.never_overflows(reader)
                    assert not (is_safe and number in exact.overflows), (seed, chain)
                    if is_safe:
                        assert (bounds.longest(reader) or 0) >= exact.longest[number], (seed, chain)
    assert asked > SEEDS and known > 0.9 * asked, (asked, known)


def test_callbacks_of_engines_have_no_share_of_a_thread() -> None:
    """The thread of an engine is not that of its callbacks: 0 % would say that they need no time."""
    chain = Chain(8, (0, 1), (Stage((0, 1), 1, (0, 1)), Stage((0, 1), 1, (1, 2), is_engine=False)))
    model = model_of(chain)
    bounds = Bounds(model)
    assert [bounds.share_of_thread(callback_of(model, number)) for number in (-1, 0)] == [None, None]
    assert bounds.share_of_thread(callback_of(model, 1)) == Fraction(1, 4)
