"""Nothing is lost on the way through a PNML file."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.metamodel import pn, pnm, rtm, sym
from dineros.metamodel.build import flow, read
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find
from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files import load, save
from dineros.metamodel.files.pnml import pnml_bytes, read_pnml, write_pnml
from dineros.metamodel.files.pnml.vocabulary import Version
from tests.support.equality import differences
from tests.support.pnml import again, document, read_net, read_text
from tests.support.ros2_systems.deliveries import deliveries
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.models import plain_nets, system_models
from tests.support.systems.odd_models import odd_models

versions = st.sampled_from(["0.1", "0.2"])


def written_and_read(net: pn.Net, version: Version, folder: Path) -> pn.Net:
    """Return what reading gives, having checked that writing that gives the same bytes."""
    content = pnml_bytes(net, version)
    file = folder / "model.pnml"
    file.write_bytes(content)
    back = read_pnml(file)
    assert pnml_bytes(back, version) == content
    return back


@pytest.mark.long
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(
    net=st.one_of(plain_nets(), system_models(with_properties=True), calling_systems(circles=True)),
    version=versions,
)
def test_generated_models(net: pn.Net, version: Version, tmp_path: Path) -> None:
    assert not differences(net, written_and_read(net, version, tmp_path))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=15)
@given(net=st.one_of(plain_nets(), system_models(with_properties=True), calling_systems(circles=True)))
def test_from_xmi_to_pnml_and_back(net: pn.Net, tmp_path: Path) -> None:
    save(net, tmp_path / "first.xmi")
    save(load(tmp_path / "first.xmi"), tmp_path / "middle.pnml")
    save(load(tmp_path / "middle.pnml"), tmp_path / "last.xmi")
    assert (tmp_path / "first.xmi").read_bytes() == (tmp_path / "last.xmi").read_bytes()


@pytest.mark.long
@settings(suppress_health_check=list(HealthCheck), deadline=None)
@given(net=odd_models(), version=versions)
def test_odd_models(net: pn.Net, version: Version, tmp_path: Path) -> None:
    assert not differences(net, written_and_read(net, version, tmp_path))


@pytest.mark.parametrize("suffix", ["pnml", "xmi"])
def test_actions(suffix: str, tmp_path: Path) -> None:
    model = deliveries(2, 3, feedback=True)
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel) and channel.server is not None
    robot = find(model, "robot", sym.NodeNet)
    robot.callbackGroups.append(sym.CallbackGroup(id="goals"))
    channel.clients[1].outstanding = 2
    page = channel.server.page
    assert isinstance(page, sym.CallbackPage)
    page.group = robot.callbackGroups[0]
    save(model, tmp_path / f"model.{suffix}")
    assert not differences(model, load(tmp_path / f"model.{suffix}"))


# Foreign blocks -------------------------------------------------------------------------------------------

FOREIGN = """
    <toolspecific tool="PNML Studio" version="3.1">
      <!-- comments go -->
      <studio:layer xmlns:studio="urn:studio" studio:name="back">
         kept  as it <b/> is
      </studio:layer>
    </toolspecific>
    <toolspecific tool="empty" version="1"/>
    <toolspecific tool="plain" version="1" colour="red">text</toolspecific>
"""
DOCUMENT = f"""
    {FOREIGN}
    <page id="page">{FOREIGN}
      <place id="p">{FOREIGN}<name><text>P</text>{FOREIGN}</name></place>
      <transition id="t">{FOREIGN}</transition>
      <referencePlace id="r" ref="p">{FOREIGN}</referencePlace>
      <arc id="a" source="p" target="t">{FOREIGN}</arc>
    </page>
