"""Places with token types of their own: which data continues, and what handlers have to make."""

from __future__ import annotations

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.build import flow, read
from dineros.metamodel.elements import find
from dineros.runtime import Net, Node
from tests.runtime.tiny import settle, stepped, tiny

DEFAULT = {"text": "none", "level": 0}


def typed(transitions: dict[str, str], marking: dict[str, int | list[str]]) -> rtm.RuntimeModel:
    """Return a net whose places in capital letters carry a level, `Z` a bare type, others as in `tiny`."""
    model = tiny(transitions, marking)
    level = sym.TokenType(
        id="Level",
        fields=[
            sym.TokenField(name="text", default='"none"', ros="string<=6"),
            sym.TokenField(name="level", kind="integer", ros="int8", maximum=100),
        ],
    )
    bare = sym.TokenType(id="Bare")
    model.otherTokenTypes.extend([level, bare])
    for place in model.pages[0].objects:
        if isinstance(place, sym.Place) and place.id.isupper():
            place.tokenType = bare if place.id == "Z" else level
    return model


def data(net: Net, place: str) -> list[object]:
    return [token.data for token in net.inspect().marking[place]]


def test_data_goes_on_by_type() -> None:
    """Each place gets the data of the first token of its type, also where that was only read."""
    net = Net(typed({"t": "a B ?C -> d E 2*F Z"}, {"a": ['{"color": "red"}'], "B": ['{"level": 3}'], "C": 1}))
    with stepped(net) as (node, _):
        settle(node)
        (red,) = data(net, "d")
        assert isinstance(red, dict) and red["color"] == "red"
        assert data(net, "E") == [{"text": "none", "level": 3}]
        assert data(net, "F") == [{"text": "none", "level": 3}] * 2
        assert data(net, "Z") == [{}]


def test_a_handler_makes_what_is_not_taken() -> None:
    """What it returns, or leaves, is of the type that it puts; the defaults are there before."""
    net = Net(typed({"t": "a -> B"}, {"a": ['{"color": "red"}', "{}"]}))

    @net.handler("t")
    def make(firing):  # type: ignore[no-untyped-def]
        assert firing.data == DEFAULT
        color = firing.inputs["a"][0].data["color"]
        if color:
            return {"text": color}
        firing.data["level"] = 7
        return None

    with stepped(net) as (node, _):
        settle(node)
        assert data(net, "B") == [{"text": "red", "level": 0}, {"text": "none", "level": 7}]


def test_each_type_that_is_not_taken_is_given() -> None:
    net = Net(typed({"t": "a -> a B Z", "u": "c -> D Z"}, {"a": 1, "c": 1}))
    net.handler("t")(lambda firing: firing.give({"B": {"level": 1}}))
    net.handler("u")(lambda firing: {"level": 2})
    with stepped(net) as (node, _):
        node.step()
        node.step()
        said = [error.error for error in net.inspect().errors]
    assert said[0].endswith(
        "gives no Bare to 'Z', which the transition does not take (return firing.give({'Z': {...}}))"
    )
    net = Net(typed({"t": "a -> B Z"}, {"a": 1}))
    net.handler("t")(lambda firing: firing.give({"B": {"level": 1}, "Z": {}}))
    with stepped(net) as (node, _):
        settle(node)
        assert (data(net, "B"), data(net, "Z")) == ([{"text": "none", "level": 1}], [{}])


def test_ranges_are_checked_when_a_handler_returns() -> None:
    for wrong, said in (
        ({"level": 128}, "level takes int8, -128 to 127, not 128"),
        ({"level": 101}, "level takes at most 100, not 101"),
        ({"text": "longest"}, "text takes at most 6 bytes, not 7"),
        ({"color": "red"}, "tokens have no field 'color'"),
    ):
        net = Net(typed({"t": "a -> B"}, {"a": 1}))
        net.handler("t")(lambda firing, wrong=wrong: wrong)
        with stepped(net) as (node, _):
            node.step()
            inspection = net.inspect()
        assert said in inspection.errors[0].error
        assert len(inspection.marking["a"]) == 1


def test_a_node_goes_on_with_the_types_of_its_places() -> None:
    model = typed({"t": "a -> B", "u": "B -> C"}, {"a": 1, "C": ['{"level": 5}']})
    first = Net(model)
    with stepped(first) as (node, _):
        node.step()
        checkpoint = node.checkpoint()
    net = Net(model)
    node = Node(net, resume=checkpoint)
    node.open()
    try:
        settle(node)
        assert data(net, "C") == [{"text": "none", "level": 5}, DEFAULT]
    finally:
        node.close()


def test_server_pages_keep_the_types_of_their_places() -> None:
    model = typed({"t": "a -> B"}, {"a": 1})
    page = pn.Page(id="server", page=model.pages[0])
    level = find(model, "Level", sym.TokenType)
    entry = rtm.Place(id="In", page=page, tokenType=level)
    out = rtm.Place(id="Out", page=page, tokenType=level)
    serve = sym.Transition(id="serve", page=page)
    flow(entry, serve, out)
    read(pn.ReferencePlace(id="here", target=find(model, "a", pn.Place), page=page), serve)
    entry.ports.append(rtm.ServerPort(channel="S", service="s", exit=out, page=page, instances=2))
    structure = Net(model).structure
    named = dict(zip(structure.places, (type_.name for type_ in structure.types), strict=True))
    assert {place: name for place, name in named.items() if place.startswith("S[")} == {
        "S[1].In": "Level",
        "S[1].Out": "Level",
        "S[2].In": "Level",
        "S[2].Out": "Level",
    }
    assert structure.ports.type_at("Out").name == structure.ports.type_at("S[2].In").name == "Level"
    assert structure.ports.type_at("a").name == "Thing"
