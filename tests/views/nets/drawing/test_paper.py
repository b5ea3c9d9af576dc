"""Pictures that can be read: on paper, and at first sight."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.views.nets import (
    Paper,
    around,
    collapse,
    collapse_to_read,
    layout,
    save_for_paper,
    to_svg,
    view_of,
)
from dineros.views.nets.contents.operations import expand
from tests.support.systems.talker import talker
from tests.views.nets.samples import case_study, every_sign

POINTS = 72 / 25.4


def points_of_text(svg: str) -> list[float]:
    """Return the sizes of all texts of a file in print, by its style sheet."""
    width, units = re.search(r'width="([\d.]+)mm"', svg), re.search(r'viewBox="\S+ \S+ ([\d.]+)', svg)
    assert width and units
    per_unit = float(width[1]) * POINTS / float(units[1])
    body = svg.partition("</style>")[2]
    small = {"subtitle", "clause", "note"}
    sizes = {9.0 if any(f'class="{name}"' in body for name in small) or 'class="edge' in body else 11.0}
    sizes |= {float(size) for size in re.findall(r"font-size:([\d.]+)px", body)}
    return [size * per_unit for size in sizes]


@pytest.mark.long
@pytest.mark.parametrize("width", [60, 170])
def test_what_is_written_has_its_width_and_text_that_can_be_read(tmp_path: Path, width: float) -> None:
    written, _ = save_for_paper(view_of(case_study()), tmp_path / "study.svg", Paper(width))
    assert written
    for path in written:
        svg = path.read_text(encoding="utf-8")
        assert f'width="{width}mm"' in svg
        assert min(points_of_text(svg)) >= 6


@pytest.mark.long
def test_a_model_that_is_too_large_is_drawn_page_by_page(tmp_path: Path) -> None:
    view = view_of(case_study())
    written, too_large = save_for_paper(view, tmp_path / "study.svg", Paper(100))
    pages = {box.id for box in view.boxes if any(node.box == box.id for node in view.nodes)}
    drawn = {path.stem.removeprefix("study-") for path in written}
    assert drawn | {str(sheet.page) for sheet in too_large if sheet.page} == pages
    assert {sheet.page for sheet in too_large} >= {None}
    assert all(sheet.needed > 100 for sheet in too_large)
    nodes = set(re.findall(r'data-id="([^"]+)"', (tmp_path / "study-Safety.svg").read_text(encoding="utf-8")))
    assert {"Safety", "TStop", "Unsafe"} <= nodes and "TPick" not in nodes


def test_a_width_that_is_needed_is_enough(tmp_path: Path) -> None:
    """And a little less is not."""
    view = around(view_of(talker()), ["Listen"], 1)
    with pytest.raises(DinerosError, match="too large for 20 mm") as refused:
        save_for_paper(view, tmp_path / "x.svg", Paper(20))
    assert list(tmp_path.iterdir()) == []
    needed = int(re.search(r"needs (\d+) mm", str(refused.value.hint))[1])  # type: ignore[index]
    assert save_for_paper(view, tmp_path / "x.svg", Paper(needed))[0] == [tmp_path / "x.svg"]
    with pytest.raises(DinerosError):
        save_for_paper(view, tmp_path / "y.svg", Paper(needed - 1.01))


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.5])
def test_the_form_is_the_one_asked_for_and_the_net_is_in_its_middle(tmp_path: Path, aspect: float) -> None:
    positioned = layout(view_of(talker()))
    svg = to_svg(positioned, paper=Paper(200, aspect))
    x, y, wide, high = (float(value) for value in re.search(r'viewBox="([^"]+)"', svg)[1].split())  # type: ignore[index]
    assert wide / high == pytest.approx(aspect, rel=1e-3)
    height = float(re.search(r'height="([\d.]+)mm"', svg)[1])  # type: ignore[index]
    assert 200 / height == pytest.approx(aspect, rel=1e-3)
    assert x + wide / 2 == pytest.approx(positioned["width"] / 2, abs=0.2)
    assert y + high / 2 == pytest.approx(positioned["height"] / 2, abs=0.2)


def test_a_layout_of_another_form_shows_the_same() -> None:
    view = collapse(view_of(case_study()))
    one, other = layout(view), layout(view, aspect=1.0)
    assert other["width"] < one["width"] * 0.7
    for name in ("boxes", "nodes", "edges"):
        assert [item["id"] for item in one[name]] == [item["id"] for item in other[name]]


def test_png_for_paper_has_600_dots_to_the_inch(tmp_path: Path) -> None:
    view = around(view_of(talker()), ["Listen"], 1)
    (path,), _ = save_for_paper(view, tmp_path / "x.png", Paper(50.8))
    assert struct.unpack(">I", path.read_bytes()[16:20])[0] == pytest.approx(1200, abs=2)


def test_large_numbers_of_tokens_count_as_text() -> None:
    positioned = layout(view_of(every_sign()))
    paper = Paper(500)
    needed = paper.needed(positioned)
    for node in positioned["nodes"]:
        node["tokens"] = 1
    assert needed > paper.needed(positioned)


def test_names_can_be_read_at_first_sight() -> None:
    view = collapse_to_read(view_of(case_study()))
    positioned = layout(view)
    assert min(1280 / positioned["width"], 640 / positioned["height"]) * 11 >= 8
    assert any(box.collapsed for box in view.boxes)  # of less than 150 nodes
    small = view_of(talker())
    assert collapse_to_read(small) == small


def test_only_as_many_levels_collapse_as_it_takes() -> None:
    view = collapse_to_read(view_of(every_sign()))
    assert not any(box.collapsed for box in view.boxes)
    wide = expand(around(view_of(case_study()), ["controller", "executor"], 1))
    seen = {box.id: bool(box.collapsed) for box in collapse_to_read(wide).boxes}
    assert True in seen.values()
    assert all(seen[box.id] or not box.parent or not seen[box.parent] for box in wide.boxes)
