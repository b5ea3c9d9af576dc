"""Siphons and traps against all subsets of the places."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations

from hypothesis import given, settings

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.siphons import largest_trap, smaller_trap, unmarked_siphon
from tests.analysis.reductions.generated_nets import nets


def _closed_sets(net: CompiledNet, traps: bool) -> list[set[int]]:
    """All non-empty siphons or traps, straight from the definition."""
    arcs, answers = (net.pre, net.post) if traps else (net.post, net.pre)
    found = []
    for size in range(1, len(net.places) + 1):
        for subset in map(set, combinations(range(len(net.places)), size)):
            touching = [t for t in range(len(net.transitions)) if subset & {p for p, _ in arcs.row(t)}]
            if all(subset & {p for p, _ in answers.row(t)} for t in touching):
                found.append(subset)
    return found


@settings(max_examples=150, deadline=None)
@given(nets())
def test_the_largest_trap_is_the_union_of_traps(net: CompiledNet) -> None:
    traps = _closed_sets(net, traps=True)
    for places in ({p for p in range(len(net.places)) if p % 2}, set(range(len(net.places)))):
        assert set(largest_trap(net, places)) == set().union(*(trap for trap in traps if trap <= places))


@settings(max_examples=150, deadline=None)
@given(nets())
def test_no_place_of_a_smaller_trap_can_be_left_out(net: CompiledNet) -> None:
    def marked(places: Iterable[int]) -> tuple[int, ...]:
        trap = largest_trap(net, places)
        return trap if any(net.initial[place] for place in trap) else ()

    trap = marked(range(len(net.places)))
    found = smaller_trap(net, trap) if trap else ()
    for place in trap:
        if place in trap:
            trap = marked([p for p in trap if p != place]) or trap
    assert found == trap


@settings(max_examples=150, deadline=None)
@given(nets())
def test_the_unmarked_siphon_is_the_union_of_siphons_without_tokens(net: CompiledNet) -> None:
    unmarked = {place for place, tokens in enumerate(net.initial) if not tokens}
    siphons = (siphon for siphon in _closed_sets(net, traps=False) if siphon <= unmarked)
    assert set(unmarked_siphon(net)) == set().union(*siphons)
