"""Conformance of calls: several of one client, given up, served too late, lost by a full history."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.analysis.conformance import Monitor, Verdict, conform
from dineros.analysis.conformance.net import ConformanceNet
from dineros.analysis.conformance.replay import Replay
from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.witness import replay
from dineros.metamodel import sym
from dineros.metamodel.records import (
    Checkpoint,
    Drop,
    GiveUp,
    Header,
    Record,
    Reply,
    Request,
    Response,
    Serve,
    read_trace,
    traces_of_runs,
)
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.split import split
from tests.support.systems.ovens import oven

COMMON = settings(deadline=None, max_examples=6, suppress_health_check=list(HealthCheck))
Traces = Mapping[str, Sequence[Record]]


def run(model: sym.SystemModel, seed: int, seconds: float = 0.5, **options: Any) -> dict[str, list[Record]]:
    """Return the traces of a run in simulated time."""
    with tempfile.TemporaryDirectory() as folder:
        recorder = partial(JournalRecorder, Path(folder), **options)
        application = LocalApplication(split(model), seed=seed, recorder=recorder)
        application.open()
        application.run(lambda _: False, seconds)
        application.close()
        return {node: list(read_trace(parts)) for node, parts in traces_of_runs([Path(folder)]).items()}


def verdict_on(model: sym.SystemModel, traces: Traces) -> Verdict:
    return conform(model, {node: partial(iter, records) for node, records in traces.items()}, firings=True)


def of(traces: Traces, kind: type[Record]) -> list[Record]:
    return [record for records in traces.values() for record in records if isinstance(record, kind)]


@st.composite
def ovens(draw: st.DrawFn) -> sym.SystemModel:
    model = oven(
        draw(st.integers(1, 4)),
        draw(st.integers(1, 3)),
        outstanding=draw(st.integers(1, 3)),
        timeout=draw(st.sampled_from([None, 0.002, 0.005, 0.02, 0.1])),
        tells=draw(st.booleans()),
    )
    service = model.channels[0]
    assert isinstance(service, sym.ServiceChannel)
    service.instances = draw(st.integers(1, 2))
    for client in service.clients:
        if client.timeout is None:
            client.timedOut = None
        elif client.timedOut is None:
            client.timedOut = draw(st.sampled_from([None, client.request, client.response]))
    return model


@pytest.mark.long
@given(ovens(), st.integers(0, 2**20))
@COMMON
def test_runs_conform(model: sym.SystemModel, seed: int) -> None:
    """What is inferred is a sequence of firings of the net; the monitor finds the same, record by record."""
    traces = run(model, seed)
    verdict = verdict_on(model, traces)
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])
    subject = subject_of(model, "fully-enabled")
    replay(subject.net, [subject.transition_index[name] for name in verdict.sequence])
    monitor = Monitor(model)
    for record in sorted(of(traces, Record), key=lambda record: record.time or 0.0):
        assert monitor.add([record]) == []
    assert monitor.finish().status == "conforms"


def test_what_happens_in_a_run() -> None:
    """Requests are given up at every stage, late ones are served, and full histories lose some."""
    seen: Counter[str] = Counter()
    for depth, outstanding, timeout in ((2, 2, 0.008), (3, 2, 0.012)):
        model = oven(3, depth, outstanding=outstanding, timeout=timeout, tells=True)
        traces, net = run(model, seed=1), ConformanceNet(model)
        in_time = Replay(net, firings=[])
        for record in sorted(of(traces, Record), key=lambda record: record.time or 0.0):
            assert in_time.step(record) is None, record
        names = [net.net.transitions[transition] for transition in in_time.noted]
        names += verdict_on(model, traces).sequence  # where clients give up as late as they can
        for name in names:
            seen[name.partition(".giveUp.")[2].partition("[")[0]] += 1
            seen["late"] += ".late.call" in name
            seen["instead"] += name.endswith(".instead")
        seen["lost"] += len(of(traces, Drop))
    assert min(seen[what] for what in ("requests", "inUse", "responses", "late", "instead", "lost")) > 0


@pytest.mark.long
@given(ovens(), st.integers(0, 2**20))
@COMMON
def test_traces_that_begin_within_the_run(model: sym.SystemModel, seed: int) -> None:
    """Each begins with its last checkpoints only: what was given up before is known to nobody."""
    traces = run(model, seed, part_bytes=3000, kept_parts=2)
    cut = {node: _from_a_checkpoint(records, seed) for node, records in traces.items()}
    verdict = verdict_on(model, cut)
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])


def _from_a_checkpoint(records: list[Record], seed: int) -> list[Record]:
    """Return the records from a header on that a checkpoint follows."""
    starts = [
        number
        for number, (first, second) in enumerate(pairwise(records))
        if isinstance(first, Header) and isinstance(second, Checkpoint)
    ]
    return records[starts[seed % len(starts)] :]


Change = Callable[[list[Record]], list[Record] | None]


def _changed(kind: type[Record], change: Callable[[Any], Sequence[Record]], which: int = 0) -> Change:
    """Return what puts other records in the place of one of a kind."""

    def changed(records: list[Record]) -> list[Record] | None:
        found = [number for number, record in enumerate(records) if isinstance(record, kind)]
        if len(found) <= which:
            return None
        at = found[which]
        return [*records[:at], *change(records[at]), *records[at + 1 :]]

    return changed


def _answered(records: list[Record]) -> list[Record] | None:
    """Let a client get a response to what it has given up."""
    given_up = [number for number, record in enumerate(records) if isinstance(record, GiveUp)]
    response = next((record for record in records if isinstance(record, Response)), None)
    if not given_up or response is None:
        return None
    lost = records[given_up[0]]
    assert isinstance(lost, GiveUp)
    late = replace(response, message=lost.message)
    return [*records[: given_up[0] + 1], late, *records[given_up[0] + 1 :]]


MUTATIONS: dict[str, Change] = {
    "given up twice": _changed(GiveUp, lambda record: [record, record]),
    "never asked": _changed(GiveUp, lambda record: [replace(record, message="baker0/Ask0/9999")]),
    "no token": _changed(GiveUp, lambda record: [replace(record, change={})]),
    "another place": _changed(GiveUp, lambda record: [replace(record, place="Ask0")]),
    "another client": _changed(GiveUp, lambda record: [replace(record, client="baker9")]),
    "not given up": _changed(GiveUp, lambda record: []),
    "one more request under way": _changed(
        Request, lambda record: [record, replace(record, message="baker0/Ask0/7777")]
    ),
    "a response to what is given up": _answered,
    "served twice": _changed(Serve, lambda record: [record, record], 1),
    "answered twice": _changed(Reply, lambda record: [record, record], 1),
    "lost by a history with room": _changed(
        Serve,
        lambda record: [
            Drop(
                sequence=record.sequence,
                node=record.node,
                time=record.time,
                channel="Oven",
                queue="request",
                message=getattr(record, "message", None),
            ),
            record,
        ],
    ),
    "lost after it was served": _changed(
        Serve,
        lambda record: [
            record,
            Drop(
                sequence=record.sequence,
                node=record.node,
                time=record.time,
                channel="Oven",
                queue="request",
                message=getattr(record, "message", None),
            ),
        ],
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("name", MUTATIONS)
def test_changed_traces_are_refused(name: str) -> None:
    model = oven(2, 5, outstanding=2, timeout=0.01, tells=True)
    traces = run(model, seed=3)
    assert verdict_on(model, traces).status == "conforms"
    tried = 0
    for node, records in traces.items():
        changed = MUTATIONS[name](records)
        if changed is not None:
            tried += 1
            verdict = verdict_on(model, {**traces, node: changed})
            assert verdict.status == "violated", (node, name)
    assert tried


def test_a_client_without_a_time_out_gives_nothing_up() -> None:
    """Nor has it more requests under way than the model says."""
    model = oven(2, 2, outstanding=2, timeout=0.02, tells=True)
    traces = run(model, seed=1)
    patient = oven(2, 2, outstanding=2, tells=False)
    (first, *_) = verdict_on(patient, traces).violations
    assert "has no time-out" in first.reason or "holds" in first.reason or "no place" in first.reason
    model.channels[0].clients[0].outstanding = 1  # type: ignore[attr-defined]
    assert verdict_on(model, traces).status == "violated"
