"""Symmetric nets: unfolded when read, compared with an interpreter of coloured nets."""

from __future__ import annotations

import tracemalloc
from collections import deque
from pathlib import Path

import pytest

from dineros.metamodel import pn
from dineros.metamodel.colours.origins import origins_of
from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.pnml import read_pnml
from tests.support.references.coloured import Coloured, random_net

MOST = 300


def read(tmp_path: Path, text: str) -> pn.Net:
    file = tmp_path / "net.pnml"
    file.write_text(text, encoding="utf-8")
    return read_pnml(file)


def graph(net: pn.Net) -> tuple[int, list[tuple[str, ...]]]:
    """Return the number of reachable markings of a plain net, and its steps by place counts, sorted."""
    (page,) = net.pages
    places = [node for node in page.objects if isinstance(node, pn.Place)]
    index = {place: number for number, place in enumerate(places)}
    moves = []
    for node in page.objects:
        if isinstance(node, pn.Transition):
            takes = [(index[arc.source], arc.weight) for arc in node.incoming]  # type: ignore[index]
            puts = [(index[arc.target], arc.weight) for arc in node.outgoing]  # type: ignore[index]
            moves.append((str(node.id).partition("(")[0], takes, puts))
    start = tuple(place.tokens for place in places)
    seen, todo = {start}, deque([start])
    steps = []
    group = {
        id: [n for n, place in enumerate(places) if place.id in each]
        for id, each in origins_of(net).places.items()
    }
    while todo:
        marking = todo.popleft()
        for name, takes, puts in moves:
            if any(marking[place] < weight for place, weight in takes):
                continue
            after = list(marking)
            for place, weight in takes:
                after[place] -= weight
            for place, weight in puts:
                after[place] += weight
            key = tuple(after)
            totals = [
                str([sum(each[n] for n in members) for members in group.values()]) for each in (marking, key)
            ]
            steps.append((totals[0], name, totals[1]))
            if key not in seen:
                seen.add(key)
                todo.append(key)
    return len(seen), sorted(steps)


def expected(net: Coloured) -> tuple[int, list[tuple[str, ...]]] | None:
    found = net.graph(MOST)
    if found is None:
        return None

    def totals(marking: frozenset[tuple[str, object, int]]) -> str:
        return str([sum(n for place, _, n in marking if place == each) for each in net.places])

    steps = [
        (totals(marking), transition, totals(after))
        for marking, each in found.items()
        for transition, after in each
    ]
    return len(found), sorted(steps)


@pytest.mark.parametrize("start", range(4))
def test_random_nets_have_the_markings_and_steps_of_an_interpreter(tmp_path: Path, start: int) -> None:
    compared = 0
    for seed in range(start * 1000, start * 1000 + 60):
        coloured = random_net(seed)
        found = expected(coloured)
        if found is not None:
            compared += found[0] > 1
            assert graph(read(tmp_path, coloured.pnml())) == found, seed
    assert compared >= 10


NET = """<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml">
<net id="n" type="http://www.pnml.org/version-2009/grammar/symmetricnet">
<declaration><structure><declarations>
<namedsort id="Site" name="Site"><finiteenumeration>
<feconstant id="a" name="a"/><feconstant id="b" name="b"/><feconstant id="c" name="c"/>
</finiteenumeration></namedsort>
<partition id="Zone" name="Zone"><usersort declaration="Site"/>
<partitionelement id="north" name="north"><useroperator declaration="a"/></partitionelement>
<partitionelement id="south" name="south">
<useroperator declaration="b"/><useroperator declaration="c"/></partitionelement></partition>
<variabledecl id="x" name="x"><usersort declaration="Site"/></variabledecl>
</declarations></structure></declaration>
<page id="one">
<place id="At"><type><structure><usersort declaration="Site"/></structure></type>
<hlinitialMarking><structure><all><usersort declaration="Site"/></all></structure></hlinitialMarking></place>
<referenceTransition id="far" ref="move"/>
<arc id="in" source="At" target="far">
<hlinscription><structure><variable refvariable="x"/></structure></hlinscription></arc>
</page>
<page id="two">
<transition id="move"><condition><structure><equality>
<subterm><partitionelementof refpartition="Zone">
<subterm><variable refvariable="x"/></subterm></partitionelementof></subterm>
<subterm><useroperator declaration="south"/></subterm>
</equality></structure></condition></transition>
<place id="Never"><type><structure><usersort declaration="Site"/></structure></type></place>
</page>
</net></pnml>
"""


