"""Random time nets, all engines: the markings, LTL and CTL against plain references.

The nets have read and inhibitor arcs, weights, open and closed, finite and infinite intervals, and some of
them priorities. One hundred are drawn in each run; with ``DINEROS_EXAMPLES=20``, two thousand.
"""

from __future__ import annotations

import os
from functools import partial
from random import Random

import pytest

from dineros.analysis.answers.budget import UNLIMITED
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.timed.atomic import AtomicSearch
from dineros.analysis.timed.branching_time import check_timed_ctl
from dineros.analysis.timed.integers.counting import count_markings
from dineros.analysis.timed.integers.net import integer_net
from dineros.analysis.timed.linear_time import verify_timed_ltl
from dineros.analysis.timed.search import ClassSearch
from tests.analysis.timed.test_branching_time import is_true, random_formula
from tests.analysis.timed.test_linear_time import FORMULAS, region_net
from tests.analysis.timed.time_nets import RandomNet, lively_net, prior_net
from tests.support.references.timed_ctl import FiringGraph

TIMES = int(os.environ.get("DINEROS_EXAMPLES", "1"))
PARTS = 10

FEATURES = {
    "read arcs": lambda net: any(one.read for one in net.transitions),
    "inhibitor arcs": lambda net: any(one.inhibitor for one in net.transitions),
    "weights": lambda net: any(max(one.take.values()) > 1 for one in net.transitions),
    "open below": lambda net: any(one.is_open_below for one in net.transitions),
    "open above": lambda net: any(one.is_open_above for one in net.transitions),
    "no latest bound": lambda net: any(one.latest is None for one in net.transitions),
    "one moment": lambda net: any(one.latest == one.earliest for one in net.transitions),
    "priorities": lambda net: bool(net.pairs),
}


def drawn(seed: int) -> RandomNet:
    """Return the net of a seed: every third has priorities, every fourth closed intervals only.

    Those with both have priorities that time as a counter knows.
    """
    if seed % 12 == 0:
        return prior_net(Random(7_000 + seed), most=1_500)
    return lively_net(Random(7_000 + seed), has_priorities=seed % 3 == 0, is_closed=seed % 4 == 0, most=1_500)


@pytest.mark.long
@pytest.mark.parametrize("part", range(PARTS))
def test_all_engines_agree(part: int) -> None:
    for seed in range(part, 100 * TIMES, PARTS):
        net = drawn(seed)
        regions = net.regions()
        markings_agree(seed, net)
        random = Random(seed)
        firings = FiringGraph(regions)
        for formula in [random_formula(random, net, 3) for _ in range(4)]:
            expected = firings.holds(parse(formula, "ctl"), partial(is_true, net))
            assert (check_timed_ctl(net.net, formula).status == "holds") == expected, (seed, formula)
        plain, names = region_net(net)
        for formula in random.sample(FORMULAS, 2):
            expected_status = verify_ltl(plain, formula, names).status
            assert verify_timed_ltl(net.net, formula).status == expected_status, (seed, formula)


def markings_agree(seed: int, net: RandomNet) -> None:
    expected = net.regions().markings
    for kind in "SEA" if net.pairs else "WMSEA":
        search = AtomicSearch(net.net) if kind == "A" else ClassSearch(net.net, kind)  # type: ignore[arg-type]
        search.run()
        assert {tuple(row) for row in search.markings().tolist()} == expected, (seed, kind)
    if seed % 4 == 0:
        assert count_markings(integer_net(net.net), UNLIMITED) == len(expected), seed


def test_the_nets_have_all_features() -> None:
    nets = [drawn(seed) for seed in range(40)]
    for feature, is_there in FEATURES.items():
        assert sum(map(is_there, nets)) >= 5, feature
