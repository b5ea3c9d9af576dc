"""SVG and PNG: structure and overlays."""

from __future__ import annotations

import struct
from collections import Counter
from typing import Any

import pytest
from lxml import etree

from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError
from dineros.views.nets import Box, ViewModel, compare, layout, to_png, to_svg, view_of
from dineros.views.nets.contents.glyphs import finish_box
from dineros.views.nets.contents.measures import text_width, wrap
from dineros.views.nets.contents.model import Signal
from dineros.views.nets.drawing.legend import legend_svg
from dineros.views.nets.placement.picture import Picture
from tests.support.systems.talker import talker
from tests.views.nets.samples import case_study, every_sign, models

NAMESPACE = "{http://www.w3.org/2000/svg}"


def parsed(svg: str) -> Any:
    return etree.fromstring(svg.encode())


def group(root: Any, id: str) -> Any:
    (found,) = root.xpath("//*[@data-id=$id]", id=id)
    return found


@pytest.fixture(scope="module")
def picture() -> Picture:
    return layout(view_of(case_study()))


@pytest.mark.parametrize("name", list(models()))
def test_every_element_is_drawn_once(name: str) -> None:
    view = view_of(models()[name])
    root = parsed(to_svg(layout(view)))
    drawn = Counter(root.xpath("//@data-id"))
    signals = [signal.id for box in view.boxes for signal in box.signals]
    assert drawn == Counter([*(item.id for item in view.elements()), *signals])


def test_names_clauses_and_channels_can_be_read(picture: Picture) -> None:
    root = parsed(to_svg(picture))
    texts = {"".join(node.itertext()) for node in root.iter(f"{NAMESPACE}text")}
    assert {"selector", "TStop", "Danger", "service, 2 instances", "dispatcher 16, queue 10"} <= texts
    assert group(root, "LeftCellObjects").get("class") == "topic"
    assert group(root, "Pick").get("class") == "service"
    assert group(root, "Pick").find(f"{NAMESPACE}polygon") is not None  # not by colour alone
    assert group(root, "UITopic").find(f"{NAMESPACE}polygon") is None


def test_all_text_fits_into_the_picture(picture: Picture) -> None:
    root = parsed(to_svg(picture))
    assert root.get("viewBox") == f"0 0 {root.get('width')} {root.get('height')}"
    for text in root.iter(f"{NAMESPACE}text"):
        x, y = float(text.get("x", 0)), float(text.get("y", 0))
        for outer in text.iterancestors(f"{NAMESPACE}g"):
            move = outer.get("transform")
            if move:
                dx, dy = move.removeprefix("translate(").rstrip(")").split(",")
                x, y = x + float(dx), y + float(dy)
        assert 0 <= x <= float(root.get("width"))
        assert 0 <= y <= float(root.get("height"))


def test_tokens_are_dots_or_numbers() -> None:
    root = parsed(to_svg(layout(view_of(every_sign()))))
    few, many, none = (
        group(root, id).find(f"{NAMESPACE}g[@class='tokens']") for id in ("few", "many", "none")
    )
    assert [child.tag for child in few] == [f"{NAMESPACE}circle"] * 3
    assert [child.text for child in many] == ["1234"]
    assert len(none) == 0
    assert "<few> & 'so'" in "".join(group(root, "few").itertext())


def test_inhibitor_arcs_end_in_a_ring_and_read_arcs_have_two_heads() -> None:
    root = parsed(to_svg(layout(view_of(every_sign()))))
    assert group(root, "none-go-inhibitor").find(f"{NAMESPACE}circle") is not None
    assert len(group(root, "many-go-read").findall(f"{NAMESPACE}polygon")) == 2
    assert len(group(root, "go-many").findall(f"{NAMESPACE}polygon")) == 1


def test_a_marking_overlays_the_initial_one(picture: Picture) -> None:
    root = parsed(
        to_svg(picture, marking={"Safe": 2, "Unsafe": 0}, signals={"Danger": True}, highlights=["TStop"])
    )
    dots = {id: len(group(root, id).find(f"{NAMESPACE}g[@class='tokens']")) for id in
            ("Safe", "Safe@PickServer", "Unsafe", "StateGet")}  # fmt: skip
    assert dots == {"Safe": 2, "Safe@PickServer": 2, "Unsafe": 0, "StateGet": 1}
    assert group(root, "Danger").get("class") == "signal true"
    assert group(root, "Sensor").get("class") == "signal"
    assert group(root, "TStop").get("class") == "transition marked"
    assert group(root, "TRetry").get("class") == "transition"


