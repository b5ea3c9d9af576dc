"""What is wrong with a PNML file is one line that names file, line and cause."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError, ModelFileError
from tests.support.pnml import DINEROS, PNML, PTNET, dineros, document, read_text

PAGE = '<page id="g">\n<place id="p"/><transition id="t"/>\n{}\n</page>'
OWN = '<toolspecific tool="org.dineros" version="1.0"><element{}</element></toolspecific>'
NODE = dineros("<type>nodePage</type>")
TIMED = "<type>timeTransitionType</type>"
TOPIC = '<transition id="c">' + dineros("<type>topicTransitionType</type>{}") + "</transition>"


def inside(content: str) -> str:
    """Return a file with one page that has a place `p`, a transition `t` and, on line 6, the content."""
    return document(PAGE.format(content))


BAD = {
    # the file as a whole
    "no PNML": ("<svg/>", "the root is <svg> without a namespace", 1),
    "old namespace": ('<pnml xmlns="old"/>', "holds no nets", 1),
    "no net": (f'<pnml xmlns="{PNML}"/>', "holds no nets", 1),
    "two nets": (
        f'<pnml xmlns="{PNML}"><net id="a" type="{PTNET}"/>\n<net id="b" type="{PTNET}"/></pnml>',
        "holds 2 nets",
        2,
    ),
    "other net type": (
        f'<pnml xmlns="{PNML}">\n<net id="a" type="http://www.pnml.org/version-2009/grammar/highlevelnet"/></pnml>',
        "highlevelnet' is not supported",
        2,
    ),
    "no page": (document("<name><text>n</text></name>"), "the net has no page", 3),
    # ids and references
    "no id": (inside("<place/>"), "<place> has no id", 6),
    "blank id": (inside('<place id=" "/>'), "<place> has no id", 6),
    "id twice": (
        inside('<place id="t"/>'),
        "the id 't' is taken (by line 5; all elements of a file share one space of ids)",
        6,
    ),
    "id of the net": (inside('<place id="net"/>'), "the id 'net' is taken", 6),
    "id of a signal twice": (
        inside(OWN.format(' class="sym.NodeNet"><signals id="p"/>')),
        "the id 'p' is taken",
        6,
    ),
    "arc without end": (inside('<arc id="a" source="p"/>'), "<arc> has no target", 6),
    "arc to nothing": (inside('<arc id="a" source="p" target="tt"/>'), "'tt', which does not exist", 6),
    "arc to a page": (
        inside('<arc id="a" source="p" target="g"/>'),
        "'g', which is not a place or transition",
        6,
    ),
    "arc to a topic": (
        inside(TOPIC.format("<topicName>x</topicName>") + '\n<arc id="a" source="p" target="c"/>'),
        "arc 'a' ends at the topic 'c'",
        7,
    ),
    "reference to nothing": (
        inside('<referencePlace id="r" ref="q"/>'),
        "'r' refers to 'q', which does not exist",
        6,
    ),
    "reference without target": (inside('<referencePlace id="r"/>'), "<referencePlace> has no ref", 6),
    "reference to the wrong kind": (
        inside('<referencePlace id="r" ref="t"/>'),
        "'t', which is not a place",
        6,
    ),
    "reference to a page": (
        inside('<referenceTransition id="r" ref="g"/>'),
        "'g', which is not a transition",
        6,
    ),
    # numbers
    "negative marking": (
        inside('<place id="q">\n<initialMarking><text>-1</text></initialMarking></place>'),
        "the initial marking '-1' is out of range",
        7,
    ),
    "huge marking": (
        inside('<place id="q"><initialMarking><text>2147483648</text></initialMarking></place>'),
        "it may be from 0 to 2147483647",
        6,
    ),
    "enormous marking": (
        inside(f'<place id="q"><initialMarking><text>{"9" * 100_000}</text></initialMarking></place>'),
        "out of range",
        6,
    ),
    "marking that is not a number": (
        inside('<place id="q"><initialMarking><text>1.5</text></initialMarking></place>'),
        "'1.5' is not a whole number",
        6,
    ),
    "foreign digits": (
        inside('<place id="q"><initialMarking><text>١</text></initialMarking></place>'),
        "is not a whole number",
        6,
    ),
    "weight 0": (
        inside('<arc id="a" source="p" target="t"><inscription><text>0</text></inscription></arc>'),
        "the weight '0' is out of range",
        6,
    ),
    "position that is not a number": (
        inside('<place id="q"><graphics><position x="1" y="nan"/></graphics></place>'),
        "y 'nan' is not a number",
        6,
    ),
    "position beyond numbers": (
        inside('<place id="q"><graphics><position x="1e999" y="1"/></graphics></place>'),
        "x '1e999' is not a number",
        6,
    ),
    "position without y": (
        inside('<place id="q"><graphics><position x="1"/></graphics></place>'),
        "<position> has no y",
        6,
    ),
    # what a P/T net does not have
    "capacity": (inside('<place id="q"><capacity/></place>'), "the capacity is empty", 6),
    "other namespace": (inside('<place id="q" xmlns="urn:x"/>'), "<place> is not part of the <page>", 6),
    "number in a label": (inside('<place id="q"><name><number/></name></place>'), "not part of a label", 6),
    "two texts in a label": (
        inside('<place id="q"><name><text>a</text>\n<value>b</value></name></place>'),
        "<name> has two texts, on lines 6 and 7",
        7,
    ),
    "arc type": (
        inside('<arc id="a" source="p" target="t"><type value="reset"/></arc>'),
        "'reset' is not a type",
        6,
    ),
    # the extension
    "version": (inside(f'<place id="q">{dineros("", "0.3")}</place>'), "version '0.3'", 6),
    "page type": (
        inside(f'<page id="h">{dineros("<type>nodepage</type>")}</page>'),
        "did you mean 'nodePage'",
        6,
    ),
    "transition type": (
        inside(f'<transition id="u">{dineros("<type>timeTransition</type>")}</transition>'),
        "did you mean 'timeTransitionType'",
        6,
    ),
    "field twice": (
        inside(f'<place id="q">{dineros("<subnet>a</subnet>")}{dineros("<subnet>b</subnet>")}</place>'),
        "<subnet> occurs here twice",
        6,
    ),
    "place type": (inside(f'<place id="q">{dineros("<type>start</type>")}</place>'), "not a type of", 6),
    "time": (
        inside(f'<transition id="u">{dineros(TIMED + "<time start=" + repr("x") + "/>")}</transition>'),
        "the start time 'x' is not a number",
        6,
    ),
    "executor": (
        inside(f'<page id="h">{dineros("<type>nodePage</type><executor>double</executor>")}</page>'),
        "the executor is single or multi, not 'double'",
        6,
    ),
    "threads": (
        inside(f'<page id="h">{dineros("<type>nodePage</type><threads>many</threads>")}</page>'),
        "the number of threads 'many'",
        6,
    ),
    "port to nothing": (
        inside(TOPIC.format("<publishers><publisher><id>pp</id></publisher></publishers>")),
        "a port names 'pp', which does not exist (did you mean 'p'?)",
        6,
    ),
    "port to a transition": (
        inside(TOPIC.format("<subscribers><subscriber><id>t</id></subscriber></subscribers>")),
        "a port names 't', a Transition, not a place",
        6,
    ),
    "port without a place": (
        inside(TOPIC.format("<publishers><publisher><limit>3</limit></publisher></publishers>")),
        "it has no <id>",
        6,
    ),
    "port to a circle of references": (
        inside(
            '<referencePlace id="r" ref="s"/><referencePlace id="s" ref="r"/>'
            + TOPIC.format("<publishers><publisher><id>r</id></publisher></publishers>")
        ),
        "references run in a circle: r -> s -> r",
        6,
    ),
    "clause without a node": (
        inside(f'<transition id="u">{dineros("<inputsignalclause>A</inputsignalclause>")}</transition>'),
        "'u' has an input clause but no node",
        6,
    ),
    "group without a node": (
        document(dineros("<callbackgroups><group><id>x</id></group></callbackgroups>") + '<page id="g"/>'),
        "the callback group 'x' names no node",
        4,
    ),
    "group of an unknown node": (
        document(
            dineros("<callbackgroups><group><id>x</id><node>y</node></group></callbackgroups>")
            + f'<page id="g">{NODE}</page>'
        ),
        "names the node 'y', which does not exist (nodes are g)",
        4,
    ),
    "callback page with a group outside of a node": (
        inside(f'<page id="h">{dineros("<type>callbackTimer</type><group>x</group>")}</page>'),
        "'h' names the group 'x'",
        6,
    ),
    "group type": (
        document(
            dineros("<callbackgroups><group><id>x</id><type>odd</type></group></callbackgroups>")
            + f'<page id="g">{NODE}</page>'
        ),
        "'odd' is not a kind of callback group",
        4,
    ),
    # our own blocks
    "newer block": (inside('<toolspecific tool="org.dineros" version="2.0"/>'), "version '2.0'", 6),
    "unknown class": (
        inside(f"<place id='q'>{OWN.format(' class=' + repr('sym.Plaze') + '>')}</place>"),
        "Plaze",
        6,
    ),
    "abstract class": (
        inside(f"<place id='q'>{OWN.format(' class=' + repr('pn.Node') + '>')}</place>"),
        "pn.Node",
        6,
    ),
    "class of another kind": (
        inside(f"<place id='q'>{OWN.format(' class=' + repr('sym.Transition') + '>')}</place>"),
        "sym.Transition is not a class of a place",
        6,
    ),
    "no class": (
        inside(f"<place id='q'>{OWN.format(' class=' + repr('eClass') + '>')}</place>"),
        "'eClass'",
        6,
    ),
    "unknown feature": (
        inside(f"<place id='q'>{OWN.format(' tokenz=' + repr('1') + '>')}</place>"),
        "did you mean 'tokens'",
        6,
    ),
    "wrong value": (
        inside(f"<place id='q'>{OWN.format(' tokens=' + repr('x') + '>')}</place>"),
        "whole number",
        6,
    ),
    "unknown literal": (
        inside(f"<arc id='a' source='p' target='t'>{OWN.format('><labels kind=' + repr('x') + '/>')}</arc>"),
        "kind must be one of elementName",
        6,
    ),
    "list as attribute": (
        inside(f"<place id='q'>{OWN.format(' labels=' + repr('x') + '>')}</place>"),
        "labels is not an attribute",
        6,
    ),
    "attribute as list": (
        inside(f"<place id='q'>{OWN.format('><tokens/>')}</place>"),
        "tokens contains nothing",
        6,
    ),
    "contained class of another kind": (
        inside(f"<place id='q'>{OWN.format('><labels class=' + repr('pn.Page') + '/>')}</place>"),
        "labels cannot be a Page",
        6,
    ),
    "reference to nothing in a block": (
        inside(f"<transition id='u'>{OWN.format('><overrides ref=' + repr('tt') + '/>')}</transition>"),
        "nothing has the id 'tt'",
        6,
    ),
    "reference to the wrong kind in a block": (
        inside(f"<transition id='u'>{OWN.format('><overrides ref=' + repr('p') + '/>')}</transition>"),
        "overrides cannot be 'p', which is a Place",
        6,
    ),
    "signal without id": (
        inside(f"<page id='h'>{NODE}{OWN.format('><signals/>')}</page>"),
        "<signals> has no id",
        6,
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_errors(name: str, tmp_path: Path) -> None:
    text, message, line = BAD[name]
    with pytest.raises(DinerosError) as caught:
        read_text(tmp_path, text)
    shown = str(caught.value)
    assert message in shown
    assert shown.startswith(f"{tmp_path / 'model.pnml'}:{line}: ")
    assert "\n" not in shown and len(shown) < 500


@pytest.mark.parametrize(
    "content",
    [
        '<arc id="a" source="p" target="p"/>',
        '<referencePlace id="r" ref="s"/><referencePlace id="s" ref="r"/>',
        '<referencePlace id="r" ref="r"/><arc id="a" source="r" target="t"/>',
        TOPIC.format("<publishers><publisher><id>p</id><limit>-3</limit></publisher></publishers>"),
        f'<page id="h">{dineros("<type>nodePage</type><threads>-1</threads>")}</page>',
        f'<place id="q">{dineros("<balloonMarking><token>no JSON</token></balloonMarking>")}</place>',
    ],
)
def test_what_validation_reports_can_be_read(content: str, tmp_path: Path) -> None:
    read_text(tmp_path, inside(content))


def test_the_largest_marking_and_lines_far_down(tmp_path: Path) -> None:
    marking = '<place id="q"><initialMarking><text>+{}</text></initialMarking></place>'
    read_text(tmp_path, inside(marking.format(2**31 - 1)))
    with pytest.raises(ModelFileError) as caught:
        read_text(tmp_path, inside("\n" * 100_000 + marking.format(2**31)))
    assert caught.value.location is not None
    assert caught.value.location.line == 100_006


def test_a_block_of_the_extension_inside_another_tool_is_not_read(tmp_path: Path) -> None:
    hidden = f'<toolspecific tool="x" version="1"><toolspecific tool="{DINEROS}" version="9"/></toolspecific>'
    assert type(read_text(tmp_path, inside(f'<place id="q">{hidden}</place>'))).__name__ == "Net"
