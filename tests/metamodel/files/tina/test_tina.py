from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, inhibit, read
from dineros.metamodel.elements import arcs, find, places, resolve, transitions
from dineros.metamodel.errors import DinerosError, ModelFileError
from dineros.metamodel.files import load, save
from dineros.metamodel.files.tina import net_from_text, net_text
from dineros.metamodel.positions import location_of
from tests.support.equality import differences
from tests.support.systems.models import plain_nets
from tests.support.systems.small import small_system

PATH = Path("example.net")


def parse(text: str) -> pn.Net:
    return net_from_text(text.encode(), PATH)


def same(text: str) -> str:
    """Return what is written of a text that was read."""
    return net_text(parse(text))


Condition = tuple[str, str, str, int]


def meaning(net: pn.Net) -> dict[str, object]:
    """Return what a net says, told independently of how it is written."""
    effects: Counter[Condition] = Counter()
    inhibitors: dict[Condition, int] = {}
    for arc in arcs(net):
        source, target = resolve(arc.source), resolve(arc.target)
        if str(arc.kind) == "inhibitor":
            key = (source.id, target.id, "inhibitor", 0)
            inhibitors[key] = min(inhibitors.get(key, arc.weight), arc.weight)
        elif str(arc.kind) == "read":  # short for a pair
            effects[source.id, target.id, "take", 0] += arc.weight
            effects[target.id, source.id, "put", 0] += arc.weight
        else:
            kind = "take" if isinstance(source, pn.Place) else "put"
            effects[source.id, target.id, kind, 0] += arc.weight
    intervals = {}
    for transition in transitions(net):
        interval = transition.interval
        if interval is not None:
            open_end = interval.latest is not None and interval.latestExcluded
            intervals[transition.id] = (
                interval.earliest,
                interval.latest,
                interval.earliestExcluded,
                open_end,
            )
    return {
        "places": [(place.id, place.name, place.tokens) for place in places(net)],
        "transitions": [(transition.id, transition.name) for transition in transitions(net)],
        "effects": effects,
        "inhibitors": inhibitors,
        "intervals": intervals,
        "overrides": {t.id: [other.id for other in t.overrides] for t in transitions(net)},
    }


@given(plain_nets())
def test_reading_what_was_written_gives_a_net_of_the_same_meaning(net: pn.Net) -> None:
    again = parse(net_text(net))
    assert meaning(again) == meaning(net)
    assert net_text(again) == net_text(net)


def test_a_small_net_looks_like_this() -> None:
    net = pn.Net(id="example", name="two words")
    page = pn.Page(id="page", net=net)
    idle, busy = pn.Place(id="idle", tokens=2, name="Idle", page=page), pn.Place(id="tr", page=page)
    start = pn.Transition(id="start", interval=pn.TimeInterval(earliest=1.0, latestExcluded=True), page=page)
    stop = pn.Transition(id="stop", overrides=[start], page=page)
    flow(idle, start, weight=2)
    flow(start, busy, stop)
    inhibit(busy, start, 3)
    read(idle, stop)
    assert net_text(net) == (
        "net {two words}\n"
        "pl idle : Idle (2)\n"
        "pl {tr}\n"
        "tr start [1,w[ idle*2 {tr}?-3 -> {tr}\n"
        "tr stop {tr} idle?1 ->\n"
        "pr stop > start\n"
    )
    again = parse(net_text(net))
    assert differences(again, net, frozenset({"id", "name", "arcs", "latestExcluded"})) == []


def test_every_declaration_of_the_manual_is_read() -> None:
    net = parse(
        "# a comment\n"
        "net {my \\} net}\n"
        "tr t1 : {a label} [0,4[ p1 p2*2 p3?3 p4?-1 -> q1 {q 2}*2K\n"
        "  tr t2 ]1,w[ p1\n -> # continues here\n q1\n"
        "pl p1 (3) t2*2 -> t1*2\n"
        "pl p9 : label9 (1M)\n"
        "pl p5 -> t1?-2 t2?5\n"
        "lb q1 {label of q1}\n"
        "pr t1 > t2 t3\n"
        "pr t2 < t3\n"
        "tr t3\n"
        "nt n1 1 {a note}\n"
    )
    assert meaning(net) == {
        "places": [
            ("p1", None, 3),
            ("p2", None, 0),
            ("p3", None, 0),
            ("p4", None, 0),
            ("q1", "label of q1", 0),
            ("q_2", "q 2", 0),
            ("p9", "label9", 1_000_000),
            ("p5", None, 0),
        ],
        "transitions": [("t1", "a label"), ("t2", None), ("t3", None)],
        "effects": {
            ("p1", "t1", "take", 0): 3,
            ("p2", "t1", "take", 0): 2,
            ("p3", "t1", "take", 0): 3,
            ("t1", "p3", "put", 0): 3,
            ("t1", "q1", "put", 0): 1,
            ("t1", "q_2", "put", 0): 2000,
            ("p1", "t2", "take", 0): 1,
            ("t2", "q1", "put", 0): 1,
            ("t2", "p1", "put", 0): 2,
            ("p5", "t2", "take", 0): 5,
            ("t2", "p5", "put", 0): 5,
        },
        "inhibitors": {("p4", "t1", "inhibitor", 0): 1, ("p5", "t1", "inhibitor", 0): 2},
        "intervals": {"t1": (0.0, 4.0, False, True), "t2": (1.0, None, True, False)},
        "overrides": {"t1": ["t2", "t3"], "t2": [], "t3": ["t2"]},
    }
    assert (net.id, net.name) == ("my_}_net", "my } net")


