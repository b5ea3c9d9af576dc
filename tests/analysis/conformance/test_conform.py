"""Conformance: real behaviours conform, whatever the clocks say; what is not allowed is found and named."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.analysis.conformance import ATTEMPTS, Monitor, Verdict, conform
from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.witness import replay
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import transitions
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load
from dineros.metamodel.records import (
    Drop,
    Fire,
    Publish,
    Record,
    Signal,
    Start,
    Take,
)
from dineros.metamodel.records.schema import Step
from dineros.metamodel.settings import apply
from tests.analysis.conformance.brute_force import TooLargeError, is_behaviour
from tests.analysis.conformance.recording import recorded
from tests.support.references.runs import ReferenceRun
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.chatty_systems import chatty_systems
from tests.support.systems.small_systems import small_system_models
from tests.support.systems.talker import talker

CASE_STUDY = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"
MODELS = st.one_of(small_system_models(), chatty_systems(), calling_systems(circles=True))
SEEDS = st.integers(0, 2**20)
COMMON = settings(deadline=None, suppress_health_check=list(HealthCheck))

Traces = Mapping[str, Sequence[Record]]


def verdict_on(model: sym.SystemModel, traces: Traces, attempts: int = ATTEMPTS) -> Verdict:
    return conform(model, {node: partial(iter, records) for node, records in traces.items()}, attempts)


def without_priorities(model: sym.SystemModel) -> sym.SystemModel:
    for transition in transitions(model):
        transition.overrides.clear()
    return model


def skewed(traces: Traces, seed: int) -> dict[str, list[Record]]:
    """Let each node have a clock of its own: another time, another speed, sometimes backwards."""
    draw = random.Random(seed)
    return {
        node: [
            replace(record, time=draw.uniform(-9, 9) + speed * (record.time or 0))
            for speed in [draw.choice([1, 0.1, 7, -1])]
            for record in records
        ]
        for node, records in traces.items()
    }


@pytest.mark.long
@given(MODELS, SEEDS, st.integers(5, 80))
@settings(COMMON, max_examples=15)
def test_behaviours_conform(model: sym.SystemModel, seed: int, steps: int) -> None:
    run = ReferenceRun(without_priorities(model), seed).run(steps).stop()
    traces = skewed(run.records, seed)
    verdict = conform(model, {node: partial(iter, trace) for node, trace in traces.items()}, firings=True)
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])
    # The sequence that was found is one of the plain firing rule.
    subject = subject_of(model, "fully-enabled")
    replay(subject.net, [subject.transition_index[name] for name in verdict.sequence])
    monitor, draw = Monitor(model), random.Random(seed)
    for node in draw.sample(run.nodes, len(run.nodes)):
        assert monitor.add(traces[node]) == []
    live = monitor.finish()
    assert live.status in ("conforms", "unknown")
    assert not any(not isinstance(deviation.record, Drop) for deviation in live.unknown)


def mutated(traces: Traces, draw: random.Random) -> dict[str, list[Record]] | None:
    """Remove a step, do it twice, or swap it with the next one of its node."""
    changed = {node: list(records) for node, records in traces.items()}
    node = draw.choice(sorted(changed))
    steps = [number for number, record in enumerate(changed[node]) if isinstance(record, Step)]
    if not steps:
        return None
    number = draw.choice(steps)
    match draw.choice(["remove", "repeat", "swap"]):
        case "remove":
            del changed[node][number]
        case "repeat":
            changed[node].insert(number, changed[node][number])
        case "swap" if number + 1 in steps:
            pair = changed[node][number : number + 2]
            changed[node][number : number + 2] = pair[::-1]
    return changed


@pytest.mark.long
@given(MODELS, SEEDS, st.integers(5, 40))
@settings(COMMON, max_examples=12)
def test_mutated_traces_against_all_orders(model: sym.SystemModel, seed: int, steps: int) -> None:
    run = ReferenceRun(without_priorities(model), seed).run(steps).stop()
    draw = random.Random(seed)
    for _ in range(3):
        traces = mutated(run.records, draw)
        if traces is None:
            continue
        verdict = verdict_on(model, skewed(traces, seed))
        try:
            allowed = is_behaviour(model, traces, limit=5000)
        except TooLargeError:
            continue
        assert verdict.status == "unknown" or (verdict.status == "conforms") == allowed, verdict


def case_study(*changes: str) -> sym.SystemModel:
    model = load(CASE_STUDY)
    assert isinstance(model, sym.SystemModel)
    for change in changes:
        apply(model, change)
    return model


class TestTheEngine:
    """Traces that the runtime records."""

    def test_the_case_study_conforms(self) -> None:
        model = case_study("RedObjects.tokens=3")
        traces = recorded(model, 4, 3000)
        verdict = verdict_on(model, skewed(traces, 4))
        assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])
        assert verdict.steps > 300
        assert verdict.silent > 10

    @pytest.mark.long
    @given(st.one_of(chatty_systems(), calling_systems(circles=True)), SEEDS)
    @settings(COMMON, max_examples=20)
    def test_small_queues_and_calls(self, model: sym.SystemModel, seed: int) -> None:
        verdict = verdict_on(model, recorded(model, seed, 120))
        assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])

    def test_another_model_than_was_run(self) -> None:
        traces = recorded(case_study(), 4, 500)
        verdict = verdict_on(case_study("RedObjects.tokens=2"), traces)
        assert verdict.status == "violated"
        assert str(verdict.violations[0]) == "checkpoint: RedObjects holds 1 tokens, in the model 2"
        inverted = verdict_on(case_study("SelectRed.clause=!Red"), traces)
        assert [str(found) for found in inverted.violations] == [
            "SelectRed fires: its clause ICSelectRed is false: Red is true"
        ]


def said(seed: int = 1, steps: int = 60) -> dict[str, list[Record]]:
    """Return a run of the talker in which messages were heard."""
    return ReferenceRun(talker(), seed).run(steps).stop().records


def first(records: Iterable[Record], kind: type[Record], number: int = 0) -> int:
    return [position for position, record in enumerate(records) if isinstance(record, kind)][number]


def edited(node: str, edit: Callable[[list[Record]], object]) -> dict[str, list[Record]]:
    traces = {name: list(records) for name, records in said().items()}
    edit(traces[node])
    return traces


class TestWhatIsNotAllowed:
    def reasons(self, traces: Traces, model: sym.SystemModel | None = None) -> list[str]:
        verdict = verdict_on(model or talker(), traces)
        assert verdict.status == "violated"
        live = Monitor(model or talker())
        told = [deviation for records in traces.values() for deviation in live.add(records)]
        final = live.finish()
        assert final.status == "violated"
        assert all(deviation in final.violations for deviation in told)
        return [str(violation) for violation in verdict.violations]

    def change(
        self, traces: dict[str, list[Record]], node: str, kind: type[Record], **fields: object
    ) -> Traces:
        position = first(traces[node], kind)
        traces[node][position] = replace(traces[node][position], **fields)  # type: ignore[arg-type]
        return traces

    def test_tokens_are_missing(self) -> None:
        traces = edited(
            "listener", lambda records: records.insert(first(records, Fire), records[first(records, Fire)])
        )
        assert self.reasons(traces) == ["Listen fires: Heard holds no token, 1 needed"]

    def test_a_clause_is_false(self) -> None:
        traces = edited("talker", lambda records: records.pop(first(records, Signal)))
        (reason,) = self.reasons(traces)
        assert reason.startswith("Say fires: its clause ")
        assert reason.endswith("is false: Button is false") or "already" in reason

    def test_a_message_is_taken_twice(self) -> None:
        traces = edited(
            "listener", lambda records: records.insert(first(records, Take), records[first(records, Take)])
        )
        assert self.reasons(traces) == [
            "Heard takes talker/Said/1 (Chatter): it has already taken talker/Said/1"
        ]

    def test_a_message_was_never_sent(self) -> None:
        traces = self.change(said(), "listener", Take, message="talker/Said/99")
        assert self.reasons(traces) == [
            "Heard takes talker/Said/99 (Chatter): talker/Said/99 was not published before"
        ]

    def test_a_message_is_from_nowhere(self) -> None:
        traces = self.change(said(), "listener", Take, message="moon/Said/1")
        assert self.reasons(traces) == [
            "Heard takes moon/Said/1 (Chatter): 'moon/Said/1' comes from no publisher of topic channel "
            "'Chatter'"
        ]

    def test_a_message_is_sent_twice(self) -> None:
        traces = said()
        position = first(traces["talker"], Publish, 1)
        traces["talker"][position] = replace(traces["talker"][position], message="talker/Said/1")  # type: ignore[call-arg]
        assert (
            self.reasons(traces)[0] == "Said publishes talker/Said/1 (Chatter): talker/Said/1 was sent before"
        )

    def test_the_change_is_another(self) -> None:
        traces = self.change(said(), "talker", Fire, change={"Words": -1, "Said": 2})
        assert self.reasons(traces) == [
            "Say fires: it changes Words by -1, Said by +2; in the model it changes Words by -1, Said by +1"
        ]

    def test_what_the_model_does_not_have(self) -> None:
        for fields, kind, node, reason in (
            ({"transition": "Shout"}, Fire, "talker", "Shout fires: the model has no such transition"),
            (
                {"transition": "Listen"},
                Fire,
                "talker",
                "Listen fires: the transition belongs to node listener, not talker",
            ),
            (
                {"signal": "Bell"},
                Signal,
                "talker",
                "signal Bell becomes true: node talker has no signal 'Bell'",
            ),
            (
                {"place": "Words"},
                Publish,
                "talker",
                "Words publishes talker/Said/1 (Chatter): "
                "Words is not a publisher of topic channel 'Chatter'",
            ),
        ):
            assert self.reasons(self.change(said(), node, kind, **fields)) == [reason]

    def test_a_start_with_other_tokens(self) -> None:
        traces = self.change(said(), "talker", Start, marking={})
        assert self.reasons(traces) == ["the node starts: Words holds 0 tokens, in the model 3"]

    def test_a_queue_that_was_not_full(self) -> None:
        traces = said()
        lost = Drop(sequence=0, time=0, node="listener", channel="Chatter", queue="subscriber", place="Heard")
        traces["listener"].insert(2, lost)
        assert self.reasons(traces) == [
            "the subscriber queue of Chatter drops 1 message: the subscriber queue of Heard (topic chatter) "
            "was not full: at most 3 messages were under way to its 10"
        ]
        traces = said()
        fields = {"channel": "Chatter", "queue": "publisher", "place": "Said", "token": 0}
        position = first(traces["talker"], Publish)
        lost = Drop(sequence=0, time=0, node="talker", change={"Said": -1}, **fields)  # type: ignore[arg-type]
        traces["talker"][position] = lost
        verdict = verdict_on(talker(), traces)
        assert (
            verdict.violations[0].reason
            == "the publisher queue of Said (topic chatter) was not full (0 of 10)"
        )

    def test_messages_in_a_circle(self) -> None:
        model = sym.SystemModel(id="circle")
        for mine, other in (("a", "b"), ("b", "a")):
            net = sym.NodeNet(id=mine, net=model)
            sent = sym.Place(id=f"sent-{mine}", tokens=1, page=net)
            heard = sym.Place(id=f"heard-{mine}", page=net)
            for id, publisher, subscriber in ((f"from-{mine}", sent, None), (f"from-{other}", None, heard)):
                channel = next((each for each in model.channels if each.id == id), None)
                channel = channel or sym.TopicChannel(id=id, topic=id, model=model)
                assert isinstance(channel, sym.TopicChannel)
                if publisher is not None:
                    channel.publishers.append(sym.PublisherPort(place=publisher))
                if subscriber is not None:
                    channel.subscribers.append(sym.SubscriberPort(place=subscriber))
        run = ReferenceRun(model, 1).run(40).stop()
        assert verdict_on(model, run.records).status == "conforms"
        for records in run.records.values():
            sent_at, heard_at = first(records, Publish), first(records, Take)
            if sent_at < heard_at:
                records[sent_at], records[heard_at] = records[heard_at], records[sent_at]
        reasons = self.reasons(run.records, model)
        assert len(reasons) == 2
        assert "was not published before" in reasons[0]

    def test_the_first_one_is_named_first(self) -> None:
        traces = said()
        for node, kind in (("listener", Fire), ("talker", Fire)):
            self.change(traces, node, kind, transition="Shout")
        verdict = verdict_on(talker(), traces)
        times = [violation.record.time or 0 for violation in verdict.violations]
        assert times == sorted(times)
        assert verdict.violations[0].record.node == "talker"


class TestWhatIsNotKnown:
    def test_a_node_without_a_trace(self) -> None:
        verdict = verdict_on(talker(), {"listener": said()["listener"]})
        assert verdict.status == "unknown"
        assert str(verdict.unknown[0]).endswith("there is no trace of node talker")

    def test_a_trace_that_ends_without_a_stop(self) -> None:
        traces = said()
        traces["talker"] = traces["talker"][: first(traces["talker"], Publish)]
        verdict = verdict_on(talker(), traces)
        assert verdict.status == "unknown"
        assert str(verdict.unknown[0]).endswith("the trace of talker ends without a stop")


class TestLosses:
    """A publisher's full queue needs an order in which nobody has taken messages too early."""

    def model(self) -> sym.SystemModel:
        """Return a model in which two publishers with room for one message each share a slow subscriber."""
        model = sym.SystemModel(id="losses")
        channel = sym.TopicChannel(id="c", topic="/c", model=model)
        for name in ("p", "q"):
            net = sym.NodeNet(id=name, net=model)
            sent = sym.Place(id=f"sent-{name}", tokens=2, page=net)
            channel.publishers.append(sym.PublisherPort(place=sent, limit=1))
        heard = sym.Place(id="heard", page=sym.NodeNet(id="s", net=model))
        channel.subscribers.append(sym.SubscriberPort(place=heard))
        return model

    def traces(self) -> dict[str, list[Record]]:
        run = ReferenceRun(self.model(), 0)
        topic = run.topics[0]
        for place in ("sent-p", "sent-q"):
            topic._publish(place, topic.publishers[place])
            topic._publish(place, topic.publishers[place])  # lost
        run.run(60)
        return run.stop().records

    def test_takes_with_early_clocks(self) -> None:
        traces = self.traces()
        assert sum(isinstance(record, Drop) for records in traces.values() for record in records) == 2
        early = {
            node: [replace(r, time=0.0 if node == "s" else r.time) for r in t] for node, t in traces.items()
        }
        assert verdict_on(self.model(), early).status == "conforms"

    def test_losses_told_after_the_publication(self) -> None:
        traces = self.traces()
        for node in ("p", "q"):
            position = first(traces[node], Drop)
            drop = traces[node][position]
            assert isinstance(drop, Drop)
            message = f"{node}/{drop.place}/2"
            fields = {"sequence": 0, "time": drop.time, "node": node, "channel": "c", "place": drop.place}
            published = Publish(**fields, token=drop.token, message=message, change=drop.change)  # type: ignore[arg-type]
            traces[node][position : position + 1] = [published, replace(drop, change={})]
        assert verdict_on(self.model(), traces).status == "conforms"
        monitor = Monitor(self.model())
        for node in ("p", "q", "s"):
            for record in traces[node]:
                assert monitor.add([record]) == []
        assert monitor.finish().status == "conforms"

    def test_losses_of_a_node_that_has_lost_others_messages(self) -> None:
        """What must come before the loss has a loss itself, for which other nodes must have done more."""
        model = sym.SystemModel(id="both")
        nets = {name: sym.NodeNet(id=name, net=model) for name in "pns"}
        for number, (sender, receiver) in enumerate([("p", "n"), ("n", "s")]):
            sent = sym.Place(id=f"sent-{sender}", tokens=2, page=nets[sender])
            sym.TopicChannel(
                id=f"t{number}",
                topic=f"/t{number}",
                publishers=[sym.PublisherPort(place=sent, limit=2 - number)],
                subscribers=[sym.SubscriberPort(place=sym.Place(id=f"got-{receiver}", page=nets[receiver]))],
                dispatchers=[sym.Dispatcher(node=nets[receiver], limit=1)],
                model=model,
            )
        run = ReferenceRun(model, 0)
        first_topic, second_topic = run.topics
        (sending,), (receiving,) = first_topic.publishers.values(), first_topic.dispatchers.values()
        for _ in range(2):
            first_topic._publish("sent-p", sending)
            first_topic.under_way.append(sending.load.pop())
            first_topic._deliver()
            first_topic._enter(receiving, "n", "dispatcher", None)  # the second one is lost
        for _ in range(2):
            second_topic._publish("sent-n", second_topic.publishers["sent-n"])  # here, too
        traces = run.run(60).stop().records
        assert sum(isinstance(record, Drop) for record in traces["n"]) == 2
        traces["s"] = [replace(record, time=0.0) for record in traces["s"]]
        verdict = verdict_on(model, traces)
        assert verdict.status == "conforms", verdict

    def test_more_losses_than_there_can_be(self) -> None:
        traces = self.traces()
        position = first(traces["p"], Publish)
        traces["p"][position], traces["p"][position + 1] = traces["p"][position + 1], traces["p"][position]
        verdict = verdict_on(self.model(), traces)
        assert verdict.status == "violated"
        assert "was not full (0 of 1)" in verdict.violations[0].reason

    def test_the_number_of_orders_is_limited(self) -> None:
        verdict = verdict_on(self.model(), self.traces(), attempts=1)
        assert verdict.status in ("conforms", "unknown")


