"""What a view shows: neighbourhoods, collapsed pages, badges; and two models compared."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel import elements, pn, sym
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.errors import DinerosError, UnknownElementError
from dineros.metamodel.settings import apply
from dineros.views.javascript.client import evaluate
from dineros.views.nets import (
    ViewModel,
    around,
    collapse,
    collapse_if_large,
    compare,
    differences,
    expand,
    view_of,
    with_badges,
)
from tests.support.systems.talker import talker
from tests.views.nets.samples import case_study


def nodes_of(view: ViewModel) -> set[str]:
    return {node.id for node in view.nodes}


def test_steps_follow_lines_both_ways() -> None:
    view = view_of(talker())
    assert nodes_of(around(view, ["Said"], 0)) == {"Said"}
    assert nodes_of(around(view, ["Said"], 1)) == {"Say", "Said", "Chatter"}
    assert nodes_of(around(view, ["Said"], 2)) == {"Words", "Say", "Said", "Chatter", "Heard"}
    assert nodes_of(around(view, ["Said"], 99)) == nodes_of(view)


def test_a_neighbourhood_keeps_the_boxes_around_it_open() -> None:
    view = around(collapse(view_of(case_study())), ["Safe"], 1)
    assert {box.id for box in view.boxes} == {"executor", "Safety", "PickServer", "PlaceServer"}
    assert not any(box.collapsed for box in view.boxes)
    assert all({edge.source, edge.target} <= nodes_of(view) for edge in view.edges)


def test_neighbourhoods_of_boxes_and_lines() -> None:
    view = view_of(talker())
    assert nodes_of(around(view, ["listener"], 0)) == {"Heard", "Listen", "Noted"}
    assert nodes_of(around(view, ["Words-Say"], 0)) == {"Words", "Say"}
    assert nodes_of(around(view, ["Words", "Noted"], 0)) == {"Words", "Noted"}


def test_unknown_elements_name_near_ones() -> None:
    view = view_of(case_study())
    with pytest.raises(UnknownElementError, match="did you mean 'TStop'"):
        around(view, ["TStp"], 1)
    with pytest.raises(UnknownElementError, match="did you mean 'executor'"):
        collapse(view, ["executr"])
    with pytest.raises(UnknownElementError, match="shows no 'nobody'"):
        with_badges(view, {"nobody": "1"})
    with pytest.raises(DinerosError, match="is negative"):
        around(view, ["TStop"], -1)


@settings(max_examples=25, deadline=None)
@given(st.data())
def test_python_and_pages_agree_on_neighbourhoods(data: st.DataObject) -> None:
    view = collapse(view_of(case_study()), data.draw(st.sampled_from([[], ["executor"], ["Safety"]])))
    known = [item.id for item in view.elements()]
    ids = data.draw(st.lists(st.sampled_from(known), min_size=1, max_size=3, unique=True))
    steps = data.draw(st.integers(0, 4))
    expected = json.loads(json.dumps(around(view, ids, steps).to_json()))
    found = evaluate(["static/net/layout/shown.js"], "around", view.to_json(), ids, steps)
    assert found == expected


def test_only_large_views_are_collapsed_by_themselves() -> None:
    view = view_of(case_study())
    assert not any(box.collapsed for box in collapse_if_large(view).boxes)
    assert all(box.collapsed for box in collapse_if_large(view, 50).boxes)


def test_a_page_opens_with_those_around_it() -> None:
    view = expand(collapse(view_of(case_study())), ["Safety"])
    assert [box.id for box in view.boxes if not box.collapsed] == ["executor", "Safety"]
    assert not any(box.collapsed for box in expand(view).boxes)
    with pytest.raises(UnknownElementError, match="did you mean 'Safety'"):
        expand(view, ["Safty"])


def test_a_comparison_says_what_changed() -> None:
    before, after = talker(), talker()
    apply(after, "Words.tokens=5")
    apply(after, "Chatter.publisher.Said.limit=2")
    set_clause(elements.find(after, "Say", sym.Transition), "!Button")
    page = elements.find(after, "talker", sym.NodeNet)
    page.objects.append(sym.Place(id="Spare"))
    listener = elements.find(after, "OnChatter", sym.CallbackPage)
    listener.objects.remove(elements.find(after, "Noted", pn.Place))
    for arc in list(listener.arcs):
        if arc.id == "Listen-Noted":
            listener.arcs.remove(arc)
    view = compare(view_of(before), view_of(after))
    assert differences(view) == {
        "added": ["Spare"],
        "removed": ["Noted", "Listen-Noted"],
        "changed": ["Words", "Say", "publish Said Chatter"],
    }
    assert view.node("Words").notes == ["tokens: 3 → 5"]
    assert view.node("Say").notes == ["text: Say, Button → Say, !Button", "Input clause: Button → !Button"]
    assert next(edge for edge in view.edges if edge.kind == "publish").notes == ["queue 10 → queue 2"]
    assert view.box("talker").summary.endswith("3 differences")


def test_equal_models_do_not_differ() -> None:
    view = compare(view_of(case_study()), view_of(case_study()))
    assert differences(view) == {"added": [], "removed": [], "changed": []}
    assert view.compared


def test_a_removed_page_keeps_its_content() -> None:
    before, after = talker(), talker()
    after.pages.remove(after.pages[1])
    after.channels.remove(after.channels[0])
    view = compare(view_of(before), view_of(after))
    assert set(differences(view)["removed"]) >= {"listener", "OnChatter", "Heard", "Chatter"}
    assert view.node("Heard").box == "OnChatter"
