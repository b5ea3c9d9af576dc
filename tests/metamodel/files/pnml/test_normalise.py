"""Flat files of the DiNeROS extension become pages: node nets, subnets, references."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import find, node_nets, resolve
from dineros.metamodel.errors import ModelFileError
from tests.support.equality import differences
from tests.support.pnml import again, dineros, drawing, read_net, read_system


def of(node: str, subnet: str = "", more: str = "") -> str:
    """Return the block of an element of a flat file."""
    inner = f"<subnet>{subnet}</subnet>" if subnet else ""
    return dineros(f"<node>\n  {node}\n</node>{inner}{more}", "0.1")


def test_a_flat_file_of_two_nodes_with_a_service(tmp_path: Path) -> None:
    service = dineros(
        """<type>serviceTransitionType</type><serviceName>sense</serviceName>
        <serverInput>in</serverInput><serverOutput>out</serverOutput><serverCapacity>1</serverCapacity>
        <channels><channel><cid>c</cid><request>ask</request><response>told</response></channel></channels>""",
        "0.1",
    )
    clause = "<inputsignalclause>Ready</inputsignalclause>"
    model = read_system(
        tmp_path,
        f"""
        <page id="top">
          <transition id="start">{of("Client", "Work")}</transition>
          <place id="ask">{of("Client", "Work")}</place>
          <place id="told">{of("Client", "Work")}</place>
          <place id="in">{of("Server", "Serve")}</place>
          <transition id="sense">{of("Server", "Serve", clause)}</transition>
          <place id="out">{of("Server", "Serve")}</place>
          <place id="state">{of("Server", "State")}</place>
          <transition id="service">{service}</transition>
          <arc id="a1" source="start" target="ask"/>
          <arc id="a2" source="in" target="sense"/>
          <arc id="a3" source="sense" target="out"/>
          <arc id="a4" source="state" target="sense"/>
          <arc id="a5" source="sense" target="state"/>
        </page>
        """,
    )
    assert drawing(model) == {
        "top": ["Client", "Server"],
        "Client": ["Work"],
        "Work": ["start", "ask", "told", "start>ask"],
        "Server": ["Serve", "State"],
        "Serve": [
            *["in", "sense", "out", "state.Serve"],
            *["in>sense", "sense>out", "state.Serve>sense", "sense>state.Serve"],
        ],
        "State": ["state"],
    }
    assert [node_net.id for node_net in node_nets(model)] == ["Client", "Server"]
    (channel,) = model.channels
    assert isinstance(channel, sym.ServiceChannel)
    assert channel.server.page.id == "Serve"
    assert channel.canvas is find(model, "top", pn.Element)
    assert [signal.id for signal in node_nets(model)[1].signals] == ["Ready"]
    assert not differences(model, again(tmp_path, model))
    assert not differences(model, again(tmp_path, model, "0.1"))


def test_a_page_of_one_node_becomes_its_node_net(tmp_path: Path) -> None:
    model = read_system(
        tmp_path,
        f"""
        <page id="left"><graphics><position x="1" y="2"/></graphics><place id="p">{of("Robot")}</place></page>
        <page id="right"><name><text>Arm</text></name><place id="q">{of("Arm")}</place></page>
        <page id="Leg"><transition id="t">{of("Leg")}</transition></page>
        <page id="drawn"><name><text>My drawing</text></name><place id="r">{of("Head")}</place></page>
        """,
    )
    found = [(node_net.id, node_net.name) for node_net in node_nets(model)]
    assert found == [("left", "Robot"), ("right", "Arm"), ("Leg", None), ("Head", None)]
    assert node_nets(model)[0].graphics is not None
    assert drawing(model)["drawn"] == ["Head"]
    assert not differences(model, again(tmp_path, model))


def test_pages_inside_are_moved_whole_or_copied_where_shared(tmp_path: Path) -> None:
    model = read_system(
        tmp_path,
        f"""
        <page id="top">
          <page id="shared"><place id="p">{of("A")}</place><place id="q">{of("B")}</place></page>
          <page id="own"><place id="r">{of("A")}</place>
            <page id="deep"><place id="s">{of("A")}</place></page></page>
          <place id="u">{of("B")}</place>
        </page>
        """,
    )
    assert drawing(model) == {
        "top": ["shared", "B", "A"],
        "shared": [],
        "B": ["shared.B", "u"],
        "shared.B": ["q"],
        "A": ["shared.A", "own"],
        "shared.A": ["p"],
        "own": ["r", "deep"],
        "deep": ["s"],
    }
    assert find(model, "shared.B", pn.Element).name == "shared"


def test_a_node_on_several_top_level_pages_gets_a_page_of_its_own(tmp_path: Path) -> None:
    model = read_system(
        tmp_path,
        f"""
        <page id="one"><place id="p">{of("A")}</place></page>
        <page id="two"><place id="q">{of("A")}</place><place id="r">{of("B")}</place></page>
        """,
    )
    assert [page.id for page in model.pages] == ["two", "A"]
    assert drawing(model)["A"] == ["two.A", "one"]


def test_elements_join_the_node_page_of_their_name(tmp_path: Path) -> None:
    model = read_system(
        tmp_path,
        f"""
        <page id="n1"><name><text>Robot</text></name>{dineros("<type>nodePage</type>")}<place id="p"/></page>
        <page id="rest"><transition id="t">{of("Robot")}</transition><transition id="u"/></page>
        """,
    )
    assert drawing(model) == {"n1": ["p", "t"], "rest": ["u"]}
    assert len(node_nets(model)) == 1


def test_subnets_match_pages_that_are_there(tmp_path: Path) -> None:
    model = read_system(
        tmp_path,
        f"""
        <page id="Robot">{dineros("<type>nodePage</type>")}
          <page id="x"><name><text>Serve</text></name><place id="p">{of("Robot", "Serve")}</place></page>
          <place id="q">{of("Robot", "Serve")}</place>
          <place id="r">{of("Robot", "Robot")}</place>
          <place id="s">{of("Robot", "Free")}</place>
        </page>
        """,
    )
    assert drawing(model) == {"Robot": ["x", "r", "Free"], "x": ["p", "q"], "Free": ["s"]}


def test_references_follow_the_node_they_are_joined_to(tmp_path: Path) -> None:
    model = read_system(
        tmp_path,
        f"""
        <page id="top">
          <place id="p">{of("A")}</place><place id="q">{of("B")}</place>
          <transition id="t">{of("A")}</transition>
          <referencePlace id="r" ref="p"/><arc id="a" source="r" target="t"/>
          <referencePlace id="lonely" ref="q"/>
        </page>
        """,
    )
    assert drawing(model) == {"top": ["lonely", "A", "B"], "A": ["p", "t", "r", "r>t"], "B": ["q"]}


def test_page_ids_stay_unique(tmp_path: Path) -> None:
    model = read_system(
        tmp_path,
        f"""<page id="top"><place id="A">{of("A")}</place><place id="p">{of("B", "A")}</place></page>""",
    )
    assert drawing(model) == {"top": ["A.2", "B"], "A.2": ["A"], "B": ["A.3"], "A.3": ["p"]}
    assert [(node_net.id, node_net.name) for node_net in node_nets(model)] == [("A.2", "A"), ("B", None)]
    assert find(model, "A.3", pn.Element).name == "A"
    assert not differences(model, again(tmp_path, model))


def test_elements_of_no_node_stay_where_they_are(tmp_path: Path) -> None:
    model = read_system(tmp_path, f'<page id="top"><place id="p">{of("A")}</place><place id="q"/></page>')
    assert drawing(model) == {"top": ["q", "A"], "A": ["p"]}


def test_arcs_between_node_nets_stay_for_validation_to_report(tmp_path: Path) -> None:
    model = read_system(
        tmp_path,
        f"""
        <page id="top"><place id="p">{of("A")}</place><transition id="t">{of("B")}</transition>
          <arc id="a" source="p" target="t"/></page>
        """,
    )
    assert drawing(model)["top"] == ["A", "B", "p>t"]


def test_a_node_that_contradicts_the_page_is_an_error(tmp_path: Path) -> None:
    page = f'<page id="Robot">{dineros("<type>nodePage</type>")}\n<place id="p">{of("Arm")}</place></page>'
    with pytest.raises(ModelFileError, match="'p' names the node 'Arm'") as caught:
        read_net(tmp_path, page)
    assert caught.value.location is not None
    assert caught.value.location.line == 5
    assert "Robot" in str(caught.value.hint)


def test_ports_may_name_references(tmp_path: Path) -> None:
    topic = dineros(
        "<type>topicTransitionType</type><topicName>x</topicName>"
        "<publishers><publisher><id>r2</id></publisher></publishers>"
    )
    model = read_system(
        tmp_path,
        f"""
        <page id="a"><place id="p">{of("A")}</place><referencePlace id="r1" ref="p"/></page>
        <page id="b"><referencePlace id="r2" ref="r1"/><transition id="topic">{topic}</transition></page>
        """,
    )
    (channel,) = model.channels
    assert isinstance(channel, sym.TopicChannel)
    assert channel.publishers[0].place is find(model, "p", pn.Element) is resolve(find(model, "r2", pn.Node))
