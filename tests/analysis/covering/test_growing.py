"""Places that stop where nobody can tell, against plain search."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.covering.growing import growing_places, largest_weights, limited, without_growth
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import replay
from tests.analysis.covering.plain import Seen, plain_search
from tests.analysis.strategies import nets

MOST = 2_000


@st.composite
def nets_that_count(draw: st.DrawFn) -> CompiledNet:
    """A net with one or two more places that nothing takes from, some of them read or inhibiting."""
    net = draw(nets())
    names = [*net.places, "seen", "logged"][: len(net.places) + draw(st.integers(1, 2))]
    counters = st.dictionaries(st.sampled_from(names[len(net.places) :]), st.integers(1, 2), max_size=1)
    rows = []
    for t, name in enumerate(net.transitions):
        reads, inhibitors = draw(counters), draw(counters)
        inputs = {names[p]: w for p, w in net.pre.row(t)} | reads
        outputs = {names[p]: w for p, w in net.post.row(t)} | reads
        for place, gain in draw(counters).items():
            outputs[place] = outputs.get(place, 0) + gain
        rows.append(
            Transition(name, inputs, outputs, {names[p]: w for p, w in net.inhibitor.row(t)} | inhibitors)
        )
    tokens = dict(zip(net.places, net.initial.tolist(), strict=True))
    return CompiledNet.build({name: tokens.get(name, draw(st.integers(0, 3))) for name in names}, rows)


def _cut(net: CompiledNet, seen: Seen, limits: dict[int, int]) -> set[tuple[int, ...]]:
    return {
        tuple(min(n, limits.get(p, n)) for p, n in enumerate(marking) if limits.get(p) != 0)
        for marking in seen.markings
    }


@settings(max_examples=40, deadline=None)
@given(nets_that_count(), st.integers(0, 4))
def test_nobody_can_tell_that_a_place_stops(net: CompiledNet, compared: int) -> None:
    growing = growing_places(net)
    small = without_growth(net, {growing[0]: compared} if growing else None)
    if small is None:
        assert not growing
        return
    before, after = plain_search(net, MOST), plain_search(small.net, MOST)
    if not after.is_complete or not before.is_complete:
        return
    weights = largest_weights(net)
    limits = {p: max(weights[p], compared if p == growing[0] else 0) for p in growing}
    kept = [small.place[p] for p in range(len(net.places)) if p in small.place]
    assert {tuple(marking[p] for p in kept) for marking in after.markings} == _cut(net, before, limits)
    assert {small.origin[t] for t in after.enabled} == before.enabled
    assert after.has_deadlock == before.has_deadlock


@settings(max_examples=40, deadline=None)
@given(nets_that_count())
def test_what_loses_tokens_shows_runs_of_the_net(net: CompiledNet) -> None:
    weights = largest_weights(net)
    lossy = limited(net, {p: max(weights[p], 1) for p in range(len(net.places)) if p % 2})
    # With an inhibitor arc at such a place, tokens that are lost would allow more.
    if not set(net.inhibitor.place.tolist()).isdisjoint(range(1, len(net.places), 2)):
        return
    marking, trace = lossy.net.initial.tolist(), []
    for _ in range(12):
        enabled = [t for t in range(len(lossy.net.transitions)) if lossy.net.is_enabled(t, marking)]
        assert len({lossy.origin[t] for t in enabled}) == len(enabled)
        if not enabled:
            break
        trace.append(enabled[sum(marking) % len(enabled)])
        marking = lossy.net.fire(trace[-1], marking)
    reached = replay(net, lossy.back(trace))[-1]
    assert all(reached[p] >= marking[q] for p, q in lossy.place.items())


def test_a_counter_leaves_the_net() -> None:
    net = CompiledNet.build({"on": 1, "count": 0}, [("tick", {"on": 1}, {"on": 1, "count": 1})])
    small = without_growth(net)
    assert small is not None and small.net.places == ("on",)
    assert plain_search(small.net).is_complete
    asked = without_growth(net, {1: 5})
    assert asked is not None and len(plain_search(asked.net).markings) == 6


def test_a_net_where_all_is_taken_again_stays_as_it_is() -> None:
    assert without_growth(CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1})])) is not None
    assert without_growth(CompiledNet.build({"a": 1}, [("t", {"a": 1}, {"a": 1})])) is None
