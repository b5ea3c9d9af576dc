"""State classes against regions of random nets: all kinds reach the same markings, and none is left out."""

from __future__ import annotations

import time
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.timed.atomic import AtomicSearch
from dineros.analysis.timed.search import ClassSearch
from tests.analysis.timed.time_nets import RandomNet, lively_net


def markings(net: RandomNet, kind: str) -> set[tuple[int, ...]]:
    search = AtomicSearch(net.net) if kind == "A" else ClassSearch(net.net, kind)  # type: ignore[arg-type]
    search.run()
    assert search.reason is None
    return {tuple(row) for row in search.markings().tolist()}


@pytest.mark.parametrize("seed", range(60))
def test_all_kinds_reach_the_markings_of_the_regions(seed: int) -> None:
    net = lively_net(Random(seed))
    expected = net.regions().markings
    for kind in "WMSEA":
        assert markings(net, kind) == expected, kind


@pytest.mark.parametrize("seed", range(40))
def test_strong_classes_obey_priorities(seed: int) -> None:
    net = lively_net(Random(1000 + seed), has_priorities=True)
    expected = net.regions().markings
    for kind in "SEA":
        assert markings(net, kind) == expected, kind


@pytest.mark.parametrize(("seconds", "reason"), [(1e-6, "time"), (1000.0, "interrupted")])
def test_who_asks_to_end_says_why(monkeypatch: pytest.MonkeyPatch, seconds: float, reason: str) -> None:
    """A search whose time is over is asked to end as one is that is interrupted."""
    search = AtomicSearch(lively_net(Random(1)).net)

    def interrupted() -> None:
        search._budget = Budget(seconds=seconds).begun()
        time.sleep(0.001)
        raise KeyboardInterrupt

    monkeypatch.setattr(search, "_cut", interrupted)
    search.run()
    assert search.reason == reason