def test_a_server_that_no_client_of_the_model_asks() -> None:
    """The net leaves its page out; the node has it, for programs that are not in the model."""
    model = sym.SystemModel(id="unasked")
    node = sym.NodeNet(id="server", net=model)
    page = sym.CallbackPage(id="Serving", kind="server", page=node)
    entry, stock, exit_ = (sym.Place(id=id, page=page) for id in ("Asked", "Stock", "Answered"))
    stock.tokens = 2
    flow(entry, sym.Transition(id="Serve", page=page), exit_)
    service = sym.ServiceChannel(id="Help", service="/help", model=model)
    service.server = sym.ServerPort(entry=entry, exit=exit_, page=page)
    traces = recorded(model, seed=1, steps=10)
    assert "Help[1].Stock" in traces["server"][1].marking  # type: ignore[attr-defined]
    assert verdict_on(model, traces).status == "conforms"


def test_the_monitor_waits_for_messages() -> None:
    traces, monitor = said(), Monitor(talker())
    monitor.add(traces["listener"])
    assert isinstance(monitor.waiting["listener"], Take)
    monitor.add(traces["talker"])
    assert monitor.waiting == {}
    assert monitor.steps == sum(isinstance(record, Step) for trace in traces.values() for record in trace)
    assert monitor.finish().status == "conforms"


