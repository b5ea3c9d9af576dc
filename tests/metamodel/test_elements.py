"""Walking a model, following references, and finding elements."""

import pytest

from case_study.build import build
from dineros.metamodel import pn, sym
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
