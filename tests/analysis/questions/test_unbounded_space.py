"""What is left of an unbounded net without its counters and logs, against a plain search that caps them."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.questions.state_space import state_space
from tests.analysis.strategies import nets

MOST = 2_000


def capped_search(net: CompiledNet, caps: dict[int, int]) -> tuple[int, int, int] | None:
    """Markings, arcs and deadlocks where some places forget what is more than they may hold."""

    def capped(marking: list[int]) -> tuple[int, ...]:
        return tuple(min(tokens, caps.get(place, tokens)) for place, tokens in enumerate(marking))

    seen = {start := capped(net.initial.tolist())}
    todo, arcs, deadlocks = [start], 0, 0
    for marking in todo:
        enabled = [t for t in range(len(net.transitions)) if net.is_enabled(t, marking)]
        arcs, deadlocks = arcs + len(enabled), deadlocks + (not enabled)
        for after in {capped(net.fire(t, marking)) for t in enabled} - seen:
            seen.add(after)
            todo.append(after)
        if len(seen) > MOST:
            return None
    return len(seen), arcs, deadlocks


@settings(max_examples=20, deadline=None)
@given(st.data(), nets(), st.integers(0, 3))
def test_the_rest_is_counted_without_what_nothing_takes_from(
    data: st.DataObject, net: CompiledNet, needed: int
) -> None:
    logs = data.draw(st.sets(st.sampled_from(range(len(net.transitions))), min_size=1))
    reader = data.draw(st.sampled_from(range(len(net.transitions))))
    rows = []
    for t, name in enumerate(net.transitions):
        takes, puts, stops = (
            {net.places[p]: w for p, w in table.row(t)} for table in (net.pre, net.post, net.inhibitor)
        )
        puts |= {"log": 1} if t in logs else {}
        if t == reader and needed:  # it needs so many, and leaves them there
            takes["log"], puts["log"] = needed, needed + puts.get("log", 0)
        rows.append((name, takes, puts, stops))
    initial = dict(zip(net.places, net.initial.tolist(), strict=True))
    logged = CompiledNet.build({**initial, "log": 0}, rows)
    space = state_space(logged, budget=Budget(256 << 20))
    if space.rest is None or not space.rest.complete:
        return
    assert space.pumping is not None
    weights = {place: needed if logged.places[place] == "log" else 0 for place in range(len(logged.places))}
    for table in (logged.pre, logged.inhibitor):
        for t in range(len(logged.transitions)):
            weights |= {p: max(weights[p], w) for p, w in table.row(t)}
    caps = {logged.places.index(name): weights[logged.places.index(name)] for name in space.without}
    expected = capped_search(logged, caps)
    if expected is not None:
        assert (space.rest.states, space.rest.arcs, space.rest.deadlocks) == expected


def test_a_net_in_which_more_grows_says_so() -> None:
    rows = [("make", {"idle": 1}, {"idle": 1, "queue": 1, "log": 1}), ("take", {"queue": 1}, {})]
    space = state_space(CompiledNet.build({"idle": 1, "queue": 0, "log": 0}, rows))
    assert space.without == ("log",)
    assert space.rest is not None
    assert (space.rest.complete, space.rest.states) == (False, None)
    assert space.rest.reason == "unbounded: queue can grow forever"