@pytest.mark.parametrize(
    ("text", "marking", "effects"),
    [
        ("pl p (3K)\ntr t p*2K -> q", 3_000, {("p", "t"): 2_000, ("t", "q"): 1}),
        ("pl p (2M)\ntr t p -> q*1M", 2_000_000, {("p", "t"): 1, ("t", "q"): 1_000_000}),
        ("pl p (2G)\ntr t p*1G -> q*2G", 2_000_000_000, {("p", "t"): 10**9, ("t", "q"): 2 * 10**9}),
        ("pl p (0E)\ntr t p?1G p*3 -> q", 0, {("p", "t"): 10**9, ("t", "p"): 10**9 - 3, ("t", "q"): 1}),
        # A factor belongs to the number: behind white space it is a place.
        ("tr t p*2 G -> q*1 K", 0, {("p", "t"): 2, ("G", "t"): 1, ("t", "q"): 1, ("t", "K"): 1}),
    ],
)
def test_factors_of_weights(text: str, marking: int, effects: dict[tuple[str, str], int]) -> None:
    net = parse(text)
    assert find(net, "p", pn.Place).tokens == marking
    found: Counter[Condition] = meaning(net)["effects"]  # type: ignore[assignment]
    assert {(source, target): weight for (source, target, _, _), weight in found.items()} == effects


@pytest.mark.parametrize(
    "text",
    [
        "tr tr pl w -> q\npl pl (1)\npl w (1)",
        "pl pl (1)\npl w (1)\ntr tr pl w\n -> q",
        "pl {pl} (1)\npl w (1)\ntr {tr} {pl} w -> q",
    ],
)
def test_key_words_as_names(text: str) -> None:
    net = parse(text)
    assert sorted((place.id, place.tokens) for place in places(net)) == [("pl", 1), ("q", 0), ("w", 1)]
    assert sorted(f"{arc.source.id}>{arc.target.id}" for arc in arcs(net)) == ["pl>tr", "tr>q", "w>tr"]


def test_declarations_may_share_a_line() -> None:
    net = parse("net net pl p (1) tr t p -> q pl r (2) lb r pl nt n 0 tr")
    assert {place.id: (place.name, place.tokens) for place in places(net)} == {
        "p": (None, 1),
        "q": (None, 0),
        "r": ("pl", 2),
    }
    assert [transition.id for transition in transitions(net)] == ["t"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("transition t1 p -> q", "1:1: unexpected 'transition' (a declaration begins with net, tr, pl"),
        ("place p (1)", "1:1: unexpected 'place'"),
        ("net n\nplp (1)", "2:1: unexpected 'plp'"),
        ("{tr} t p -> q", "1:1: unexpected '{tr}'"),
        ("tr t p*2q -> r", "1:8: unexpected '2q' (expected a number"),
        ("tr t p*2KK -> r", "unexpected '2KK'"),
        ("tr t p*K -> r", "unexpected 'K'"),
        ("tr t p? q -> r", "1:9: unexpected 'q' (expected a number"),
        ("tr t p -> q*3G", "1:13: 3000000000 is too large"),
        ("pl p (1T)", "is too large"),
        ("tr t p q", "unexpected the end of the file (expected a name, ->)"),
        ("tr t [1,2 p -> q", "unexpected 'p' (expected [, ])"),
        ("tr t [1,w] p -> q", "an unbounded interval ends with w["),
        ("tr t [K,2] p -> q", "unexpected 'K'"),
        ("tr t [-1,2] p -> q", "1:7: unexpected '-' (expected a number"),
        ("tr t [1.,2] p -> q", "1:9: unexpected ',' (a bound is a number such as 3, 0.25 or 1/3)"),
        ("tr t [1. 5,2] p -> q", "1:10: unexpected '5' (a bound is"),
        ("tr t [1K.5,2] p -> q", "unexpected '5' (a bound is"),
        ("tr t [1/0,2] p -> q", "1:7: the bound '1/0' is not understood: it takes a number"),
        ("tr t [1/3,0.3333] p -> q", "the interval [1/3,0.3333] is empty"),
        ("tr t ]0.5,1/2] p -> q", "the interval ]0.5,1/2] is empty"),
        ("tr t [nan,2] p -> q", "unexpected 'nan'"),
        ("pl p (w)", "unexpected 'w'"),
        ("pr t u", "unexpected the end of the file (expected <, >, a name)"),
        ("pr > u", "1:4: unexpected '>' (expected a name)"),
        ("pl p (1)\npl p (2)", "2:7: place 'p' has two markings, on lines 1 and 2"),
        ("net a\npl p\nnet b", "3:5: the net has two names, on lines 1 and 3 (a file holds one net)"),
        ("nt n 2 {a note}", "1:6: a note has the number 0 or 1 between its name and text"),
        ("tr t [1,2] p -> q\n\ntr t [1,3]", "transition 't' has two intervals, on lines 1 and 3"),
    ],
)
def test_what_the_grammar_does_not_have(text: str, message: str) -> None:
    with pytest.raises(ModelFileError) as caught:
        parse(text)
    assert message in str(caught.value)


