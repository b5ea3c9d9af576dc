"""Shortened witnesses still lead to their goal, and nothing more can be left out."""

from __future__ import annotations

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.analysis.explicit import Goal
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.nets.witness import replay
from tests.analysis import classic_nets as classic
from tests.analysis.strategies import nets


@given(nets(), st.data())
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_no_single_firing_can_be_left_out(net: CompiledNet, data: st.DataObject) -> None:
    marking, trace = net.initial.tolist(), []
    for _ in range(data.draw(st.integers(0, 20))):
        enabled = [t for t in range(len(net.transitions)) if net.is_enabled(t, marking)]
        if not enabled:
            break
        trace.append(data.draw(st.sampled_from(enabled)))
        marking = net.fire(trace[-1], marking)
    goal = Goal((data.draw(st.integers(0, len(net.transitions) - 1)),))
    if not goal.holds(net, marking):
        return
    short = shortened(net, trace, lambda marking: goal.holds(net, marking))
    ways = replay(net, short)
    assert len(short) <= len(trace)
    assert [goal.holds(net, step) for step in ways] == [False] * len(short) + [True]
    for left_out in range(len(short)):
        now = net.initial.tolist()
        for t in (*short[:left_out], *short[left_out + 1 :]):
            if net.is_enabled(t, now):
                now = net.fire(t, now)
        assert not goal.holds(net, now) or any(goal.holds(net, step) for step in ways[:-1])


def test_what_has_nothing_to_do_with_the_goal_goes() -> None:
    net = classic.philosophers(6)
    index = {name: t for t, name in enumerate(net.transitions)}
    others = [index[name] for i in (2, 4) for name in (f"take_left{i}", f"left_eat{i}", f"end{i}")] * 20
    trace = [*others, index["take_right0"], *others, index["right_eat0"], index["take_left2"]]
    eating = Goal.enabled(net, "end0")
    short = shortened(net, trace, lambda marking: eating.holds(net, marking))
    assert [net.transitions[t] for t in short] == ["take_right0", "right_eat0"]


def test_the_best_so_far_is_returned_when_there_is_no_time() -> None:
    net = CompiledNet.build(
        {"a": 1, "b": 0}, [("up", {"a": 1}, {"a": 1, "b": 1}), ("stay", {"b": 1}, {"b": 1})]
    )
    trace = [0, 1] * 10
    short = shortened(net, trace, lambda marking: marking[1] == 5, most=1)
    assert replay(net, short)[-1] == [1, 5]
    assert shortened(net, trace, lambda marking: marking[1] == 5) == (0,) * 5
