"""Bars of goals: what is drawn of runs with actions, in pages, figures and exports."""

from __future__ import annotations

import json
from typing import Any

import pytest

from dineros.metamodel.records import decode_record, encode_fields
from dineros.views.exports.timing import calls_of
from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.facts import facts_of
from dineros.views.traces.figures import trace_svg
from dineros.views.traces.goals import ENDS
from tests.support.ros2_systems.deliveries import deliveries

Happening = tuple[str, str, dict[str, Any]]

GOAL: list[Happening] = [
    ("office0", "goal", {"client": "office0", "place": "Send0", "change": {"Send0": -1}}),
    ("robot", "accept", {"instance": 1, "place": "Delivery[1].Parcel", "change": {"Delivery[1].Parcel": 1}}),
    ("office0", "accepted", {"client": "office0"}),
    ("robot", "feedback", {"instance": 1, "place": "Delivery[1].Progress", "number": 1}),
    ("office0", "cancel", {"client": "office0", "place": "Recall0", "change": {"Recall0": -1}}),
    ("robot", "canceling", {"instance": 1, "place": "Delivery[1].Stop"}),
    ("office0", "hear", {"client": "office0", "place": "Heard0", "number": 1}),
    ("robot", "finish", {"instance": 1, "place": "Delivery[1].Back", "outcome": "canceled"}),
    ("office0", "outcome", {"client": "office0", "place": "Canceled0", "outcome": "canceled"}),
]


def built(happenings: list[Happening], goal: str = "g", builder: TraceBuilder | None = None) -> TraceBuilder:
    builder = builder or TraceBuilder(facts_of(deliveries(feedback=True)))
    for number, (node, event, fields) in enumerate(happenings, len(builder.steps)):
        values = {"channel": "Delivery", "message": goal, "node": node, "time": 1.0 + number, **fields}
        builder.add(decode_record(encode_fields(event, number, values)))
    return builder


def marks(builder: TraceBuilder) -> list[list[Any]]:
    return [mark[1:] for step in builder.steps for mark in step.marks]


def test_a_goal_has_a_bar_with_all_that_happens_to_it() -> None:
    builder = built(GOAL)
    assert marks(builder) == [
        ["q", 1], ["s", 1, 1], ["b", 1], ["c", 1], ["x", 1], ["h", 1], ["r", 1], ["a", 1, 2]
    ]  # fmt: skip
    (lane,) = [lane for lane in builder.lanes.all if lane.group == "actions"]
    assert (lane.kind, lane.label, lane.note, lane.node) == ("client", "/deliver", "C office0", "office0")
    assert [step.text for step in builder.steps][-2:] == [
        "the goal of client office0 of action /deliver is canceled",
        "client office0 learns that its goal of action /deliver is canceled",
    ]
    (call,) = calls_of(builder)
    assert (call.request, call.serve, call.reply, call.response) == (0, 1, 7, 8)
    assert ENDS[call.end or 0] == "canceled"


def test_a_goal_whose_acceptance_is_read_first_is_one_goal() -> None:
    """Of a run that continues, the trace of a server may be read before that of its client."""
    goal, accept, *rest = GOAL
    for clients, known in ((1, "C office0"), (2, "C ?")):
        facts = facts_of(deliveries(clients, feedback=True))
        builder = built([accept, goal, *rest], builder=TraceBuilder(facts))
        (lane,) = [lane for lane in builder.lanes.all if lane.group == "actions"]
        assert lane.note == known
        assert marks(builder)[:2] == [["s", 1, 1], ["q", 1]]
        assert marks(builder)[-1] == ["a", 1, 2]


def test_goals_under_way_at_the_same_time_have_rows_of_their_own() -> None:
    builder = built(GOAL[:2], "g")
    built(GOAL[:2], "h", builder)
    built(GOAL[7:], "g", builder)
    built(GOAL[:1], "i", builder)
    lanes = [lane.note for lane in builder.lanes.all if lane.group == "actions"]
    assert lanes == ["C office0", "C office0 (2)"]
    rows = [(step.event, mark[0], mark[2]) for step in builder.steps for mark in step.marks]
    first, second = (lane.index for lane in builder.lanes.all if lane.group == "actions")
    assert rows[0] == ("goal", first, 1)
    assert rows[2] == ("goal", second, 1)
    assert rows[-1] == ("goal", first, 2)


def test_a_request_to_cancel_without_a_goal_and_a_refusal() -> None:
    refused = ("office0", "reject", {"client": "office0", "place": "Refused0"})
    builder = built([*GOAL[:1], refused])
    built([("office0", "cancel", {"client": "office0", "place": "Recall0", "message": None})], "", builder)
    assert marks(builder) == [["q", 1], ["a", 1, 3], ["c", 1]]
    assert builder.steps[-1].text == "client office0 asks to cancel a goal of action /deliver, and has none"


def test_the_page_and_the_figure_have_them() -> None:
    view = TraceCoder(built(GOAL), "goals").snapshot()
    assert "actions" in {lane["group"] for lane in view["lanes"]}
    assert ">asks to cancel</text>" in trace_svg([view])


def test_exports_tell_how_goals_end() -> None:
    mcap = pytest.importorskip("mcap.reader")
    import io

    from dineros.views.exports.mcap_file import export

    reader = mcap.make_reader(io.BytesIO(export(built(GOAL))))
    states = [
        json.loads(message.data)["state"]
        for _, channel, message in reader.iter_messages()
        if channel.topic == "/dineros/actions/Delivery/office0"
    ]
    assert states == [
        "sent", "accepted", "feedback", "asked to cancel", "canceling", "heard", "finished", "canceled"
    ]  # fmt: skip
