"""Server pages that call and publish: an answer comes back to the instance that asked, also after a crash."""

from __future__ import annotations

import random
from functools import partial
from pathlib import Path

import pytest

from dineros.analysis.conformance import conform
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.records import Publish, Request, Response, Take, read_trace, traces_of_runs
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder, resume_journal
from dineros.runtime.nets.structure import read_structure
from dineros.transformations.flattening.split import split
from tests.support.systems.bakery import bakery, shared

NODES = ("ann", "bob", "shop", "oven", "board", "printer")


def got(application: LocalApplication) -> dict[str, set[object]]:
    """Return the labels of what each customer got, and of what was printed."""
    nets = application.nets
    found = {name: nets[name].inspect().marking[f"Got{name}"] for name in ("ann", "bob")}
    found["board"] = nets["board"].inspect().marking["Printed"]
    return {name: {token.data["label"] for token in tokens} for name, tokens in found.items()}


OWN = {
    "ann": {"ann1", "ann2"},
    "bob": {"bob1", "bob2"},
    "board": {"ann1", "ann2", "bob1", "bob2"},
}


def to_the_end(application: LocalApplication) -> None:
    for _ in range(1000):
        if not application.step():
            break


@pytest.mark.parametrize("instances", [None, 1, 3])
def test_everyone_gets_an_answer_of_their_own(instances: int | None) -> None:
    assert validate(bakery(instances)) == []
    for seed in range(8):
        application = LocalApplication(split(bakery(instances)), seed=seed)
        application.open()
        to_the_end(application)
        assert got(application) == OWN
        application.close()


def test_a_client_that_instances_share_mixes_answers_up_and_is_warned_of() -> None:
    (warning,) = validate(shared(bakery()))
    assert warning.constraint == "client-not-shared-by-instances"
    results = []
    for seed in range(8):
        application = LocalApplication(split(shared(bakery())), seed=seed)
        application.open()
        to_the_end(application)
        results.append(got(application))
        application.close()
    assert any(result != OWN for result in results)


def test_each_instance_is_a_client_and_they_share_a_publisher() -> None:
    (part,) = (part for part in split(bakery()) if part.node.id == "shop")
    ports = read_structure(part).ports
    assert [(port.client, port.request, port.response) for port in ports.clients] == [
        ("Order[1].baker", "Order[1].Dough", "Order[1].Baked"),
        ("Order[2].baker", "Order[2].Dough", "Order[2].Baked"),
    ]
    assert [(port.place, port.places) for port in ports.publishers] == [
        ("Told", ("Order[1].Told", "Order[2].Told"))
    ]
    (oven,) = (part for part in split(bakery(3)) if part.node.id == "oven")
    assert read_structure(oven).ports.servers[0].instances == 3


def test_nodes_that_crash_go_on_and_the_records_name_the_instances(tmp_path: Path) -> None:
    draw = random.Random(3)
    application = LocalApplication(split(bakery()), seed=3, recorder=partial(JournalRecorder, tmp_path))
    application.open()
    for seed in range(12):
        for _ in range(draw.randint(3, 12)):
            application.step()
        application.close()
        recorders = {node: resume_journal(tmp_path, node) for node in NODES}
        application = LocalApplication(
            split(bakery()),
            seed=seed,
            recorder=lambda node, found=recorders: found[node][0],  # type: ignore[misc]
            resume={node: state for node, (_, state) in recorders.items() if state is not None},
        )
        application.open()
    to_the_end(application)
    found = got(application)
    application.close()
    assert (found["ann"], found["bob"]) == (OWN["ann"], OWN["bob"])
    traces = traces_of_runs([tmp_path])
    records = [record for parts in traces.values() for record in read_trace(parts)]
    calls = [each for each in records if isinstance(each, Request | Response) and each.channel == "Bake"]
    asked = {(each.client, each.place) for each in calls if isinstance(each, Request)}
    answered = {(each.client, each.place) for each in calls if isinstance(each, Response)}
    assert asked == {(f"Order[{number}].baker", f"Order[{number}].Dough") for number in (1, 2)}
    assert answered == {(f"Order[{number}].baker", f"Order[{number}].Baked") for number in (1, 2)}
    assert {each.place for each in records if isinstance(each, Publish)} <= {"Order[1].Told", "Order[2].Told"}
    verdict = conform(bakery(), {node: partial(read_trace, parts) for node, parts in traces.items()})
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])


def test_what_is_lost_between_two_instances_does_not_come_again(tmp_path: Path) -> None:
    """The board hears the last message only: one of the other instance before it is lost, and stays so."""
    model = bakery()
    model.middleware = "ros2"
    (news,) = (channel for channel in model.channels if channel.id == "Sales")
    assert isinstance(news, sym.TopicChannel)
    news.publishers[0].limit = 4
    news.subscribers[0].limit, news.subscribers[0].inHand = 1, 1
    lost: set[tuple[str, int]] = set()
    for seed in range(6):
        folder = tmp_path / str(seed)
        for _ in range(2):
            found = {node: resume_journal(folder, node) for node in NODES}
            application = LocalApplication(
                split(model),
                seed=seed,
                recorder=lambda node, found=found: found[node][0],  # type: ignore[misc]
                resume={node: state for node, (_, state) in found.items() if state is not None},
            )
            application.open()
            to_the_end(application)
            application.close()
        parts = traces_of_runs([folder])
        records = [record for each in parts.values() for record in read_trace(each)]
        ids = {each.message for each in records if isinstance(each, Publish)}
        assert ids == {f"shop/Told/{number}" for number in range(1, 5)}, "the instances count together"
        heard = [each.message for each in records if isinstance(each, Take)]
        lost |= {(str(seed), len(ids) - len(heard))}
        assert len(set(heard)) == len(heard)
        verdict = conform(model, {node: partial(read_trace, each) for node, each in parts.items()})
        assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])
    assert any(count for _, count in lost)
