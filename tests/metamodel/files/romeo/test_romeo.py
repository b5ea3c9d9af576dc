from __future__ import annotations

from collections import Counter
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import assume, given

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, inhibit, read
from dineros.metamodel.elements import arcs, find, places, resolve, transitions
from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files import load, save
from dineros.metamodel.files.exact import exact_number, fraction_of
from dineros.metamodel.files.romeo import net_content, net_from_content
from dineros.metamodel.positions import location_of
from tests.support.systems.models import plain_nets
from tests.support.systems.small import small_system

PATH = Path("example.xml")


def parse(text: str) -> pn.Net:
    return net_from_content(text.encode(), PATH)


def meaning(net: pn.Net) -> dict[str, object]:
    """Return what a net says by the order of its nodes, since Romeo takes few characters in identifiers."""
    number = {node: at for nodes in (places(net), transitions(net)) for at, node in enumerate(nodes)}
    effects: Counter[tuple[str, int, int]] = Counter()
    inhibitors: dict[tuple[int, int], int] = {}
    for arc in arcs(net):
        source, target = resolve(arc.source), resolve(arc.target)
        key = (number[source], number[target])
        if str(arc.kind) == "inhibitor":
            inhibitors[key] = min(inhibitors.get(key, arc.weight), arc.weight)
        elif str(arc.kind) == "read":
            effects["read", *key] += arc.weight
        else:
            effects["take" if isinstance(source, pn.Place) else "put", *key] += arc.weight
    return {
        "tokens": [place.tokens for place in places(net)],
        "effects": effects,
        "inhibitors": inhibitors,
        "intervals": [interval(transition) for transition in transitions(net)],
        "above": {number[t]: sorted(number[low] for low in under(t)) for t in transitions(net)},
    }


def interval(transition: pn.Transition) -> tuple[Fraction, Fraction | None, bool, bool]:
    given = transition.interval or pn.TimeInterval()
    latest = None if given.latest is None else fraction_of(given.latest)
    opens = latest is not None and bool(given.latestExcluded)
    return fraction_of(given.earliest), latest, bool(given.earliestExcluded), opens


def under(transition: pn.Transition) -> set[pn.Transition]:
    found: set[pn.Transition] = set()
    todo = list(transition.overrides)
    while todo:
        low = todo.pop()
        if low not in found:
            found.add(low)
            todo.extend(low.overrides)
    return found


@given(plain_nets())
def test_reading_what_was_written_gives_a_net_of_the_same_meaning(net: pn.Net) -> None:
    try:
        content = net_content(net)
    except ModelFileError as error:
        assert "priorities" in str(error)
        assume(False)
    again = net_from_content(content, PATH)
    assert meaning(again) == meaning(net)
    assert [p.name or p.id for p in places(again)] == [p.name or p.id for p in places(net)]
    once_more = net_from_content(net_content(again), PATH)
    assert meaning(once_more) == meaning(net)
    assert [t.id for t in transitions(once_more)] == [t.id for t in transitions(again)]


FILE = """<?xml version="1.0" encoding="UTF-8" ?>
<romeo version="Romeo v3.8.4-rc1">{end_of_head}
<TPN name="/home/someone/nets/crossing.xml">
  <place id="1" identifier="far" label="Far away" initialMarking="2" eft="0" lft="inf">
      <graphics color="0">
         <position x="10.5" y="20"/>
         <deltaLabel deltax="10" deltay="10"/>
      </graphics>
      <scheduling gamma="0" omega="0"/>
  </place>
  <place id="7" identifier="near" label="near" initialMarking="0" eft="0" lft="inf"/>
  <transition id="1" identifier="come" label="come" eft="1.5" eftIncl="1" lft="7/3" lftIncl="0"
     speed="1" priority="0" cost="3" unctrl="1" obs="0" guard="">
     <update><![CDATA[// nothing
     ]]></update>
  </transition>
  <transition id="2" identifier="go" label="go" eft="2" lft="inf" speed="1" priority="4" guard=""/>
  <arc place="1" transition="1" type="PlaceTransition" weight="2" tokenColor="-1" inhibitingCondition="">
    <nail xnail="0" ynail="0"/>
    <graphics  color="0">
     </graphics>
  </arc>
  <arc place="1" transition="1" type="read" weight="3" tokenColor="-1"/>
  <arc place="7" transition="1" type="logicalInhibitor" weight="2"/>
  <arc place="7" transition="1" type="TransitionPlace" weight="1" tokenColor="-1"/>
  <arc place="7" transition="2" type="PlaceTransition" weight="1"/>
  <timedCost></timedCost>
  <nbTokenColor>0</nbTokenColor>
  <declaration><![CDATA[// insert here your type definitions]]></declaration>
  <initialization><![CDATA[// state variables]]></initialization>
  <project nbinput="0" openinput="0" nbinclude="0"></project>
  <preferences>
      <colorPlace c0="SkyBlue2" c1="gray"/>
  </preferences>
</TPN>{end}
"""


