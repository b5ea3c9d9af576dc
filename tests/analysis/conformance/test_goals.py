"""Runs with actions conform to the net; runs that were tampered with do not."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from dineros.analysis.conformance import Verdict, conform
from dineros.analysis.conformance.monitor import Monitor
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, step
from dineros.metamodel.records import Header, Record, decode_record, encode_fields
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal.recording import ListRecorder
from dineros.transformations.flattening.split import split
from tests.support.ros2_systems.deliveries import deliveries, regretting_any_time

Records = dict[str, list[dict[str, Any]]]


def recorded(model: sym.SystemModel, seed: int, steps: int = 1500) -> Records:
    recorders: dict[str, ListRecorder] = {}

    def recorder(node: str) -> ListRecorder:
        return recorders.setdefault(node, ListRecorder())

    with LocalApplication(split(model), seed=seed, recorder=recorder) as running:
        for _ in range(steps):
            running.step()
    return {node: list(each.records) for node, each in recorders.items()}


def decoded(model: sym.SystemModel, node: str, records: list[dict[str, Any]]) -> list[Record]:
    made: list[Record] = [Header(sequence=0, kind="run", model=model.id, node=node)]
    for number, record in enumerate(records):
        values = {name: value for name, value in record.items() if name not in ("sequence", "event")}
        made.append(decode_record(encode_fields(str(record["event"]), number, values)))
    return made


def channel(model: sym.SystemModel) -> sym.ActionChannel:
    (found,) = model.channels
    assert isinstance(found, sym.ActionChannel)
    return found


def judged(model: sym.SystemModel, run: Records) -> Verdict:
    traces = {node: decoded(model, node, records) for node, records in run.items()}
    return conform(model, {node: partial(iter, records) for node, records in traces.items()})


OPTIONS = [
    {"clients": 1, "goals": 3, "cancels": 2},
    {"clients": 2, "slots": 1, "goals": 3, "cancels": 2, "feedback": True},
    {"clients": 3, "slots": 2, "goals": 2, "cancels": 1, "feedback": True, "rejects": False},
    {"clients": 2, "slots": 1, "goals": 2, "cancels": 2, "heeds": False, "feedback": True},
    {"clients": 1, "goals": 2, "cancels": 0},
]


@pytest.mark.long
@pytest.mark.parametrize("options", OPTIONS)
def test_runs_conform(options: dict[str, Any]) -> None:
    for seed in range(3):
        model = deliveries(**options)
        verdict = judged(model, recorded(model, seed))
        assert verdict.status == "conforms", (seed, verdict.violations, verdict.unknown)


def test_several_goals_of_a_client_conform() -> None:
    for seed in range(3):
        model = deliveries(clients=1, slots=3, goals=5, cancels=4, feedback=True)
        channel(model).clients[0].outstanding = 3
        verdict = judged(model, recorded(model, seed))
        assert verdict.status == "conforms", (seed, verdict.violations, verdict.unknown)


@pytest.mark.parametrize(("slots", "outstanding"), [(1, 2), (2, 2), (3, 3)])
def test_requests_to_cancel_at_any_time_conform(slots: int, outstanding: int) -> None:
    """More of them than goals under way: some find none."""
    without = 0
    for seed in range(3):
        model = deliveries(clients=1, slots=slots, goals=5, cancels=8)
        channel(model).clients[0].outstanding = outstanding
        regretting_any_time(model)
        run = recorded(model, seed)
        without += sum(record["event"] == "cancel" and record["message"] is None for record in run["office0"])
        verdict = judged(model, run)
        assert verdict.status == "conforms", (seed, verdict.violations, verdict.unknown)
    assert without


def test_a_server_that_refuses_requests_to_cancel_conforms() -> None:
    for seed in range(3):
        model = deliveries(clients=1, goals=3, cancels=3)
        channel(model).server.cancel = None
        verdict = judged(model, recorded(model, seed))
        assert verdict.status == "conforms", (seed, verdict.violations, verdict.unknown)


def test_a_monitor_that_hears_the_nodes_in_turn_agrees() -> None:
    model = deliveries(clients=2, slots=1, goals=3, cancels=2, feedback=True)
    run = recorded(model, 4)
    monitor = Monitor(model)
    traces = {node: decoded(model, node, records) for node, records in run.items()}
    while any(traces.values()):
        for records in traces.values():
            assert monitor.add(records[:3]) == []
            del records[:3]
    assert monitor.finish().status == "conforms"


def _first(run: Records, event: str) -> tuple[list[dict[str, Any]], int]:
    """Return a node's records, and where the first record of an event stands."""
    for records in run.values():
        for number, record in enumerate(records):
            if record["event"] == event:
                return records, number
    raise AssertionError(f"no {event}")


