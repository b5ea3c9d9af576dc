"""Handlers: order, data, what they may return, and that they reach nothing but copies."""

from __future__ import annotations

import gc
import types
from typing import Any

import pytest

from dineros.metamodel.errors import UnknownElementError
from dineros.runtime import Aside, Firing, HandlerError, Net, Retry
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nodes.core import Core
from tests.runtime.tiny import counts, events, settle, stepped, tiny

ONE_STEP = {"go": "a -> b"}
RED = ['{"color": "red", "count": 1}']


def one(net: Net, place: str) -> dict[str, Any]:
    (token,) = net.inspect().marking[place]
    return dict(token.data)


def test_data_is_passed_on() -> None:
    net = Net(tiny(ONE_STEP, {"a": RED}))
    with stepped(net) as (node, _):
        node.run_until_idle()
        rest = {"weight": 0.0, "done": False, "pose": [0.0, 0.0], "notes": [], "marks": {}}
        assert one(net, "b") == {"color": "red", "count": 1} | rest


def test_the_first_input_goes_on_and_loops_come_back_unchanged() -> None:
    marking = {"a": ['{"count": 5}'], "b": ['{"color": "blue", "count": 7}'], "loop": ['{"color": "own"}']}
    net = Net(tiny({"go": "loop a b -> c loop"}, marking))
    with stepped(net) as (node, _):
        before = net.inspect().marking["loop"][0].id
        node.step()
        assert (one(net, "c")["color"], one(net, "c")["count"]) == ("", 5)
        assert one(net, "loop")["color"] == "own"
        assert net.inspect().marking["loop"][0].id == before


def test_where_there_is_only_a_loop_or_a_read_arc_its_data_goes_on() -> None:
    net = Net(
        tiny({"go": "a loop -> loop b", "look": "c ?seen -> d"}, {"a": 1, "loop": RED, "c": 1, "seen": RED})
    )
    with stepped(net) as (node, _):
        node.run_until_idle()
        assert one(net, "b")["color"] == ""  # `a` is an input of its own
    net = Net(tiny({"go": "loop -> loop b", "stop": "b ?seen -> d"}, {"loop": RED, "seen": 1}))
    with stepped(net) as (node, _):
        node.step()
        assert one(net, "b")["color"] == "red"


def test_handlers_run_by_priority_and_see_what_the_former_left() -> None:
    net = Net(tiny(ONE_STEP, {"a": RED}))
    seen: list[tuple[str, object]] = []

    @net.handler("go", priority=1)
    def last(firing: Firing) -> dict[str, object]:
        seen.append(("last", firing.data["count"]))
        return {"done": True}

    @net.handler("go", priority=5)
    def first(firing: Firing) -> None:
        seen.append(("first", firing.data["count"]))
        firing.data["count"] += 10

    with stepped(net) as (node, recorder):
        node.step()
        assert seen == [("first", 1), ("last", 11)]
        assert (one(net, "b")["count"], one(net, "b")["done"], one(net, "b")["color"]) == (11, True, "red")
        assert events(recorder, "fire")[0]["handlers"] == ["first", "last"]


def test_handlers_are_replaced_and_reprioritised_while_running() -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 4}))
    order: list[str] = []
    net.handler("go", name="x", priority=2)(lambda firing: order.append("x"))
    net.handler("go", name="y", priority=1)(lambda firing: order.append("y"))
    with stepped(net) as (node, _):
        node.step()
        net.set_priority("go", "y", 3)
        node.step()
        net.handler("go", name="x", replace=True)(lambda firing: order.append("new x"))
        node.step()
        net.remove_handler("go", "y")
        node.step()
    assert order == ["x", "y", "y", "x", "y", "new x", "new x"]


def test_give_sets_the_tokens_of_single_places() -> None:
    net = Net(tiny({"go": "a keep -> 2*b c keep"}, {"a": RED, "keep": ['{"color": "own"}']}))

    @net.handler("go")
    def share(firing: Firing) -> object:
        firing.data["weight"] = 2
        return firing.give({"b": [{"count": 1}, {"count": 2}], "keep": {"done": True}})

    with stepped(net) as (node, _):
        node.step()
        assert [token.data["count"] for token in net.inspect().marking["b"]] == [1, 2]
        assert [token.data["color"] for token in net.inspect().marking["b"]] == ["red", "red"]
        assert (one(net, "c")["count"], one(net, "c")["weight"]) == (1, 2.0)
        assert (one(net, "keep")["color"], one(net, "keep")["done"]) == ("own", True)


