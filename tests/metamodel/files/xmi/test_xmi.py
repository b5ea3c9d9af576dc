from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel import pn, pnm, rtm, sym, trace
from dineros.metamodel.base import EObject
from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.xmi import read_xmi, write_xmi, xmi_bytes
from dineros.metamodel.positions import location_of
from tests.support.equality import differences
from tests.support.systems.models import plain_nets, system_models
from tests.support.systems.small import small_net, small_system

HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
SPACES = 'xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
NET = f'{HEAD}<pn:Net {SPACES} xmlns:pn="http://dineros.org/pn/1.0" id="net">\n%s\n</pn:Net>\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("xmi")


def read_text(folder: Path, text: str) -> EObject:
    path = folder / "model.xmi"
    path.write_text(text, encoding="utf-8")
    return read_xmi(path)


@pytest.mark.long
@given(model=st.one_of(plain_nets(), system_models(with_properties=True)))
def test_reading_what_was_written_gives_an_equal_model_and_the_same_bytes(
    folder: Path, model: pn.Net
) -> None:
    write_xmi(model, folder / "round.xmi")
    again = read_xmi(folder / "round.xmi")
    assert differences(model, again) == []
    assert xmi_bytes(again) == (folder / "round.xmi").read_bytes()


def test_a_small_model_looks_like_this() -> None:
    net = pn.Net(id="n", name='a "b" <c>\n')
    page = pn.Page(id="p", net=net)
    place = pn.Place(id="i", tokens=1, graphics=pn.Graphics(positions=[pn.Point(x=3.0, y=0.5)]), page=page)
    step = pn.Transition(id="t", interval=pn.TimeInterval(latest=0.0), page=page)
    pn.Arc(id="i-t", source=place, target=step, kind="read", page=page)
    assert xmi_bytes(net).decode() == (
        f'{HEAD}<pn:Net {SPACES} xmlns:pn="http://dineros.org/pn/1.0" id="n" '
        'name="a &quot;b&quot; &lt;c&gt;&#10;">\n'
        '  <pages id="p">\n'
        '    <objects xsi:type="pn:Place" id="i" tokens="1">\n'
        "      <graphics>\n"
        '        <positions x="3" y="0.5"/>\n'
        "      </graphics>\n"
        "    </objects>\n"
        '    <objects xsi:type="pn:Transition" id="t">\n'
        '      <interval latest="0"/>\n'
        "    </objects>\n"
        '    <arcs id="i-t" source="i" target="t" kind="read"/>\n'
        "  </pages>\n"
        "</pn:Net>\n"
    )


@given(st.permutations(["id", "name", "tokens", "kind", "graphics", "page"]))
def test_bytes_do_not_depend_on_the_order_in_which_features_were_set(order: list[str]) -> None:
    def make(names: list[str]) -> bytes:
        model = sym.SystemModel(id="m")
        page = sym.NodeNet(id="n", net=model)
        values = {
            "id": "p",
            "name": "P",
            "tokens": 3,
            "kind": sym.PlaceKind.start,
            "graphics": pn.Graphics(positions=[pn.Point(x=1.0, y=2.0)]),
            "page": page,
        }
        place = sym.Place()
        for name in names:
            setattr(place, name, values[name])
        return xmi_bytes(model)

    assert make(order) == make(sorted(order))


def test_a_default_that_was_set_and_unset_again_is_left_out() -> None:
    net = small_net()
    before = xmi_bytes(net)
    place = net.pages[0].objects[0]
    assert isinstance(place, pn.Place)
    place.tokens, place.name = 0, "x"
    place.tokens, place.name = 2, None
    assert xmi_bytes(net) == before


def test_elements_remember_file_and_line(tmp_path: Path) -> None:
    write_xmi(small_net(), tmp_path / "net.xmi")
    net = read_xmi(tmp_path / "net.xmi")
    assert isinstance(net, pn.Net)
    place = net.pages[0].objects[0]
    text = (tmp_path / "net.xmi").read_text().splitlines()
    location = location_of(place)
    assert location is not None
    assert location.line is not None
    assert 'id="idle"' in text[location.line - 1]
    # Something made later, in Python, points at the nearest container that came from the file.
    graphics = pn.Graphics()
    place.graphics = graphics
    assert location_of(graphics) == location
    assert location_of(pn.Net(id="made")) is None


@pytest.mark.parametrize("number", [0.1, 1e300, -2.5e-7, 1e15, 123456789.0, 3.0])
def test_numbers_come_back_exactly(folder: Path, number: float) -> None:
    net = pn.Net(id="n", graphics=pn.Graphics(positions=[pn.Point(x=number, y=-number)]))
    again = read_text(folder, xmi_bytes(net).decode())
    assert isinstance(again, pn.Net)
    assert again.graphics is not None
    assert (again.graphics.positions[0].x, again.graphics.positions[0].y) == (number, -number)


