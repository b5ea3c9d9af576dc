"""Capacities of nets without channels: every engine obeys them, formats that cannot say them refuse."""

from __future__ import annotations

from collections import deque
from pathlib import Path

import pytest
from hypothesis import given, settings

from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.models import compile_net
from dineros.analysis.questions.state_space import state_space
from dineros.metamodel import pn
from dineros.metamodel.elements import places
from dineros.metamodel.errors import DinerosError, ModelFileError
from dineros.metamodel.files import save
from dineros.transformations.flattening.bounding import bounded
from tests.support.reachability import ReachabilityGraph
from tests.support.references.flattening import PlainNet
from tests.support.systems.models import plain_nets


def plain(net: pn.Net) -> PlainNet:
    """Return a net in the plain form, references followed."""
    form = PlainNet()

    def end(node: pn.Node) -> pn.Node:
        while isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)):
            node = node.target
        return node

    for element in net.eAllContents():
        if isinstance(element, pn.Place):
            form.place(element.id, element.tokens)
        elif isinstance(element, pn.Transition):
            form.transition(element.id)
        elif isinstance(element, pn.Arc):
            ends = end(element.source).id, end(element.target).id
            form.arcs.append((*ends, element.weight, str(element.kind)))
    return form


def markings_within(net: pn.Net, limit: int) -> int:
    """Count the markings that are reached without any place ever holding more than its capacity."""
    most = {place.id: place.capacity for place in places(net) if place.capacity is not None}
    graph = ReachabilityGraph(plain(net))
    seen, queue = {graph.start}, deque([graph.start])
    while queue:
        before = queue.popleft()
        for _, after in graph.successors(before):
            grown = zip(graph.places, before, after, strict=True)
            if any(then > now and then > most.get(str(place), then) for place, now, then in grown):
                continue
            if after not in seen:
                seen.add(after)
                queue.append(after)
                if len(seen) > limit:
                    return -1
    return len(seen)


@given(plain_nets())
@settings(max_examples=40, deadline=None)
def test_generated_nets(net: pn.Net) -> None:
    for transition in net.eAllContents():
        if isinstance(transition, pn.Transition):
            transition.overrides.clear()
    for place in places(net):
        place.capacity = place.tokens + 1
    expected = markings_within(net, 2000)
    counted = ReachabilityGraph(plain(bounded(net)))
    if expected >= 0:
        assert counted.count(expected + 1) == expected
    assert all(place.capacity == place.tokens + 1 for place in places(net)), "the net itself is not changed"


def test_engines_count_what_fits() -> None:
    net = pn.Net(id="plain")
    page = pn.Page(id="page", net=net)
    box, make = pn.Place(id="Box", capacity=3, page=page), pn.Transition(id="Make", page=page)
    pn.Arc(id="Make-Box", source=make, target=box, page=page)
    pn.Place(id="Box.free", tokens=7, page=page)  # a name that is taken
    for engine in ("explicit", "symbolic"):
        space = state_space(subject_of(net).net, engine)
        assert (space.states, space.deadlocks) == (4, 1)


def test_what_does_not_obey_a_capacity_is_refused(tmp_path: Path) -> None:
    net = pn.Net(id="plain")
    pn.Place(id="Box", capacity=3, page=pn.Page(id="page", net=net))
    with pytest.raises(DinerosError, match="Box has a capacity that no arc enforces"):
        compile_net(net)
    with pytest.raises(ModelFileError, match=r"'Box' has a capacity, which \.net cannot express"):
        save(net, tmp_path / "plain.net")
    assert not (tmp_path / "plain.net").exists()
