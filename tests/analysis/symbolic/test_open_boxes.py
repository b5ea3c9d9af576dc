"""Boxes taken out of a set in one walk: against one difference after another, and where room runs out."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit import explore
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.symbolic import vector_sets
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.kernels.diagrams import POOL_LIMIT, POOL_TOP
from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.symbolic.vector_sets import Scope
from tests.analysis import classic_nets as classic

Boxes = list[dict[int, list[bool]]]

NETS = [classic.philosophers(4), classic.kanban(2), classic.swimming_pool(1)]


def one_by_one(space: SymbolicStateSpace, boxes: Boxes) -> int:
    left = space.diagram.root
    with Scope(space.diagram) as scope:
        for box in boxes:
            scope.hold(left)
            if left:
                left = space.sets.difference(left, space.sets.box(box))
    return left


@st.composite
def boxes_of(draw: st.DrawFn, space: SymbolicStateSpace) -> Boxes:
    levels = range(len(space.encoding.levels))
    boxes = []
    for _ in range(draw(st.integers(0, 6))):
        touched = draw(st.lists(st.sampled_from(levels), min_size=1, max_size=4, unique=True))
        sizes = {level: len(space.encoding.levels[level].states) for level in touched}
        boxes.append(
            {level: draw(st.lists(st.booleans(), min_size=n, max_size=n)) for level, n in sizes.items()}
        )
    return boxes


@pytest.mark.long
@pytest.mark.parametrize("most", [1, 5, vector_sets.MOST_SETS])
@pytest.mark.parametrize("number", range(len(NETS)))
def test_all_at_once_leaves_what_one_by_one_leaves(
    number: int, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vector_sets, "MOST_SETS", most)
    space = symbolic_state_space(NETS[number])

    @given(boxes_of(space))
    @settings(max_examples=60, deadline=None)
    def check(boxes: Boxes) -> None:
        # A set has one node, so that equal sets are equal numbers.
        assert space.sets.without_boxes(space.diagram.root, boxes) == one_by_one(space, boxes)

    check()


def test_no_box_and_a_box_that_holds_everything() -> None:
    space = symbolic_state_space(NETS[0])
    root = space.diagram.root
    assert space.sets.without_boxes(root, []) == root
    assert space.sets.without_boxes(root, [{}]) == 0
    assert space.sets.without_boxes(0, [{}]) == 0


def clients_of_one_server(count: int) -> CompiledNet:
    """Clients that ask a server, which works for one at a time and may break while it works for the first."""
    places, transitions = {"idle": 1}, []
    for n in range(count):
        places |= {f"rests{n}": 1, f"asks{n}": 0, f"works{n}": 0}
        transitions += [
            (f"ask{n}", {f"rests{n}": 1}, {f"asks{n}": 1}),
            (f"take{n}", {f"asks{n}": 1, "idle": 1}, {f"works{n}": 1}),
            (f"answer{n}", {f"works{n}": 1}, {f"rests{n}": 1, "idle": 1}),
        ]
    return CompiledNet.build(places, [*transitions, ("break", {"works0": 1}, {"asks0": 1})])


def test_deadlocks_of_many_clients_of_one_server_are_counted() -> None:
    for count in (1, 2, 5):
        net = clients_of_one_server(count)
        assert symbolic_state_space(net).deadlocks() == explore(net).deadlocks == 1
    space = symbolic_state_space(clients_of_one_server(40))
    assert space.deadlocks() == 1
    assert space.diagram.sets_of_boxes < 100_000


@pytest.mark.long
@pytest.mark.parametrize("is_tidy", [False, True])
def test_it_goes_on_after_garbage_collection_or_says_that_memory_ran_out(is_tidy: bool) -> None:
    net = classic.philosophers(8)
    good = symbolic_state_space(net).order
    order = (*good[::2], *good[1::2])  # one that leaves much to collect
    ended = {"at once": 0, "after collecting": 0, "out of memory": 0}
    for room in range(0, 1_200, 15):
        space = symbolic_state_space(net, Budget(1 << 22), order=order)
        sets, diagram = space.sets, space.diagram  # making `sets` takes room itself
        with Scope(diagram) as scope:
            scope.hold(diagram.root)
            if is_tidy:  # then there is nothing to collect
                diagram.collect([diagram.root])
                diagram.free[:] = 0
            before = diagram.collections
            diagram.control[POOL_LIMIT] = diagram.control[POOL_TOP] + room
            try:
                dead = sets.without_boxes(diagram.root, space.event_masks())
            except DiagramMemoryError:
                ended["out of memory"] += 1
                continue
            ended["after collecting" if diagram.collections > before else "at once"] += 1
            assert DiagramCounts(diagram, dead).vectors() == 2
    expected = {"at once", "out of memory"} if is_tidy else {"at once", "after collecting"}
    assert {how for how, times in ended.items() if times} == expected, ended


def test_a_thousand_philosophers() -> None:
    space = symbolic_state_space(classic.philosophers(1_000))
    assert space.markings == 3**1_000
    assert space.deadlocks() == 2  # all hold their left forks, or all their right ones
