"""PNML of other tools is read with a note, and nothing that concerns the behaviour is dropped."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from dineros.metamodel import pn
from dineros.metamodel.elements import arcs, find, places, transitions
from dineros.metamodel.errors import CollectedModelFileError, ModelFileError
from dineros.metamodel.files.pnml import pnml_bytes
from dineros.metamodel.files.remarks import remarks_of
from tests.support.equality import differences
from tests.support.pnml import PNML, again, document, read_net, read_text

NODES = (
    '<place id="p" {place}>{inplace}</place>\n<transition id="t" {transition}>{intransition}</transition>\n'
)
EDITOR_MARK = '<toolspecific tool="ModernPetriEditor" version="1.0" type="inhibitor"/>'
ARC = '<arc id="a" source="p" target="t" {arc}>{inarc}</arc>\n'


def page(extra: str = "", **parts: str) -> str:
    """Return a page with a place, a transition and an arc on lines 5 to 7, with some parts filled in."""
    names = ("place", "inplace", "transition", "intransition", "arc", "inarc")
    filled = (NODES + ARC).format(**{name: parts.get(name, "") for name in names})
    return f'<page id="g">\n{filled}{extra}</page>'


def the_arc(net: pn.Net) -> pn.Arc:
    return find(net, "a", pn.Arc)


def the_place(net: pn.Net) -> pn.Place:
    return find(net, "p", pn.Place)


def the_interval(net: pn.Net) -> tuple[float, float | None, bool, bool]:
    interval = find(net, "t", pn.Transition).interval
    assert interval is not None
    return interval.earliest, interval.latest, interval.earliestExcluded, interval.latestExcluded


def mathml(closure: str, low: str, high: str) -> str:
    space = "http://www.w3.org/1998/Math/MathML"
    return f'<delay><interval xmlns="{space}" closure="{closure}">{low}{high}</interval></delay>'


READ: dict[str, tuple[str, Callable[[pn.Net], object], object]] = {
    "attribute inhibitor": (page(arc='type="inhibitor"'), lambda net: str(the_arc(net).kind), "inhibitor"),
    "element inhibitor": (
        page(inarc='<type value="inhibitor"/>'),
        lambda net: str(the_arc(net).kind),
        "inhibitor",
    ),
    "text inhibitor": (
        page(inarc="<arctype><text>inhibitor</text></arctype>"),
        lambda net: str(the_arc(net).kind),
        "inhibitor",
    ),
    "attribute test": (page(arc='type="test"'), lambda net: str(the_arc(net).kind), "read"),
    "attribute read": (page(arc='type="read"'), lambda net: str(the_arc(net).kind), "read"),
    "attribute normal": (page(arc='type="normal"'), lambda net: str(the_arc(net).kind), "normal"),
    "Renew's normal arc": (
        page(inarc="<type><text>ordinary</text></type>"),
        lambda net: str(the_arc(net).kind),
        "normal",
    ),
    "two forms that agree": (
        page(arc='type="inhibitor"', inarc='<type value="inhibitor"/>'),
        lambda net: str(the_arc(net).kind),
        "inhibitor",
    ),
    "attribute weight": (page(arc='weight="3"'), lambda net: the_arc(net).weight, 3),
    "attribute inscription": (page(arc='inscription="4"'), lambda net: the_arc(net).weight, 4),
    "TAPAAL's weight": (
        page(arc='inscription="1" weight="2" type="normal"'),
        lambda net: the_arc(net).weight,
        2,
    ),
    "TAPAAL's weight without time": (
        page(arc='inscription="[0,inf)" weight="2" type="timed"'),
        lambda net: (the_arc(net).weight, str(the_arc(net).kind)),
        (2, "normal"),
    ),
    "TAPAAL's inhibitor": (
        page(arc='inscription="[0,inf)" weight="2" type="tapnInhibitor"'),
        lambda net: (the_arc(net).weight, str(the_arc(net).kind)),
        (2, "inhibitor"),
    ),
    "value": (
        page(inarc="<inscription><value>5</value><graphics/></inscription>"),
        lambda net: the_arc(net).weight,
        5,
    ),
    "PIPE's weight": (
        page(inarc="<inscription><value>Default,5</value></inscription>"),
        lambda net: the_arc(net).weight,
        5,
    ),
    "attribute marking": (page(place='initialMarking="3"'), lambda net: the_place(net).tokens, 3),
    "marking without text": (
        page(inplace="<initialMarking> 3 </initialMarking>"),
        lambda net: the_place(net).tokens,
        3,
    ),
    "PIPE's marking": (
        page(inplace="<initialMarking><value>Default,2,Red,0</value></initialMarking>"),
        lambda net: the_place(net).tokens,
        2,
    ),
    "attribute capacity": (page(place='capacity="4"'), lambda net: the_place(net).capacity, 4),
    "PIPE's capacity": (
        page(inplace="<capacity><value>4</value></capacity>"),
        lambda net: the_place(net).capacity,
        4,
    ),
    "PIPE's missing capacity": (
        page(inplace="<capacity><value>0</value></capacity>"),
        lambda net: the_place(net).capacity,
        None,
    ),
    "TAPAAL's invariant": (page(place='invariant="&lt; inf"'), lambda net: the_place(net).capacity, None),
    "attribute name": (page(place='name="Idle"'), lambda net: the_place(net).name, "Idle"),
    "neutral": (
        page(
            '<transition id="u" priority="0"/>',
            transition='urgent="false" player="1" infiniteServer="true" positionX="1"',
        ),
        lambda net: len(list(transitions(net))),
        2,
    ),
    "the same priority": (
        page('<transition id="u" priority="3"/>', transition='priority="3"'),
        lambda net: len(list(transitions(net))),
        2,
    ),
    "the same priority and timing in other words": (
        page('<transition id="u" priority="1" timed="0"/>', transition='priority="01" timed="false"'),
        lambda net: len(list(transitions(net))),
        2,
    ),
    "closed delay": (
        page(intransition=mathml("closed", "<cn>4</cn>", "<cn>9</cn>")),
        the_interval,
        (4.0, 9.0, False, False),
    ),
    "half open delay": (
        page(intransition=mathml("open-closed", "<cn>3</cn>", "<cn>5</cn>")),
        the_interval,
        (3.0, 5.0, True, False),
    ),
    "unbounded delay": (
        page(intransition=mathml("closed-open", "<cn>4</cn>", "<ci>infty</ci>")),
        the_interval,
        (4.0, None, False, False),
    ),
    "no page": (
        NODES.format(place="", inplace="", transition="", intransition="")
        + '<arc id="a" source="t" target="p"/>',
        lambda net: [page.id for page in net.pages],
        ["page"],
    ),
    "arc without id": (page('<arc source="t" target="p"/>'), lambda net: len(list(arcs(net))), 2),
    "arc ids twice": (page('<arc id="a" source="t" target="p"/>'), lambda net: len(list(arcs(net))), 2),
    "arc id of a place": (page('<arc id="p" source="t" target="p"/>'), lambda net: len(list(arcs(net))), 2),
    "drawn": (
        page(
            place='positionX="1" nameOffsetX="2" markingOffsetY="3" displayName="true"',
            inarc="<arcpath/><tagged/>",
        ),
        lambda net: len(list(places(net))),
        1,
    ),
    "arc ids as of PIPE": (
        page('<arc id="t to p" source="t" target="p"/><arc id="t_to_p" source="t" target="p"/>'),
        lambda net: [arc.id for arc in arcs(net)],
        ["a", "t_to_p_2", "t_to_p"],
    ),
    "ids of names": (
        '<page id="g"><place id="my place"><name><text>my place</text></name></place><transition id="t 1"/>'
        '<arc id="a" source="t 1" target="my place"/></page>',
        lambda net: [(node.id, node.name) for node in (*places(net), *transitions(net))],
        [("my_place", "my place"), ("t_1", None)],
    ),
    "distribution": (
        page(transition='distribution="constant" value="2.0" firingMode="Oldest" weight="1.0" player="1"'),
        lambda net: len(list(transitions(net))),
        1,
    ),
    "ProM": (
        page() + '<finalmarkings><marking><place idref="p"><text>1</text></place></marking></finalmarkings>',
        lambda net: len(list(places(net))),
        1,
    ),
}


@pytest.mark.parametrize("name", READ)
def test_what_is_meant_is_read(name: str, tmp_path: Path) -> None:
    text, look, expected = READ[name]
    net = read_net(tmp_path, text)
    assert look(net) == expected
    assert not differences(net, again(tmp_path, net))


EMPTY = f'<pnml xmlns="{PNML}">' + '<net id="n"{}><page id="g"/></net>{}</pnml>'
REFUSED = {
    "reset": (page(arc='type="reset"'), "'reset' is not a type of an arc", 7),
    "stopwatch": (page(inarc='<type value="stopwatch"/>'), "'stopwatch' is not a type", 7),
    "unknown type": (page(arc='type="flush"'), "'flush' is not a type", 7),
    "unknown attribute of a place": (page(place='tokens="3"'), "'p' has an unknown attribute 'tokens'", 5),
    "unknown attribute of a transition": (
        page(transition='guard="x &gt; 1"'),
        "unknown attribute 'guard'",
        6,
    ),
    "value of a transition": (page(transition='value="2"'), "unknown attribute 'value'", 6),
    "unknown attribute of an arc": (page(arc='multiplicity="3"'), "unknown attribute 'multiplicity'", 7),
    "unknown attribute of a page": (
        '<page id="g" kind="x"/>',
        "<page> 'g' has an unknown attribute 'kind'",
        4,
    ),
    "attribute of another namespace": (page(place='xmlns:x="urn:x" x:capacity="1"'), "unknown attribute", 5),
    "attribute of a marking": (
        page(inplace='<initialMarking value="3"/>'),
        "<initialMarking> has an unknown attribute 'value'",
        5,
    ),
    "attribute of an inscription": (page(inarc='<inscription kind="x"/>'), "<inscription> has an unknown", 7),
    "unknown element": (page(inplace="<tokens>3</tokens>"), "<tokens> is not part of the <place>", 5),
    "guard": (page(intransition="<guard/>"), "<guard> is not part of the <transition>", 6),
    "urgent": (page(transition='urgent="true"'), "transition 't' is urgent", 6),
    "two priorities": (
        page('<transition id="u" priority="2"/>', transition='priority="1"'),
        "transition 'u' has the priority 2, and 't' has the priority 1 on line 6",
        8,
    ),
    "one priority": (page('<transition id="u"/>', transition='priority="2"'), "'u' has the priority 0", 8),
    "immediate and timed": (
        page(
            '<transition id="u"><timed><value>true</value></timed></transition>',
            intransition="<timed><value>false</value></timed>",
        ),
        "'u' has timed = true, and 't' has timed = false on line 6",
        8,
    ),
    "age": (page(arc='inscription="[1,3]" type="timed"'), "arc 'a' has the interval '[1,3]'", 7),
    "invariant": (page(place='invariant="&lt;= 3"'), "place 'p' has the invariant '<= 3'", 5),
    "two classes": (
        page(inplace="<initialMarking><value>Default,1,Red,2</value></initialMarking>"),
        "tokens of several classes",
        5,
    ),
    "another class": (
        page(
            inplace="<initialMarking><value>Default,1</value></initialMarking>",
            inarc="<inscription><value>Red,1</value></inscription>",
        ),
        "tokens of two classes: 'Default' on line 5, 'Red' here",
        7,
    ),
    "two markings": (
        page(
            inplace=""
            "<initialMarking><text>1</text></initialMarking>\n<initialMarking><text>1</text></initialMarking>"
        ),
        "<place> 'p' has two <initialMarking>, on lines 5 and 6",
        6,
    ),
    "two inscriptions": (
        page(inarc="<inscription><text>2</text></inscription>\n<inscription><text>3</text></inscription>"),
        "<arc> 'a' has two <inscription>, on lines 7 and 8",
        8,
    ),
    "two types": (
        page(inarc='<type value="normal"/>\n<type value="inhibitor"/>'),
        "<arc> 'a' has two <type>, on lines 7 and 8",
        8,
    ),
    "two types in two forms": (
        page(inarc='<type value="normal"/>\n' + EDITOR_MARK),
        "arc 'a' is inhibitor on line 8 and normal on line 7",
        7,
    ),
    "two capacities": (page(inplace="<capacity>1</capacity>\n<capacity>1</capacity>"), "two <capacity>", 6),
    "two markings in two forms": (
        page(place='initialMarking="1"', inplace="<initialMarking><text>2</text></initialMarking>"),
        "<place> 'p' gives its marking twice: '2' and '1'",
        5,
    ),
    "two weights in two forms": (page(arc='weight="2" inscription="3"'), "gives its weight twice", 7),
    "delay of nothing": (page(intransition="<delay/>"), "<delay> holds one <interval>", 6),
    "empty delay": (
        page(intransition=mathml("closed", "<cn>4</cn>", "<cn>3</cn>")),
        "the interval is empty",
        6,
    ),
    "delay of a name": (
        page(intransition=mathml("closed", "<cn>4</cn>", "<ci>d</ci>")),
        "'d' is not a number",
        6,
    ),
    "text next to text": (
        page(inplace="<initialMarking>3<text>1</text></initialMarking>"),
        "<initialMarking> holds the text '3' outside of <text>",
        5,
    ),
    "text in two parts": (
        page(inplace="<initialMarking>1<graphics/>0</initialMarking>"),
        "<initialMarking> holds the text '10' in parts",
        5,
    ),
    "text behind a drawing": (
        page(inarc="<inscription><graphics/>7</inscription>"),
        "<inscription> holds the text '7' in parts",
        7,
    ),
    "text of another namespace": (
        page(inplace='<initialMarking><text xmlns="urn:x">3</text></initialMarking>'),
        "<text> is not part of a label",
        5,
    ),
    "thousands": (page(place='initialMarking="1,500"'), "the initial marking '1,500' is not a whole", 5),
    "a decimal comma": (
        page(inarc="<inscription><text>2,5</text></inscription>"),
        "the weight '2,5' is not a whole number",
        7,
    ),
    "digits as a class": (
        page(inplace="<initialMarking><value>Default,1,2,0</value></initialMarking>"),
        "'Default,1,2,0' is not a whole number",
        5,
    ),
    "text of a place": (page(inplace="3"), "<place> 'p' holds the text '3'", 5),
    "text of an arc": (page(inarc="inhibitor"), "<arc> 'a' holds the text 'inhibitor'", 7),
    "text of a page": ("<page id='g'>3</page>", "<page> 'g' holds the text '3'", 4),
    "attribute of a text": (
        page(inplace='<initialMarking><text class="x">1</text></initialMarking>'),
        "<text> has an unknown attribute 'class'",
        5,
    ),
    "two names": (
        page(inplace="<name><text>x</text></name>\n<name><text>x</text></name>"),
        "<place> 'p' has two <name>, on lines 5 and 6",
        6,
    ),
    "two names of a page": ("<page id='g'><name/>\n<name/></page>", "<page> 'g' has two <name>", 5),
    "two priorities in two forms": (
        page(transition='priority="2"', intransition="<priority><value>1</value></priority>"),
        "<transition> 't' gives its priority twice: '1' and '2'",
        6,
    ),
    "many servers with times": (
        page(transition='infiniteServer="true"', intransition=mathml("closed", "<cn>4</cn>", "<cn>9</cn>")),
        "'t' has an interval and infinitely many servers",
        6,
    ),
    "attribute of an interval": (
        page(intransition=mathml('closed" unit="ms', "<cn>4</cn>", "<cn>9</cn>")),
        "<interval> has an unknown attribute 'unit'",
        6,
    ),
    "number with an exponent": (
        page(intransition=mathml("closed", '<cn type="e-notation">2<sep/>3</cn>', "<cn>2000</cn>")),
        "<cn> is not understood",
        6,
    ),
    "number of another element": (
        page(intransition=mathml("closed", "<minus>4</minus>", "<cn>9</cn>")),
        "<minus> is not a number",
        6,
    ),
    "number of another base": (
        page(intransition=mathml("closed", '<cn base="16">10</cn>', "<cn>20</cn>")),
        "<cn> has an unknown attribute 'base'",
        6,
    ),
    "net inside of a page": ('<page id="g"><net id="h"/></page>', "<net> is not part of the <page>", 4),
    "attribute of the net": (EMPTY.format(' semantics="x"', ""), "'semantics'", 1),
    "next to the net": (EMPTY.format("", "<shared-place/>"), "<shared-place>", 1),
    "coloured feature": (EMPTY.format("", '<feature isColored="True"/>'), "coloured", 1),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_would_change_the_behaviour_is_refused(name: str, tmp_path: Path) -> None:
    text, message, line = REFUSED[name]
    with pytest.raises(ModelFileError) as caught:
        read_text(tmp_path, text if text.startswith("<pnml") else document(text))
    assert not isinstance(caught.value, CollectedModelFileError)
    assert message in str(caught.value)
    assert caught.value.location is not None and caught.value.location.line == line


def test_all_complaints_of_a_file_come_at_once(tmp_path: Path) -> None:
    broken = page(
        '<place id="q" tokens="1"/>\n<place id="q"/>\n<arc id="b" source="x" target="t" type="reset"/>\n',
        place='initialMarking="many"',
        transition='urgent="true"',
        inarc="<inscription>0</inscription>",
    )
    with pytest.raises(CollectedModelFileError) as caught:
        read_net(tmp_path, broken)
    lines = [error.location.line for error in caught.value.errors if error.location]
    assert lines == [5, 6, 7, 8, 9, 10, 10]


WRAPPED = """<net id="n" type="{type}"{more}>
<place id="p"><initialMarking><text>1</text></initialMarking></place><transition id="t"/>
<arc id="a" source="p" target="t"/></net>"""


@pytest.mark.parametrize(
    ("start", "type", "more", "notes"),
    [
        (f'<pnml xmlns="{PNML}">', "http://www.pnml.org/version-2009/grammar/pnmlcoremodel", "", 2),
        ("<pnml>", "http://www.informatik.hu-berlin.de/top/pntd/ptNetb", "", 3),
        ("<pnml>", "P/T net", "", 3),
        ("<pnml>", "http://www.yasper.org/specs/epnml-1.1", "", 3),
        ('<pnml xmlns="http://www.informatik.hu-berlin.de/top/pnml/ptNetb">', "P/T net", ' active="true"', 3),
        (f'<x:pnml xmlns:x="{PNML}">', "http://www.laas.fr/tina/tpn", "", 3),
    ],
)
def test_namespaces_and_types(start: str, type: str, more: str, notes: int, tmp_path: Path) -> None:
    end = "</x:pnml>" if start.startswith("<x") else "</pnml>"
    net = read_text(tmp_path, f"{start}{WRAPPED.format(type=type, more=more)}{end}")
    assert [place.tokens for place in places(net)] == [1]
    assert len(list(arcs(net))) == 1
    assert len(remarks_of(net)) == notes
    assert remarks_of(again(tmp_path, net)) == ()


def test_other_readers_see_inhibitor_arcs(tmp_path: Path) -> None:
    net = read_net(tmp_path, page(arc='type="inhibitor"'))
    text = pnml_bytes(net).decode()
    assert 'type="inhibitor"' in text.split("<arc")[1].split(">")[0]
    assert '<type value="inhibitor"/>' in text
    assert 'tool="ModernPetriEditor"' in text
    assert not differences(net, again(tmp_path, net))


def test_other_readers_see_read_arcs_as_a_pair_of_normal_ones(tmp_path: Path) -> None:
    net = read_net(tmp_path, page(arc='type="test" weight="2"'))
    text = pnml_bytes(net).decode()
    assert 'source="p" target="t"' in text and 'source="t" target="p"' in text
    assert text.count("<text>2</text>") == 2
    assert "<type" not in text
    assert str(the_arc(again(tmp_path, net)).kind) == "read"


@pytest.mark.parametrize(
    "inside",
    [
        '<arc kind="inhibitor"/>',
        "<kind> Inhibitor </kind>",
        '<x:arc xmlns:x="urn:x" is="reset"/>',
        "<inhibitor/>",
        "<isInhibitor>true</isInhibitor>",
        '<style inhibitor_arc="1"/>',
        '<arc type="read"/>',
        "<transfer>yes</transfer>",
    ],
)
def test_a_block_of_another_tool_that_names_a_kind_of_arc_is_noted(tmp_path: Path, inside: str) -> None:
    """Blocks are their tools' own; but a reader who means such an arc must learn that it is a normal one."""
    block = f'<toolspecific tool="sketch" version="1">{inside}</toolspecific>'
    net = read_net(tmp_path, page(inarc=block))
    assert str(the_arc(net).kind) == "normal"
    (remark,) = remarks_of(net)
    assert remark.startswith("arcs that blocks of 'sketch' call ")
    assert remark.endswith(" taken as normal: blocks are not read")


