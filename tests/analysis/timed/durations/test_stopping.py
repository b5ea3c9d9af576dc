"""Bounds of times proved by inclusion, and of nets without some places, against the exact answers."""

from __future__ import annotations

from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.logic.language.bounded import Bounded, read_bounded
from dineros.analysis.timed.durations.bounded_response import decide_bounded
from dineros.analysis.timed.durations.stopping import always_within
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.reductions.cuts import restricted
from tests.analysis.timed.time_nets import lively_net, random_net

FIRED = ["fired(t0)", "fired(t1)", "fired(t2)"]
MARKED = ["p0 >= 1", "p1 >= 1", "p1 >= 2", "p1 == 0", "p0 < 1", "p0 + p1 >= 1", "p0 + p1 == 0"]
SMALL = Budget(states=20_000, memory_bytes=1 << 27)


def formulas(random: Random, count: int) -> list[Bounded]:
    """Return formulas ``a leads to b within d`` of random nets, whose unit is a seventh."""
    found = []
    for _ in range(count):
        trigger = f"fired(t{random.randrange(3)})"
        among = random.choice((FIRED, MARKED, FIRED + MARKED))
        conditions = random.sample(among, random.choice((1, 1, 2)))
        joined = random.choice((" | ", " & "))
        last = Fraction(random.randint(0, 6), 7)
        window = random.choice((f"[<={last}]", f"[<{last}]" if last else "[<=0]"))
        after = random.choice(("", "X "))
        formula = read_bounded(f"G ({trigger} -> {after}F{window} ({joined.join(conditions)}))")
        assert formula is not None
        found.append(formula)
    return found


@pytest.mark.parametrize("seed", range(60))
def test_what_is_proved_by_inclusion_holds(seed: int) -> None:
    """Each formula that holds for firings is proved, too, as nothing ends a firing in the same moment."""
    random = Random(seed)
    net = lively_net(random, is_closed=seed % 2 == 0, most=400).net
    for formula in formulas(random, 12):
        exact = decide_bounded(net, formula).status
        found = always_within(net, formula, None, UNLIMITED)
        assert found is None or (found.status, exact) == ("holds", "holds"), str(formula)
        said = str(formula.condition)
        if "p" not in said and "&" not in said:
            assert (found is not None) == (exact == "holds"), str(formula)


def cut(random: Random, net: TimedNet) -> TimedNet | None:
    """Return a net without some of its places."""
    places = range(len(net.untimed.places))
    return restricted(net, random.sample(places, random.randint(1, len(places))))


@pytest.mark.parametrize("seed", range(300))
def test_what_a_part_proves_holds(seed: int) -> None:
    random = Random(seed)
    net = lively_net(random, is_closed=seed % 2 == 0, most=400).net
    for _ in range(4):
        part = cut(random, net)
        assert part is not None
        kept = {name for t in range(len(part.intervals)) for name in _around(part, t)}
        for formula in formulas(random, 4):
            named = {name for name in ("p0", "p1", "p2") if name in str(formula)}
            fired = {int(t[1:]) for t in ("t0", "t1", "t2") if t in str(formula)}
            if not named <= kept or any(_is_dropped(part, t) for t in fired):
                continue
            found = always_within(part, formula, None, SMALL)
            if found is not None:
                assert decide_bounded(net, formula).status == "holds", str(formula)


def _around(net: TimedNet, t: int) -> list[str]:
    return [net.untimed.places[place] for place, _ in (*net.untimed.pre.row(t), *net.untimed.post.row(t))]


def _is_dropped(net: TimedNet, t: int) -> bool:
    return any(name.startswith("never") for name in _around(net, t))


@pytest.mark.parametrize("seed", range(200))
def test_a_part_has_all_markings_of_the_net(seed: int) -> None:
    """Each firing sequence with times is one of the part: so are the markings of the places that are left."""
    from dineros.analysis.timed.exploring import explore_timed

    random = Random(1000 + seed)
    net = random_net(random).net
    whole = explore_timed(net, SMALL)
    places = sorted(random.sample(range(len(net.untimed.places)), 2))
    part = restricted(net, places)
    assert part is not None
    found = explore_timed(part, SMALL)
    if not whole.is_complete or not found.is_complete:
        return
    left = {tuple(row) for row in found.markings[:, places].tolist()}
    assert {tuple(row) for row in whole.markings[:, places].tolist()} <= left


def test_a_part_knows_how_many_tokens_are_elsewhere() -> None:
    """A token goes round three places; the part with one of them puts no second one there."""
    from dineros.analysis.nets.compiled import Transition
    from dineros.analysis.timed.exploring import explore_timed

    net = TimedNet.build(
        {"a": 1, "b": 0, "c": 0},
        [
            Transition("t", {"a": 1}, {"b": 1}),
            Transition("u", {"b": 1}, {"c": 1}),
            Transition("v", {"c": 1}, {"a": 1}),
        ],
        {},
    )
    part = restricted(net, [0])
    assert part is not None
    found = explore_timed(part, UNLIMITED)
    assert (found.is_complete, len(found.markings)) == (True, 2)
