"""What holds for every flattened model: rules add and never change, the certificate, equal state spaces."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from case_study.build import HOME, build
from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import arcs, find, nodes, pages, places, resolve, transitions
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.xmi import xmi_bytes
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.support.reachability import Marking, ReachabilityGraph, TooManyMarkingsError
from tests.support.references.flattening import Name, plain_net_of
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.small import small_system
from tests.support.systems.small_systems import small_system_models

VARIANTS = st.tuples(st.sampled_from(get_args(SignalVariant)), st.sampled_from(get_args(OverflowVariant)))
Variant = tuple[SignalVariant, OverflowVariant]


def graph_of(net: pn.Net) -> ReachabilityGraph:
    return ReachabilityGraph(plain_net_of(net))


def server_pages(model: sym.SystemModel) -> set[pn.Page]:
    """Return the server pages with all pages on them."""
    found: set[pn.Page] = set()
    for page in pages(model):  # outer before inner
        servers = [
            channel.server.page for channel in model.channels if isinstance(channel, sym.ServiceChannel)
        ]
        if page in servers or page.page in found:
            found.add(page)
    return found


@given(small_system_models(clients=0), VARIANTS)
@settings(max_examples=25)
def test_the_rules_add_and_never_change(model: sym.SystemModel, variant: Variant) -> None:
    before = xmi_bytes(model)

    net = flatten(model, *variant).net

    assert xmi_bytes(model) == before
    prototypes = server_pages(model)
    made = {node.id: node for node in nodes(net)}
    for node in nodes(model):
        if node.page in prototypes:
            assert node.id not in made
        elif isinstance(node, pn.Place):
            kept = made[node.id]
            assert isinstance(kept, pn.Place) and (kept.tokens, kept.name) == (node.tokens, node.name)
        elif isinstance(node, pn.Transition):
            assert isinstance(made[node.id], pn.Transition) and made[node.id].name == node.name
    joined = {arc.id: arc for arc in arcs(net)}
    for arc in arcs(model):
        if arc.page not in prototypes:
            kept_arc = joined[arc.id]
            assert (kept_arc.source.id, kept_arc.target.id) == (
                resolve(arc.source).id,
                resolve(arc.target).id,
            )
            assert (kept_arc.weight, kept_arc.kind) == (arc.weight, arc.kind)


@given(small_system_models(clients=0), VARIANTS)
@settings(max_examples=25)
def test_the_result_is_a_valid_plain_net_with_ids_of_its_own(
    model: sym.SystemModel, variant: Variant
) -> None:
    net = flatten(model, *variant).net

    assert len(net.pages) == 1
    assert {type(node) for node in net.pages[0].objects} <= {pn.Place, pn.Transition}
    ids = [element.id for element in (net, *net.pages, *nodes(net), *arcs(net))]
    assert len(ids) == len(set(ids))
    assert [found for found in validate(net) if found.severity == "error"] == []


@pytest.mark.long
@given(small_system_models(), VARIANTS)
@settings(max_examples=25)
def test_the_certificate_holds_in_every_reachable_marking(model: sym.SystemModel, variant: Variant) -> None:
    net = flatten(model, *variant).net
    graph = graph_of(net)
    invariants = [
        (invariant.name, invariant.value, [(term.place.id, term.weight) for term in invariant.terms])
        for invariant in net.certificate
    ]

    for marking in first_markings(graph, 300):
        tokens = graph.named(marking)
        for name, value, terms in invariants:
            assert sum(weight * tokens[place] for place, weight in terms) == value, name


def first_markings(graph: ReachabilityGraph, limit: int) -> Iterator[Marking]:
    """Yield the reachable markings, or at least as many as asked for."""
    yield graph.start
    try:
        for _, _, after in graph.firings(limit):
            yield after
    except TooManyMarkingsError:
        return


@given(small_system_models(), VARIANTS)
@settings(max_examples=25)
def test_the_certificate_covers_queues_services_and_signals(model: sym.SystemModel, variant: Variant) -> None:
    flattened = flatten(model, *variant)
    covered = [frozenset(term.place for term in each.terms) for each in flattened.net.certificate]

    def targets(role: str) -> list[pn.Element]:
        return [link.target for link in flattened.trace.with_role(role)]

    for first, second in [("queue.load", "queue.capacity"), ("active", "inactive"), ("true", "false")]:
        for pair in zip(targets(first), targets(second), strict=True):
            assert frozenset(pair) in covered
    for role in ("ready", "requests", "responses", "in_use", "true_literals"):
        assert all(any(place in each for each in covered) for place in targets(role))


@pytest.mark.long
@given(
    st.one_of(small_system_models(), calling_systems(circles=True)),
    st.sampled_from(get_args(SignalVariant)),
)
@settings(max_examples=20)
def test_both_overflow_variants_have_the_same_reachability_graph(
    model: sym.SystemModel, signals: SignalVariant
) -> None:
    graphs = [graph_of(flatten(model, signals, overflow).net) for overflow in ("weighted", "inhibitor")]

    assert graphs[0].places == graphs[1].places
    assert list(first_firings(graphs[0])) == list(first_firings(graphs[1]))


def first_firings(graph: ReachabilityGraph) -> Iterator[tuple[Marking, Name, Marking]]:
    """Yield the firings in breadth-first order, at least up to 1000 markings."""
    try:
        yield from graph.firings(1000)
    except TooManyMarkingsError:
        return


@pytest.mark.long
@pytest.mark.parametrize("signals", ["none", "input-enabled"])
def test_both_overflow_variants_of_the_case_study_have_the_same_graph(signals: SignalVariant) -> None:
    model = build()
    for colour in ("Blue", "Green"):
        find(model, f"{colour}Objects", pn.Place).tokens = 0
    graphs = [graph_of(flatten(model, signals, overflow).net) for overflow in ("weighted", "inhibitor")]

    assert set(graphs[0].firings(5000)) == set(graphs[1].firings(5000))


@pytest.mark.long
@given(small_system_models(satisfiable=True))
@settings(max_examples=25)
def test_signals_that_change_freely_double_the_markings(model: sym.SystemModel) -> None:
    used = {
        literal.signal
        for transition in transitions(model)
        if isinstance(transition, sym.Transition) and transition.clause is not None
        for disjunction in transition.clause.disjunctions
        for literal in disjunction.literals
    }
    try:
        without = graph_of(flatten(model, "none").net).count(limit=1000)
    except TooManyMarkingsError:
        assume(False)
    free = graph_of(flatten(model, "fully-enabled").net)

    assert free.count(limit=2 ** len(used) * without + 1) == 2 ** len(used) * without


@pytest.mark.long
@given(small_system_models(satisfiable=True))
@settings(max_examples=15)
def test_a_signal_that_may_change_less_often_reaches_no_more(model: sym.SystemModel) -> None:
    counts = []
    try:
        for signals in ("input-enabled", "io-enabled", "fully-enabled"):
            counts.append(graph_of(flatten(model, signals).net).count(limit=800))
    except TooManyMarkingsError:
        assume(False)

    assert counts == sorted(counts)


@given(small_system_models(clients=0), VARIANTS)
@settings(max_examples=15)
def test_the_same_model_gives_the_same_bytes(model: sym.SystemModel, variant: Variant) -> None:
    first, second = (flatten(model, *variant) for _ in range(2))

    assert xmi_bytes(first.net) == xmi_bytes(second.net)
    links = [
        [
            (link.rule, link.role, link.application, link.index, link.sources, link.target.id)
            for link in each.trace
        ]
        for each in (first, second)
    ]
    assert links[0] == links[1]


FLATTEN_AND_SAVE = """
import sys
from pathlib import Path
from dineros.metamodel.files import load, save
from dineros.transformations.flattening.flatten import flatten
model = load(sys.argv[1])
flattened = flatten(model, "io-enabled")
save(flattened.net, Path(sys.argv[2], "net.pnm"))
save(flattened.trace.to_model("model", "net"), Path(sys.argv[2], "trace.xmi"))
"""


@pytest.mark.long
def test_the_same_model_gives_the_same_bytes_in_another_process(tmp_path: Path) -> None:
    written = []
    for seed in ("1", "2"):
        folder = tmp_path / "out"
        folder.mkdir(exist_ok=True)
        subprocess.run(
            [sys.executable, "-c", FLATTEN_AND_SAVE, str(HOME / "sorting.sym.xmi"), str(folder)],
            env={**os.environ, "PYTHONHASHSEED": seed},
            check=True,
        )
        written.append([(folder / name).read_bytes() for name in ("net.pnm", "trace.xmi")])

    assert written[0] == written[1]
    assert b"queue.load" in written[0][1]


def test_the_net_says_how_it_was_made() -> None:
    net = flatten(small_system(), "io-enabled", "inhibitor").net

    assert (net.signals, net.overflow) == (pnm.SignalVariant.ioEnabled, pnm.OverflowVariant.inhibitor)
    assert (net.id, net.systemModel) == ("talk", "talk")


def test_limits_and_tokens_are_those_of_the_model() -> None:
    model = small_system()
    (topic,) = model.channels
    assert isinstance(topic, sym.TopicChannel)
    topic.dispatchers.append(sym.Dispatcher(node=find(model, "listener", sym.NodeNet), limit=7))
    topic.subscribers[0].limit = 4
    net = flatten(model, "none").net

    assert {place.id: place.tokens for place in places(net) if place.id.endswith(".Capacity")} == {
        "chatter.publisher.said.Capacity": 3,
        "chatter.dispatcher.listener.Capacity": 7,
        "chatter.subscriber.heard.Capacity": 4,
    }


def test_a_dispatcher_without_a_limit_has_sixteen_places() -> None:
    net = flatten(small_system(), "none").net

    assert find(net, "chatter.dispatcher.listener.Capacity", pn.Place).tokens == 16


def service_model(instances: int | None, clients: int = 2) -> sym.SystemModel:
    """Return a model of a server whose page has a clause, and of clients."""
    server, caller = sym.NodeNet(id="server"), sym.NodeNet(id="caller")
    sym.InputSignal(id="go", node=server)
    page = sym.CallbackPage(id="page", kind="server", page=server)
    entry, exit_ = sym.Place(id="entry", page=page), sym.Place(id="exit", page=page)
    serve = sym.Transition(id="serve", page=page)
    flow(entry, serve, exit_)
    set_clause(serve, "go")
    service = sym.ServiceChannel(
        id="service",
        service="/service",
        server=sym.ServerPort(entry=entry, exit=exit_, page=page),
        instances=instances,
    )
    for number in range(clients):
        request, response = sym.Place(id=f"q{number}", page=caller), sym.Place(id=f"r{number}", page=caller)
        service.clients.append(sym.ClientPort(client=f"c{number}", request=request, response=response))
    return sym.SystemModel(id="model", pages=[server, caller], channels=[service])


@pytest.mark.parametrize(
    ("instances", "clients", "expected"), [(None, 2, 2), (None, 3, 3), (1, 2, 1), (3, 1, 3), (None, 0, 0)]
)
def test_number_of_server_instances(instances: int | None, clients: int, expected: int) -> None:
    trace = flatten(service_model(instances, clients)).trace

    assert len(trace.role("S3", "active")) == expected
    assert len(trace.role("S2", "t_call")) == expected * clients


def test_a_signal_of_a_server_without_instances_is_not_used() -> None:
    flattened = flatten(service_model(None, clients=0), "fully-enabled")

    assert flattened.trace.role("I4", "true") == []


def test_what_overrides_a_server_transition_overrides_it_in_every_instance() -> None:
    model = service_model(2)
    serve = find(model, "serve", pn.Transition)
    hold = sym.Transition(id="hold", overrides=[serve], page=find(model, "server", sym.NodeNet))
    net = flatten(model).net

    assert hold.id == "hold"
    assert [lower.id for lower in find(net, "hold", pn.Transition).overrides] == [
        "service[1].serve",
        "service[2].serve",
    ]


def test_inputs_of_a_transition_that_come_by_references_to_it_count_as_its_inputs() -> None:
    model = small_system()
    take = find(model, "take", sym.Transition)
    page = pn.Page(id="other", page=find(model, "listener", sym.NodeNet))
    permit = sym.Place(id="permit", tokens=1, page=page)
    inner = pn.ReferenceTransition(id="take2", target=take, page=page)
    flow(permit, pn.ReferenceTransition(id="take3", target=inner, page=page))
    trace = flatten(model, "input-enabled").trace

    tested = {
        link.target.source.id
        for link in trace.role("I6InputEnabled", "each")
        if isinstance(link.target, pn.Arc)
    }
    assert tested == {"heard", "permit"}


def test_elements_of_the_model_keep_their_ids_whatever_rules_call_theirs() -> None:
    model = small_system()
    listener = find(model, "listener", sym.NodeNet)
    for id in ("net", "chatter.transport", "chatter.publisher.said.Load"):
        sym.Place(id=id, tokens=5, page=listener)
    sym.Transition(id="chatter.publisher.said.out-chatter", page=listener)
    net = flatten(model).net

    for id in ("net", "chatter.transport", "chatter.publisher.said.Load"):
        assert find(net, id, pn.Place).tokens == 5
    assert find(net, "chatter.publisher.said.out-chatter", pn.Transition).id
    ids = [element.id for element in (net, *net.pages, *nodes(net), *arcs(net))]
    assert len(ids) == len(set(ids))


def test_an_arc_into_a_server_page_from_outside_is_an_error_that_names_it() -> None:
    model = service_model(1)
    server = find(model, "server", sym.NodeNet)
    ask = sym.Transition(id="ask", page=server)
    flow(ask, pn.ReferencePlace(id="inside", target=find(model, "entry", pn.Place), page=server))

    with pytest.raises(DinerosError) as caught:
        flatten(model)

    assert caught.value.element == "ask-inside"
    assert "server page" in caught.value.message
