"""The DiNeROS extension of PNML: every row of its table, in both versions."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.clauses import cnf_text
from dineros.metamodel.elements import find, node_nets
from dineros.metamodel.errors import ClauseError
from dineros.metamodel.files.pnml import pnml_bytes
from dineros.metamodel.files.pnml.vocabulary import Version
from tests.support.equality import differences
from tests.support.pnml import again, dineros, drawing, read_net, read_system

VERSIONS: list[Version] = ["0.1", "0.2"]


def node_page(inside: str, fields: str = "") -> str:
    """Return a node page."""
    return f'<page id="robot">{dineros("<type>nodePage</type>" + fields)}{inside}</page>'


def test_any_block_of_the_extension_makes_a_system_model(tmp_path: Path) -> None:
    page = '<page id="page"><place id="p"/><transition id="t">{}</transition></page>'
    assert type(read_net(tmp_path, page.format(""))) is pn.Net
    model = read_system(tmp_path, page.format(dineros("<type>discreteTransitionType</type>")))
    assert type(find(model, "p", pn.Element)) is sym.Place
    assert type(find(model, "t", pn.Element)) is sym.Transition


@pytest.mark.parametrize("version", VERSIONS)
def test_balloon_tokens(tmp_path: Path, version: Version) -> None:
    marking = """<node> robot </node><balloonMarking><tokens>
        <token> {"color": "red", "name": "r 1"} </token><token>{}</token>
    </tokens></balloonMarking>"""
    text = f"""
        <page id="robot"><place id="p">{dineros(marking, version)}
          <initialMarking><text> 3 </text></initialMarking></place></page>
    """
    model = read_system(tmp_path, text)
    place = find(model, "p", sym.Place)
    assert place.tokens == 3
    assert [balloon.data for balloon in place.balloons] == ['{"color": "red", "name": "r 1"}', "{}"]
    written = pnml_bytes(model, version).decode()
    assert '<token>{"color": "red", "name": "r 1"}</token>' in written
    assert "<initialMarking><text>3</text></initialMarking>" in written
    assert not differences(model, again(tmp_path, model, version))


def test_balloon_tokens_alone_are_the_marking(tmp_path: Path) -> None:
    marking = "<balloonMarking><tokens><token>{}</token><token>{}</token></tokens></balloonMarking>"
    given = "<initialMarking><text>0</text></initialMarking>"
    text = f'<page id="page"><place id="p">{dineros(marking)}</place>'
    text += f'<place id="q">{dineros(marking)}{given}</place></page>'
    model = read_system(tmp_path, text)
    assert find(model, "p", sym.Place).tokens == 2
    assert find(model, "q", sym.Place).tokens == 0  # a contradiction, which validation reports
    assert not differences(model, again(tmp_path, model))


@pytest.mark.parametrize(("name", "kind"), [("placeStartType", "start"), ("placeEndType", "end")])
def test_kinds_of_places(tmp_path: Path, name: str, kind: str) -> None:
    model = read_system(
        tmp_path, f'<page id="page"><place id="p">{dineros(f"<type> {name} </type>")}</place></page>'
    )
    assert str(find(model, "p", sym.Place).kind) == kind
    assert f"<type>{name}</type>" in pnml_bytes(model).decode()
    assert name not in pnml_bytes(model, "0.1").decode()
    for version in VERSIONS:
        assert not differences(model, again(tmp_path, model, version))


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("discreteTransitionType", "discrete"),
        ("timeTransitionType", "timed"),
        ("transitionStartType", "start"),
        ("transitionEndType", "end"),
    ],
)
def test_kinds_of_transitions(tmp_path: Path, name: str, kind: str) -> None:
    model = read_system(
        tmp_path, f'<page id="page"><transition id="t">{dineros(f"<type>{name}</type>")}</transition></page>'
    )
    assert str(find(model, "t", sym.Transition).kind) == kind
    assert f"<type>{name}</type>" in pnml_bytes(model).decode()
    assert "<type>discreteTransitionType</type>" in pnml_bytes(model, "0.1").decode()
    for version in VERSIONS:
        assert not differences(model, again(tmp_path, model, version))


@pytest.mark.parametrize(
    ("time", "earliest", "latest"),
    [
        ('<time start="1" end="2.5"/>', 1.0, 2.5),
        ('<time start=" 1 "/>', 1.0, None),
        ('<time start="0" end="inf"/>', 0.0, None),
        ("<time><start>3</start><end>4</end></time>", 3.0, 4.0),
    ],
)
def test_timed_transitions(tmp_path: Path, time: str, earliest: float, latest: float | None) -> None:
    block = dineros(f"<type>timeTransitionType</type>{time}")
    model = read_system(tmp_path, f'<page id="page"><transition id="t">{block}</transition></page>')
    interval = find(model, "t", sym.Transition).interval
    assert interval is not None
    assert (interval.earliest, interval.latest) == (earliest, latest)
    assert "org.dineros" not in pnml_bytes(model).decode()
    assert "<time" not in pnml_bytes(model, "0.1").decode()
    for version in VERSIONS:
        assert not differences(model, again(tmp_path, model, version))


@pytest.mark.parametrize(
    ("text", "form"),
    [
        ("(Green)", "Green"),
        ("\n  Green and not Red ", "Green & !Red"),
        ("¬(Green ∨ Red)", "!Green & !Red"),
        ("Green &amp; !Green", "Green & !Green"),
    ],
)
def test_input_clauses_make_the_signals_they_use(tmp_path: Path, text: str, form: str) -> None:
    clause = f"<inputsignalclause>{text}</inputsignalclause>"
    model = read_system(tmp_path, node_page(f'<transition id="t">{dineros(clause, "0.1")}</transition>'))
    stored = find(model, "t", sym.Transition).clause
    assert stored is not None
    assert cnf_text(stored) == form
    assert stored.text == text.strip().replace("&amp;", "&")
    (node_net,) = node_nets(model)
    assert [signal.id for signal in node_net.signals] == (["Green", "Red"] if "Red" in text else ["Green"])
    assert not any(signal.initial for signal in node_net.signals)
    for version in VERSIONS:
        assert not differences(model, again(tmp_path, model, version))


def test_an_empty_input_clause_is_none(tmp_path: Path) -> None:
    block = dineros("<inputsignalclause> </inputsignalclause>", "0.1")
    model = read_system(tmp_path, node_page(f'<transition id="t">{block}</transition>'))
    assert find(model, "t", sym.Transition).clause is None
    assert len(node_nets(model)[0].signals) == 0


def test_signals_of_one_name_in_two_nodes_or_beside_a_place_get_free_ids(tmp_path: Path) -> None:
    clause = dineros("<inputsignalclause>Stop</inputsignalclause>")
    model = read_system(
        tmp_path,
        f"""
        <page id="a">{dineros("<type>nodePage</type>")}<transition id="t">{clause}</transition></page>
        <page id="b">{dineros("<type>nodePage</type>")}<transition id="u">{clause}</transition></page>
        <page id="c">{dineros("<type>nodePage</type>")}<transition id="v">{clause}</transition>
          <place id="Go"/></page>
        """.replace("Stop</inputsignalclause>", "Stop &amp; Go</inputsignalclause>"),
    )
    named = [[(signal.id, signal.name) for signal in node_net.signals] for node_net in node_nets(model)]
    assert named == [
        [("Stop", None), ("a.Go", "Go")],
        [("b.Stop", "Stop"), ("b.Go", "Go")],
        [("c.Stop", "Stop"), ("c.Go", "Go")],
    ]
    assert not differences(model, again(tmp_path, model))


@pytest.mark.parametrize("text", ["Green &amp;", "(", "1 + 1"])
def test_a_clause_that_is_none_names_its_line(tmp_path: Path, text: str) -> None:
    clause = f"\n<inputsignalclause>{text}</inputsignalclause>"
    with pytest.raises(ClauseError) as caught:
        read_net(tmp_path, node_page(f'<transition id="t">{dineros(clause)}</transition>'))
    assert caught.value.location is not None
    assert caught.value.location.line == 5
    assert caught.value.element == "t"


@pytest.mark.parametrize("version", VERSIONS)
def test_topics(tmp_path: Path, version: Version) -> None:
    fields = """<type> topicTransitionType </type><topicName> /objects </topicName>
      <publishers><publisher><id> sent </id><limit> 5 </limit></publisher></publishers>
      <subscribers>
        <subscriber><id>alias</id><limit>3</limit></subscriber>
        <subscriber><id>received2</id></subscriber>
      </subscribers>"""
    model = read_system(
        tmp_path,
        f"""
        <page id="canvas">
          <transition id="topic">{dineros(fields, version)}
            <name><text>Objects</text></name><graphics><position x="1" y="2"/></graphics></transition>
          <page id="node"><place id="sent"/><place id="received"/><place id="received2"/>
            <page id="inner"><referencePlace id="alias" ref="received"/></page></page>
        </page>
        """,
    )
    (channel,) = model.channels
    assert isinstance(channel, sym.TopicChannel)
    assert (channel.id, channel.name, channel.topic) == ("topic", "Objects", "/objects")
    assert channel.graphics is not None and channel.graphics.positions[0].x == 1.0
    assert channel.canvas is find(model, "canvas", pn.Element)
    assert [(port.place.id, port.limit) for port in channel.publishers] == [("sent", 5)]
    assert [(port.place.id, port.limit) for port in channel.subscribers] == [
        ("received", 3),
        ("received2", 10),
    ]
    assert "topic" not in drawing(model)["canvas"]
    assert not differences(model, again(tmp_path, model, version))


@pytest.mark.parametrize("version", VERSIONS)
def test_services(tmp_path: Path, version: Version) -> None:
    fields = """<type>serviceTransitionType</type><serviceName>sense</serviceName>
      <serverInput> in </serverInput><serverOutput>out</serverOutput><serverCapacity> 2 </serverCapacity>
      <channels><channel><cid> c9 </cid><request>req</request><response>res</response></channel></channels>"""
    model = read_system(
        tmp_path,
        f"""
        <page id="canvas"><transition id="service">{dineros(fields, version)}</transition>
          <page id="client"><place id="req"/><place id="res"/></page>
          <page id="server"><place id="in"/><place id="out"/></page></page>
        """,
    )
    (channel,) = model.channels
    assert isinstance(channel, sym.ServiceChannel)
    assert (channel.service, channel.instances) == ("sense", 2)
    assert (channel.server.entry.id, channel.server.exit.id, channel.server.page.id) == (
        "in",
        "out",
        "server",
    )
    assert [(each.client, each.request.id, each.response.id) for each in channel.clients] == [
        ("c9", "req", "res")
    ]
    assert not differences(model, again(tmp_path, model, version))


@pytest.mark.parametrize(
    "page",
    [
        '<page id="robot">{}{}</page>',
        '<nodePage id="robot">{}{}</nodePage>',
    ],
)
def test_node_pages(tmp_path: Path, page: str) -> None:
    fields = "<type> nodePage </type><executor> multi </executor><threads>4</threads>"
    name = "<name><text>Robot</text></name>"
    model = read_system(tmp_path, page.format(dineros(fields), name + '<place id="p"/>'))
    (node_net,) = node_nets(model)
    assert (node_net.id, node_net.name, str(node_net.executor), node_net.threads) == (
        "robot",
        "Robot",
        "multi",
        4,
    )
    assert "<node>Robot</node>" in pnml_bytes(model).decode()
    for version in VERSIONS:
        assert not differences(model, again(tmp_path, model, version))
    assert "nodePage" not in pnml_bytes(model, "0.1").decode()


def test_the_element_node_page_needs_no_type(tmp_path: Path) -> None:
    block = dineros("<type>discreteTransitionType</type>")
    model = read_system(tmp_path, f'<nodePage id="robot"><transition id="t">{block}</transition></nodePage>')
    assert [node_net.id for node_net in node_nets(model)] == ["robot"]


@pytest.mark.parametrize(
    ("name", "kind", "more"),
    [
        ("callbackTimer", "timer", "<timer> 2.5 </timer>"),
        ("callbackSubscriber", "subscriber", ""),
        ("callbackServer", "server", ""),
    ],
)
def test_callback_pages(tmp_path: Path, name: str, kind: str, more: str) -> None:
    block = dineros(f"<type>{name}</type><group> fast </group>{more}<priority> 7 </priority>")
    page = f'<page id="call">{block}<place id="p"/></page>'
    model = read_system(tmp_path, node_page(page))
    callback = find(model, "call", sym.CallbackPage)
    assert (str(callback.kind), callback.priority) == (kind, 7)
    assert callback.timer == (2.5 if kind == "timer" else None)
    assert callback.group is not None
    assert list(node_nets(model)[0].callbackGroups) == [callback.group]
    assert callback.group.id == "fast"
    for version in VERSIONS:
        assert not differences(model, again(tmp_path, model, version))


def test_callback_groups_of_the_net(tmp_path: Path) -> None:
    groups = """<callbackgroups>
      <group><id> fast </id><type> exclusive </type><priority> 3 </priority><node> robot </node>
        <graphics><position x="1" y="2"/><dimension x="3" y="4"/></graphics></group>
      <group><id>slow</id><type>Reentrant</type><node>robot</node></group>
      <group><id>late</id><type>MutuallyExclusive</type></group>
    </callbackgroups>"""
    call = f'<page id="call">{dineros("<type>callbackTimer</type><group>fast</group>")}</page>'
    model = read_system(tmp_path, dineros(groups) + node_page(call + '<place id="p"/>'))
    (node_net,) = node_nets(model)
    assert [(group.id, str(group.kind), group.priority) for group in node_net.callbackGroups] == [
        ("fast", "exclusive", 3),
        ("slow", "reentrant", 0),
        ("late", "exclusive", 0),
    ]
    fast = node_net.callbackGroups[0]
    assert find(model, "call", sym.CallbackPage).group is fast
    assert fast.graphics is not None and fast.graphics.positions[0].y == 2.0
    text = pnml_bytes(model).decode()
    assert "<callbackgroups>" in text and "org.dineros" not in text
    for version in VERSIONS:
        assert not differences(model, again(tmp_path, model, version))


def test_unknown_fields_of_the_extension_are_kept(tmp_path: Path) -> None:
    block = dineros("<type>placeEndType</type><colour>blue</colour><shape kind='round'/>")
    model = read_system(tmp_path, f'<page id="page"><place id="p">{block}</place></page>')
    (info,) = find(model, "p", pn.Element).toolInfos
    assert info.content is not None
    assert "<colour>blue</colour>" in info.content and "placeEndType" not in info.content
    text = pnml_bytes(model).decode()
    assert text.count("<colour>blue</colour>") == text.count("placeEndType") == 1
    assert not differences(model, again(tmp_path, model))