"""


def test_foreign_blocks_are_kept_everywhere(tmp_path: Path) -> None:
    net = read_net(tmp_path, DOCUMENT)
    holders: list[pn.Element | pn.Label] = [
        net,
        *(find(net, id, pn.Element) for id in ("page", "p", "t", "r", "a")),
    ]
    for holder in [*holders, find(net, "p", pn.Element).labels[0]]:
        assert [info.tool for info in holder.toolInfos] == ["PNML Studio", "empty", "plain"]
        layer, empty, plain = holder.toolInfos
        assert empty.content is None and layer.content is not None and plain.content is not None
        assert 'xmlns:studio="urn:studio"' in layer.content and "kept  as it <b></b> is\n" in layer.content
        assert plain.content.endswith('version="1">text</toolspecific>')
    text = pnml_bytes(net).decode()
    assert text.count("kept  as it <b/> is") == 7
    assert "org.dineros" not in text
    assert not differences(net, again(tmp_path, net))


def test_foreign_blocks_do_not_depend_on_where_namespaces_are_declared(tmp_path: Path) -> None:
    block = '<toolspecific tool="x" version="1"><y:z xmlns:y="urn:y"/></toolspecific>'
    plain = document(f'<page id="page">{block}</page>')
    above = plain.replace(' xmlns:y="urn:y"', "").replace("<pnml ", '<pnml xmlns:y="urn:y" ')
    first, second = (read_text(tmp_path, text) for text in (plain, above))
    assert pnml_bytes(first) != pnml_bytes(
        second
    )  # a name in scope may be used inside a value, so it is kept
    for net in (first, second):
        assert not differences(net, again(tmp_path, net))
    assert pnml_bytes(again(tmp_path, second)) == pnml_bytes(second)


# Our own blocks -------------------------------------------------------------------------------------------


def test_what_the_format_cannot_say_stands_in_our_own_blocks(tmp_path: Path) -> None:
    node_net = sym.NodeNet(id="robot", package="cell", namespace="/left", threads=2, executor="multi")
    node_net.signals.append(sym.InputSignal(id="Danger", initial=True))
    sent, received = sym.Place(id="sent", page=node_net), sym.Place(id="received", page=node_net)
    stop = sym.Transition(id="stop", page=node_net)
    flow(received, stop, sent)
    set_clause(stop, "!Danger", "may stop")
    model = sym.SystemModel(id="model", pages=[node_net])
    model.tokenType = sym.TokenType(id="Token", fields=[sym.TokenField(name="color")])
    topic = sym.TopicChannel(id="topic", topic="t", type="std_msgs/msg/String", canvas=node_net, model=model)
    topic.qos = sym.QualityOfService(reliability="bestEffort")
    topic.publishers.append(sym.PublisherPort(place=sent))
    topic.subscribers.append(sym.SubscriberPort(place=received))
    topic.dispatchers.append(sym.Dispatcher(node=node_net, limit=3))
    topic.mappings.append(sym.FieldMapping(messageField="data", tokenField="color"))
    text = pnml_bytes(model).decode()
    for line in (
        '<element package="cell" namespace="/left">',
        '<signals id="Danger" initial="true"/>',
        '<element clauseName="may stop"/>',
        '<element type="std_msgs/msg/String">',
        '<qos reliability="bestEffort"/>',
        '<dispatchers node="robot" limit="3"/>',
        '<mappings messageField="data" tokenField="color"/>',
        '<tokenType id="Token">',
        '<fields name="color"/>',
    ):
        assert line in text
    assert text.count("org.dineros") == 4  # net, node net, transition, topic
    for version in ("0.1", "0.2"):
        assert not differences(model, again(tmp_path, model, version))


@pytest.mark.parametrize("name", [" padded ", " ", "", "second", "second.id"])
def test_node_nets_with_names_that_are_hard_to_refer_to(name: str, tmp_path: Path) -> None:
    first, second = sym.NodeNet(id="first.id", name=name), sym.NodeNet(id="second.id", name="second")
    model = sym.SystemModel(id="model", pages=[first, second])
    for page in (first, second):
        page.objects.append(sym.Place(id=f"place of {page.id}"))
        page.callbackGroups.append(sym.CallbackGroup(id=f"group of {page.id}", priority=2))
    assert not differences(model, again(tmp_path, model))
    assert not differences(model, again(tmp_path, model, "0.1"))


def test_runtime_models_and_flattened_nets(tmp_path: Path) -> None:
    node_net = sym.NodeNet(id="robot")
    runtime = rtm.RuntimeModel(id="robot.rtm", systemModel="cell", node=node_net, pages=[node_net])
    ask, told = rtm.Place(id="ask", page=node_net), rtm.Place(id="told", page=node_net)
    ask.ports.append(rtm.ClientPort(channel="s", service="sense", client="c", response=told))
    ask.ports.append(rtm.PublisherPort(channel="t", topic="x", limit=3))
    page = pn.Page(id="page", objects=[place := pn.Place(id="p"), transition := pn.Transition(id="t")])
    read(place, transition)
    flattened = pnm.PetriNetModel(id="flat", systemModel="cell", signals="ioEnabled", pages=[page])
    flattened.certificate.append(
        pnm.PlaceInvariant(name="p is constant", value=1, terms=[pnm.InvariantTerm(place=place)])
    )
    for net in (runtime, flattened):
        back = again(tmp_path, net)
        assert type(back) is type(net)
        assert not differences(net, back)


@pytest.mark.parametrize(
    ("net", "message"),
    [
        (pn.Net(id="n"), "Net 'n' has no page"),
        (pn.Net(pages=[pn.Page(id="a")]), "Net None has no id"),
        (pn.Net(id=" n", pages=[pn.Page(id="a")]), "has no id that PNML can hold"),
        (pn.Net(id="n", pages=[pn.Page(id="n")]), "Page 'n' has the id of another element"),
        (pn.Net(id="n", pages=[pn.Page(id="p", name="a\0")]), "Page 'p' has text with characters"),
        (pn.Net(id="n", pages=[pn.Page(id="p", objects=[pn.Place(id="q", tokens=-1)])]), "'q' has -1 tokens"),
        (
            pn.Net(id="n", pages=[pn.Page(id="p", objects=[pn.Place(id="q", tokens=2**31)])]),
            "2147483648 tokens",
        ),
        (pn.Net(id="n", pages=[pn.Page(id="p", objects=[pn.ReferencePlace(id="q")])]), "'q' refers to None"),
        (
            pn.Net(
                id="n",
                pages=[pn.Page(id="p", objects=[pn.ReferencePlace(id="q", target=pn.Place(id="away"))])],
            ),
            "'q' refers to 'away', which is not in the net",
        ),
    ],
)
def test_what_cannot_be_written_is_refused(net: pn.Net, message: str, tmp_path: Path) -> None:
    (tmp_path / "old.pnml").write_text("old")
    with pytest.raises(ModelFileError) as caught:
        write_pnml(net, tmp_path / "old.pnml")
    assert message in str(caught.value)
    assert [file.read_text() for file in tmp_path.iterdir()] == ["old"]


def test_nesting_that_readers_refuse_is_not_written() -> None:
    page = top = pn.Page(id="top")
    for number in range(300):
        page.objects.append(inner := pn.Page(id=f"p{number}"))
        page = inner
    with pytest.raises(ModelFileError, match="nested too deep"):
        pnml_bytes(pn.Net(id="n", pages=[top]))


def test_an_unknown_version_is_refused() -> None:
    with pytest.raises(ModelFileError, match=r"version '0\.3'"):
        pnml_bytes(pn.Net(id="n", pages=[pn.Page(id="p")]), "0.3")  # type: ignore[arg-type]
