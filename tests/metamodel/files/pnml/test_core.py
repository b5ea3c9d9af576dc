"""PNML of ISO/IEC 15909-2 without any extension."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel import pn
from dineros.metamodel.elements import arcs, find, resolve
from dineros.metamodel.files.pnml import pnml_bytes, read_pnml, write_pnml
from dineros.metamodel.positions import location_of
from tests.support.equality import differences
from tests.support.pnml import PNML, again, document, drawing, read_net, read_text

NESTED = """
    <name><text>Nested</text></name>
    <page id="outer">
      <place id="p"><name><text>Idle</text></name><initialMarking><text>3</text></initialMarking></place>
      <page id="middle">
        <referencePlace id="r1" ref="p"/>
        <page id="inner">
          <referencePlace id="r2" ref="r1"/>
          <transition id="t"/>
          <arc id="a" source="r2" target="t"><inscription><text>2</text></inscription></arc>
        </page>
        <referenceTransition id="s" ref="t"/>
      </page>
    </page>
    <page id="other"><place id="q"/></page>
"""


def test_nested_pages_and_chains_of_references(tmp_path: Path) -> None:
    net = read_net(tmp_path, NESTED)
    assert type(net) is pn.Net
    assert (net.id, net.name) == ("net", "Nested")
    assert drawing(net) == {
        "outer": ["p", "middle"],
        "middle": ["r1", "inner", "s"],
        "inner": ["r2", "t", "r2>t"],
        "other": ["q"],
    }
    assert resolve(find(net, "r2", pn.Node)) is find(net, "p", pn.Element)
    assert resolve(find(net, "s", pn.Node)) is find(net, "t", pn.Element)
    assert find(net, "p", pn.Place).tokens == 3
    assert find(net, "a", pn.Arc).weight == 2
    assert not differences(net, again(tmp_path, net))


def test_plain_nets_use_plain_classes_and_no_blocks(tmp_path: Path) -> None:
    net = read_net(tmp_path, NESTED)
    assert type(find(net, "p", pn.Element)) is pn.Place
    assert type(find(net, "t", pn.Element)) is pn.Transition
    assert b"toolspecific" not in pnml_bytes(net)


def test_elements_remember_their_lines(tmp_path: Path) -> None:
    net = read_net(tmp_path, NESTED)
    location = location_of(find(net, "p", pn.Element))
    assert location is not None
    assert (location.file, location.line) == (tmp_path / "model.pnml", 6)


def test_order_of_parts_padding_and_unwrapped_text_do_not_matter(tmp_path: Path) -> None:
    net = read_net(
        tmp_path,
        """
        <page id="page">
          <arc id="a" target="t" source="p"><inscription> 4 </inscription></arc>
          <transition id="t"><name>
              <text>
                Go on
              </text></name></transition>
          <place id="p">
            <initialMarking> <text> 7
            </text> </initialMarking>
            <name> Ready </name>
          </place>
        </page>
        """,
    )
    assert find(net, "p", pn.Element).name == "Ready"
    assert find(net, "p", pn.Place).tokens == 7
    assert find(net, "t", pn.Element).name == "Go on"
    assert find(net, "a", pn.Arc).weight == 4


def test_graphics_of_nodes_arcs_and_labels(tmp_path: Path) -> None:
    net = read_net(
        tmp_path,
        """
        <page id="page">
          <place id="p">
            <name><text>P</text><graphics><offset x="1.5" y="-2"/><font size="9"/></graphics></name>
            <graphics>
              <position x="10" y="20.25"/><dimension x="30" y="40"/>
              <fill color="#fff"/><line shape="curve" width="2"/>
            </graphics>
            <initialMarking><graphics><offset x="3" y="4"/></graphics><text>0</text></initialMarking>
          </place>
          <transition id="t"/>
          <arc id="a" source="p" target="t">
            <graphics><position x="1" y="1"/><position x="2" y="2"/></graphics>
            <inscription><text>1</text><graphics><offset x="5" y="6"/></graphics></inscription>
          </arc>
        </page>
        """,
    )
    place, arc = find(net, "p", pn.Element), find(net, "a", pn.Element)
    assert place.graphics is not None and place.graphics.dimension is not None
    assert [(point.x, point.y) for point in place.graphics.positions] == [(10.0, 20.25)]
    assert (place.graphics.dimension.x, place.graphics.dimension.y) == (30.0, 40.0)
    assert place.graphics.style == '<fill color="#fff"></fill><line shape="curve" width="2"></line>'
    assert [str(label.kind) for label in place.labels] == ["elementName", "initialMarking"]
    first = place.labels[0].graphics
    assert first is not None and first.offset is not None
    assert (first.offset.x, first.offset.y, first.style) == (1.5, -2.0, '<font size="9"></font>')
    assert arc.graphics is not None
    assert [(point.x, point.y) for point in arc.graphics.positions] == [(1.0, 1.0), (2.0, 2.0)]
    assert [str(label.kind) for label in arc.labels] == ["inscription"]
    assert b"org.dineros" not in pnml_bytes(net)
    assert not differences(net, again(tmp_path, net))


@pytest.mark.parametrize(
    ("mark", "kind"),
    [
        ("", "normal"),
        ('<type value="normal"/>', "normal"),
        ('<type value="inhibitor"/>', "inhibitor"),
        ("<type><text>inhibitor</text></type>", "inhibitor"),
        ("<type><text> read </text></type>", "read"),
        ('<type value="test"/>', "read"),
        ('<toolspecific tool="ModernPetriEditor" version="1.0" type="inhibitor"/>', "inhibitor"),
    ],
)
def test_kinds_of_arcs(tmp_path: Path, mark: str, kind: str) -> None:
    page = '<page id="page"><place id="p"/><transition id="t"/>{}</page>'
    net = read_net(tmp_path, page.format(f'<arc id="a" source="p" target="t">{mark}</arc>'))
    (arc,) = arcs(net)
    assert str(arc.kind) == kind
    assert len(arc.toolInfos) == 0
    assert not differences(net, again(tmp_path, net))


def test_a_read_arc_is_written_as_a_pair_of_normal_arcs(tmp_path: Path) -> None:
    net = read_net(
        tmp_path,
        """
        <page id="page"><place id="p"/><transition id="t"/>
          <arc id="a" source="p" target="t">
            <type value="read"/><inscription><text>2</text></inscription>
          </arc>
        </page>
        """,
    )
    text = pnml_bytes(net).decode()
    assert '<arc id="a" source="p" target="t">' in text
    assert '<arc id="a.back" source="t" target="p">' in text
    assert text.count("<text>2</text>") == 2
    (arc,) = arcs(again(tmp_path, net))
    assert (arc.id, str(arc.kind), arc.weight) == ("a", "read", 2)


@pytest.mark.parametrize("change", ['target="p"', 'id="a.back"', "<text>2</text>"])
def test_half_a_read_arc_is_a_normal_arc(tmp_path: Path, change: str) -> None:
    """Another tool took one arc of the pair away or changed it: then nothing says "read" any more."""
    net = read_net(
        tmp_path,
        """
        <page id="page"><place id="p"/><place id="q"/><transition id="t"/>
          <arc id="a" source="p" target="t">
            <type value="read"/><inscription><text>2</text></inscription>
          </arc>
        </page>
        """,
    )
    text = pnml_bytes(net).decode()
    start = text.index('<arc id="a.back"')
    end = text.index("</arc>", start) + len("</arc>")
    if change.startswith("id"):
        text = text[:start] + text[end:]
    else:
        changed = text[start:end].replace(change, change.replace('"p"', '"q"').replace("2", "1"))
        text = text[:start] + changed + text[end:]
    assert {str(arc.kind) for arc in arcs(read_text(tmp_path, text))} == {"normal"}


def test_arcs_that_stand_elsewhere_move_to_their_ends(tmp_path: Path) -> None:
    net = read_net(
        tmp_path,
        """
        <page id="root">
          <arc id="a" source="p" target="t"/>
          <arc id="b" source="t" target="q"/>
          <arc id="c" source="q" target="t"/>
          <page id="left"><place id="p"/><transition id="t"/></page>
          <page id="right"><place id="q"/></page>
        </page>
        """,
    )
    assert drawing(net) == {
        "root": ["left", "right"],
        "left": ["p", "t", "q.left", "p>t", "t>q.left", "q.left>t"],
        "right": ["q"],
    }
    assert resolve(find(net, "q.left", pn.Node)) is find(net, "q", pn.Element)


def test_an_inserted_reference_takes_a_free_id_or_uses_one_that_is_there(tmp_path: Path) -> None:
    net = read_net(
        tmp_path,
        """
        <page id="left"><transition id="t"/><arc id="a" source="q" target="t"/><place id="q.left"/></page>
        <page id="right"><place id="q"/></page>
        <page id="third">
          <transition id="u"/><referencePlace id="r" ref="q"/><arc id="b" source="u" target="q"/>
        </page>
        """,
    )
    assert drawing(net)["left"] == ["t", "q.left", "q.left.2", "q.left.2>t"]
    assert drawing(net)["third"] == ["u", "r", "u>r"]


def test_firing_intervals_and_priorities_survive_in_our_own_blocks(tmp_path: Path) -> None:
    page = pn.Page(id="page")
    slow, quick = pn.Transition(id="slow"), pn.Transition(id="quick")
    slow.interval = pn.TimeInterval(earliest=1.5, latest=2.0, latestExcluded=True)
    quick.interval = pn.TimeInterval(earliest=3.0)
    quick.overrides.append(slow)
    page.objects.extend([slow, quick])
    net = pn.Net(id="net", pages=[page])
    back = again(tmp_path, net)
    assert type(back) is pn.Net
    assert not differences(net, back)
    assert list(find(back, "quick", pn.Transition).overrides) == [find(back, "slow", pn.Element)]


def test_prefixed_elements_are_read(tmp_path: Path) -> None:
    text = document('<page id="page"><place id="p"/></page>').replace("<", "<x:").replace("<x:/", "</x:")
    text = text.replace("<x:?", "<?").replace("xmlns=", "xmlns:x=")
    assert drawing(read_text(tmp_path, text)) == {"page": ["p"]}


def test_large_ids_of_all_kinds_are_kept(tmp_path: Path) -> None:
    page = pn.Page(id="Seite <1>", name="ä & 'b' \"c\"\n\td")
    page.objects.append(pn.Place(id="p&<>\"'😀", name=" padded "))
    page.objects.append(pn.Place(id="empty", name=""))
    net = pn.Net(id="net", pages=[page])
    assert not differences(net, again(tmp_path, net))


def test_writing_is_deterministic_and_leaves_nothing_but_the_file(tmp_path: Path) -> None:
    net = read_net(tmp_path, NESTED)
    write_pnml(net, tmp_path / "out.pnml")
    write_pnml(read_pnml(tmp_path / "out.pnml"), tmp_path / "second.pnml")
    assert (tmp_path / "out.pnml").read_bytes() == (tmp_path / "second.pnml").read_bytes() == pnml_bytes(net)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["model.pnml", "out.pnml", "second.pnml"]
    assert f'<pnml xmlns="{PNML}">' in (tmp_path / "out.pnml").read_text()
