"""The trace of a flattening: one link for each element made, found from both sides, saved with the net."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from case_study.build import build
from dineros.metamodel import pn, sym, trace
from dineros.metamodel.calls import instance_counts
from dineros.metamodel.elements import arcs, find, nodes
from dineros.metamodel.errors import UnknownElementError
from dineros.metamodel.files import load, save
from dineros.metamodel.files.xmi import read_xmi
from dineros.transformations.flattening.flatten import KEPT, flatten
from dineros.transformations.flattening.trace_files import save_trace, trace_path
from dineros.transformations.flattening.traces import Link
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.support.systems.bakery import bakery
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.small_systems import small_system_models

VARIANTS = st.tuples(st.sampled_from(get_args(SignalVariant)), st.sampled_from(get_args(OverflowVariant)))


@pytest.mark.long
@given(st.one_of(small_system_models(clients=0), calling_systems(circles=True)), VARIANTS)
@settings(max_examples=25)
def test_every_element_has_one_link_and_is_found_from_both_sides(
    model: sym.SystemModel, variant: tuple[SignalVariant, OverflowVariant]
) -> None:
    flattened = flatten(model, *variant)
    made = {*nodes(flattened.net), *arcs(flattened.net)}

    assert Counter(link.target for link in flattened.trace) == Counter(made)
    inside = {model, *model.eAllContents()}
    for link in flattened.trace:
        assert flattened.trace.origin(link.target) is link
        assert flattened.trace.find(link.target.id) is link
        assert link in flattened.trace.role(link.rule, link.role)
        assert link in flattened.trace.with_role(link.role)
        assert inside.issuperset(link.sources)
        assert all(link in flattened.trace.made_from(source) for source in link.sources)


@pytest.mark.long
@given(st.one_of(small_system_models(), calling_systems(circles=True)), VARIANTS)
@settings(max_examples=20)
def test_what_is_kept_is_linked_to_itself_and_copies_to_their_original(
    model: sym.SystemModel, variant: tuple[SignalVariant, OverflowVariant]
) -> None:
    trace = flatten(model, *variant).trace

    for link in trace:
        if link.rule == KEPT:
            (source,) = link.sources
            assert isinstance(source, pn.Element) and source.id == link.target.id
            assert link.index is None
        elif link.rule == "S4":
            (source,) = link.sources
            assert isinstance(source, pn.Element) and link.target.id.endswith(f"[{link.index}].{source.id}")
    counts = instance_counts(model)
    for service in model.channels:
        if isinstance(service, sym.ServiceChannel):
            count = counts[service]
            for node in service.server.page.objects:
                if isinstance(node, (pn.Place, pn.Transition)):
                    copies = [link for link in trace.made_from(node) if link.rule == "S4"]
                    assert [link.index for link in copies] == list(range(1, count + 1))


def test_parts_of_calls_from_server_pages_name_the_instance() -> None:
    model = bakery()
    trace = flatten(model, "none").trace
    baker = next(each for each in model.channels if each.id == "Bake").clients[0]  # type: ignore[attr-defined]

    requests = [link for link in trace.made_from(baker) if link.role == "t_req"]
    calls = [link for link in trace.made_from(baker) if link.role == "t_call"]
    assert [(link.target.id, link.index, link.client_index) for link in requests] == [
        ("Bake.client.Order[1].baker.req", 1, 1),
        ("Bake.client.Order[2].baker.req", 2, 2),
    ]
    # Which oven bakes for which instance of the shop.
    assert sorted((link.client_index or 0, link.index or 0) for link in calls) == [
        (1, 1),
        (1, 2),
        (2, 1),
        (2, 2),
    ]
    saved = trace.to_model("bakery.sym.xmi", "bakery.pnm")
    assert {(link.clientIndex, link.index) for link in saved.links if link.role == "t_call"} == {
        (None, 1),
        (None, 2),
        (1, 1),
        (1, 2),
        (2, 1),
        (2, 2),
    }


@pytest.fixture(scope="module")
def sorting() -> sym.SystemModel:
    return build()


def ids(links: list[Link]) -> list[str]:
    return [link.target.id for link in links]


def test_roles_of_a_publisher_queue(sorting: sym.SystemModel) -> None:
    trace = flatten(sorting, "none").trace
    topic = find(sorting, "RightCellObjects", sym.TopicChannel)
    (port,) = topic.publishers
    links = {link.role: link for link in trace.made_from(port) if link.rule == "T2"}

    assert {role for role in links if "arcs" not in role} == {
        "queue.load",
        "queue.capacity",
        "queue.enter",
        "queue.leave",
        "queue.drop",
    }
    for link in links.values():
        assert (link.rule, link.index) == ("T2", None)
        assert link.sources == (topic, port, port.place)
        assert link.application == links["queue.load"].application
    assert links["queue.load"].target.id == "RightCellObjects.publisher.SortGreen.Load"
    assert len(links) == 5 + 7


def test_roles_of_calls_with_the_number_of_the_instance(sorting: sym.SystemModel) -> None:
    trace = flatten(sorting, "none").trace
    service = find(sorting, "Pick", sym.ServiceChannel)
    client = service.clients[0]
    calls = [link for link in trace.role("S2", "t_call") if client in link.sources]

    assert [link.index for link in calls] == [1, 2]
    assert calls[0].sources == (
        service,
        client,
        service.server.entry,
        service.server.exit,
    )
    assert ids([link for link in trace.role("S3", "active") if service in link.sources]) == [
        "Pick[1].active",
        "Pick[2].active",
    ]


def test_signal_rules_of_a_copied_transition_lead_to_its_original(sorting: sym.SystemModel) -> None:
    trace = flatten(sorting, "input-enabled").trace
    success = find(sorting, "TPickSuccess", sym.Transition)
    assert success.clause is not None
    first = success.clause.disjunctions[0]
    found = [link for link in trace.role("I1", "true_literals") if first in link.sources]

    assert [link.index for link in found] == [1, 2]
    assert [link.sources for link in found] == [(success, first)] * 2
    signal = find(sorting, "ObjectIsPicked", sym.InputSignal)
    assert ids([link for link in trace.made_from(signal) if link.role == "true"]) == ["ObjectIsPicked.true"]


def test_overflow_rules_lead_to_the_ports_of_their_queues(sorting: sym.SystemModel) -> None:
    for overflow, rule in (("weighted", "T5b"), ("inhibitor", "T5a")):
        trace = flatten(sorting, "none", overflow).trace  # type: ignore[arg-type]
        (port,) = find(sorting, "RightCellObjects", sym.TopicChannel).publishers
        made = [link for link in trace.made_from(port) if link.rule == rule]

        assert {link.target.target.id for link in made if isinstance(link.target, pn.Arc)} >= {
            "RightCellObjects.publisher.SortGreen.drop"
        }


def test_an_unknown_element_names_near_matches(sorting: sym.SystemModel) -> None:
    trace = flatten(sorting, "none").trace

    with pytest.raises(UnknownElementError) as caught:
        trace.find("RightCellObject")

    assert "'RightCellObjects'" in (caught.value.hint or "")


@pytest.mark.long
@pytest.mark.parametrize("suffix", [".pnm", ".pnml"])
def test_saved_and_loaded_again_the_links_lead_into_both_files(tmp_path: Path, suffix: str) -> None:
    source, target = tmp_path / "sorting.sym.xmi", tmp_path / f"net{suffix}"
    save(build(), source)
    model = load(source)
    assert isinstance(model, sym.SystemModel)
    flattened = flatten(model, "io-enabled")
    save(flattened.net, target)
    assert save_trace(flattened.trace, source, target) == trace_path(target)

    loaded = read_xmi(trace_path(target))

    assert isinstance(loaded, trace.TraceModel)
    assert (loaded.source, loaded.target) == (source.name, target.name)
    for link, again in zip(flattened.trace, loaded.links, strict=True):
        assert (link.rule, link.role, link.application, link.index) == (
            again.rule,
            again.role,
            again.application,
            again.index,
        )
        assert isinstance(again.target, pn.Element) and again.target.id == link.target.id
        assert [type(found).__name__ for found in again.sources] == [
            type(found).__name__ for found in link.sources
        ]
        for found, original in zip(again.sources, link.sources, strict=True):
            if isinstance(original, pn.Element):
                assert isinstance(found, pn.Element) and found.id == original.id