def test_a_block_of_another_tool_that_repeats_the_type_passes(tmp_path: Path) -> None:
    block = '<toolspecific tool="sketch" version="1"><arc kind="inhibitor"/></toolspecific>'
    net = read_net(tmp_path, page(inarc=f'<type value="inhibitor"/>{block}'))
    assert str(the_arc(net).kind) == "inhibitor"
    assert not remarks_of(net)
    assert not differences(net, again(tmp_path, net))


@pytest.mark.parametrize(
    "inside",
    ["<inhibitor>false</inhibitor>", '<arc inhibitor="0"/>', "<kind>normal</kind>", "<reset>no</reset>"],
)
def test_a_block_of_another_tool_that_denies_a_kind_of_arc_passes(tmp_path: Path, inside: str) -> None:
    block = f'<toolspecific tool="sketch" version="1">{inside}</toolspecific>'
    assert not remarks_of(read_net(tmp_path, page(inarc=block)))


@pytest.mark.parametrize(
    ("part", "inside", "name"),
    [
        ("inplace", "<capacity>3</capacity>", "capacity"),
        ("inplace", '<data Capacity="2"/>', "capacity"),
        ("inplace", "<capacity>0</capacity>", None),
        ("intransition", "<x:priority xmlns:x='urn:x'>2</x:priority>", "priority"),
        ("intransition", "<guard>x &gt; 1</guard>", "guard"),
        ("intransition", '<timing urgent="true"/>', "urgent"),
        ("intransition", '<timing urgent="false"/>', None),
        ("intransition", "<time>0</time><timeUnit>1</timeUnit><orientation>3</orientation>", None),
    ],
)
def test_a_block_of_another_tool_that_names_behaviour_of_a_node_is_noted(
    tmp_path: Path, part: str, inside: str, name: str | None
) -> None:
    block = f'<toolspecific tool="sketch" version="1">{inside}</toolspecific>'
    remarks = list(remarks_of(read_net(tmp_path, page(**{part: block}))))
    noted = f"blocks of 'sketch' that name a {name} left out: blocks are not read"
    assert remarks == ([noted] if name else [])


