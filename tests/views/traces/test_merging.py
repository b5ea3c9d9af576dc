"""Several nodes' records as one sequence."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel.records import Accept, Accepted, Finish, Fire, Goal, Outcome, Publish, Record, Take
from dineros.views.traces.merging import Merger, merge

NODES = ("a", "b", "c")


@st.composite
def traces(draw: st.DrawFn) -> dict[str, list[Record]]:
    """Draw a run as it happened, then let every node's clock be wrong by some seconds."""
    wrong = {node: draw(st.floats(-5, 5)) for node in NODES}
    found: dict[str, list[Record]] = {node: [] for node in NODES}
    sent: list[str] = []
    for time in range(draw(st.integers(0, 30))):
        node = draw(st.sampled_from(NODES))
        fields: dict[str, Any] = {"sequence": len(found[node]), "time": time + wrong[node], "node": node}
        what = draw(st.sampled_from(["fire", "publish", "take"]))
        if what == "publish":
            sent.append(f"{node}/p/{time}")
            found[node].append(Publish(**fields, channel="c", place="p", message=sent[-1]))
        elif what == "take" and sent:
            message = draw(st.sampled_from(sent))
            found[node].append(Take(**fields, channel="c", place="q", message=message))
        else:
            found[node].append(Fire(**fields, transition="t"))
    return found


@given(traces())
def test_nothing_is_taken_before_it_is_sent_and_no_node_loses_its_order(
    found: dict[str, list[Record]],
) -> None:
    merged = list(merge(found))
    for node in NODES:
        assert [record for of, record in merged if of == node] == found[node]
    seen = set()
    for _, record in merged:
        if isinstance(record, Publish):
            seen.add(record.message)
        if isinstance(record, Take):
            assert record.message in seen


def test_a_message_whose_sender_lost_its_record_holds_nothing_up() -> None:
    take = Take(sequence=0, time=1.0, node="b", channel="c", place="q", message="a/p/1")
    others = [Fire(sequence=i, time=float(i), node="a", transition="t") for i in range(4)]
    assert [record.time for _, record in merge({"a": others, "b": [take]})] == [0.0, 1.0, 1.0, 2.0, 3.0]


def test_live_a_message_waits_for_the_record_that_sent_it() -> None:
    merger = Merger(["a", "b"])
    take = Take(sequence=0, time=1.0, node="b", channel="c", place="q", message="a@7/p/1")
    merger.push("b", take)
    assert list(merger.ready()) == []
    assert merger.waiting
    merger.push("a", Publish(sequence=0, time=9.0, node="a", channel="c", place="p", message="a@7/p/1"))
    assert [node for node, _ in merger.ready()] == ["a", "b"]
    merger.push("b", Take(sequence=1, time=1.0, node="b", channel="c", place="q", message="a/p/2"))
    assert [node for node, _ in merger.ready(force=True)] == ["b"]


def test_a_goal_is_sent_before_it_is_accepted_and_over_before_its_client_knows() -> None:
    """A client notes that it has sent a goal when it is sent, and the server may be quicker."""
    goal: dict[str, Any] = {"channel": "Drive", "message": "g"}
    client = [
        Goal(sequence=0, time=1.2, node="c", **goal),
        Accepted(sequence=1, time=1.3, node="c", **goal),
        Outcome(sequence=2, time=1.4, node="c", outcome="succeeded", **goal),
    ]
    server = [
        Accept(sequence=0, time=1.1, node="s", **goal),
        Finish(sequence=1, time=1.5, node="s", outcome="succeeded", **goal),
    ]
    merged = [record.event for _, record in merge({"c": client, "s": server})]
    assert merged == ["goal", "accept", "accepted", "finish", "outcome"]