def test_partitions_references_and_colours_that_cannot_occur(tmp_path: Path) -> None:
    net = read(tmp_path, NET)
    origins = origins_of(net)
    assert origins.places == {"At": ("At(a)", "At(b)", "At(c)"), "Never": ()}
    assert origins.transitions == {"move": ("move(b)", "move(c)")}


VARIABLE = '<variable refvariable="x"/>'
SUBTERM = f"<subterm>{VARIABLE}</subterm>"


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        (f"{VARIABLE}</structure></hl", '<variable refvariable="y"/></structure></hl', 18, "not declared"),
        ('"Site"/></variabledecl>', '"Sight"/></variabledecl>', 11, "the sort 'Sight' is not declared"),
        ('<useroperator declaration="south"/>', '<useroperator declaration="a"/>', 21, "Zone and Site"),
        ('declaration="b"/>', 'declaration="a"/>', 7, "each value of Site exactly once"),
        ("<equality>", "<successor/><equality>", 21, "holds 2 elements"),
        (
            f"<structure>{VARIABLE}</structure></hl",
            f"<structure><successor><subterm><tuple>{2 * SUBTERM}</tuple></subterm></successor>"
            "</structure></hl",
            18,
            "a tuple",
        ),
        ("<equality>", "<equality><subterm/>", 21, "<subterm> holds 0 elements"),
        ('ref="move"', 'ref="far"', 16, "refers to itself"),
        ('ref="move"', 'ref="moves"', 17, "there is no node 'moves'"),
        ('id="b" name="b"', 'id="a" name="b"', 5, "the constant 'a' is declared twice"),
        ('<page id="two">', '<page id="two"><place id="P"/>', 20, "<place> 'P' has no <type>"),
        ('id="move">', 'id="move"><priority/>', 21, "<priority> is not part of the <transition>"),
        ('id="in"', 'id="in" type="inhibitor"', 17, "has an unknown attribute 'type'"),
        (
            "<hlinscription>",
            '<toolspecific tool="ModernPetriEditor" version="1.0" type="inhibitor"/><hlinscription>',
            18,
            "arc 'in' is an inhibitor arc",
        ),
        ("<hlinscription>", "<hlinscription><structure/>", 18, "has two <structure>"),
        ("<hlinscription>", "<hlinscription><guard/>", 18, "<guard> is not part of <hlinscription>"),
        (f"<structure>{VARIABLE}", f"<structure><add>{VARIABLE}</add>", 18, "<subterm> is expected"),
        (
            f"<hlinscription><structure>{VARIABLE}</structure></hlinscription>",
            "",
            17,
            "how many tokens it moves, and of which colours, is not known",
        ),
        (
            '<variabledecl id="x"',
            '<namedoperator id="o" name="o"/><variabledecl id="x"',
            11,
            "write its definition where it is used",
        ),
        (
            f"<structure>{VARIABLE}</structure>",
            f"<structure><cardinality><subterm>{VARIABLE}</subterm></cardinality></structure>",
            18,
            "write the number or the colours",
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_line(
    tmp_path: Path, old: str, new: str, line: int, message: str
) -> None:
    assert old in NET
    with pytest.raises(ModelFileError) as caught:
        read(tmp_path, NET.replace(old, new, 1))
    assert message in str(caught.value)
    assert f":{line}:" in str(caught.value)


def test_a_net_that_would_be_too_large_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DINEROS_LIMITS", "elements=4")
    with pytest.raises(ModelFileError, match=r"the unfolded net is too large .*--limit elements=NUMBER"):
        read(tmp_path, NET)


HUGE = 2**31 - 1
NUMBERS = f'<namedsort id="N" name="N"><finiteintrange start="1" end="{HUGE}"/></namedsort>'
ONE = f'<finiteintrangeconstant value="1"><finiteintrange start="1" end="{HUGE}"/></finiteintrangeconstant>'
PAIRS = (
    '<namedsort id="P" name="P"><productsort>'
    + 2 * '<usersort declaration="S"/>'
    + "</productsort></namedsort>"
)
SMALL = '<namedsort id="S" name="S"><finiteintrange start="1" end="1000"/></namedsort>'
ALL = '<all><usersort declaration="{}"/></all>'
EACH = '<subterm><all><usersort declaration="S"/></all></subterm>'


def _huge(declarations: str, sort: str, marking: str, taken: str) -> str:
    return f"""<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"><net id="n"
    type="http://www.pnml.org/version-2009/grammar/symmetricnet"><declaration><structure><declarations>
    {declarations}</declarations></structure></declaration><page id="g">
    <place id="p"><type><structure><usersort declaration="{sort}"/></structure></type>
    <hlinitialMarking><structure>{marking}</structure></hlinitialMarking></place><transition id="t"/>
    <arc id="a" source="p" target="t"><hlinscription><structure>{taken}</structure></hlinscription></arc>
    </page></net></pnml>"""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (_huge(NUMBERS, "N", ALL.format("N"), ONE), "the unfolded net is too large"),
        (_huge(NUMBERS, "N", ONE, ALL.format("N")), "the unfolded net is too large"),
        (
            _huge(SMALL + PAIRS, "P", f"<tuple>{2 * EACH}</tuple>", ALL.format("P")),
            "the unfolded net is too large",
        ),
        (
            _huge(
                f'{NUMBERS}<partition id="G" name="G"><usersort declaration="N"/>'
                f'<partitionelement id="g" name="g">{ONE}</partitionelement></partition>',
                "N",
                ONE,
                ONE,
            ),
            "the partition 'G' does not have each value of N exactly once",
        ),
    ],
    ids=["all in a marking", "all on an arc", "pairs", "partition"],
)
def test_a_sort_of_two_thousand_million_values_takes_no_memory(
    tmp_path: Path, text: str, message: str
) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(ModelFileError, match=message):
            read(tmp_path, text)
        assert tracemalloc.get_traced_memory()[1] < 100 << 20  # reading a file takes 64 MiB
    finally:
        tracemalloc.stop()