def test_a_net_without_a_name_is_called_like_its_file(tmp_path: Path) -> None:
    path = tmp_path / "abp.net"
    path.write_text("pl abp (1)\npl page\n")
    net = load(path)
    assert (net.name, [place.id for place in places(net)]) == ("abp", ["abp", "page"])
    assert len({net.id, net.pages[0].id, "abp", "page"}) == 4


def test_what_a_transition_reads_beside_what_it_takes_is_converted() -> None:
    # TINA: at least 5, take 2. DiNeROS: take 2, and 3 more are there.
    net = parse("tr t p*2 p?5 ->\n")
    assert [(str(arc.kind), arc.weight) for arc in arcs(net)] == [("normal", 2), ("read", 3)]
    assert net_text(net) == "net example\npl p\ntr t p*2 p?5 ->\n"
    # Reading no more than is taken says nothing.
    assert same("tr t p*2 p?1 ->\n") == "net example\npl p\ntr t p*2 ->\n"


def test_arcs_through_references_add_up() -> None:
    net = pn.Net(id="n")
    page, inner = pn.Page(id="page", net=net), pn.Page(id="inner", net=net)
    place = pn.Place(id="p", page=page)
    first = pn.ReferencePlace(id="r1", target=place, page=inner)
    second = pn.ReferencePlace(id="r2", target=first, page=inner)
    step = pn.Transition(id="t", page=inner)
    flow(first, step, weight=2)
    flow(second, step)
    inhibit(first, step, 7)
    inhibit(second, step, 9)
    assert net_text(net) == "net n\npl p\ntr t p*3 p?-7 ->\n"


@pytest.mark.parametrize("name", ["a b", "é", "{", "}", "\\", "tr", "", "a\nb", "#", "{\\}"])
def test_any_name_can_be_quoted(name: str) -> None:
    net = pn.Net(id="n", pages=[pn.Page(id="page", objects=[pn.Place(id="p", name=name)])])
    assert find(parse(net_text(net)), "p").name == (name or None)


def test_elements_remember_line_and_column() -> None:
    net = parse("net x\n\n  tr t p -> q\n")
    location = location_of(find(net, "q"))
    assert str(location) == "example.net:3:13"


def test_what_has_no_place_in_the_format_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "out.net"
    with pytest.raises(
        ModelFileError, match=r"with channels cannot be written as \.net \(flatten it first\)"
    ):
        save(small_system(), path)
    silent = small_system()
    silent.channels.clear()
    with pytest.raises(ModelFileError, match="'take' has a clause"):
        save(silent, path)
    below = pn.Transition(id="start", interval=pn.TimeInterval(earliest=-1.0))
    with pytest.raises(ModelFileError, match=r"transition 'start' has the bound -1.0 \(bounds are numbers"):
        save(pn.Net(id="n", pages=[pn.Page(id="page", objects=[below])]), path)
    assert list(tmp_path.iterdir()) == []


def test_a_system_model_without_channels_and_clauses_is_a_net() -> None:
    model = sym.SystemModel(id="m", pages=[sym.NodeNet(id="n", objects=[sym.Place(id="p", tokens=1)])])
    assert net_text(model) == "net m\npl p (1)\n"


def test_broken_references_are_reported() -> None:
    page = pn.Page(id="page")
    reference, step = pn.ReferencePlace(id="r", page=page), pn.Transition(id="t", page=page)
    flow(reference, step)
    net = pn.Net(id="n", pages=[page])
    with pytest.raises(DinerosError, match="'r' has no target"):
        net_text(net)
    reference.target = reference
    with pytest.raises(DinerosError, match="in a circle"):
        net_text(net)


@pytest.mark.long
@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("a b " * 12_500_000, "more than 500000 names"),
        ("(" * 50_000_000, r"1:1: unexpected '\('"),
        ("{" * 20_000_000, "names"),
        ("tr t " + "p " * 100_000, "unexpected the end"),
        ("\n" * 1_000_000 + "x", "1000001"),
    ],
    ids=["names", "brackets", "braces", "arcs", "lines"],
)
def test_large_nonsense_is_answered(content: str, message: str) -> None:
    with pytest.raises(ModelFileError, match=message):
        parse(content)
