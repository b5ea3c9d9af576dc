"""Pictures and descriptions of rules: every element is shown, where it belongs, and looks like what it is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.errors import DinerosError, UnknownElementError
from dineros.transformations.language.creation import Copy, ForAll, New
from dineros.transformations.language.patterns import Absent, Made, Node
from dineros.transformations.language.rule import Rule
from dineros.transformations.pictures.describing import lhs_rows, rhs_rows, rule_text
from dineros.transformations.pictures.diagram import Side
from dineros.transformations.pictures.drawing import draw_rule, rule_dot, rule_svg
from dineros.transformations.rules import services, signals, topics
from dineros.transformations.rules.catalogue import FAMILIES, find_rule, name_of, summary_of
from dineros.transformations.rules.notation import arc, place, transition
from tests.support.programs.system_packages import needs

RULES = [rule for family in FAMILIES for rule in family.rules]
needs_graphviz = needs("graphviz")


class Odd(Rule):
    """Shows what no standard rule has <here & there>."""

    source = Node(sym.Place)
    gone = Node(pn.Arc, source=source)
    forbidden = Node(sym.PublisherPort, place=source)
    sink = transition("{source.id}.sink")
    marks = ForAll([Node(sym.InputSignal)], make=[place("{source.id}.mark", tokens=7)])
    arcs = [arc(source, sink, weight=3)]

    absent = [Absent(forbidden)]
    lhs = [source, gone]
    rhs = [source, sink, marks, *arcs]


def test_each_rule_has_a_name_of_its_own_and_a_summary() -> None:
    assert len({name_of(rule) for rule in RULES}) == len(RULES)
    assert all(summary_of(rule) for rule in RULES)


def test_rules_are_called_as_in_the_paper() -> None:
    names = [name_of(rule) for rule in RULES]
    assert names[:8] == ["T1", "T2", "T2-history", "T2-instance", "T3", "T4", "T5a", "T5b"]
    assert names[names.index("R1") - 1] == "I6-io-enabled"
    assert names[-1] == "B4"
    assert find_rule("i5-FULLY-enabled") is signals.I5FullyEnabled
    assert find_rule("I5FullyEnabled") is signals.I5FullyEnabled
    with pytest.raises(UnknownElementError, match="did you mean 'T5b' or 'T5a'"):
        find_rule("T5")


@pytest.mark.parametrize("rule", [*RULES, Odd], ids=name_of)
def test_a_picture(rule: type[Rule]) -> None:
    each_side_shows_its_elements(rule)
    what_is_underlined_on_one_side_is_underlined_on_the_other(rule)
    assert rule_dot(rule) == rule_dot(rule)


def each_side_shows_its_elements(rule: type[Rule]) -> None:
    left, right = Side(rule, left=True), Side(rule, left=False)
    for node in rule.lhs:
        if isinstance(node, (Node, Made)) and not (node.eclass and issubclass(node.eclass, pn.Arc)):
            assert str(node) in left.shapes or str(node) in left.boxes
            is_kept = all(node is not each for each in rule.deleted)
            assert (str(node) in right.shapes or str(node) in right.boxes) is is_kept
    for element in rule.created.values():
        if isinstance(element, Copy):
            assert right.boxes[str(element)].status == "created"
        elif not issubclass(element.eclass or pn.Arc, pn.Arc):
            assert right.shapes[str(element)].status == "created"
            assert str(element) not in left.shapes
    drawn = [line for line in right.lines if line.status == "created" and line.kind not in ("link", "flow")]
    made = [element for element in rule.created.values() if isinstance(element, New) and is_arc(element)]
    repeated = [element for item in rule.for_all for element in item.created() if is_arc(element)]
    assert len(drawn) == len(made) + len(repeated)
    assert not [line for line in left.lines if line.status == "created"]


def is_arc(element: New) -> bool:
    return element.eclass is not None and issubclass(element.eclass, pn.Arc)


def what_is_underlined_on_one_side_is_underlined_on_the_other(rule: type[Rule]) -> None:
    dot = rule_dot(rule)
    underlined = {side: set(re.findall(rf'"{side} ([^"]+)" \[[^\n]*<U>', dot)) for side in "LR"}
    assert underlined["L"] == underlined["R"]
    assert not re.findall(r"<U>[^\n]*penwidth=2.4|penwidth=2.4[^\n]*<U>", dot)


def test_the_overflow_queue_looks_as_in_the_paper() -> None:
    right = Side(topics.T2, left=False)
    assert right.shapes["queue.capacity"].inside == "l"
    assert right.notes == ["l = port.limit"]
    assert right.boxes["group queue"].title == "queue: OverflowQueue"
    assert {(line.source, line.target) for line in right.lines if line.status == "created"} == {
        ("source", "queue.enter"),
        ("queue.capacity", "queue.enter"),
        ("queue.enter", "queue.load"),
        ("queue.load", "queue.leave"),
        ("queue.leave", "queue.capacity"),
        ("queue.leave", "topic"),
        ("source", "queue.drop"),
    }


def test_arcs_have_the_papers_ends() -> None:
    assert "arrowhead=odot" in rule_dot(topics.T5a)
    assert "arrowhead=odot" not in rule_dot(topics.T5b)
    read_arc = re.search(r'"R true_literals" -> "R transition".*', rule_dot(signals.I1))
    assert read_arc is not None
    assert "arrowhead=normal, arrowtail=normal" in read_arc.group()


def test_lookups_say_which_rule_made_what_they_find() -> None:
    left = Side(services.S2, left=True)
    assert left.shapes["requests"].notes == ["by S1 for client"]
    assert left.boxes["page"].title == "«page» page, by S4 for service, instance"
    assert left.shapes["entry"].box == "page"
    assert left.notes == ["instance = 1 … service.instances or number of service.clients"]
    assert Side(topics.T5b, left=True).boxes["queue"].title == "queue: any OverflowQueue"


def test_a_place_found_by_its_page_stands_in_it() -> None:
    left = Side(topics.T4, left=True)
    assert left.boxes["node"].title == "«node net» node"
    assert left.shapes["sink"].box == "node"


def test_the_copy_of_a_page_shows_the_places_of_its_port() -> None:
    right = Side(services.S4, left=False)
    assert {(shape.name, shape.box, shape.status) for shape in right.shapes.values() if shape.box} == {
        ("entry", "page", "created"),
        ("exit", "page", "created"),
        ("entry", "server.page", "kept"),
        ("exit", "server.page", "kept"),
    }


def test_what_no_standard_rule_has_is_drawn() -> None:
    left, right = Side(Odd, left=True), Side(Odd, left=False)
    assert [line.status for line in left.lines if line.label == "gone"] == ["deleted"]
    assert not [line for line in right.lines if line.label == "gone"]
    assert left.boxes["absent 0"].kind == "absent"
    assert left.shapes["forbidden"].box == "absent 0"
    (for_all,) = [box for box in right.boxes.values() if box.kind == "for-all"]
    assert [(shape.name, shape.inside) for shape in right.shapes.values() if shape.box == for_all.key][
        -1
    ] == (
        "mark",
        "7",
    )
    assert for_all.title == "for all InputSignal"
    assert "&lt;here &amp; there&gt;" in rule_dot(Odd)
    assert ("gone", "deleted") in rhs_rows(Odd)
    assert ("no", "forbidden PublisherPort with place = source") in lhs_rows(Odd)


@pytest.mark.long
@needs_graphviz
@pytest.mark.parametrize("rule", [*RULES, Odd], ids=name_of)
def test_left_is_left_and_nothing_overlaps(rule: type[Rule]) -> None:
    svg = rule_svg(rule)
    assert svg.rstrip().endswith("</svg>")
    boxes = {name: box_of(points) for name, points in clusters(svg)}
    left, right = boxes["cluster_L"], boxes["cluster_R"]
    assert left[2] < right[0]
    shapes = [(match[1], float(match[2]), float(match[3])) for match in CIRCLES.finditer(svg)]
    for number, (name, x, y) in enumerate(shapes):
        side = left if name.startswith("L ") else right
        assert side[0] < x < side[2] and side[1] < y < side[3]
        for other, other_x, other_y in shapes[number + 1 :]:
            assert abs(x - other_x) > 30 or abs(y - other_y) > 30, (name, other)


CIRCLES = re.compile(r'<title>([LR] [^<]+)</title>\n<ellipse[^>]* cx="([-\d.]+)" cy="([-\d.]+)"')


def clusters(svg: str) -> list[tuple[str, str]]:
    return re.findall(r'<title>(cluster_[LR])</title>\n<path [^>]* d="([^"]+)"', svg)


def box_of(path: str) -> tuple[float, float, float, float]:
    numbers = [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", path)]
    return min(numbers[::2]), min(numbers[1::2]), max(numbers[::2]), max(numbers[1::2])


@needs_graphviz
def test_the_suffix_chooses_the_format(tmp_path: Path) -> None:
    for suffix, start in ((".png", b"\x89PNG"), (".svg", b"<?xml"), (".dot", b"digraph"), (".SVG", b"<?xml")):
        draw_rule(topics.T1, tmp_path / f"t1{suffix}")
        assert (tmp_path / f"t1{suffix}").read_bytes().startswith(start)


@pytest.mark.parametrize(("name", "part"), [("t1.jpg", "'.jpg' is not a format"), ("t1", "has no suffix")])
def test_other_formats_are_refused(tmp_path: Path, name: str, part: str) -> None:
    with pytest.raises(DinerosError, match=part):
        draw_rule(topics.T1, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_missing_graphviz_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DinerosError, match=r"no command 'dot' \(install the package graphviz\)"):
        draw_rule(topics.T1, tmp_path / "t1.svg")
    draw_rule(topics.T1, tmp_path / "t1.dot")  # needs no layout


def test_a_rule_reads_as_text() -> None:
    assert rule_text(topics.T1) == (
        "LHS\n"
        "  channel    TopicChannel\n"
        "RHS: the same, and\n"
        "  topic      Place {channel.id}\n"
        "  transport  Transition {channel.id}.transport\n"
        "  arc        topic -> transport"
    )
    text = rule_text(signals.I6InputEnabled)
    assert "for all     incoming Arc with target = transition with incoming.kind != inhibitor" in text
    assert "arc       incoming.source <-> change.to_true with weight incoming.weight" in text
    assert "queue.capacity -o queue.drop" in rule_text(topics.T5a)


def test_signs_mean_what_they_mean_in_pictures_of_nets() -> None:
    """Services are pointed, topics round, and nothing else is."""
    pointed = re.findall(r'"L (\w+)" \[.*shape=hexagon', rule_dot(services.S2) + rule_dot(signals.I4))
    assert pointed == ["service"]
    assert re.search(r'"L channel" \[.*shape=box.*rounded', rule_dot(topics.T2))
    assert not re.search(r'"L signal" \[.*rounded', rule_dot(signals.I4))


def test_arcs_run_behind_names() -> None:
    source = rule_dot(topics.T2)
    assert "outputorder=edgesfirst" in source
    names = re.findall(r"<TD[^>]*><U>?<I>[PT]</I>|<TD[^>]*><I>[PT]</I>", source)
    assert names and all('BGCOLOR="white"' in name for name in names)
