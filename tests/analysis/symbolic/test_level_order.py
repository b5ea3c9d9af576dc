"""Orders of levels: what is tried first, and what a search does with it."""

from __future__ import annotations

import pytest

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.symbolic import level_order
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.level_order import OrderSearch
from dineros.analysis.symbolic.level_starts import first_start, force_order, starts
from dineros.analysis.symbolic.levels import encode
from dineros.analysis.symbolic.saturation import Diagram
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import reference_case_study
from tests.support.shuffled_nets import shuffled

NETS = {
    "philosophers": classic.philosophers(12),
    "kanban": classic.kanban(8),
    "manufacturing": classic.flexible_manufacturing(8),
    "pool": classic.swimming_pool(2),
    "case study": reference_case_study((2, 2, 2), "none"),
    "no flow": CompiledNet.build({"a": 1, "b": 2}, [("t", {"a": 1}, {}), ("u", {"b": 2}, {})]),
    "nothing changes": CompiledNet.build({"a": 1}, [("t", {"a": 1}, {"a": 1})]),
}


def diagram(net: CompiledNet) -> Diagram:
    encoding = encode(net)
    return Diagram(encoding, range(len(encoding.levels)), 1 << 28)


def effort(space: Diagram, order: list[int]) -> int:
    space.restart(order)
    assert space.run()
    return space.effort


@pytest.mark.parametrize("name", NETS)
def test_orders_to_begin_with_have_each_level_once(name: str) -> None:
    space = diagram(NETS[name])
    found = [first_start(space.encoding, space.events), *starts(space.encoding, space.events)]
    assert all(sorted(order) == list(range(space.top)) for order in found)
    assert len(set(map(tuple, found[1:]))) == len(found) - 1


def test_semiflows_keep_together_what_events_alone_tear_apart() -> None:
    space = diagram(NETS["manufacturing"])
    alone = force_order(space.events, range(space.top))
    assert effort(space, first_start(space.encoding, space.events)) * 4 < effort(space, alone)


@pytest.mark.parametrize("name", ["kanban", "manufacturing", "pool", "case study"])
def test_a_race_takes_an_order_that_is_good_on_the_net_itself(name: str) -> None:
    space = diagram(NETS[name])
    search = OrderSearch(space.encoding, space.events)
    search.race()
    assert effort(space, search.order) <= 3 * min(
        effort(space, o) for o in starts(space.encoding, space.events)
    )


def test_a_race_that_no_order_finishes_takes_the_order_that_came_furthest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(level_order, "LAST_RACE", level_order.FIRST_RACE)
    space = diagram(classic.philosophers(100))
    search = OrderSearch(space.encoding, space.events)
    search.race()
    assert search.is_blind
    reached = {}
    for order in starts(space.encoding, space.events):
        space.restart(order)
        assert not space.run(None, level_order.FIRST_RACE)
        reached[tuple(order)] = space.saturated
    assert reached[tuple(search.order)] == max(reached.values()) > min(reached.values())


@pytest.mark.parametrize("name", NETS)
def test_a_run_that_a_limit_ended_is_continued(name: str) -> None:
    whole, parts = diagram(NETS[name]), diagram(NETS[name])
    assert whole.run()
    limit = 0
    while not parts.run(None, limit):
        assert parts.effort >= limit and parts.saturated < parts.top
        limit += 1 + limit // 4
    for each in (whole, parts):
        each.collect([])
    assert parts.saturated == parts.top
    assert parts.nodes == whole.nodes


@pytest.mark.parametrize("name", ["kanban", "manufacturing", "pool", "case study"])
def test_a_search_finds_no_worse_order_and_the_same_one_each_time(name: str) -> None:
    space = diagram(NETS[name])
    searches = [OrderSearch(space.encoding, space.events, seed=3) for _ in range(2)]
    first = effort(space, searches[0].order)
    for search in searches:
        for work in (20_000, 80_000, 200_000):
            search.improve(work)
    assert searches[0].order == searches[1].order
    assert searches[0].work == searches[1].work
    # Trials are made on a smaller instance, whose best order is not always the best one here.
    assert effort(space, searches[0].order) <= 2 * first


def test_an_order_that_needs_much_on_a_smaller_instance_is_not_promising() -> None:
    space = diagram(reference_case_study((10, 10, 10), "none"))
    search = OrderSearch(space.encoding, space.events)
    search.improve(50_000)
    assert not search.is_promising(10_000)
    assert search.is_promising(1 << 40)


def test_where_no_instance_is_smaller_every_order_is_promising() -> None:
    space = diagram(classic.round_robin_mutex(6))
    assert OrderSearch(space.encoding, space.events).is_promising(0)


@pytest.mark.parametrize("name", NETS)
def test_shuffled_nets_with_other_names_cost_what_the_net_costs(name: str) -> None:
    net = NETS[name]
    space = symbolic_state_space(net)
    largest = dict(zip(net.places, space.largest_place(), strict=True))
    for seed in range(4):
        other = symbolic_state_space(shuffled(net, seed))
        assert (other.markings, other.arcs(), other.deadlocks()) == (
            space.markings,
            space.arcs(),
            space.deadlocks(),
        )
        assert sorted(other.largest_place()) == sorted(largest.values())
        assert other.peak_nodes <= 2 * space.peak_nodes
        assert other.diagram.effort <= 2 * space.diagram.effort


def test_two_hundred_shuffled_philosophers_need_nodes_in_proportion_to_them() -> None:
    few, many = (symbolic_state_space(shuffled(classic.philosophers(n), 1)) for n in (100, 200))
    assert many.markings == 3**200
    assert many.peak_nodes <= 3 * few.peak_nodes