@pytest.mark.parametrize("name", ["a#b", "/topic", "#x", "a:b", "ä{}"])
def test_odd_ids_can_be_referred_to(folder: Path, name: str) -> None:
    net = pn.Net(id="n")
    page = pn.Page(id="p", net=net)
    first = pn.Transition(id=name, page=page)
    pn.Transition(id="t", overrides=[first], page=page)
    text = xmi_bytes(net).decode()
    # Eclipse takes "#" and "/" for other files and paths, so these are referred to by path.
    assert ('overrides="//@pages.0/@objects.0"' in text) == ("#" in name or name.startswith("/"))
    assert differences(read_text(folder, text), net) == []


def test_runtime_models_and_petri_net_models_come_back(folder: Path) -> None:
    node = sym.NodeNet(id="node")
    response = rtm.Place(id="response", page=node)
    request = rtm.Place(id="request", page=node)
    request.ports.append(rtm.ClientPort(channel="c", service="/s", client="c1", response=response))
    request.ports.append(rtm.PublisherPort(channel="d", topic="/t", qos=sym.QualityOfService()))
    runtime = rtm.RuntimeModel(id="r", node=node, systemModel="m", pages=[node])
    place = pn.Place(id="p")
    plain = pnm.PetriNetModel(
        id="n", systemModel="m", signals="ioEnabled", pages=[pn.Page(id="g", objects=[place])]
    )
    plain.certificate.append(
        pnm.PlaceInvariant(name="load", value=16, terms=[pnm.InvariantTerm(place=place, weight=2)])
    )
    for model in (runtime, plain):
        assert differences(read_text(folder, xmi_bytes(model).decode()), model) == []


# What Eclipse and others write differently ------------------------------------------------------------


def arc_of(root: EObject) -> pn.Arc:
    assert isinstance(root, pn.Net)
    return root.pages[0].arcs[0]


@pytest.mark.parametrize(
    ("source", "target"),
    [
        ("a", "b"),
        ("#a", "#b"),
        ("//@pages.0/@objects.0", "#//@pages.0/@objects.1"),
        ("/0/@pages.0/@objects.0", "x1"),
    ],
)
def test_references_by_id_path_and_xmi_id(folder: Path, source: str, target: str) -> None:
    root = read_text(
        folder,
        NET
        % f"""<pages id="p">
        <objects xsi:type="pn:Place" id="a"/>
        <objects xmi:type="pn:Transition" xmi:id="x1"><id>b</id><name>two
        lines</name></objects>
        <arcs id="c" source="{source}"><target href="#{target}"/></arcs></pages>""",
    )
    arc = arc_of(root)
    assert (arc.source.id, arc.target.id) == ("a", "b")
    assert arc.target.name is not None
    assert "\n" in arc.target.name
    assert list(arc.source.outgoing) == [arc]


def test_a_wrapper_a_schema_location_and_nil_are_accepted(folder: Path) -> None:
    root = read_text(
        folder,
        f"""<xmi:XMI {SPACES} xmlns:pn="http://dineros.org/pn/1.0"
        xsi:schemaLocation="http://dineros.org/pn/1.0 pn.ecore"><!-- a comment -->
        <pn:Net id="net"><name xsi:nil="true"/><graphics xsi:nil="true"/></pn:Net></xmi:XMI>""",
    )
    assert isinstance(root, pn.Net)
    assert (root.id, root.name, root.graphics) == ("net", None, None)


# References across files ------------------------------------------------------------------------------


def interval_of(net: pn.Net) -> pn.TimeInterval:
    transition = net.pages[0].objects[2]
    assert isinstance(transition, pn.Transition)
    assert transition.interval is not None
    return transition.interval


def trace_of(source: pn.Net, target: pn.Net) -> trace.TraceModel:
    links = [
        trace.TraceLink(
            rule="T1", role="place", sources=[source.pages[0], source], target=target.pages[0].objects[0]
        ),
        trace.TraceLink(rule="T2", role="interval", sources=[], target=interval_of(target)),
    ]
    return trace.TraceModel(source="a", target="b", links=links)


def test_a_trace_model_refers_into_both_files(tmp_path: Path) -> None:
    (tmp_path / "made here").mkdir()
    source, target = small_system(), small_net()
    write_xmi(source, tmp_path / "a#b.xmi")
    write_xmi(target, tmp_path / "made here/target.xmi")
    write_xmi(trace_of(source, target), tmp_path / "made here/trace.xmi")
    text = (tmp_path / "made here/trace.xmi").read_text()
    assert '<sources xsi:type="sym:NodeNet" href="../a%23b.xmi#talker"/>' in text
    assert 'href="target.xmi#//@pages.0/@objects.2/@interval"' in text

    read = read_xmi(tmp_path / "made here/trace.xmi")
    assert isinstance(read, trace.TraceModel)
    node, root = read.links[0].sources
    assert isinstance(node, sym.NodeNet)
    assert node.eContainer() is root
    assert isinstance(read.links[1].target, pn.TimeInterval)
    assert differences(root, source) == []

    same = read_xmi(tmp_path / "made here/trace.xmi", models=[source, target])
    assert isinstance(same, trace.TraceModel)
    assert same.links[0].sources[0] is source.pages[0]
    assert same.links[0].target is target.pages[0].objects[0]


