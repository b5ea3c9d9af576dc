"""State spaces as solutions of the invariants: they are those of a plain search, or are not proved."""

from __future__ import annotations

import random
from itertools import product

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.symbolic import engine
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import UnknownBoundError, encode
from dineros.analysis.symbolic.solutions.distances import firing_distances, rising
from dineros.analysis.symbolic.solutions.solved import Effort, solved
from tests.analysis import classic_nets as classic
from tests.analysis.reference_search import reference_search

MEMORY = 1 << 26
EFFORT = Effort(1 << 20, 100_000)
Rows = list[tuple[str, dict[str, int], dict[str, int], dict[str, int]]]


def count(net: CompiledNet, effort: Effort = EFFORT) -> int | None:
    """Return the number of solutions, or None if they are not proved to be the reachable markings."""
    diagram, _ = solved(net, encode(net), Budget(MEMORY).begun(), effort)
    return None if diagram is None else DiagramCounts(diagram).vectors()


def squares(order: int) -> CompiledNet:
    """Partial Latin squares, filled cell by cell."""
    numbers = range(order)
    places = {f"{kind} {i} {j}": 1 for kind in ("cell", "row", "column") for i in numbers for j in numbers}
    transitions = []
    for r, c, v in product(numbers, repeat=3):
        places[f"put {r} {c} {v}"] = 0
        taken = {f"cell {r} {c}": 1, f"row {r} {v}": 1, f"column {c} {v}": 1}
        transitions.append((f"put {r} {c} {v}", taken, {f"put {r} {c} {v}": 1}))
    return CompiledNet.build(places, transitions)


def moves(seed: int) -> CompiledNet:
    """A random net of a few parts that keep their tokens; transitions move tokens, read and inhibit."""
    dice = random.Random(seed)
    parts = [[f"p{n}.{i}" for i in range(dice.randint(2, 4))] for n in range(dice.randint(1, 3))]
    places = {place: 0 for part in parts for place in part}
    for part in parts:
        for _ in range(dice.choice((1, 1, 1, 2, 3))):
            places[part[0] if dice.random() < 0.8 else dice.choice(part)] += 1
    transitions: Rows = []
    for number in range(dice.randint(2, 9)):
        taken: dict[str, int] = {}
        put: dict[str, int] = {}
        for part in dice.sample(parts, dice.randint(1, min(2, len(parts)))):
            source, target = dice.choice(part), dice.choice(part)
            taken[source] = taken.get(source, 0) + 1
            put[target] = put.get(target, 0) + 1
        inhibited = {dice.choice(list(places)): dice.randint(1, 2)} if dice.random() < 0.2 else {}
        transitions.append((f"t{number}", taken, put, inhibited))
    if dice.random() < 0.3:  # a part that loses tokens: its bounds come from no invariant
        transitions.append(("lose", {dice.choice(list(places)): 1}, {}, {}))
    if dice.random() < 0.3:
        places["weighted"] = 0
        transitions.append(("three", {parts[0][0]: 1}, {"weighted": 2}, {}))
        transitions.append(("back", {"weighted": 2}, {parts[0][0]: 1}, {}))
    return CompiledNet.build(places, [Transition(*row) for row in transitions])


def test_partial_latin_squares_are_the_solutions() -> None:
    assert [count(squares(order)) for order in (1, 2, 3)] == [2, 35, 11_776]
    net = squares(3)
    space = symbolic_state_space(net, Budget(MEMORY))
    expected = reference_search(net, 20_000)
    assert expected is not None
    assert (space.markings, space.arcs(), space.deadlocks()) == (
        expected.markings, expected.arcs, expected.deadlocks,
    )  # fmt: skip


def test_the_engine_counts_large_squares_by_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "ROUNDS", engine.ROUNDS[:3])
    space = symbolic_state_space(squares(4), Budget(1 << 28))
    assert space.complete and space.markings == 127_545_137
    assert space.deadlocks() == 409_584
    assert space.largest_total() == 48 and set(space.largest_place()) == {1}


def test_processes_that_return_are_the_solutions() -> None:
    net = classic.philosophers(5)
    expected = reference_search(net, 5_000)
    assert expected is not None and count(net) == expected.markings


def test_generated_nets_have_the_counts_of_a_search() -> None:
    proved = 0
    for seed in range(600):
        net = moves(seed)
        try:
            found = count(net)
        except UnknownBoundError:
            continue
        if found is not None:
            expected = reference_search(net, 50_000)
            assert expected is not None and found == expected.markings, seed
            proved += 1
    assert proved > 60


@pytest.mark.parametrize(
    ("places", "transitions"),
    [
        # A solution that no firing reaches: both tokens move together only.
        ({"a": 1, "b": 0, "c": 1, "d": 0}, [("t", {"a": 1, "c": 1}, {"b": 1, "d": 1}, {})]),
        # The inhibitor arc keeps the second token where it is.
        ({"a": 2, "b": 0}, [("t", {"a": 1}, {"b": 1}, {"b": 1})]),
        # A circle that is reached from nowhere: each of its markings has a predecessor.
        (
            {"a": 1, "b": 0, "c": 0},
            [("t", {"b": 1}, {"c": 1}, {}), ("u", {"c": 1}, {"b": 1}, {}), ("v", {"b": 1}, {"a": 1}, {})],
        ),
    ],
)
def test_solutions_that_cannot_be_reached(places: dict[str, int], transitions: Rows) -> None:
    net = CompiledNet.build(places, [Transition(*row) for row in transitions])
    expected = reference_search(net, 100)
    found = count(net)
    assert expected is not None and found in (None, expected.markings)


def test_inhibitor_arcs_that_forbid_nothing_reachable() -> None:
    net = CompiledNet.build({"a": 2, "b": 0}, [Transition("t", {"a": 1}, {"b": 1}, {"b": 2})])
    assert count(net) == 3


def test_little_effort_proves_nothing() -> None:
    assert count(squares(3), Effort(1 << 12, 100_000)) is None
    assert count(squares(3), Effort(1 << 20, 10)) is None


def test_distances_grow_with_the_first_firings() -> None:
    net = CompiledNet.build(
        {"a": 1, "b": 0, "c": 0, "never": 0},
        [
            ("t", {"a": 1}, {"b": 1}),
            ("u", {"b": 2}, {"c": 1}),
            ("back", {"c": 1}, {"a": 1}),
            ("v", {"never": 1}, {"a": 1}),
        ],
    )
    distances = firing_distances(net)
    assert distances == [0, 1, 3, 0]
    assert rising(net, distances) == [0, 1]
