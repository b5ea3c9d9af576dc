"""Traces of which the older parts are gone; messages that are gone without a record of it."""

from __future__ import annotations

import random
from functools import partial
from pathlib import Path

import pytest

from dineros.analysis.conformance import Monitor, conform
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load
from dineros.metamodel.records import Drop, Record, Take, read_trace, traces_of_runs
from dineros.metamodel.settings import apply
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.split import split
from tests.support.systems.talker import talker

CASE_STUDY = Path(__file__).parents[3] / "case_study" / "sorting.sym.xmi"
Traces = dict[str, list[Record]]


def sorting() -> sym.SystemModel:
    model = load(CASE_STUDY)
    assert isinstance(model, sym.SystemModel)
    for color in ("Red", "Blue", "Green"):
        apply(model, f"{color}Objects.tokens=8")
    return model


def record(model: sym.SystemModel, folder: Path, seed: int, seconds: float) -> None:
    """Write traces in parts, of which the last three stay."""
    recorder = partial(JournalRecorder, part_bytes=8000, kept_parts=2)
    application = LocalApplication(split(model), seed=seed, recorder=lambda node: recorder(folder, node))
    draw = random.Random(seed)
    signals = [(net, name) for net in application.nets.values() for name in net.structure.signals]

    def toggle(_: float) -> None:
        for net, name in signals:
            net.signal(name).set(draw.random() < (0.05 if name == "Danger" else 0.8))

    application.every(0.1, toggle)
    with application:
        application.run(lambda _: False, seconds)


def traces_in(folder: Path) -> Traces:
    return {node: list(read_trace(parts)) for node, parts in traces_of_runs([folder]).items()}


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_traces_that_begin_within_the_run_are_replayed(tmp_path: Path, seed: int) -> None:
    """Each node's begins at another moment: calls and messages are cut at any stage."""
    model = sorting()
    record(model, tmp_path, seed, 6 + seed)
    traces = traces_in(tmp_path)
    began = [trace[0].sequence for trace in traces.values()]
    assert sum(sequence > 0 for sequence in began) >= 3
    for cut in (0, 1, 2):  # and every combination of parts that are gone
        draw = random.Random(cut)
        kept = {
            node: [
                each
                for part in parts[draw.randrange(len(parts)) if cut else 0 :]
                for each in read_trace(part)
            ]
            for node, parts in traces_of_runs([tmp_path]).items()
        }
        verdict = conform(model, {node: partial(iter, trace) for node, trace in kept.items()})
        assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])
        assert verdict.steps > 20
    monitor = Monitor(model)
    assert monitor.add([each for trace in traces.values() for each in trace]) == []
    assert monitor.finish().status == "conforms"


def test_what_is_wrong_is_found_in_them(tmp_path: Path) -> None:
    model = sorting()
    record(model, tmp_path, 1, 6)
    traces = traces_in(tmp_path)
    fires = [number for number, each in enumerate(traces["controller"]) if each.event == "fire"]
    del traces["controller"][fires[0]]
    verdict = conform(model, {node: partial(iter, trace) for node, trace in traces.items()})
    assert verdict.status == "violated"


def talk(folder: Path) -> Traces:
    application = LocalApplication(split(talker()), seed=1, recorder=partial(JournalRecorder, folder))
    with application:
        application.nets["talker"].signal("Button").set(True)
        application.run(lambda each: each.count("listener", "Noted") == 3, timeout=10)
    return traces_in(folder)


def without_take(trace: list[Record], message: str) -> list[Record]:
    """Return a listener's trace as if one message had not come, with all that followed from it."""
    (take,) = (each for each in trace if isinstance(each, Take) and each.message == message)
    gone = [take, next(each for each in trace if each.event == "fire" and each.sequence > take.sequence)]
    return [each for each in trace if each not in gone]


def test_a_message_that_is_lost_without_a_record_is_named(tmp_path: Path) -> None:
    """No token of the model tells it: messages that stay in a queue are allowed, but they come in order."""
    traces = talk(tmp_path)
    traces["listener"] = without_take(traces["listener"], "talker/Said/2")
    verdict = conform(talker(), {node: partial(iter, trace) for node, trace in traces.items()})
    (deviation,) = verdict.violations
    assert deviation.reason == "talker/Said/2 is lost, and no full queue dropped it"
    assert isinstance(deviation.record, Take)
    assert deviation.record.message == "talker/Said/3"


def test_the_last_message_may_be_under_way(tmp_path: Path) -> None:
    traces = talk(tmp_path)
    traces["listener"] = without_take(traces["listener"], "talker/Said/3")
    assert (
        conform(talker(), {node: partial(iter, trace) for node, trace in traces.items()}).status == "conforms"
    )


def test_a_loss_at_a_restart_is_named(tmp_path: Path) -> None:
    traces = talk(tmp_path)
    last = traces["listener"][-1]
    lost = Drop(
        sequence=last.sequence, node="listener", channel="Chatter", queue="restart", place="Heard", count=2
    )
    traces["listener"].insert(-1, lost)
    (deviation,) = conform(
        talker(), {node: partial(iter, trace) for node, trace in traces.items()}
    ).violations
    assert deviation.reason.startswith("the publisher was restarted, and had sent more messages")


def test_parts_without_a_checkpoint_are_refused(tmp_path: Path) -> None:
    traces = talk(tmp_path)
    del traces["talker"][:2]
    with pytest.raises(DinerosError, match="begins with record 2"):
        conform(talker(), {node: partial(iter, trace) for node, trace in traces.items()})


@pytest.mark.long
def test_what_the_dispatcher_loses_is_missed_by_every_subscriber_of_the_node(tmp_path: Path) -> None:
    """One drop of the node explains one missing message at each of its places."""
    pool, say, said = sym.Place(id="Pool", tokens=4), sym.Transition(id="Say"), sym.Place(id="Said")
    speaker = sym.NodeNet(id="speaker", objects=[pool, say, said])
    flow(pool, say, said)
    listener = sym.NodeNet(id="listener")
    chatter = sym.TopicChannel(id="Chatter", topic="/chatter")
    chatter.publishers.append(sym.PublisherPort(place=said, limit=4))
    for name in ("A", "B"):
        heard, hear, noted = (
            sym.Place(id=name),
            sym.Transition(id=f"Hear{name}"),
            sym.Place(id=f"Noted{name}"),
        )
        listener.objects.extend([heard, hear, noted])
        flow(heard, hear, noted)
        chatter.subscribers.append(sym.SubscriberPort(place=heard, limit=4))
    chatter.dispatchers.append(sym.Dispatcher(node=listener, limit=1))
    model = sym.SystemModel(id="model", pages=[speaker, listener], channels=[chatter])
    dropped = 0
    for seed in range(30):
        folder = tmp_path / str(seed)
        application = LocalApplication(split(model), seed=seed, recorder=partial(JournalRecorder, folder))
        with application:
            application.run(lambda _: False, 5.0)
        traces = traces_in(folder)
        dropped += sum(isinstance(record, Drop) for record in traces["listener"])
        verdict = conform(model, {node: partial(iter, trace) for node, trace in traces.items()})
        assert (verdict.status, verdict.violations) == ("conforms", [])
    assert dropped
