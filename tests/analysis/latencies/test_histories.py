"""Histories of servers, clients and actions: by state classes, by counted time and by a plain program."""

from __future__ import annotations

import os

import numpy as np
import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import Latencies
from dineros.analysis.latencies.histories import histories_of
from dineros.analysis.timed.integers.counting import all_markings
from dineros.analysis.timed.integers.net import integer_net
from dineros.metamodel import sym
from dineros.metamodel.build import seconds
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.elements import find, transitions
from tests.analysis.bounds.test_services import drawn, with_goals
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.callers import Callers
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.models import model_of

SEEDS = 8 * int(os.environ.get("DINEROS_EXAMPLES", "1"))


def counted(latencies: Latencies) -> dict[str, tuple[int, bool]]:
    """Return what waits in each history, and whether it overflows, by time that is counted in units."""
    timed, found = latencies.subject.timed, {}
    untimed = timed.untimed
    markings, fires = all_markings(integer_net(timed), untimed.places, Budget(seconds=60))
    fired = {untimed.transitions[t] for t in fires}
    for name, history in histories_of(latencies.subject.links()).items():
        columns = [untimed.places.index(place) for place in history.places]
        found[name] = int(np.asarray(markings)[:, columns].sum(axis=1).max()), bool(fired & history.drops)
    return found


@pytest.mark.long
def test_random_systems_with_calls() -> None:
    compared = 0
    for seed in range(SEEDS):
        system = drawn(seed)
        try:
            facts = Callers(system).explore(8_000)
        except TooManyStatesError:
            continue
        model = model_of(system, 0.01)
        latencies = Latencies(model, Budget(seconds=30))
        readers = latencies.everything().readers
        if not latencies.reason:
            compared += 1
            own = {name: each for name, each in facts.longest.items() if not name.endswith(".then")}
            named = {
                name.removesuffix(".heard").removesuffix(".entry"): each for name, each in readers.items()
            }
            assert {name: named[name] for name in own} == {
                name: (most, name in facts.lost) for name, most in own.items()
            }, seed
            assert all(each == (1, False) for name, each in readers.items() if name.endswith(".response"))
            assert counted(latencies) == readers, seed
            bounded = Bounds(model).everything().readers
            assert bounded.keys() == readers.keys()
            for name, (most, overflows) in readers.items():
                assert bounded[name][0] >= most and not (overflows and bounded[name][1] is False), (
                    seed,
                    name,
                )
    assert compared > SEEDS / 4, compared


@pytest.mark.parametrize("slots", [1, 2])
def test_goals_and_results_of_clients_that_do_not_wait(slots: int) -> None:
    model = with_goals(3, slots)
    latencies = Latencies(model, Budget(seconds=60))
    readers = latencies.everything().readers
    assert {*readers} == {"entry", "goal0.results", "goal1.results"}
    assert counted(latencies) == readers
    assert readers["entry"] == (2, False), "both send one at the same time"
    bounded = Bounds(model).everything().readers
    assert bounded.keys() == readers.keys()
    assert all(bounded[name][0] >= most for name, (most, _) in readers.items())


def test_histories_are_not_called_exact_where_the_net_allows_more() -> None:
    """The stretches of a callback that waits take any time up to its duration."""
    model = model_of(COUNTED[15].system)
    assert Latencies(model, Budget(seconds=60)).everything().is_exact
    ask = find(model, "ask")
    assert isinstance(ask, sym.CallbackPage)
    for each in transitions(model):
        if callback_page_of(each) is ask:
            each.interval = None
    ask.duration = seconds(1, 2)
    assert not Latencies(model, Budget(seconds=60)).everything().is_exact


@pytest.mark.parametrize(
    ("work", "latency", "is_exact"),
    [((0, 0), (0, 1), False), ((0, 0), (1, 2), True), ((1, 2), (0, 0), True), ((0, 2), (0, 0), False)],
)
def test_a_callback_that_starts_itself_in_no_time_makes_nothing_exact(
    work: tuple[int, int], latency: tuple[int, int], is_exact: bool
) -> None:
    """Its runs may all be at one moment, after which no time passes."""
    system = {
        "nodes": {"n": {"threads": 1}},
        "latency": {"t": latency},
        "chains": [],
        "callbacks": [
            {"name": "tick", "node": "n", "group": "default", "script": [["work", 1, 1], ["publish", "t"]],
             "period": 9, "offset": 2},
            {"name": "echo", "node": "n", "group": "default", "script": [["work", *work], ["publish", "t"]],
             "topic": "t", "depth": 1},
        ],
    }  # fmt: skip
    latencies = Latencies(model_of(system), Budget(seconds=1, states=10))
    assert latencies.everything().is_exact is is_exact
