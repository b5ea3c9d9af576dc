"""From records to steps and lanes."""

from __future__ import annotations

from functools import cache
from typing import Any

from dineros.metamodel import sym
from dineros.metamodel.files import load
from dineros.metamodel.records import (
    Checkpoint,
    Drop,
    Fire,
    GiveUp,
    Header,
    Publish,
    Reply,
    Request,
    Response,
    Serve,
    Start,
    StoredToken,
    Take,
)
from dineros.views.exports.timing import calls_of
from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.facts import Facts, facts_of, prototype
from dineros.views.traces.merging import merge
from tests.support.systems.bakery import bakery
from tests.support.systems.ovens import oven
from tests.views.samples import CASE_STUDY, Scribe, lasso, run


@cache
def facts() -> Facts:
    model = load(CASE_STUDY)
    assert isinstance(model, sym.SystemModel)
    return facts_of(model)


def built(*scribes: Scribe, loads: dict[str, tuple[str, str, str]] | None = None) -> TraceBuilder:
    builder = TraceBuilder(facts(), loads)
    for _, record in merge(
        {scribe.node or str(number): scribe.records for number, scribe in enumerate(scribes)}
    ):
        builder.add(record)
    return builder


def marks(builder: TraceBuilder, *key: str) -> list[list[Any]]:
    """Return the marks of a lane, each with the index of its step."""
    lane = builder.lanes.get(*key)
    assert lane is not None, key
    return [
        [i, *mark[1:]] for i, step in enumerate(builder.steps) for mark in step.marks if mark[0] == lane.index
    ]


def test_a_model_says_who_owns_what_and_what_is_replicated() -> None:
    assert facts().owner_of("Pick[2].TPick") == "executor"
    assert {"Pick[1].TPick", "Pick[2].TPick"} <= set(facts().transitions)
    assert "TPick" not in facts().transitions
    clause = facts().clauses["TPickFail"]
    assert clause.disjunctions == (
        (("RobotIsIdle", False), ("RobotHasFinished", False)),
        (("ObjectIsPicked", True),),
    )
    assert facts().limits["LeftCellObjects", "controller"] == 16
    assert prototype("a[1].b[2].c") == "c"


def test_lanes_of_a_witness() -> None:
    load = "LeftCellObjects.publisher.SortRed.Load"
    builder = built(lasso(), loads={load: ("LeftCellObjects", "publisher", "SortRed")})
    assert marks(builder, "signal", "Red") == [[1, "v", 1]]
    assert marks(builder, "queue", "LeftCellObjects", "publisher", "SortRed") == [[3, "p", 1], [6, "d", 1, 1]]
    assert marks(builder, "client", "SensorService", "safety") == [[4, "q", 1], [5, "s", 1, 1]]
    assert builder.loop == 7
    assert [step.node for step in builder.steps][:4] == ["executor", "selector", "selector", "selector"]
    signals = [lane.id for lane in builder.lanes.all if lane.kind == "signal"]
    assert signals == ["Red", "Blue", "Danger"]  # the property's first
    asked = [lane.id for lane in builder.lanes.all if lane.group == "property"]
    assert asked == ["Shown"]


def test_a_run_of_several_nodes_is_in_the_order_of_its_messages() -> None:
    builder = built(*run().values())
    texts = [(step.node, step.event) for step in builder.steps]
    assert texts.index(("selector", "publish")) < texts.index(("controller", "take"))
    assert texts.index(("controller", "request")) < texts.index(("synchronizer", "serve"))
    assert texts.index(("synchronizer", "reply")) < texts.index(("controller", "response"))
    calls = marks(builder, "client", "GetControl", "L")
    assert [mark[1:3] for mark in calls] == [["q", 1], ["s", 1], ["r", 1], ["o", 1], ["a", 1], ["q", 2]] or [
        mark[1:3] for mark in calls
    ] == [["q", 1], ["o", 1], ["s", 1], ["r", 1], ["a", 1], ["q", 2]]
    taken = marks(builder, "queue", "LeftCellObjects", "subscriber", "ReqControlL")
    assert [mark[1:] for mark in taken] == [["n", 1], ["k", 0], ["d", 0, 3]]


def test_the_marking_of_a_run_is_that_of_all_nodes_once() -> None:
    builder = built(*run().values())
    assert builder.marking == {**builder.marking, "StateGet": 0, "StateEnd": 1, "RedObjects": 0, "SortRed": 0}
    assert not [step for step in builder.steps if step.event == "start" and step.node == "selector"]


def test_what_a_node_resumes_with_is_a_step() -> None:
    node = Scribe("selector")
    node.write(Header, kind="run", model="sorting")
    node.write(Start, marking={"RedObjects": [StoredToken(1, {})]}, signals={"Red": False})
    node.write(Fire, 1, transition="SelectRed", change={"RedObjects": -1, "SortRed": 1})
    node.write(Start, 1, marking={"RedObjects": [StoredToken(1, {})]}, signals={"Red": True}, resumed=True)
    builder = built(node)
    assert builder.steps[1].text == "selector continues"
    assert builder.steps[1].change == {"RedObjects": 1, "SortRed": -1}
    assert marks(builder, "signal", "Red") == [[1, "v", 1]]


def test_a_checkpoint_in_the_middle_is_no_step() -> None:
    node = Scribe("selector")
    node.write(Header, kind="run", model="sorting")
    node.write(Start, marking={"RedObjects": [StoredToken(1, {})]})
    node.write(Fire, 1, transition="SelectRed", change={"RedObjects": -1, "SortRed": 1})
    node.write(Checkpoint, marking={"SortRed": [StoredToken(2, {})]})
    assert len(built(node).steps) == 1


