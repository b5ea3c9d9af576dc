"""Which transition fires: uniformly by a seed, by priorities, or as a developer's function says."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from dineros.metamodel import sym
from dineros.metamodel.elements import find
from dineros.runtime import Candidates, Choice, Enabled, Net, Retry
from tests.runtime.tiny import counts, events, stepped, tiny

FORK = {"one": "a -> b", "two": "a -> c", "three": "a -> d"}


def fired(seed: int) -> list[object]:
    net = Net(tiny(FORK, {"a": 300}), seed=seed)
    with stepped(net) as (node, recorder):
        node.run_until_idle()
        return [record["transition"] for record in events(recorder, "fire")]


def test_the_default_is_uniform_and_follows_the_seed() -> None:
    assert fired(1) == fired(1)
    assert fired(1) != fired(2)
    tally = Counter(transition for seed in range(3) for transition in fired(seed))
    assert all(240 < tally[transition] < 360 for transition in FORK)


def test_a_transition_of_higher_priority_goes_first() -> None:
    model = tiny({"high": "a -> b", "low": "c -> d"}, {"a": 3, "c": 3})
    find(model, "high", sym.Transition).overrides.append(find(model, "low", sym.Transition))
    net = Net(model)
    with stepped(net) as (node, recorder):
        assert net.inspect().enabled == ("high",)
        node.run_until_idle()
        assert [record["transition"] for record in events(recorder, "fire")] == ["high"] * 3 + ["low"] * 3


def test_a_function_prefers_by_the_tokens() -> None:
    net = Net(tiny({"safe": "a -> b", "unsafe": "a -> c"}, {"a": ['{"done": true}', "{}", '{"done": true}']}))

    @net.selection
    def choose(enabled: Candidates) -> Enabled | None:
        assert [each.transition for each in enabled] == ["safe", "unsafe"]
        return enabled.named("unsafe" if enabled[0].inputs["a"][0].data["done"] else "safe")

    with stepped(net) as (node, recorder):
        node.run_until_idle()
        fires = [record["transition"] for record in events(recorder, "fire")]
        assert fires == ["unsafe", "safe", "unsafe"]


def test_a_function_chooses_the_tokens() -> None:
    net = Net(tiny({"go": "2*a x -> b"}, {"a": [f'{{"count": {n}}}' for n in range(5)], "x": 2}))

    @net.selection
    def largest(enabled: Candidates) -> Choice:
        best = sorted(enabled[0].available["a"], key=lambda token: -int(str(token.data["count"])))[:2]
        return enabled[0].taking({"a": best})

    with stepped(net) as (node, _):
        node.run_until_idle()
        assert [token.data["count"] for token in net.inspect().marking["a"]] == [0]
        assert [token.data["count"] for token in net.inspect().marking["b"]] == [4, 2]


def test_a_function_that_picks_none_is_asked_again_after_a_change() -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 1}, signals="s"))
    asked = []

    @net.selection
    def choose(enabled: Candidates) -> Enabled | None:
        asked.append(net.signal("s").value)
        return enabled[0] if net.signal("s").value else None

    with stepped(net) as (node, _):
        node.run_until_idle()
        assert counts(net) == {"a": 1, "b": 0}
        assert not node.step()
        net.signal("s").set(True)
        node.run_until_idle()
        assert counts(net) == {"a": 0, "b": 1}
        assert asked[0] is False
        assert asked[-1] is True


def test_what_a_function_sees_are_copies() -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": ['{"notes": ["x"]}']}))

    @net.selection
    def vandal(enabled: Candidates) -> Enabled:
        enabled[0].inputs["a"][0].data["notes"].clear()  # type: ignore[union-attr]
        enabled[0].available["a"][0].data.clear()  # type: ignore[attr-defined]
        return enabled.random()

    with stepped(net) as (node, _):
        node.run_until_idle()
        assert net.inspect().marking["b"][0].data["notes"] == ["x"]


@pytest.mark.parametrize(
    ("choose", "says"),
    [
        (lambda enabled: 1 / 0, "ZeroDivisionError: division by zero"),
        (lambda enabled: "go", "the selection returned 'go'"),
        (lambda enabled: enabled[0].taking({"a": 99}), "takes 1 of the tokens [1, 2]"),
        (lambda enabled: enabled[0].taking({"a": [1, 2]}), "takes 1 of the tokens [1, 2]"),
        (lambda enabled: enabled[0].taking({"b": 1}), "takes nothing from 'b'"),
    ],
)
def test_a_faulty_function_changes_nothing(choose: Any, says: str) -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 2}))
    net.selection(choose)
    with stepped(net) as (node, _):
        node.run_until_idle()
        state = net.inspect()
        assert counts(net) == {"a": 2, "b": 0}
        assert says in state.errors[0].error
        assert state.halted is not None


def test_a_faulty_function_is_asked_again_where_the_policy_says_so() -> None:
    now = [0.0]
    net = Net(tiny({"go": "a -> b"}, {"a": 1}), policy=Retry(attempts=3, delay=1.0), clock=lambda: now[0])
    asked: list[float] = []

    @net.selection
    def fails_once(enabled: Candidates) -> Enabled:
        asked.append(now[0])
        if len(asked) == 1:
            raise ValueError
        return enabled[0]

    with stepped(net) as (node, _):
        node.run_until_idle()
        assert counts(net) == {"a": 1, "b": 0}
        now[0] = 1.5
        node.run_until_idle()
        assert counts(net) == {"a": 0, "b": 1}
        assert asked == [0.0, 1.5]
