"""Runs under the rules of ROS 2: what nodes record is a behaviour of the net; what it forbids is found."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.analysis.conformance import Monitor, Verdict, conform
from dineros.analysis.conformance.verdict import Deviation
from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.witness import replay
from dineros.metamodel import sym
from dineros.metamodel.elements import node_nets, transitions
from dineros.metamodel.records import Drop, Fire, Record, Response, Take, read_trace, traces_of_runs
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.split import split
from tests.analysis.conformance.brute_force import TooLargeError, is_behaviour
from tests.analysis.conformance.recording import recorded
from tests.analysis.conformance.test_conform import mutated
from tests.histories.test_figures import periodic
from tests.support.ros2_systems.executor_cases import Case, case_model
from tests.support.ros2_systems.history_models import history_models
from tests.support.ros2_systems.shared_histories import shared_histories
from tests.support.systems.chatty_systems import chatty_systems

COMMON = settings(deadline=None, suppress_health_check=list(HealthCheck))
MODELS = st.one_of(history_models(chatty_systems()), history_models())
SEEDS = st.integers(0, 2**20)
Traces = Mapping[str, Sequence[Record]]


def verdict_on(model: sym.SystemModel, traces: Traces, firings: bool = False) -> Verdict:
    return conform(model, {node: partial(iter, records) for node, records in traces.items()}, firings=firings)


def skewed(traces: Traces, seed: int) -> dict[str, list[Record]]:
    """Let each node have a clock of its own."""
    draw = random.Random(seed)
    return {
        node: [replace(record, time=shift + speed * (record.time or 0)) for record in records]
        for node, records in traces.items()
        for shift, speed in [(draw.uniform(-9, 9), draw.choice([1, 1, 0.1, 7, -1]))]
    }


def small(model: sym.SystemModel, draw: random.Random) -> sym.SystemModel:
    """Let histories be so shallow that they lose messages."""
    for channel in model.channels:
        if isinstance(channel, sym.TopicChannel):
            for port in (*channel.publishers, *channel.subscribers):
                port.limit = draw.choice([1, 1, 2, 3])
    for transition in transitions(model):
        transition.overrides.clear()
    return model


def monitored(model: sym.SystemModel, traces: Traces, seed: int) -> Verdict:
    """Return what a monitor says to whom records come in pieces, each node's in their order."""
    monitor, draw = Monitor(model), random.Random(seed)
    rest = {node: list(records) for node, records in traces.items()}
    while any(rest.values()):
        node = draw.choice([node for node, records in rest.items() if records])
        size = draw.randint(1, 20)
        assert monitor.add(rest[node][:size]) == []
        del rest[node][:size]
    verdict = monitor.finish()
    assert monitor.waiting == {}
    return verdict


def may_be_told_late(model: sym.SystemModel, found: Sequence[Deviation]) -> bool:
    """Tell whether all that is found are losses of histories that several publishers fill."""
    topics = {channel.id: channel for channel in model.channels if isinstance(channel, sym.TopicChannel)}
    return all(isinstance(each.record, Drop) for each in found) and all(
        len(topics[each.record.channel].publishers) > 1 for each in found if isinstance(each.record, Drop)
    )


@pytest.mark.long
@given(MODELS, SEEDS)
@settings(COMMON, max_examples=15)
def test_runs_conform(model: sym.SystemModel, seed: int) -> None:
    model = small(model, random.Random(seed))
    traces = skewed(recorded(model, seed, 150), seed)
    verdict = verdict_on(model, traces, firings=True)
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])
    subject = subject_of(model, "fully-enabled")
    replay(subject.net, [subject.transition_index[name] for name in verdict.sequence])
    live = monitored(model, traces, seed)
    assert (live.violations, may_be_told_late(model, live.unknown)) == ([], True)


@pytest.mark.long
def test_losses_of_histories_that_several_publishers_fill() -> None:
    """They are told after what came later was taken: `conform` knows better, the monitor does not always."""
    unknown, losses = [], 0
    for seed in (*range(40), 438):  # there, two loggers, of which one ends without having heard one talker
        model = shared_histories(random.Random(seed))
        traces = skewed(recorded(model, seed, 120), seed)
        losses += sum(isinstance(record, Drop) for records in traces.values() for record in records)
        verdict = verdict_on(model, traces)
        assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], []), seed
        live = monitored(model, traces, seed)
        assert (live.violations, may_be_told_late(model, live.unknown)) == ([], True), seed
        unknown += live.unknown
    assert losses > 40
    assert len(unknown) < losses / 4


@pytest.mark.long
def test_losses_of_messages_without_ids() -> None:
    """A message of an installed interface does not say which one it is: orders are drawn until one fits."""
    losses = 0
    for seed in (*range(20), 38, 84, 88):
        model = shared_histories(random.Random(seed))
        traces = {
            node: [replace(record, message="") if isinstance(record, Take) else record for record in records]
            for node, records in skewed(recorded(model, seed, 120), seed).items()
        }
        losses += sum(isinstance(record, Drop) for records in traces.values() for record in records)
        verdict = verdict_on(model, traces)
        assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], []), seed
        live = monitored(model, traces, seed)
        assert live.violations == [], seed
        assert all(isinstance(found.record, Drop) for found in live.unknown), seed
    assert losses > 20