def test_messages_under_way_to_a_subscriber_are_counted_from_the_first() -> None:
    node = Scribe("n")
    node.write(Header, kind="run", model="m")
    for number in (1, 2, 3):
        node.write(Publish, 1, channel="c", place="p", message=f"n/p/{number}")
    node.write(Take, 1, channel="c", place="s", message="n/p/1")
    node.write(Drop, 1, channel="c", queue="subscriber", place="s", count=2)
    builder = TraceBuilder()
    for record in node.records:
        builder.add(record)
    assert marks(builder, "queue", "c", "subscriber", "s") == [[3, "k", 2], [4, "d", 0, 2]]


def test_a_history_holds_no_more_than_its_depth() -> None:
    """What comes to a full one pushes the oldest message out, of which the subscriber tells later."""
    node = Scribe("logger")
    for number in range(1, 7):
        node.write(Publish, 1, channel="Words", place="Said", message=f"talker/Said/{number}")
        if number == 1:
            node.write(Take, 1, channel="Words", place="Heard", message="talker/Said/1")
    node.write(Drop, 1, channel="Words", queue="subscriber", place="Heard", count=2)
    node.write(Take, 1, channel="Words", place="Heard", message="talker/Said/4")
    facts = Facts(limits={("Words", "Heard"): 3}, subscribers={("Words", "Heard")}, has_histories=True)
    builder = TraceBuilder(facts)
    for record in node.records:
        builder.add(record)
    assert marks(builder, "queue", "Words", "subscriber", "Heard") == [
        [1, "k", 0], *([2 + n, "n", min(n + 1, 3)] for n in range(5)), [7, "d", 3, 2], [8, "k", 2]
    ]  # fmt: skip


def test_what_is_new_adds_up_to_the_snapshot() -> None:
    records = [record for _, record in merge({name: scribe.records for name, scribe in run().items()})]
    growing, whole = TraceBuilder(facts()), TraceBuilder(facts())
    coder = TraceCoder(growing, "t")
    for record in records[:9]:
        growing.add(record)
    view = coder.snapshot()
    for record in records[9:]:
        growing.add(record)
        change = coder.changes()
        if change is not None:
            assert change["first"] == len(view["steps"])
            for table in ("steps", "lanes", "nodes", "places", "transitions", "texts"):
                view[table] += change.get(table, [])
    assert coder.changes() is None
    for record in records:
        whole.add(record)
    expected = TraceCoder(whole, "t").snapshot()
    assert view["steps"] == expected["steps"]
    assert view["lanes"] == expected["lanes"]
    assert view["places"] == expected["places"]


def test_server_instances_call_in_lanes_of_their_own_and_share_a_queue() -> None:
    facts = facts_of(bakery())
    builder = TraceBuilder(facts)
    builder.add(Header(sequence=0, time=1.0, node="shop", kind="run", model="bakery"))
    for sequence, number in ((1, 2), (2, 1)):
        at = {"sequence": sequence, "time": 1.0 + sequence, "node": "shop"}
        call = {"channel": "Bake", "message": f"shop/Order[{number}].Dough/1"}
        place = f"Order[{number}].Dough"
        builder.add(Request(**at, **call, client=f"Order[{number}].baker", place=place, change={place: -1}))  # type: ignore[arg-type]
        builder.add(Reply(**{**at, "node": "oven"}, **call, place="Bake[1].Done", instance=1))  # type: ignore[arg-type]
        told = f"Order[{number}].Told"
        builder.add(Publish(**at, channel="Sales", place=told, message=f"shop/{told}/1", change={told: -1}))  # type: ignore[arg-type]

    assert [step.text for step in builder.steps[:3]] == [
        "instance 2 of service /order calls service /bake",
        "instance 1 of service /bake answers instance 2 of service /order",
        "Order[2].Told publishes on topic /sales",
    ]
    clients = [lane.id for lane in builder.lanes.all if lane.kind == "client" and lane.channel == "Bake"]
    assert clients == ["Order[1].baker", "Order[2].baker"]
    queues = [(lane.id, lane.capacity) for lane in builder.lanes.all if lane.queue == "publisher"]
    assert queues == [("Told", 4)]
    assert marks(builder, "queue", "Sales", "publisher", "Told") == [[2, "p", 0], [5, "p", 0]]


def test_calls_that_overlap_and_calls_that_are_given_up() -> None:
    """Each step goes to its own call; what is given up is served all the same."""
    scribe = Scribe("baker0")
    for number in (1, 2, 3):
        scribe.write(Request, channel="Oven", client="baker0", place="Ask0", message=f"baker0/Ask0/{number}")
    scribe.write(GiveUp, channel="Oven", client="baker0", place="Late0", message="baker0/Ask0/2")
    scribe.write(Serve, channel="Oven", place="Dough", instance=1, message="baker0/Ask0/2")
    scribe.write(Reply, channel="Oven", place="Bread", instance=1, message="baker0/Ask0/2")
    scribe.write(Drop, channel="Oven", queue="request", message="baker0/Ask0/3")
    scribe.write(Response, channel="Oven", client="baker0", place="Got0", message="baker0/Ask0/1")
    builder = TraceBuilder(facts_of(oven(2, 2, outstanding=3, timeout=1.0, tells=True)))
    for record in scribe.records:
        builder.add(record)
    found = [mark[1:3] for mark in marks(builder, "client", "Oven", "baker0")]
    assert found == [["q", 1], ["q", 2], ["q", 3], ["g", 2], ["s", 2], ["r", 2], ["o", 3], ["a", 1]]
    assert builder.steps[3].text == "client baker0 gives up waiting for service /bake"
    assert builder.steps[6].text == "the request of client baker0 is lost by service /bake"
    calls = calls_of(builder)
    assert [(call.level, call.given_up) for call in calls] == [(0, None), (1, 3), (2, None)]
