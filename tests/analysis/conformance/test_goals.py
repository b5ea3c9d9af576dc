"""Runs with actions conform to the net; runs that were tampered with do not."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from dineros.analysis.conformance import Verdict, conform
from dineros.analysis.conformance.monitor import Monitor
from dineros.metamodel import sym
from dineros.metamodel.records import Header, Record, decode_record, encode_fields
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal.recording import ListRecorder
from dineros.transformations.flattening.split import split
from tests.support.ros2_systems.deliveries import deliveries

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