@pytest.mark.parametrize(("end_of_head", "end"), [("</romeo>", ""), ("", "</romeo>")])
def test_a_file_as_romeo_writes_it(end_of_head: str, end: str) -> None:
    net = parse(FILE.format(end_of_head=end_of_head, end=end))
    assert net.id == "crossing"
    assert [(p.id, p.name, p.tokens) for p in places(net)] == [("far", "Far away", 2), ("near", None, 0)]
    come, go = transitions(net)
    third = exact_number("7/3")
    assert interval(come) == (Fraction(3, 2), fraction_of(third), False, True)
    assert interval(go) == (Fraction(2), None, False, False)
    assert (list(come.overrides), list(go.overrides)) == ([], [come])
    assert [(str(a.kind), a.source.id, a.target.id, a.weight) for a in arcs(net)] == [
        ("normal", "far", "come", 2),
        ("read", "far", "come", 1),  # Romeo compares the marking with 3, of which 2 are taken
        ("inhibitor", "near", "come", 2),
        ("normal", "come", "near", 1),
        ("normal", "near", "go", 1),
    ]
    graphics = find(net, "far", pn.Place).graphics
    assert graphics is not None and (graphics.positions[0].x, graphics.positions[0].y) == (10.5, 20)
    assert str(location_of(come)) == "example.xml:13"  # where its tag ends


def test_what_is_written_looks_like_this() -> None:
    net = pn.Net(id="n", name="two words")
    page = pn.Page(id="page", net=net)
    idle, busy = pn.Place(id="idle.1", tokens=2, page=page), pn.Place(id="1st", name="Busy", page=page)
    work = pn.Transition(id="work", page=page, interval=pn.TimeInterval(earliest=0.1, latest=0.2))
    flow(idle, work, busy, weight=2)
    read(idle, work)
    inhibit(busy, work, 3)
    text = net_content(net).decode()
    assert '<place id="1" identifier="idle_1" label="idle.1" initialMarking="2" eft="0" lft="inf">' in text
    assert '<place id="2" identifier="_1st" label="Busy" initialMarking="0"' in text
    assert 'label="work" eft="0.1" eftIncl="1" lft="0.2" lftIncl="1" speed="1" priority="0"' in text
    assert '<arc place="1" transition="1" type="read" weight="3"' in text
    assert '<arc place="2" transition="1" type="logicalInhibitor" weight="3"' in text


PLACE = '<place id="1" identifier="p" label="p" initialMarking="1" eft="0" lft="inf" {}/>\n'
STEP = '<transition id="1" identifier="t" label="t" eft="0" lft="1" {}>{}</transition>\n'
ARC = '<arc place="1" transition="1" type="PlaceTransition" weight="1" {}/>\n'


def net_with(place: str = "", step: str = "", inside: str = "", arc: str = "", more: str = "") -> str:
    """Return a file in which attributes that are given replace those of the same name."""
    lines = [PLACE.format(place), STEP.format(step, inside), ARC.format(arc)]
    for line, attributes in enumerate((place, step, arc)):
        for name in (part.partition("=")[0] for part in attributes.split()):
            head, sign, rest = lines[line].partition(f' {name}="')
            if sign and f' {name}="' in rest:
                lines[line] = head + rest.partition('"')[2]
    return "<TPN name='n'>\n" + "".join(lines) + more + "</TPN>"