@pytest.mark.parametrize(
    ("result", "says"),
    [
        (42, "returned an object of class int"),
        ([], "returned an object of class list"),
        ({"colour": "red"}, "did you mean 'color'?"),
        ({"count": "3"}, "count takes an integer"),
        ({"count": True}, "count takes an integer"),
        ({"count": 2**63}, "count takes an integer"),
        ({"weight": float("nan")}, "weight takes a finite number"),
        ({"color": "re\0d"}, "color takes a string without NUL"),  # ROS sends a text up to its first NUL
        ({"notes": ["\0"]}, "an element of notes takes a string without NUL"),
        ({"marks": {"\0": 2}}, "a key of marks takes a string without NUL"),
        ({"done": 1}, "done takes a boolean"),
        ({"pose": [1.0]}, "pose takes 2 elements, not 1"),
        ({"notes": "abc"}, "notes takes a list"),
        ({"notes": [1]}, "an element of notes takes a text"),
        ({"marks": {1: 2}}, "a key of marks takes a text"),
        ({"color": "\ud800"}, "color takes a text"),
    ],
)
def test_a_wrong_return_changes_nothing_and_halts(result: Any, says: str) -> None:
    net = Net(tiny(ONE_STEP, {"a": RED}))
    net.handler("go", name="wrong")(lambda firing: result)
    with stepped(net) as (node, recorder):
        before = net.inspect().marking
        node.step()
        state = net.inspect()
        assert state.marking == before
        assert says in str(state.errors[0].error)
        assert state.halted is not None and "wrong" in state.halted
        (record,) = events(recorder, "error")
        assert (record["transition"], record["handler"], record["policy"]) == ("go", "wrong", "halt")
        assert not node.step()


@pytest.mark.parametrize("places", [{"nowhere": {}}, {"b": [{}, {}]}, {"a": {}}])
def test_a_wrong_gift_changes_nothing(places: Any) -> None:
    net = Net(tiny(ONE_STEP, {"a": RED}))
    net.handler("go")(lambda firing: firing.give(places))
    with stepped(net) as (node, _):
        node.step()
        assert counts(net) == {"a": 1, "b": 0}
        assert net.inspect().failures == 1


def test_handlers_reach_neither_marking_nor_structure() -> None:
    net = Net(tiny(ONE_STEP, {"a": RED}))
    reached: list[object] = []

    def vandal(firing: Firing) -> None:
        firing.inputs["a"][0].data["notes"].append("mine")  # type: ignore[union-attr]
        firing.data["pose"][0] = 9.0
        with pytest.raises(TypeError):
            firing.inputs["a"] = ()  # type: ignore[index]
        # Everything that can be got at from the firing, by attributes and containers.
        todo: list[object] = [firing]
        known: set[int] = set()
        while todo:
            each = todo.pop()
            if id(each) in known or isinstance(each, (type, types.ModuleType, types.FunctionType)):
                continue
            known.add(id(each))
            reached.append(each)
            todo.extend(gc.get_referents(each))
        raise RuntimeError("and now it fails")

    net.handler("go")(vandal)
    with stepped(net) as (node, _):
        token = net.core.engine.tokens(0)[0]
        node.step()
        assert len(reached) > 5
        assert not any(isinstance(each, (Engine, Core, Net)) or each is token.data for each in reached)
        assert one(net, "a")["notes"] == [] and one(net, "a")["pose"] == [0.0, 0.0]


def test_what_a_handler_keeps_is_not_the_marking() -> None:
    net = Net(tiny({"go": "a -> b", "on": "b -> c"}, {"a": 1}))
    kept: list[list[str]] = []

    @net.handler("go")
    def keep(firing: Firing) -> dict[str, object]:
        notes = ["one"]
        kept.append(notes)
        return {"notes": notes}

    with stepped(net) as (node, _):
        node.step()
        kept[0].append("two")
        node.step()
        assert one(net, "c")["notes"] == ["one"]