def test_files_that_refer_to_each_other_are_read_once(tmp_path: Path) -> None:
    text = f"""{HEAD}<trace:TraceModel {SPACES} xmlns:trace="http://dineros.org/trace/1.0">
    <links rule="r" role="x"><target xsi:type="trace:TraceModel" href="{{}}#/"/></links></trace:TraceModel>"""
    (tmp_path / "one.xmi").write_text(text.format("two.xmi"))
    (tmp_path / "two.xmi").write_text(text.format("../" + tmp_path.name + "/one.xmi"))
    one = read_xmi(tmp_path / "one.xmi")
    assert isinstance(one, trace.TraceModel)
    two = one.links[0].target
    assert isinstance(two, trace.TraceModel)
    assert two.links[0].target is one


@pytest.mark.parametrize(
    ("href", "message"),
    [
        ("http://example.org/a.xmi#x", "name a file relative to this one"),
        ("file:///etc/passwd#x", "name a file relative to this one"),
        ("/etc/passwd#x", "name a file relative to this one"),
        ("%2Fetc/passwd#x", "name a file relative to this one"),
        ("missing.xmi#x", "'missing.xmi', which does not exist"),
        (".#x", "is a directory"),
        ("a" * 300 + ".xmi#x", "which does not exist"),
        ("a%00b.xmi#x", "name a file relative to this one"),
        ("other.xmi#nothing", "'nothing' of other.xmi, which does not exist"),
        ("other.xmi#smal", "did you mean 'small'?"),
        ("broken.xmi#x", "broken.xmi:1:"),
    ],
)
def test_what_cannot_be_referred_to(tmp_path: Path, href: str, message: str) -> None:
    write_xmi(small_net(), tmp_path / "other.xmi")
    (tmp_path / "broken.xmi").write_text("<")
    with pytest.raises(ModelFileError) as caught:
        read_text(
            tmp_path,
            f'''{HEAD}<trace:TraceModel {SPACES} xmlns:trace="http://dineros.org/trace/1.0">
            <links rule="r" role="x"><target href="{href}"/></links></trace:TraceModel>''',
        )
    assert message in str(caught.value)


# What cannot be written -------------------------------------------------------------------------------


def change(net: pn.Net, feature: str, value: object) -> pn.Net:
    setattr(net.pages[0].objects[0], feature, value)
    return net


@pytest.mark.parametrize(
    ("net", "message"),
    [
        (change(small_net(), "id", None), "pn:Place has no id"),
        (change(small_net(), "id", "two words"), "'two words' has white space"),
        (change(small_net(), "id", "//@pages.0"), "looks like the path"),
        (change(small_net(), "id", "busy"), "'busy' is used twice, by a Place and a Place"),
        (change(small_net(), "name", "bell \a"), "holds the character '\\x07', which XML cannot carry"),
        (change(small_net(), "name", "half \ud800"), "which XML cannot carry"),
        (change(small_net(), "tokens", 2**31), "takes a whole number of 32 bits"),
        (change(small_net(), "tokens", None), "pn:Place 'idle' has no tokens"),
        (pn.Net(id="n", graphics=pn.Graphics(offset=pn.Point(x=float("nan")))), "takes a finite number"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_a_file_cannot_hold_is_refused(net: pn.Net, message: str) -> None:
    with pytest.raises(ModelFileError) as caught:
        xmi_bytes(net)
    assert message in str(caught.value)


def test_a_reference_out_of_the_model_is_refused() -> None:
    net = small_net()
    transition = net.pages[0].objects[2]
    assert isinstance(transition, pn.Transition)
    transition.overrides.append(pn.Transition(id="elsewhere"))
    with pytest.raises(
        ModelFileError, match=r"pn:Transition 'elsewhere', which is not in the model \(add it"
    ):
        xmi_bytes(net)


def test_a_model_that_no_reader_would_take_is_not_written(folder: Path) -> None:
    def nested(depth: int) -> pn.Net:
        page = pn.Page(id="p0")
        net = pn.Net(id="n", pages=[page])
        for number in range(1, depth):
            page = pn.Page(id=f"p{number}", page=page)
        return net

    deepest = nested(250)
    assert differences(read_text(folder, xmi_bytes(deepest).decode()), deepest) == []
    with pytest.raises(ModelFileError, match="nests deeper than 250"):
        xmi_bytes(nested(251))


def test_a_channel_with_the_id_of_a_transition_says_what_shares_the_space(tmp_path: Path) -> None:
    model = small_system()
    text = xmi_bytes(model).decode()
    channel = model.channels[0].id
    assert 'id="take"' in text
    with pytest.raises(ModelFileError, match="all elements of a file, channels too, share one space of ids"):
        read_text(tmp_path, text.replace(f'id="{channel}"', 'id="take"'))
