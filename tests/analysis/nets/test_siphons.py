"""Siphons and traps against all subsets of the places; Commoner's condition against reachability graphs."""

from __future__ import annotations

from itertools import combinations

from hypothesis import given, settings

from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.siphons import (
    commoner,
    largest_trap,
    minimal_siphons,
    minimal_traps,
    unmarked_siphon,
)
from tests.analysis.reductions.brute_force import Graph
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
def test_minimal_siphons_and_traps_are_those_of_the_definition(net: CompiledNet) -> None:
    for traps, search in ((False, minimal_siphons), (True, minimal_traps)):
        closed = _closed_sets(net, traps)
        minimal = {tuple(sorted(s)) for s in closed if not any(other < s for other in closed)}
        family = search(net)
        assert family.is_complete and set(family.members) == minimal


@settings(max_examples=150, deadline=None)
@given(nets())
def test_the_largest_trap_is_the_union_of_traps(net: CompiledNet) -> None:
    traps = _closed_sets(net, traps=True)
    for places in ({p for p in range(len(net.places)) if p % 2}, set(range(len(net.places)))):
        assert set(largest_trap(net, places)) == set().union(*(trap for trap in traps if trap <= places))


@settings(max_examples=200, deadline=None)
@given(nets())
def test_conclusions_hold_in_the_reachability_graph(net: CompiledNet) -> None:
    conclusion = commoner(net).conclusion
    graph = Graph.of(net)
    if conclusion == "deadlock-free":
        assert not graph.deadlocks()
    if conclusion == "live" and graph.is_complete:
        assert graph.is_live()
    if conclusion == "not live" and graph.is_complete:
        assert not graph.is_live()


def _machines(tokens: int, machines: int) -> CompiledNet:
    return CompiledNet.build(
        {"idle": tokens, "busy": 0, "machine": machines},
        [
            Transition("start", {"idle": 1, "machine": 1}, {"busy": 1}),
            Transition("end", {"busy": 1}, {"idle": 1, "machine": 1}),
        ],
    )


def test_a_marked_graph_is_live_iff_its_circuits_are_marked() -> None:
    assert commoner(_machines(1, 1)).conclusion == "live"
    broken = commoner(_machines(1, 0))
    assert (broken.holds, broken.siphon, broken.conclusion) == (False, (1, 2), "not live")


def test_limits_leave_the_answer_open() -> None:
    assert not minimal_siphons(_machines(1, 1), limit=1).is_complete
    assert commoner(_machines(1, 1), limit=1).holds is None


def test_weights_and_inhibitors_allow_no_conclusion() -> None:
    weighted = CompiledNet.build({"p": 1}, [Transition("t", {"p": 2}, {"p": 2})])
    assert commoner(weighted).holds and commoner(weighted).conclusion is None
    inhibited = CompiledNet.build({"p": 1}, [Transition("t", {"p": 1}, {"p": 1}, {"p": 1})])
    assert commoner(inhibited).holds and commoner(inhibited).conclusion is None


def test_a_net_without_transitions_is_not_called_free_of_deadlocks() -> None:
    assert commoner(CompiledNet.build({"p": 1}, [])).conclusion is None


@settings(max_examples=150, deadline=None)
@given(nets())
def test_the_unmarked_siphon_is_the_union_of_siphons_without_tokens(net: CompiledNet) -> None:
    unmarked = {place for place, tokens in enumerate(net.initial) if not tokens}
    siphons = (siphon for siphon in _closed_sets(net, traps=False) if siphon <= unmarked)
    assert set(unmarked_siphon(net)) == set().union(*siphons)
