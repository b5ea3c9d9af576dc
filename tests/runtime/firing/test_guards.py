"""Guards and assignments where handlers run: what they may return, and which tokens they get."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest

from dineros.metamodel import rtm, sym
from dineros.metamodel.elements import find
from dineros.runtime import Aside, Firing, Net
from tests.runtime.tiny import counts, events, settle, stepped, tiny


def guarded(
    arcs: dict[str, str],
    marking: dict[str, list[str]],
    guards: dict[str, str] | None = None,
    assigns: dict[str, str] | None = None,
) -> rtm.RuntimeModel:
    model = tiny(arcs, marking)
    assert model.tokenType is not None
    (count,) = (each for each in model.tokenType.fields if each.name == "count")
    count.minimum, count.maximum = 0, 9
    for id, text in (guards or {}).items():
        find(model, id, sym.Transition).guard = text
    for id, text in (assigns or {}).items():
        find(model, id, sym.Transition).assigns = text
    return model


def tokens(net: Net, place: str) -> list[dict[str, Any]]:
    return [dict(token.data) for token in net.inspect().marking[place]]


THREE = ['{"count": 1}', '{"count": 5, "color": "red"}', '{"count": 5, "color": "blue"}']


def test_the_oldest_token_that_fulfils_the_guard_is_taken() -> None:
    net = Net(guarded({"go": "a -> b"}, {"a": THREE}, {"go": "count >= 3"}))
    with stepped(net) as (node, _):
        assert net.inspect().enabled == ("go",)
        node.step()
        assert [each["color"] for each in tokens(net, "b")] == ["red"]
        node.run_until_idle()
        assert [each["color"] for each in tokens(net, "b")] == ["red", "blue"]
        assert [each["count"] for each in tokens(net, "a")] == [1]
        assert net.inspect().enabled == ()


def test_a_guard_about_a_token_that_is_read() -> None:
    model = guarded(
        {"go": "a ?mode -> b"}, {"a": ["{}"], "mode": ['{"done": false}']}, {"go": "mode.done = true"}
    )
    net = Net(model)
    with stepped(net) as (node, _):
        node.run_until_idle()
        assert counts(net)["b"] == 0
    find(model, "mode", sym.Place).balloons[0].data = '{"done": true}'
    net, seen = Net(model), []
    net.handler("go")(lambda firing: seen.append(firing.inputs["mode"][0].data["done"]))
    with stepped(net) as (node, _):
        node.run_until_idle()
        assert counts(net)["b"] == 1
    assert seen == [True]


def _returning(result: Any) -> Callable[[Firing], Any]:
    return lambda firing: result(firing) if callable(result) else result


def _changing(firing: Firing) -> None:
    firing.data["count"] = 4


@pytest.mark.parametrize(
    ("result", "said"),
    [
        ({"count": 4}, "gives b.count the value 4, but the transition assigns 3"),
        ({"count": 1}, "gives b.count the value 1, but the transition assigns 3"),
        (_changing, "gives b.count the value 4, but the transition assigns 3"),
        (lambda firing: firing.give({"b": {"count": 0}}), "gives b.count the value 0"),
        ({"count": 10}, "count takes 0 to 9, not 10"),
    ],
)
def test_a_handler_that_contradicts_the_model_fails_with_its_name(
    result: Any, said: str, caplog: pytest.LogCaptureFixture
) -> None:
    model = guarded({"go": "a -> b"}, {"a": ['{"count": 1}']}, assigns={"go": "b.count := 3"})
    net = Net(model, policy=Aside())
    net.handler("go", name="answer")(_returning(result))
    with stepped(net) as (node, recorder):
        node.run_until_idle()
        assert counts(net) == {"a": 1, "b": 0}
        (error,) = events(recorder, "error")
        assert said in str(error["error"])
        assert (error["transition"], error["handler"]) == ("go", "answer")
    assert "go: the handler answer failed" in caplog.text


@pytest.mark.parametrize(
    "result",
    [
        None,
        {},
        {"count": 3},
        {"color": "red"},
        lambda firing: firing.give({"b": {"color": "red"}}),
        lambda firing: firing.give({"b": firing.data}),
        lambda firing: dict(firing.data),
    ],
)
def test_assigned_fields_are_shown_to_handlers_and_stay(result: Any) -> None:
    model = guarded({"go": "a -> b"}, {"a": ['{"count": 1}']}, assigns={"go": "b.count := 3"})
    net, seen = Net(model), []

    @net.handler("go")
    def go(firing: Firing) -> Any:
        seen.append(firing.data["count"])
        return result(firing) if callable(result) else result

    with stepped(net) as (node, _):
        node.run_until_idle()
        assert [each["count"] for each in tokens(net, "b")] == [3]
    assert seen == [3]


def test_outputs_with_different_values_and_copies() -> None:
    model = guarded(
        {"go": "a ?mode -> b c"},
        {"a": ['{"count": 1}'], "mode": ['{"count": 7}']},
        assigns={"go": "b.done := true, c.done := false, c.count := mode.count"},
    )
    net = Net(model)
    net.handler("go")(lambda firing: {"color": "red"})
    with stepped(net) as (node, _):
        node.run_until_idle()
        (first,), (second,) = tokens(net, "b"), tokens(net, "c")
    assert (first["done"], first["count"], first["color"]) == (True, 1, "red")
    assert (second["done"], second["count"], second["color"]) == (False, 7, "red")


def test_while_a_long_handler_holds_the_token_no_other_takes_one_that_does_not_fit() -> None:
    model = guarded({"go": "a -> b"}, {"a": THREE[:2]}, {"go": "count >= 3"})
    net = Net(model)
    ends = [False]

    @net.handler("go", thread=True, parallel=2)
    def go(firing: Firing) -> None:
        while not ends[0]:
            time.sleep(0.002)

    with stepped(net) as (node, _):
        node.step()
        (flight,) = net.inspect().in_flight
        assert len(flight.tokens["a"]) == 1
        assert net.inspect().enabled == ("go",)  # in the net, which knows no reservation
        for _ in range(5):
            node.step()
        assert len(net.inspect().in_flight) == 1
        ends[0] = True
        settle(node)
        assert [each["color"] for each in tokens(net, "b")] == ["red"]


def test_a_selection_gets_the_tokens_that_fulfil_the_guard() -> None:
    net = Net(guarded({"go": "a -> b"}, {"a": THREE}, {"go": "count >= 3"}))
    seen = []

    @net.selection
    def choose(candidates: Any) -> Any:
        (go,) = candidates
        seen.append([token.data["color"] for token in go.available["a"]])
        return go.taking({"a": go.available["a"][-1]})

    with stepped(net) as (node, _):
        node.step()
        assert [each["color"] for each in tokens(net, "b")] == ["blue"]
    assert seen == [["red", "blue"]]