def _without(event: str) -> Callable[[Records], None]:
    def tamper(run: Records) -> None:
        records, number = _first(run, event)
        del records[number]

    return tamper


def _twice(event: str) -> Callable[[Records], None]:
    def tamper(run: Records) -> None:
        records, number = _first(run, event)
        records.insert(number, dict(records[number]))

    return tamper


def _with(event: str, **fields: Any) -> Callable[[Records], None]:
    def tamper(run: Records) -> None:
        records, number = _first(run, event)
        records[number] = {**records[number], **fields}

    return tamper


TAMPERED = [
    *(_without(event) for event in ("goal", "accept", "canceling", "finish", "feedback")),
    *(_twice(event) for event in ("goal", "accept", "canceling", "finish", "outcome", "cancel")),
    _with("accept", message="another goal"),
    _with("finish", outcome="succeeded"),
    _with("outcome", outcome="succeeded"),
    _with("outcome", place="Failed0"),
    _with("canceling", instance=2),
]


@pytest.mark.long
@pytest.mark.parametrize("tamper", TAMPERED)
def test_a_run_that_was_tampered_with_does_not_conform(tamper: Callable[[Records], None]) -> None:
    model, run = next(
        (model, run)
        for seed in range(50)
        for model in [deliveries(clients=1, goals=1, cancels=1, feedback=True, rejects=False)]
        for run in [recorded(model, seed, 200)]
        if any(record.get("outcome") == "canceled" for record in run["office0"])
    )
    assert judged(model, run).status == "conforms"
    tamper(run)
    assert judged(model, run).status == "violated"


def test_a_run_that_tells_of_accepted_goals_conforms() -> None:
    """The token for it comes before that of the result, and a run without the former does not conform."""
    for seed in range(3):
        model = deliveries(clients=1, goals=4, cancels=2)
        client = channel(model).clients[0]
        client.accepted = sym.Place(id="Told", page=client.goal.page)
        run = recorded(model, seed)
        told = [record for record in run["office0"] if record["event"] == "accepted"]
        assert told and all(record["change"] == {"Told": 1} for record in told)
        assert judged(model, run).status == "conforms"
        run["office0"] = [record for record in run["office0"] if record is not told[0]]
        assert judged(model, run).status == "violated"


def test_a_run_of_a_client_that_does_not_wait_conforms() -> None:
    """It has several requests under way, which its node's net does not hold up."""
    model = sym.SystemModel(id="pile", middleware="ros2")
    mover, user = (node_net(model, id) for id in ("mover", "user"))
    mover.execution = user.execution = "callbacks"
    serve, answer = callback(mover, "OnMove", "server"), callback(user, "OnAnswer", "client")
    ends = [place(serve, "In"), place(serve, "Out"), place(user, "Request"), place(answer, "Response")]
    step(serve, "Move", [ends[0]], [ends[1]])
    step(user, "Send", [place(user, "Wanted", tokens=8)], [ends[2]])
    step(answer, "Note", [ends[3]])
    sym.ServiceChannel(
        id="Move_",
        service="/move",
        depth=2,
        server=sym.ServerPort(page=serve, entry=ends[0], exit=ends[1]),
        clients=[sym.ClientPort(client="user", request=ends[2], response=ends[3])],
        model=model,
    )
    several = False
    for seed in range(5):
        run = recorded(model, seed, 200)
        steps = [record["event"] for record in run["user"]]
        under_way = [
            steps[: number + 1].count("request") - steps[: number + 1].count("response")
            for number in range(len(steps))
        ]
        several |= max(under_way) > 1
        assert judged(model, run).status == "conforms"
    assert several