def test_retry_waits_longer_each_time_and_then_puts_aside() -> None:
    now = [0.0]
    net = Net(tiny(ONE_STEP, {"a": RED}), clock=lambda: now[0])
    policy = Retry(attempts=3, delay=1.0, factor=3.0, then=Aside())

    @net.handler("go", policy=policy)
    def fail(firing: Firing) -> None:
        raise ValueError("no grip")

    with stepped(net) as (node, recorder):
        times: list[float] = []
        for _ in range(200):
            node.step()
            while len(times) < len(events(recorder, "error")):
                times.append(now[0])
            now[0] += 0.1
        assert times == [pytest.approx(0.0), pytest.approx(1.0, abs=0.11), pytest.approx(4.0, abs=0.21)]
        assert [record["attempt"] for record in events(recorder, "error")] == [1, 2, 3]
        assert [record["policy"] for record in events(recorder, "error")] == ["retry", "retry", "aside"]
        assert events(recorder, "error")[0]["error"] == "ValueError: no grip"


def test_tokens_put_aside_are_counted_left_alone_and_released() -> None:
    net = Net(tiny({"go": "a -> b", "other": "a x -> c"}, {"a": ['{"count": 1}', '{"count": 2}']}))

    @net.handler("go", policy=Aside())
    def odd(firing: Firing) -> None:
        if firing.data["count"] == 1 and not fine:
            raise ValueError

    fine = False
    with stepped(net) as (node, recorder):
        node.run_until_idle()
        state = net.inspect()
        assert counts(net) == {"a": 1, "b": 1, "x": 0, "c": 0}
        assert state.aside == {"go": {"a": (1,)}}
        assert "go" in state.enabled  # in the net it is
        assert events(recorder, "aside")[0]["tokens"] == {"a": [1]}
        fine = True
        net.release("go")
        node.run_until_idle()
        assert counts(net)["b"] == 2
        assert events(recorder, "release")[0]["tokens"] == {"a": [1]}
        assert net.inspect().aside == {}


def test_others_may_take_what_is_aside() -> None:
    net = Net(tiny({"go": "a -> b", "other": "a ?x -> c"}, {"a": 1}, signals="s", clauses={"other": "s"}))
    engine, place = net.core.engine, net.core.names.place("x")
    engine.put(place, engine.new_token(engine.passing.checkers[place].default))

    @net.handler("go", policy=Aside())
    def fail(firing: Firing) -> None:
        raise ValueError

    with stepped(net) as (node, _):
        node.run_until_idle()
        net.signal("s").set(True)
        node.run_until_idle()
        assert counts(net) == {"a": 0, "b": 0, "x": 1, "c": 1}
        assert net.inspect().aside == {}


def test_after_a_halt_the_node_proceeds() -> None:
    net = Net(tiny(ONE_STEP, {"a": 1}))
    bad = [True]

    @net.handler("go")
    def fail(firing: Firing) -> None:
        if bad.pop():
            raise ValueError

    with stepped(net) as (node, _):
        node.run_until_idle()
        assert net.inspect().halted
        bad.append(False)
        net.proceed()
        node.run_until_idle()
        assert counts(net) == {"a": 0, "b": 1}


def test_a_keyboard_interrupt_in_a_handler_goes_through_and_changes_nothing() -> None:
    net = Net(tiny(ONE_STEP, {"a": 1}))

    @net.handler("go")
    def interrupted(firing: Firing) -> None:
        raise KeyboardInterrupt

    with stepped(net) as (node, _):
        with pytest.raises(KeyboardInterrupt):
            node.step()
        assert counts(net) == {"a": 1, "b": 0}


def test_registering_what_is_not_there() -> None:
    net = Net(tiny(ONE_STEP, {"a": 1}))
    with pytest.raises(UnknownElementError, match="did you mean 'go'"):
        net.handler("goo")(lambda firing: None)
    net.handler("go", name="x")(lambda firing: None)
    with pytest.raises(HandlerError, match="replace=True"):
        net.handler("go", name="x")(lambda firing: None)
    with pytest.raises(HandlerError, match="not a function"):
        net.handler("go", name="z")(42)  # type: ignore[type-var]
    with pytest.raises(HandlerError, match="did you mean 'x'"):
        net.set_priority("go", "xx", 3)
    with pytest.raises(HandlerError):
        net.remove_handler("go", "q")


def test_an_asynchronous_handler_leaves_the_data_too() -> None:
    net = Net(tiny(ONE_STEP, {"a": RED}))

    @net.handler("go")
    async def slow(firing: Firing) -> dict[str, object]:
        firing.data["count"] += 1
        return {"done": True}

    with stepped(net) as (node, _):
        settle(node)
        assert (one(net, "b")["count"], one(net, "b")["done"]) == (2, True)
