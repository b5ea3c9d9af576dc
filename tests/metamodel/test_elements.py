"""Walking a model, following references, finding elements, and building arcs."""

import pytest

from case_study.build import build
from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, inhibit, read
from dineros.metamodel.elements import (
    ReferenceCycleError,
    elements,
    find,
    label,
    node_net_of,
    pages,
    places,
    resolve,
    transitions,
)
from dineros.metamodel.errors import DinerosError, UnknownElementError


def test_pages_come_outer_before_inner_in_model_order() -> None:
    net = pn.Net(id="n")
    first, second = pn.Page(id="first", net=net), pn.Page(id="second", net=net)
    inner = pn.Page(id="inner", page=first)
    pn.Page(id="innermost", page=inner)
    pn.Page(id="late", page=first)
    assert [page.id for page in pages(net)] == ["first", "inner", "innermost", "late", "second"]
    assert second.net is net


def test_elements_of_the_case_study_are_all_its_elements_once() -> None:
    model = build()
    found = list(elements(model))
    expected = [model, *(item for item in model.eAllContents() if isinstance(item, pn.Element))]
    assert len(found) == len(set(found)) == len(expected)
    assert set(found) == set(expected)


def test_places_and_transitions_of_the_case_study() -> None:
    model = build()
    assert len(places(model)) == 6 + 2 * 10 + 6 + 10 + 2 + 2  # per node net, in order
    assert len(transitions(model)) == 3 + 2 * 5 + 2 + 12 + 1 + 1


def test_find_names_near_matches() -> None:
    model = build()
    assert find(model, "RedObjects", sym.Place).tokens == 1
    with pytest.raises(UnknownElementError, match=r"no Place has the id 'RedObject'.*RedObjects"):
        find(model, "RedObject", sym.Place)


def test_references_are_followed_and_circles_named() -> None:
    page = pn.Page(id="page")
    place = pn.Place(id="p", page=page)
    inner = pn.ReferencePlace(id="r", target=place, page=page)
    outer = pn.ReferencePlace(id="s", target=inner, page=page)
    assert resolve(outer) is place
    inner.target = outer
    with pytest.raises(ReferenceCycleError, match="r -> s -> r"):
        resolve(inner)
    with pytest.raises(DinerosError, match="has no target"):
        resolve(pn.ReferencePlace(id="alone"))


def test_node_net_of() -> None:
    model = build()
    assert node_net_of(find(model, "StateGet")) is find(model, "synchronizer")
    assert node_net_of(find(model, "Sensor")) is find(model, "sensorics")
    assert node_net_of(find(model, "Pick")) is None


def test_label_prefers_the_name() -> None:
    assert label(pn.Place(id="p", name="Ready")) == "Ready"
    assert label(pn.Place(id="p")) == "p"


def test_flow_read_and_inhibit() -> None:
    page = pn.Page(id="page")
    before, step, after = (
        pn.Place(id="a", page=page),
        pn.Transition(id="t", page=page),
        pn.Place(id="b", page=page),
    )
    flow(before, step, after, weight=2)
    read(after, step)
    inhibit(after, step, weight=3)
    assert [(arc.id, str(arc.kind), arc.weight) for arc in page.arcs] == [
        ("a-t", "normal", 2),
        ("t-b", "normal", 2),
        ("b-t-read", "read", 1),
        ("b-t-inhibitor", "inhibitor", 3),
    ]


def test_flow_between_pages_is_refused() -> None:
    place, transition = pn.Place(id="p", page=pn.Page(id="x")), pn.Transition(id="t", page=pn.Page(id="y"))
    with pytest.raises(DinerosError, match=r"do not stand on the same page.*reference place"):
        flow(place, transition)