def test_the_monitor_tells_at_once() -> None:
    traces = edited("talker", lambda records: records.insert(2, records[first(records, Fire)]))
    monitor, told = Monitor(talker()), []
    for record in traces["talker"]:
        found = monitor.add([record])
        told += [(record.sequence, str(deviation)) for deviation in found]
    assert len(told) == 1
    assert told[0][1].startswith("Say fires: its clause ")
    assert monitor.finish().status == "violated"


class TestWrongUse:
    def test_a_trace_of_an_unknown_node(self) -> None:
        with pytest.raises(DinerosError, match="the model has no node net 'moon'"):
            verdict_on(talker(), {"moon": []})
        with pytest.raises(DinerosError, match="the model has no node net 'moon'"):
            Monitor(talker()).add([Start(sequence=0, node="moon")])

    def test_a_trace_of_another_model(self) -> None:
        traces = edited("talker", lambda records: records.__setitem__(0, replace(records[0], model="other")))  # type: ignore[call-arg]
        with pytest.raises(DinerosError, match="is a trace of model 'other', not of 'greeting'"):
            verdict_on(talker(), traces)

    def test_a_trace_that_begins_in_the_middle(self) -> None:
        traces = said()
        traces["talker"] = traces["talker"][2:]
        with pytest.raises(DinerosError, match=r"begins with record 2 \(also give the earlier parts"):
            verdict_on(talker(), traces)

    def test_records_of_two_nodes_in_one_trace(self) -> None:
        traces = said()
        traces["talker"].append(traces["listener"][-1])
        with pytest.raises(DinerosError, match="a record of node 'listener' in the trace of node 'talker'"):
            verdict_on(talker(), traces)