@pytest.mark.parametrize(
    ("parts", "hint"),
    [
        ({"place": 'marking="3"'}, "<initialMarking>"),
        ({"place": 'initialmarking="3"'}, "'initialMarking'"),
        ({"transition": 'cold="true"'}, "it may change the behaviour"),
        ({"intransition": "<time>3</time>"}, "a <delay>"),
        ({"arc": 'reset="true"'}, "takes all tokens"),
        ({"inarc": "<weight><text>3</text></weight>"}, "<inscription>"),
    ],
)
def test_hints_name_what_has_the_meaning_of_an_unknown_part(
    tmp_path: Path, parts: dict[str, str], hint: str
) -> None:
    with pytest.raises(ModelFileError) as caught:
        read_net(tmp_path, page(**parts))
    assert hint in (caught.value.hint or "")


def test_variables_pass_only_if_there_are_none(tmp_path: Path) -> None:
    assert not remarks_of(read_net(tmp_path, page() + "<variables/>"))
    with pytest.raises(ModelFileError, match="the net has data"):
        read_net(tmp_path, page() + "<variables><variable/></variables>")


def test_ids_with_white_space_may_have_any_other_characters(tmp_path: Path) -> None:
    """An id is text: braces in it are no place for a number."""
    text = page().replace('"p"', '"${id} {0} {"').replace('"t"', '"${id}_{0} {"')
    net = read_text(tmp_path, document(text))
    assert [each.id for each in (*places(net), *transitions(net))] == ["${id}_{0}_{", "${id}_{0}_{_2"]
