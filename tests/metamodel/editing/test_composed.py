"""Larger steps of drawing: what they leave is what they should, and the same net is made of it."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.checks.check import check
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import Formula, Name
from dineros.metamodel import pn, sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.editing import CommandError, Document
from dineros.metamodel.editing.commands import Set
from dineros.metamodel.editing.composed import (
    Insert,
    compose,
    decode_operation,
)
from dineros.metamodel.editing.composed.templates import TEMPLATES
from dineros.metamodel.editing.editor import Editor
from dineros.metamodel.editing.renaming import in_formula, in_name
from dineros.metamodel.elements import arcs, elements, find, pages
from dineros.metamodel.files import load
from dineros.transformations.flattening.flatten import flatten
from tests.support.equality import differences
from tests.support.systems.small_systems import small_system_models
from tests.support.systems.talker import talker

CASE_STUDY = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"


def handle(editor: Editor | Document, id: str) -> str:
    found = next(each for each in elements(editor.root) if each.id == id)
    named = editor.handles.of(found)
    assert named is not None
    return named


def do(editor: Editor, operation: object) -> None:
    editor.perform(compose(editor.root, editor.handles, decode_operation(operation)))


def flat(model: pn.Net) -> tuple[set[tuple[str, int]], set[tuple[str, str, int, str]]]:
    """Return places with tokens, and arcs, of the plain net of a model."""
    assert isinstance(model, sym.SystemModel)
    net = flatten(model).net
    places = {(each.id, each.tokens) for each in elements(net) if isinstance(each, pn.Place)}
    joined = {(arc.source.id, arc.target.id, arc.weight, str(arc.kind)) for arc in arcs(net)}
    return places, joined


@pytest.mark.long
@settings(max_examples=8)
@given(
    model=st.one_of(st.builds(lambda: load(CASE_STUDY)), small_system_models()),
    random=st.randoms(use_true_random=False),
)
def test_what_is_put_on_other_pages_is_the_same_net(model: sym.SystemModel, random: Random) -> None:
    if any(each.severity == "error" for each in validate(model)):
        return
    before = flat(model)
    editor = Editor(model)
    for _ in range(4):
        page = random.choice(list(pages(model)))
        here = [each for each in page.objects if not isinstance(each, pn.Page)]
        if not here:
            continue
        some = [editor.handles.of(each) for each in random.sample(here, random.randint(1, len(here)))]
        try:
            do(editor, {"kind": "group", "elements": some})
        except CommandError:
            continue
        if random.random() < 0.6:
            made = next(each for each in reversed(list(pages(model))) if each.id.startswith("Page"))
            do(editor, {"kind": "split", "page": editor.handles.of(made)})
        if any(
            each.severity == "error" for each in validate(model)
        ):  # a port, or a server's page, taken apart
            return
        assert flat(model) == before


def test_a_group_and_its_split() -> None:
    model = load(CASE_STUDY)
    wanted = load(CASE_STUDY)
    editor = Editor(model)
    do(editor, {"kind": "group", "elements": [handle(editor, "Safe"), handle(editor, "TStop")]})
    page = find(model, "Page1", pn.Page)
    assert [each.id for each in page.objects] == ["SensorReq@Page1", "Safe", "TStop"]
    assert [each.id for each in page.arcs] == ["Safe-TStop", "TStop-SensorReq"]
    safety = find(model, "Safety", pn.Page)
    assert "Safe@Safety" in [each.id for each in safety.objects]
    assert validate(model) == []
    do(editor, {"kind": "split", "page": handle(editor, "Page1")})
    assert {each.id for each in elements(model)} == {each.id for each in elements(wanted)}
    assert flat(model) == flat(wanted)
    with pytest.raises(CommandError, match="cannot exist without callback page 'PickServer'"):
        do(editor, {"kind": "split", "page": handle(editor, "PickServer")})


def test_an_arc_between_two_pages_leads_to_a_reference() -> None:
    model = load(CASE_STUDY)
    editor = Editor(model)
    before = flat(model)
    ends = {"source": handle(editor, "SensorRes"), "target": handle(editor, "TPick")}
    do(editor, {"kind": "join", **ends, "x": 5, "y": 7})
    page = find(model, "PickServer", pn.Page)
    reference = page.objects[-1]
    assert isinstance(reference, pn.ReferencePlace) and reference.target.id == "SensorRes"
    assert reference.graphics is not None and reference.graphics.positions[0].y == 7
    assert (page.arcs[-1].source, page.arcs[-1].target.id) == (reference, "TPick")
    after = flat(model)
    assert after[0] == before[0] and before[1] < after[1]
    assert {(source, weight) for source, _, weight, _ in after[1] - before[1]} == {("SensorRes", 1)}
    # What stands for the place already does so once more.
    ends = {"source": handle(editor, "TPickFail"), "target": handle(editor, "SensorRes")}
    do(editor, {"kind": "join", **ends, "x": 0, "y": 0})
    assert page.objects[-1] is reference and page.arcs[-1].target is reference
    assert validate(model) == []


def test_what_cannot_be_put_elsewhere_says_why() -> None:
    editor = Editor(talker())
    for operation, said in (
        ({"kind": "group", "elements": ["e1"]}, "is not on a page"),
        (
            {"kind": "group", "elements": [handle(editor, "Words")], "type": "sym.NodeNet"},
            "becomes a pn.Page",
        ),
        ({"kind": "group", "elements": [handle(editor, "Words"), handle(editor, "Heard")]}, "two pages"),
        (
            {"kind": "into", "elements": [handle(editor, "Words")], "page": handle(editor, "OnChatter")},
            "another ROS node",
        ),
        (
            {"kind": "into", "elements": [handle(editor, "OnChatter")], "page": handle(editor, "OnChatter")},
            "into itself",
        ),
        ({"kind": "split", "page": handle(editor, "talker")}, "not a page within a page"),
        (
            {
                "kind": "join",
                "source": handle(editor, "Say"),
                "target": handle(editor, "Noted"),
                "x": 0,
                "y": 0,
            },
            "another ROS node",
        ),
        (
            {
                "kind": "join",
                "source": handle(editor, "Words"),
                "target": handle(editor, "Said"),
                "x": 0,
                "y": 0,
            },
            "a place and a transition",
        ),
        ({"kind": "copy", "elements": ["e0"], "owner": "e0", "dx": 0, "dy": 0}, "the model itself"),
        (
            {"kind": "copy", "elements": [handle(editor, "Words")], "owner": "e0", "dx": 0, "dy": 0},
            "cannot hold a copy",
        ),
        (
            {"kind": "insert", "template": "servce", "x": 0, "y": 0},
            "no template 'servce'.*did you mean.*service",
        ),
        ({"kind": "fill", "token": "e1", "field": "x", "text": "1"}, "carries no data"),
        ({"kind": "melt"}, "has an unknown kind"),
    ):
        with pytest.raises(CommandError, match=said):
            do(editor, operation)


def test_a_copy_has_its_own_ids_arcs_and_signals() -> None:
    model = talker()
    editor = Editor(model)
    ids = ["Words", "Say", "Said"]
    do(
        editor,
        {
            "kind": "copy",
            "elements": [handle(editor, id) for id in ids],
            "owner": handle(editor, "listener"),
            "dx": 5,
            "dy": 0,
        },
    )
    listener = find(model, "listener", sym.NodeNet)
    assert [each.id for each in listener.objects][1:] == ["Words2", "Say2", "Said2"]
    assert [each.id for each in listener.arcs] == ["Words2-Say2", "Say2-Said2"]
    assert [(each.id, each.name) for each in listener.signals] == [("Button2", "Button")]
    say = find(model, "Say2", sym.Transition)
    assert say.clause is not None and say.clause.disjunctions[0].literals[0].signal is listener.signals[0]
    do(
        editor,
        {
            "kind": "copy",
            "elements": [handle(editor, "talker"), handle(editor, "Chatter")],
            "owner": "e0",
            "dx": 0,
            "dy": 0,
        },
    )
    channel = find(model, "Chatter2", sym.TopicChannel)
    assert channel.topic == "chatter2" and channel.publishers[0].place.id == "Said3"
    again = find(model, "Say3", sym.Transition)
    assert again.clause is not None and again.clause.text == "Button3"
    assert not [each for each in validate(model) if each.severity == "error" and "Heard" not in each.message]


@pytest.mark.parametrize("name", TEMPLATES)
def test_templates_are_models_without_a_problem_twice_too(tmp_path: Path, name: str) -> None:
    document = Document(tmp_path / "new.sym.xmi")
    for number in (1, 2):
        found = document.do(compose(document.root, document.handles, Insert(name, 100, 40 * number)))
        assert found.touched and document.violations() == []
        assert flat(document.root)
    document.save()
    assert differences(load(document.path), document.root) == []
    document.undo()
    document.undo()
    assert not document.root.pages and document.undo_label is None
    document.close()


@pytest.mark.parametrize("name", TEMPLATES)
def test_a_check_finds_nothing_in_templates(tmp_path: Path, name: str) -> None:
    document = Document(tmp_path / "new.sym.xmi")
    document.do(compose(document.root, document.handles, Insert(name, 100, 40)))
    found = [each for each in check(document.root).findings if each.severity != "note"]
    assert found == []
    document.close()


def test_a_token_is_filled_field_by_field() -> None:
    model = load(CASE_STUDY)
    editor = Editor(model)
    token = find(model, "RedObjects", sym.Place).balloons[0]
    named = editor.handles.of(token)
    token.data = '{"errors": [1.0], "color": "red"}'
    do(editor, {"kind": "fill", "token": named, "field": "pose", "text": "[1, 2, 3, 4, 5, 6.5]"})
    do(editor, {"kind": "fill", "token": named, "field": "pickSuccess", "text": "true"})
    assert (
        token.data == '{"errors": [1.0], "color": "red", "pose": [1, 2, 3, 4, 5, 6.5], "pickSuccess": true}'
    )
    do(editor, {"kind": "fill", "token": named, "field": "errors", "text": None})
    assert "errors" not in json.loads(token.data)
    for field, text, said in (
        ("pose", "[1]", "pose takes 6 elements, not 1"),
        ("pose", "[1", "no JSON at column"),
        ("pickSuccess", "7", "pickSuccess takes true or false"),
        ("colour", "red", "no field 'colour'.*color"),
    ):
        with pytest.raises(CommandError, match=said):
            do(editor, {"kind": "fill", "token": named, "field": field, "text": text})


def test_new_names_reach_stored_properties_and_fairness() -> None:
    model = talker()
    model.properties.append(sym.Property(id="P1", text="fired(Say) leads to Chatter.publisher.Said >= 1"))
    model.properties.append(
        sym.Property(id="P2", language="ltl", text='G ("Said" + Noted <= 3) & signal(Button)')
    )
    model.assumptions.append(sym.Fairness(id="F1", of="all-but:Say,Listen"))
    editor = Editor(model)
    for id, after in (("Say", "Speak"), ("Said", "WasSaid"), ("Chatter", "G"), ("Button", "Pressed")):
        editor.perform([Set(handle(editor, id), "id", after)])
    assert [str(each.text) for each in model.properties] == [
        "fired(Speak) leads to G.publisher.WasSaid >= 1",
        'G ("WasSaid" + Noted <= 3) & signal(Pressed)',
    ]
    assert [each.of for each in model.assumptions] == ["all-but:Speak,Listen"]  # type: ignore[attr-defined]


@settings(max_examples=60)
@given(
    text=st.sampled_from(
        [
            "G (a >= 1 -> F b >= 2)",
            "a + 2*b <= 3 & fired(t) | !enabled(t)",
            "A [ a >= 1 U b >= 1 ] & EF G >= 1",
            'AG ("a" = {b} & signal(a))',
            "G G >= 1",
            "fired(q.a) & q[2].a >= 1",
        ]
    ),
    before=st.sampled_from(["a", "b", "t", "q", "G"]),
    after=st.sampled_from(["n", "G", "new.name", "or", "né", "x-y", '"', "{", "3d", "\\"]),
)
def test_a_formula_with_another_name_is_read_with_that_name(text: str, before: str, after: str) -> None:
    changed = in_formula(text, before, after)
    assert _names(changed) == [in_name(name, before, after) for name in _names(text)]
    back = in_formula(in_formula(text, before, "Unused"), "Unused", before)
    assert read(back) == read(text)


def read(text: str) -> Formula:
    return parse(text, "ctl" if text.startswith(("A", "E")) else "ltl")


def _names(text: str) -> list[str]:
    """Return the names in a formula as its parser reads them, from left to right."""
    found: list[Name] = []
    stack: list[object] = [read(text)]
    while stack:
        each = stack.pop()
        if isinstance(each, Name):
            found.append(each)
        elif isinstance(each, tuple):
            stack.extend(each)
        elif dataclasses.is_dataclass(each):
            stack.extend(getattr(each, field.name) for field in dataclasses.fields(each))
    return [each.text for each in sorted(found, key=lambda name: name.column)]