def test_signals_are_shown_as_they_are_now() -> None:
    box = Box(
        "box",
        "node",
        "box",
        signals=[Signal('<a> & "b"', "a", True), Signal("c", "c", True), Signal("d", "d", False)],
    )
    finish_box(box)
    positioned = layout(ViewModel("net", "net", "net", [box]))
    svg = to_svg(positioned, signals={'<a> & "b"': False, "d": True}, highlights=["d"])
    classes = {one.get("data-id"): one.get("class") for one in parsed(svg).xpath("//*[@data-id]")}
    assert classes == {
        "box": "box node",
        '<a> & "b"': "signal",
        "c": "signal true",
        "d": "signal true marked",
    }


def test_names_of_javascript_are_names_like_others() -> None:
    names = ("constructor", "toString", "__proto__")
    box = Box("valueOf", "node", "box", signals=[Signal("hasOwnProperty", "s", False)])
    finish_box(box)
    view = view_of(
        pn.Net(id="net", pages=[pn.Page(id="p", objects=[pn.Place(id=name, tokens=2) for name in names])])
    )
    view.boxes.append(box)
    root = parsed(to_svg(layout(view), marking={"__proto__": 3}))
    dots = [len(group(root, name).find(f"{NAMESPACE}g[@class='tokens']")) for name in names]
    assert dots == [2, 2, 3]
    assert group(root, "hasOwnProperty").get("class") == "signal"


def test_the_second_arc_of_a_pair_is_highlighted_by_the_first(picture: Picture) -> None:
    root = parsed(to_svg(picture, highlights=["TPick-Safe@PickServer"]))
    assert group(root, "Safe@PickServer-TPick").get("class") == "edge read marked"


def test_themes_differ_in_colours_only(picture: Picture) -> None:
    light, dark = to_svg(picture), to_svg(picture, theme="dark")
    assert "var(" not in light + dark
    assert light != dark
    assert light.partition("</style>")[2] == dark.partition("</style>")[2]


def test_changes_have_signs_not_only_colours() -> None:
    other = talker()
    other.pages[0].objects[0].tokens = 9  # type: ignore[attr-defined]
    root = parsed(to_svg(layout(compare(view_of(talker()), view_of(other)))))
    assert [
        text.text for text in root.xpath("//*[starts-with(@class, 'change ')]/*[local-name()='text']")
    ] == ["≠"]


def test_png_has_the_size_and_shows_the_tokens(picture: Picture) -> None:
    small = layout(view_of(talker()))
    image = to_png(to_svg(small), scale=2)
    assert image.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", image[16:24])
    assert (width, height) == (
        pytest.approx(2 * small["width"], abs=2),
        pytest.approx(2 * small["height"], abs=2),
    )
    assert to_png(to_svg(small, marking={"Words": 1}), scale=2) != image


def test_huge_pictures_become_smaller(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.views.nets.drawing.png.MOST_PIXELS", 10_000)
    width, height = struct.unpack(">II", to_png(to_svg(layout(view_of(talker()))))[16:24])
    assert 5_000 < width * height <= 11_000


def test_png_without_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "resvg_py", None)
    with pytest.raises(DinerosError, match="resvg-py"):
        to_png("<svg/>")


def test_the_legend_is_well_formed() -> None:
    root = etree.fromstring(legend_svg())
    assert len(list(root.iterfind(".//*[@data-id]"))) >= 12


def test_widths_of_text() -> None:
    assert text_width("iii", 10) < text_width("mmm", 10)
    assert text_width("word", 10, bold=True) > text_width("word", 10)
    assert text_width("漢", 10) > text_width("a", 10)
    assert wrap("(RobotIsIdle | RobotHasFinished) & ObjectIsPicked", 26) == [
        "(RobotIsIdle |",
        "RobotHasFinished) &",
        "ObjectIsPicked",
    ]
    assert all(len(line) <= 26 for line in wrap("x" * 100, 20))
    assert "".join(wrap("a.b" * 30, 20)) == "a.b" * 30