def test_more_losses_of_messages_without_ids_than_were_sent() -> None:
    model = periodic(1)
    traces = recorded(model, 3, 300)
    for records in traces.values():
        records[:] = [
            replace(each, message="") if isinstance(each, Take)
            else replace(each, count=1000) if isinstance(each, Drop)
            else each
            for each in records
        ]  # fmt: skip
    verdict = verdict_on(model, traces)
    assert verdict.status == "violated"
    assert "has lost 1000" in verdict.violations[0].reason


def test_what_runs_of_nodes_written_by_hand_is_their_net(tmp_path: Path) -> None:
    """There no callback waits: the timer's continues where on an executor it would wait forever."""
    model = case_model(Case())
    with LocalApplication(split(model), seed=1, recorder=partial(JournalRecorder, tmp_path)) as application:
        application.run(lambda _: False, timeout=1.0)
    traces = {node: list(read_trace(parts)) for node, parts in traces_of_runs([tmp_path]).items()}
    assert sum(isinstance(record, Response) for record in traces["A"]) > 1
    assert verdict_on(model, traces).status == "conforms"
    assert [node.execution for node in node_nets(model)] == [sym.Execution.callbacks] * 2


def is_about_losses(found: Deviation, traces: Traces) -> bool:
    """Tell whether a loss is not explained, or what was taken after one from the same history.

    A trace says how many messages of a publisher are missing before the next one of it that is taken, which
    the search through all orders, where messages have no ids, does not know.
    """
    record = found.record
    if isinstance(record, Drop) or "lost" in found.reason:
        return True
    losses = {(each.place, each.sequence) for each in traces[record.node or ""] if isinstance(each, Drop)}
    return isinstance(record, Take) and any(
        place == record.place and sequence < record.sequence for place, sequence in losses
    )


@pytest.mark.long
@given(MODELS, SEEDS)
@settings(COMMON, max_examples=9)
def test_mutated_traces_against_all_orders(model: sym.SystemModel, seed: int) -> None:
    """What no order of the net allows is never said to conform; what one does, only for what was lost."""
    draw = random.Random(seed)
    model = small(model, draw)
    run = recorded(model, seed, 40)
    for _ in range(3):
        traces = mutated(run, draw)
        if traces is None:
            continue
        verdict = verdict_on(model, skewed(traces, seed))
        try:
            allowed = is_behaviour(model, traces, limit=5000)
        except TooLargeError:
            continue
        if not allowed:
            assert verdict.status != "conforms"
        elif verdict.status == "violated":
            # A loss of what was never sent; what else is told waits for the node that tells it.
            told = [found for found in verdict.violations if not is_about_losses(found, traces)]
            assert len(told) < len(verdict.violations), verdict
            assert all(found.reason.endswith(" before") for found in told), verdict


class TestWhatIsNotAllowed:
    """Runs of a publisher that sends at any time, and of a logger, with something made up."""

    def edited(self, edit: Callable[[list[Record]], object]) -> tuple[str, list[str]]:
        model = periodic(2)
        traces = recorded(model, 3, 300)
        edit(traces["logger"])
        verdict = verdict_on(model, traces)
        return verdict.status, [found.reason for found in verdict.violations]

    def test_it_is_a_run_with_losses(self) -> None:
        seen: Counter[type[Record]] = Counter()
        assert self.edited(lambda records: seen.update(map(type, records))) == ("conforms", [])
        assert seen[Drop] > 5
        assert seen[Take] > 20

    def test_more_is_in_hand_than_may_be(self) -> None:
        def take_too_early(records: list[Record]) -> None:
            takes = [number for number, record in enumerate(records) if isinstance(record, Take)]
            at = next(n for n in takes[5:] if isinstance(records[n - 1], Fire) and n - 2 in takes)
            records[at - 1], records[at] = records[at], records[at - 1]

        assert self.edited(take_too_early) == (
            "violated",
            ["free room at Heard holds no token, 1 needed"],
        )

    def test_more_is_lost_than_was_there(self) -> None:
        def lose_more(records: list[Record]) -> None:
            at = next(number for number, record in enumerate(records) if isinstance(record, Drop))
            records[at] = replace(records[at], count=10_000)  # type: ignore[call-arg]

        status, reasons = self.edited(lose_more)
        assert status == "violated"
        assert "has lost 10000, at most" in reasons[0]

    def test_a_loss_is_not_told(self) -> None:
        def tell_nothing(records: list[Record]) -> None:
            records[:] = [record for record in records if not isinstance(record, Drop)]

        status, reasons = self.edited(tell_nothing)
        assert status == "violated"
        assert "lost, and no full queue dropped it" in reasons[0]
