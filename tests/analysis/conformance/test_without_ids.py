"""Conformance where messages have no ids: existing message types, programs outside of the model."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.analysis.conformance import ATTEMPTS, Monitor, Verdict, conform
from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.witness import replay
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import transitions
from dineros.metamodel.records import Fire, Record, Reply, Request, Response, Serve, Stop, Take
from dineros.metamodel.records.schema import Step
from tests.analysis.conformance.brute_force import TooLargeError, is_behaviour
from tests.support.references.runs import ReferenceRun
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.chatty_systems import chatty_systems
from tests.support.systems.small_systems import small_system_models
from tests.support.systems.talker import talker

COMMON = settings(deadline=None, suppress_health_check=list(HealthCheck))
SEEDS = st.integers(0, 2**20)

Traces = Mapping[str, Sequence[Record]]


def verdict_on(model: sym.SystemModel, traces: Traces, attempts: int = ATTEMPTS) -> Verdict:
    return conform(
        model, {node: partial(iter, records) for node, records in traces.items()}, attempts, firings=True
    )


def without_ids(traces: Traces) -> dict[str, list[Record]]:
    """Let those who receive a message, and servers, not know its id: as the runtime records it."""
    return {
        node: [
            replace(record, message="") if isinstance(record, (Take, Serve, Reply)) else record
            for record in records
        ]
        for node, records in traces.items()
    }


def skewed(traces: Traces, seed: int) -> dict[str, list[Record]]:
    draw = random.Random(seed)
    return {
        node: [replace(record, time=start + speed * (record.time or 0)) for record in records]
        for node, records in traces.items()
        for start, speed in [(draw.uniform(-9, 9), draw.choice([1, 0.1, 7]))]
    }


@st.composite
def busy_services(draw: st.DrawFn) -> sym.SystemModel:
    """Return a system of clients that ask again and again, and whose answers let others ask."""
    count = draw(st.integers(1, 3))
    model = sym.SystemModel(id="busy")
    serving = sym.NodeNet(id="serving", net=model)
    page = sym.CallbackPage(id="server", page=serving)
    entry, work, exit_ = sym.Place(id="entry"), sym.Transition(id="work"), sym.Place(id="exit")
    page.objects.extend([entry, work, exit_])
    flow(entry, work, exit_)
    service = sym.ServiceChannel(
        id="S",
        service="/s",
        type="std_srvs/srv/Trigger",
        server=sym.ServerPort(page=page, entry=entry, exit=exit_),
        instances=draw(st.sampled_from([None, 1, 2])),
        model=model,
    )
    told = sym.TopicChannel(id="told", topic="/told", type="std_msgs/msg/String", model=model)
    for number in range(count):
        net = sym.NodeNet(id=f"c{number}", net=model)
        todo = sym.Place(id=f"todo{number}", tokens=draw(st.integers(0 if number else 1, 2)), page=net)
        ask, asked, got = (sym.Place(id=f"{name}{number}", page=net) for name in ("ask", "asked", "got"))
        flow(todo, sym.Transition(id=f"begin{number}", page=net), ask)
        service.clients.append(sym.ClientPort(client=f"c{number}", request=ask, response=got))
        flow(got, sym.Transition(id=f"end{number}", page=net), asked)
        if draw(st.booleans()):
            told.publishers.append(sym.PublisherPort(place=asked))
        elif draw(st.booleans()):
            told.subscribers.append(sym.SubscriberPort(place=todo))
    return model


def check_sequence(model: sym.SystemModel, verdict: Verdict) -> None:
    """Replay what was found by the plain firing rule."""
    subject = subject_of(model, "fully-enabled")
    replay(subject.net, [subject.transition_index[name] for name in verdict.sequence])


@pytest.mark.long
@given(busy_services(), SEEDS, st.integers(5, 150))
@settings(COMMON, max_examples=15)
def test_calls_are_never_refused(model: sym.SystemModel, seed: int, steps: int) -> None:
    traces = skewed(without_ids(ReferenceRun(model, seed).run(steps).stop().records), seed)
    verdict = verdict_on(model, traces)
    assert verdict.violations == []
    service = model.channels[0]
    assert isinstance(service, sym.ServiceChannel)
    if len(service.clients) == 1:
        assert verdict.status == "conforms"
    if verdict.status == "conforms":
        check_sequence(model, verdict)
    monitor, draw = Monitor(model), random.Random(seed)
    for node in draw.sample(sorted(traces), len(traces)):
        assert monitor.add(traces[node]) == []
    assert monitor.finish().violations == []


@pytest.mark.long
@given(
    st.one_of(small_system_models(clients=2), chatty_systems(), calling_systems()), SEEDS, st.integers(5, 80)
)
@settings(COMMON, max_examples=15)
def test_behaviours_are_never_refused(model: sym.SystemModel, seed: int, steps: int) -> None:
    for transition in transitions(model):
        transition.overrides.clear()
    traces = skewed(without_ids(ReferenceRun(model, seed).run(steps).stop().records), seed)
    verdict = verdict_on(model, traces)
    assert verdict.status != "violated", verdict
    assert verdict.violations == []
    if verdict.status == "conforms":
        check_sequence(model, verdict)


@pytest.mark.long
@given(busy_services(), SEEDS, st.integers(5, 30))
@settings(COMMON, max_examples=12)
def test_mutated_traces_against_all_orders(model: sym.SystemModel, seed: int, steps: int) -> None:
    run = ReferenceRun(model, seed).run(steps).stop()
    draw = random.Random(seed)
    for _ in range(3):
        traces = {node: list(records) for node, records in run.records.items()}
        node = draw.choice(sorted(traces))
        numbers = [number for number, record in enumerate(traces[node]) if isinstance(record, Step)]
        if not numbers:
            continue
        number = draw.choice(numbers)
        if draw.random() < 0.5:
            del traces[node][number]
        else:
            pair = traces[node][number : number + 2]
            traces[node][number : number + 2] = pair[::-1] if number + 1 in numbers else pair[:1] * 2
        found = skewed(without_ids(traces), seed)
        try:
            allowed = is_behaviour(model, found, limit=5000)
        except TooLargeError:
            continue
        verdict = verdict_on(model, found)
        assert verdict.status == "unknown" or (verdict.status == "conforms") == allowed, verdict


def charging(clients: int = 2, instances: int | None = None) -> sym.SystemModel:
    """Return robots a, b, ... that ask a charger, which tells nobody whose request it serves."""
    model = sym.SystemModel(id="charging")
    charger = sym.NodeNet(id="charger", net=model)
    entry, charge, exit_ = sym.Place(id="In"), sym.Transition(id="Charge"), sym.Place(id="Out")
    page = sym.CallbackPage(id="OnCharge", objects=[entry, charge, exit_], page=charger)
    flow(entry, charge, exit_)
    service = sym.ServiceChannel(
        id="Power",
        service="/power",
        type="std_srvs/srv/Trigger",
        server=sym.ServerPort(page=page, entry=entry, exit=exit_),
        instances=instances,
        model=model,
    )
    for name in "abc"[:clients]:
        net = sym.NodeNet(id=name, net=model)
        empty, full = (
            sym.Place(id=f"Empty-{name}", tokens=2, page=net),
            sym.Place(id=f"Full-{name}", page=net),
        )
        service.clients.append(sym.ClientPort(client=name, request=empty, response=full))
    return model


class Handmade:
    """Traces written by hand: one line per step, in the order of the clocks."""

    def __init__(self, model: sym.SystemModel) -> None:
        self.model = model
        run = ReferenceRun(model, 0)
        self.records: dict[str, list[Record]] = run.records
        self.clock = run.clock
        self.number: dict[str, int] = {}

    def add(self, node: str, kind: type[Record], **fields: object) -> None:
        self.clock += 1
        records = self.records[node]
        records.append(kind(sequence=len(records), time=self.clock, node=node, **fields))  # type: ignore[arg-type]

    def ask(self, name: str) -> None:
        self.number[name] = self.number.get(name, 0) + 1
        place = f"Empty-{name}"
        message = f"{name}/{place}/{self.number[name]}"
        fields = {"channel": "Power", "client": name, "message": message, "place": place}
        self.add(name, Request, **fields, change={place: -1})

    def get(self, name: str) -> None:
        place = f"Full-{name}"
        message = f"{name}/Empty-{name}/{self.number[name]}"
        fields = {"channel": "Power", "client": name, "message": message, "place": place}
        self.add(name, Response, **fields, change={place: 1})

    def serve(self, instance: int) -> None:
        place = f"Power[{instance}].In"
        fields = {"channel": "Power", "instance": instance, "message": "", "place": place}
        self.add("charger", Serve, **fields, change={place: 1})

    def reply(self, instance: int) -> None:
        before, place = f"Power[{instance}].In", f"Power[{instance}].Out"
        transition = f"Power[{instance}].Charge"
        self.add("charger", Fire, transition=transition, change={before: -1, place: 1})
        fields = {"channel": "Power", "instance": instance, "message": "", "place": place}
        self.add("charger", Reply, **fields, change={place: -1})

    def verdict(self, *left_out: str) -> Verdict:
        for node in self.records:
            self.add(node, Stop)
        traces = {node: records for node, records in self.records.items() if node not in left_out}
        return verdict_on(self.model, traces)


class TestCalls:
    def test_the_responses_tell_whose_calls_they_were(self) -> None:
        run = Handmade(charging())
        run.ask("a")
        run.ask("b")
        run.serve(1)
        run.serve(2)
        run.reply(1)
        run.get("b")
        run.reply(2)
        run.get("a")
        verdict = run.verdict()
        assert verdict.status == "conforms"
        check_sequence(run.model, verdict)
        calls = [step for step in verdict.sequence if ".call[" in step or ".return[" in step]
        assert calls == [
            "Power.client.b.call[1]",
            "Power.client.a.call[2]",
            "Power.client.b.return[1]",
            "Power.client.a.return[2]",
        ]

    def test_clocks_do_not_tell_who_asked_first(self) -> None:
        run = Handmade(charging(instances=1))
        run.ask("a")
        run.serve(1)
        run.reply(1)
        run.ask("b")  # its clock is late: it was served first
        run.get("b")
        run.ask("b")
        run.serve(1)
        run.reply(1)
        run.get("a")
        verdict = run.verdict()
        assert verdict.status == "conforms"
        check_sequence(run.model, verdict)

    def test_what_the_monitor_cannot_take_back(self) -> None:
        run = Handmade(charging(instances=1))
        run.ask("a")
        run.serve(1)
        run.reply(1)
        run.ask("b")
        run.get("b")
        assert run.verdict().status == "conforms"
        monitor = Monitor(run.model)
        for node in ("a", "charger", "b"):  # b's request comes when a is thought to be served
            assert monitor.add(run.records[node]) == []
        (unknown,) = monitor.finish().unknown
        assert str(unknown) == (
            "Full-b gets the response to b/Empty-b/1 (Power): b/Empty-b/1 was not answered before: "
            "the messages have no ids; in another order the step may be allowed"
        )

    @pytest.mark.long
    def test_many_runs_of_three_clients(self) -> None:
        model = charging(3, instances=2)
        for seed in range(40):
            traces = without_ids(ReferenceRun(model, seed).run(60).stop().records)
            verdict = verdict_on(model, skewed(traces, seed))
            assert verdict.status == "conforms", verdict
            assert verdict.steps > 20
            check_sequence(model, verdict)

    @pytest.mark.parametrize("clients", [1, 2])
    def test_a_request_from_outside(self, clients: int) -> None:
        run = Handmade(charging(clients, instances=1))
        run.ask("a")
        for _ in range(2):
            run.serve(1)
            run.reply(1)
        run.get("a")
        verdict = run.verdict()
        assert verdict.status == "violated"
        assert [str(violation) for violation in verdict.violations] == [
            "Power[1].In gets a request (Power): no request of the model waits to be served: a program "
            "outside of the model asks service /power, too, or a request was sent again after a time-out"
        ]

    def test_an_answer_from_outside(self) -> None:
        run = Handmade(charging())
        run.ask("a")
        run.get("a")
        assert [str(violation) for violation in run.verdict().violations] == [
            "Full-a gets the response to a/Empty-a/1 (Power): a/Empty-a/1 was not answered before: a program "
            "outside of the model answers requests of service /power, too"
        ]

    def test_a_server_outside(self) -> None:
        run = Handmade(charging())
        run.ask("a")
        run.get("a")
        verdict = run.verdict("charger")
        assert verdict.status == "unknown"
        assert verdict.unknown[0].reason.endswith("there is no trace of node charger")

    def test_a_reply_to_nobody(self) -> None:
        run = Handmade(charging())
        run.ask("a")
        run.serve(1)
        run.reply(1)
        run.add(
            "charger",
            Reply,
            channel="Power",
            instance=1,
            message="",
            place="Power[1].Out",
            change={"Power[1].Out": -1},
        )
        (violation,) = run.verdict().violations
        assert str(violation) == "Power[1].Out replies (Power): instance 1 serves no request"

    def test_an_instance_that_is_busy(self) -> None:
        run = Handmade(charging())
        run.ask("a")
        run.ask("b")
        run.serve(1)
        run.serve(1)
        (violation,) = run.verdict().violations
        assert "holds no token, 1 needed" in violation.reason

    def test_what_the_model_does_not_have(self) -> None:
        run = Handmade(charging())
        run.serve(7)
        (violation,) = run.verdict().violations
        assert violation.reason == "service channel 'Power' has no such port"
        run = Handmade(charging())
        run.add("charger", Serve, channel="Coffee", place="In", message="")
        (violation,) = run.verdict().violations
        assert violation.reason == "the model has no service channel 'Coffee'"
        run = Handmade(charging())
        run.add("a", Response, channel="Coffee", client="a", place="Full-a", message="")
        (violation,) = run.verdict().violations
        assert violation.reason == "the model has no service channel 'Coffee'"

    def test_ids_on_some_of_the_calls(self) -> None:
        run = Handmade(charging())
        run.ask("a")
        run.ask("b")
        run.serve(1)  # thought to be a's, until a's turns out to be the other one
        run.serve(2)
        served = run.records["charger"]
        served[-1] = replace(served[-1], message="a/Empty-a/1")  # type: ignore[call-arg]
        run.reply(2)
        served[-1] = replace(served[-1], message="a/Empty-a/1")  # type: ignore[call-arg]
        run.get("a")
        run.reply(1)
        run.get("b")
        verdict = run.verdict()
        assert verdict.status == "conforms", verdict
        check_sequence(run.model, verdict)
        assert "Power.client.b.call[1]" in verdict.sequence


class TestTopics:
    def traces(self, taken: int) -> dict[str, list[Record]]:
        """Return a run in which all three messages are taken, and then some more or less."""
        traces = without_ids(ReferenceRun(talker(), 1).run(80).stop().records)
        takes = [record for record in traces["listener"] if isinstance(record, Take)]
        assert len(takes) == 3
        *records, stop = traces["listener"]
        records = [record for record in records if record is not takes[-1] or taken > 2]
        return {**traces, "listener": [*records, *takes[:1] * (taken - 3), stop]}

    def test_takes_count(self) -> None:
        assert verdict_on(talker(), self.traces(3)).status == "conforms"
        assert verdict_on(talker(), skewed(self.traces(3), 3)).status == "conforms"

    def test_a_message_from_outside(self) -> None:
        verdict = verdict_on(talker(), self.traces(4))
        assert [str(violation) for violation in verdict.violations] == [
            "Heard takes a message (Chatter): no message of the model is under way to it: a program outside "
            "of the model also publishes on topic chatter"
        ]
        monitor = Monitor(talker())
        for records in self.traces(4).values():
            assert monitor.add(records) == []  # it may still be published
        assert monitor.finish().violations == verdict.violations

    @pytest.mark.parametrize("place", [0, 1, 2, 3])
    def test_a_message_from_outside_among_those_with_ids(self, place: int) -> None:
        """It is named wherever it comes, also where what is missing then is a message with an id."""
        traces = ReferenceRun(talker(), 1).run(80).stop().records
        takes = [record for record in traces["listener"] if isinstance(record, Take)]
        assert all(take.message for take in takes)
        *records, stop = traces["listener"]
        at = records.index(takes[place]) if place < len(takes) else len(records)
        records.insert(at, replace(takes[0], message=""))
        verdict = verdict_on(talker(), {**traces, "listener": [*records, stop]})
        (violation,) = verdict.violations
        assert violation.reason.endswith("a program outside of the model also publishes on topic chatter")

    def test_a_message_with_a_foreign_id(self) -> None:
        traces = self.traces(3)
        position = next(n for n, record in enumerate(traces["listener"]) if isinstance(record, Take))
        traces["listener"][position] = replace(traces["listener"][position], message="hello")  # type: ignore[call-arg]
        (violation,) = verdict_on(talker(), traces).violations
        assert violation.reason == "'hello' is not a message of the model: another program sent it"

    def test_without_the_trace_of_the_publisher(self) -> None:
        verdict = verdict_on(talker(), {"listener": self.traces(3)["listener"]})
        assert verdict.status == "unknown"
        assert verdict.unknown[0].reason == (
            "no message of the model is under way to it: there is no trace of node talker"
        )