REFUSED: dict[str, tuple[str, str, int]] = {
    "a stopwatch arc": (net_with(arc='type="timedInhibitor"'), "no stopwatches", 4),
    "a flush arc": (net_with(arc='type="flush"'), "takes all tokens", 4),
    "an unknown arc": (net_with(arc='type="x"'), "an arc of type 'x' is not read", 4),
    "a speed": (net_with(step='speed="0"'), "transition t: speed '0' is not read (clocks", 3),
    "a processor": (net_with(more='<place id="2" label="q"><scheduling gamma="1"/></place>'), "stopwatch", 5),
    "a parameter": (net_with(step='eft_param="a"'), "transition t: eft_param 'a' is not read (a bound", 3),
    "a symbolic bound": (net_with(step='lft="a+1"'), "transition t: lft is a number, not 'a+1' (param", 3),
    "a constraint": (
        net_with(more='<misc>\n<constraint left="a" op="Lower" right="b"/></misc>'),
        "a constraint on parameters is not read",
        6,
    ),
    "a guard": (net_with(step='guard="x>1"'), "guards on variables are not read", 3),
    "an update": (net_with(inside="<update>x = 1;</update>"), "an update is not read", 3),
    "a colour": (net_with(arc='tokenColor="0"'), "tokens with colours are not read", 4),
    "a condition": (net_with(arc='inhibitingCondition="x>1"'), "conditions on inhibitor arcs", 4),
    "an interval of a place": (net_with(place='lft="3"'), "place p: lft '3' is not read (intervals of", 2),
    "another file": (net_with(more='<project>\n<input id="1" file="a.xml"/></project>'), "another file", 6),
    "synchronisation": (net_with(more='<synchronization listSynch="1 2"/>'), "fire together", 5),
    "an unknown element": (net_with(more="<queue/>"), "<queue> is not an element of Romeo's nets", 5),
    "an empty interval": (net_with(step='eft="3"'), "transition t: the interval from 3 to 1 is empty", 3),
    "an open point": (net_with(step='eft="1" eftIncl="0"'), "the interval from 1 to 1 is empty", 3),
    "a negative bound": (net_with(step='eft="-1"'), "transition t: eft is -1", 3),
    "not a number": (net_with(step='eft="nan"'), "transition t: eft is a number, not 'nan'", 3),
    "an unknown flag": (net_with(step='eftIncl="x"'), "eftIncl is 1 or 0", 3),
    "no bound": (net_with(step='lft=""'), "<transition> has no lft", 3),
    "a marking of a variable": (net_with(place='initialMarking="x"'), "initialMarking takes a whole", 2),
    "a negative marking": (net_with(place='initialMarking="-1"'), "initialMarking is 0 or more", 2),
    "a weight of nothing": (net_with(arc='weight="0"'), "weight is 1 or more", 4),
    "an unknown place": (net_with(arc='place="9"'), "the arc names place '9', which does not exist", 4),
    "two places of an id": (net_with(more=PLACE.format("")), "the id '1' is taken by another place", 5),
    "an arc twice": (net_with(more=ARC.format("")), "two arcs of type PlaceTransition join place p", 5),
    "an unknown attribute of a place": (
        net_with(place='capacity="1"'),
        "p: has an unknown attribute 'cap",
        2,
    ),
    "an unknown attribute of a step": (net_with(step='reset="1"'), "has an unknown attribute 'reset'", 3),
    "an unknown attribute of an arc": (net_with(arc='wieght="2"'), "(did you mean 'weight'?)", 4),
    "an unknown element of a step": (net_with(inside="<when/>"), "<when> is not part of a <transition>", 3),
    "text of a step": (net_with(inside="x = 1"), "transition t: the text 'x = 1' inside <transition>", 3),
    "text of the net": (net_with(more="p > 0"), "the text 'p > 0' inside <TPN> is not read", 1),
    "two nets": (f"<romeo>{net_with()}\n{net_with()}</romeo>", "holds two nets (a model is one <TPN>)", 6),
    "another root": ("<pnml/>", "is not a net of Romeo: its root is <pnml> (rename the file to .pnml)", 1),
    "no net": ("<romeo><x/></romeo>", "its root is <romeo>", 1),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_time_petri_net_cannot_say_is_refused_with_its_line(name: str, tmp_path: Path) -> None:
    text, message, line = REFUSED[name]
    (tmp_path / "net.xml").write_text(text, encoding="utf-8")
    with pytest.raises(ModelFileError) as caught:
        load(tmp_path / "net.xml")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.location is not None and caught.value.location.line == line


def test_the_file_that_is_refused_is_read_without_what_it_is_refused_for() -> None:
    assert [t.id for t in transitions(parse(net_with()))] == ["t"]


def test_what_has_no_place_in_the_format_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "out.xml"
    with pytest.raises(ModelFileError, match="with channels cannot be written for Romeo"):
        save(small_system(), path)
    silent = small_system()
    silent.channels.clear()
    with pytest.raises(ModelFileError, match="'take' has a clause"):
        save(silent, path)
    page = pn.Page(id="page", objects=[pn.Place(id="p", capacity=3)])
    with pytest.raises(ModelFileError, match="place 'p' has a capacity"):
        save(pn.Net(id="n", pages=[page]), path)
    steps = [pn.Transition(id=name) for name in "abc"]
    steps[0].overrides.append(steps[1])
    with pytest.raises(ModelFileError, match="cannot express"):
        save(pn.Net(id="n", pages=[pn.Page(id="page", objects=steps)]), path)
    assert list(tmp_path.iterdir()) == []


def test_priorities_that_numbers_can_say_are_written_as_numbers() -> None:
    steps = [pn.Transition(id=name) for name in "abcd"]
    for high in steps[:2]:
        high.overrides.extend(steps[2:])
    net = pn.Net(id="n", pages=[pn.Page(id="page", objects=steps)])
    again = net_from_content(net_content(net), PATH)
    assert {t.id: [low.id for low in t.overrides] for t in transitions(again)} == {
        "a": ["c", "d"],
        "b": ["c", "d"],
        "c": [],
        "d": [],
    }


def test_a_system_model_without_channels_and_clauses_is_a_net(tmp_path: Path) -> None:
    model = sym.SystemModel(id="m", pages=[sym.NodeNet(id="n", objects=[sym.Place(id="p", tokens=1)])])
    save(model, tmp_path / "m.xml")
    assert [(p.id, p.tokens) for p in places(load(tmp_path / "m.xml"))] == [("p", 1)]