def _term(kind: str, *operands: str) -> str:
    return f"<{kind}>" + "".join(f"<subterm>{operand}</subterm>" for operand in operands) + f"</{kind}>"


EVERYWHERE = '<all><usersort declaration="Site"/></all>'
A, B, SOUTH = (f'<useroperator declaration="{id}"/>' for id in ("a", "b", "south"))
TWO = '<numberconstant value="2"><positive/></numberconstant>'


@pytest.mark.parametrize(
    ("marking", "tokens"),
    [
        (_term("subtract", EVERYWHERE, A, B), {"At(c)": 1}),
        (_term("numberof", TWO, A, B), {"At(a)": 2, "At(b)": 2}),
        (_term("tuple", EVERYWHERE), {"At(a)": 1, "At(b)": 1, "At(c)": 1}),
        (_term("numberof", TWO, _term("tuple", SOUTH)), {"At(b)": 2, "At(c)": 2}),
        (_term("subtract", EVERYWHERE, SOUTH), {"At(a)": 1}),
    ],
    ids=["three", "two kinds", "tuple of one", "element", "without element"],
)
def test_short_forms_that_tools_write(tmp_path: Path, marking: str, tokens: dict[str, int]) -> None:
    net = read(tmp_path, NET.replace(EVERYWHERE, marking))
    (page,) = net.pages
    assert {node.id: node.tokens for node in page.objects if isinstance(node, pn.Place)} == tokens


def test_a_product_of_one_sort_is_that_sort(tmp_path: Path) -> None:
    text = NET.replace(
        "</declarations>",
        '<namedsort id="One" name="One"><productsort><usersort declaration="Site"/></productsort></namedsort>'
        "</declarations>",
    ).replace(
        '<type><structure><usersort declaration="Site"/>', '<type><structure><usersort declaration="One"/>'
    )
    assert origins_of(read(tmp_path, text)).places == {"At": ("At(a)", "At(b)", "At(c)"), "Never": ()}


@pytest.mark.parametrize("size", [99, 101])
def test_values_of_variables_that_no_arc_binds_are_limited(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int
) -> None:
    """No pair of values fulfils the condition, so that the number of transitions limits nothing."""
    variables = "".join(
        f'<variabledecl id="{name}" name="{name}"><usersort declaration="N"/></variabledecl>' for name in "xy"
    )
    less = "".join(
        "<subterm><lessthan>"
        + "".join(f'<subterm><variable refvariable="{name}"/></subterm>' for name in pair)
        + "</lessthan></subterm>"
        for pair in ("xy", "yx")
    )
    condition = f"<condition><structure><and>{less}</and></structure></condition>"
    text = _huge(NUMBERS + variables, "N", ONE, ONE).replace(str(HUGE), str(size))
    text = text.replace('<transition id="t"/>', f'<transition id="t">{condition}</transition>')
    monkeypatch.setenv("DINEROS_LIMITS", "elements=100")
    if size <= 99:
        assert len(read(tmp_path, text).pages) == 1
    else:
        with pytest.raises(ModelFileError, match="no arc binds, with too many values to try"):
            read(tmp_path, text)
