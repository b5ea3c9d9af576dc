"""A net of independent parts has the figures of the whole, though each part is counted alone."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.parts.independent import independent, shape
from dineros.analysis.questions.state_space import state_space
from tests.analysis.reference_search import REFERENCE_LIMIT, reference_search
from tests.analysis.strategies import SLOW, nets


def _side_by_side(parts: Sequence[CompiledNet]) -> CompiledNet:
    """Return one net with the elements of all parts."""
    places: dict[str, int] = {}
    rows: list[Transition] = []
    for number, part in enumerate(parts):
        marked, transitions = part.by_names()
        places |= {f"{place}.{number}": tokens for place, tokens in marked.items()}
        for name, *arcs in transitions:
            renamed = ({f"{place}.{number}": w for place, w in row.items()} for row in arcs)
            rows.append(Transition(f"{name}.{number}", *renamed))
    return CompiledNet.build(places, rows)


@SLOW
@given(st.lists(nets(), min_size=1, max_size=3), st.integers(0, 2))
def test_figures_are_those_of_the_whole(parts: list[CompiledNet], copies: int) -> None:
    net = _side_by_side([*parts, *parts[:1] * copies])
    expected = reference_search(net, REFERENCE_LIMIT)
    if expected is None:
        return
    space = state_space(net, "symbolic")
    if not space.complete:  # no invariant bounds a place, and it grows without a proof
        assert space.states is None
        return
    assert (space.states, space.arcs, space.deadlocks) == expected[:3]
    assert space.max_tokens_in_place == max(expected.largest_place)
    assert space.max_tokens_in_marking == expected.largest_total


@SLOW
@given(st.lists(nets(), min_size=2, max_size=3))
def test_parts_have_all_changing_places_and_all_transitions_that_can_fire(parts: list[CompiledNet]) -> None:
    net = _side_by_side(parts)
    found = independent(net)
    if found.parts == (net,):
        return
    assert 2 <= len(found.parts) <= sum(map(bool, net.changing))
    places = [place for part in found.parts for place in part.places]
    assert sorted(places) == sorted(name for name, by in zip(net.places, net.changing, strict=True) if by)
    assert len(found.constant) == len(net.places) - len(places)
    firing = {name for part in found.parts for name in part.transitions}
    assert all(
        name in firing
        for t, name in enumerate(net.transitions)
        if net.delta[t] and net.is_enabled(t, net.initial)
    )


def _ring(size: int, tokens: int = 1, name: str = "r") -> CompiledNet:
    places = {f"{name}{n}": tokens * (n == 0) for n in range(size)}
    moves = [(f"{name}go{n}", {f"{name}{n}": 1}, {f"{name}{(n + 1) % size}": 1}) for n in range(size)]
    return CompiledNet.build(places, moves)


def test_many_parts_of_one_shape_are_counted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from dineros.analysis.symbolic import engine

    counted: list[int] = []
    symbolic_state_space = engine.symbolic_state_space

    def count(net: CompiledNet, *args: object, **options: object) -> engine.SymbolicStateSpace:
        counted.append(len(net.places))
        return symbolic_state_space(net, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(engine, "symbolic_state_space", count)
    space = state_space(_side_by_side([_ring(4)] * 50 + [_ring(3, 2)]), "symbolic")
    assert counted == [4, 3]
    assert (space.states, space.arcs, space.deadlocks) == (4**50 * 6, 50 * 4**50 * 6 + 4**50 * 9, 0)
    assert (space.max_tokens_in_place, space.max_tokens_in_marking, len(space.levels)) == (2, 52, 51 + 1)


def test_names_and_order_do_not_matter_for_the_shape_but_tokens_do() -> None:
    assert shape(_ring(3)) == shape(_ring(3, name="s"))
    assert shape(_ring(3)) != shape(_ring(3, tokens=2))
    assert shape(_ring(3)) != shape(_ring(4))


def test_a_connected_net_is_one_part() -> None:
    ring = _ring(3)
    assert independent(ring).parts == (ring,)
    assert independent(_side_by_side([ring, CompiledNet.build({"constant": 1}, [])])).constant == ()


def test_constant_places_connect_no_parts() -> None:
    net = CompiledNet.build(
        {"on": 3, "off": 0, "a": 1, "b": 1, "c": 1},
        [
            Transition("t", {"a": 1}, {}, {"off": 1}, {"on": 2}),
            Transition("u", {"b": 1}, {}, {}, {"on": 3}),
            Transition("never", {"b": 1}, {}, {}, {"on": 4}),
            Transition("nor", {"c": 1}, {}, {"on": 3}),
            Transition("always", {}, {}, {"off": 1}, {"on": 1}),
        ],
    )
    found = independent(net)
    assert [part.places for part in found.parts] == [("a",), ("b",), ("c",)]
    assert [part.transitions for part in found.parts] == [("t",), ("u",), ()]
    assert (found.constant, found.always_enabled) == ((3, 0), 1)
    space = state_space(net, "symbolic")
    assert (space.states, space.arcs, space.deadlocks) == (4, 8, 0)
    assert (space.max_tokens_in_place, space.max_tokens_in_marking) == (3, 6)
