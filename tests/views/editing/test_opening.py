"""Pages that are opened in place, in a real browser: what is in them is seen and edited in their frames."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import expect

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import find, label
from dineros.metamodel.files import load, save
from tests.support.systems.talker import talker
from tests.views.browser import Visit, wait_until
from tests.views.editing.conftest import Edit
from tests.views.editing.driving import Hand

NewVisit = Callable[..., Visit]


def at(element: pn.Element, x: float, y: float) -> None:
    element.graphics = pn.Graphics(positions=[pn.Point(x=x, y=y)])


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return a model that is drawn, with a page in a ROS node."""
    model = talker()
    for number, id in enumerate(("Words", "Say", "Said")):
        at(find(model, id, pn.Node), 100 + 100 * number, 80)
    for number, id in enumerate(("Heard", "Listen", "Noted")):
        at(find(model, id, pn.Node), 300 + 100 * number, 500)
    for number, id in enumerate(("talker", "Chatter", "listener")):
        at(find(model, id, pn.Element), 120 + 220 * number, 100)
    at(find(model, "OnChatter", pn.Page), 140, 90)
    save(model, tmp_path / "talker.sym.xmi")
    return tmp_path / "talker.sym.xmi"


def stored(file: Path, id: str) -> tuple[float, float]:
    graphics = find(load(file), id, pn.Element).graphics
    assert graphics is not None
    return graphics.positions[0].x, graphics.positions[0].y


def saved(hand: Hand) -> None:
    hand.idle()  # else what the last key did may come after it
    hand.page.keyboard.press("Control+s")
    hand.idle()
    wait_until(hand.page, "document.getElementById('saved').textContent === 'saved'")


def gap(hand: Hand, one: str, other: str) -> tuple[float, float]:
    (x, y), (x2, y2) = hand.middle(one), hand.middle(other)
    return round(x2 - x), round(y2 - y)


@pytest.mark.long
def test_pages_open_in_place_and_what_is_in_them_moves_there(file: Path, edit: Edit, visit: NewVisit) -> None:
    document, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.idle()
    before, apart = file.read_bytes(), gap(hand, "talker", "Chatter")
    hand.click_sign("listener")
    hand.click_sign("OnChatter")
    expect(hand.shape("listener")).to_have_attribute("aria-expanded", "true")
    frame, inner = (hand.shape(each).bounding_box() for each in ("listener", "OnChatter"))
    words = hand.shape("Noted").bounding_box()
    assert frame and inner and words
    assert frame["x"] < inner["x"] < words["x"] and frame["y"] < inner["y"] < words["y"]
    assert words["x"] + words["width"] < inner["x"] + inner["width"] < frame["x"] + frame["width"]
    # What is open is this tab's own affair: nothing of the model has changed.
    assert document.undo_label is None and document.is_saved
    assert hand.shape("Words").count() == 0 and gap(hand, "talker", "Chatter") == apart

    scale = float(hand.page.evaluate("dinerosEditor.canvas.canvas.viewbox().scale"))
    x, y = hand.middle("Listen")
    hand.drag("Listen", 0, 60)
    assert hand.middle("Listen") == pytest.approx((x, y + 60), abs=2)
    saved(hand)
    assert stored(file, "Listen") == pytest.approx((400, 500 + 60 / scale), abs=1)
    hand.page.keyboard.press("Control+z")
    saved(hand)
    assert file.read_bytes() == before
    assert hand.middle("Listen") == pytest.approx((x, y), abs=2)

    # A frame that is moved takes what is in it along, and nothing but its own position changes.
    inside = gap(hand, "OnChatter", "Heard")
    (x, y), box = hand.middle("Heard"), hand.shape("listener").bounding_box()
    assert box is not None
    hand.page.mouse.move(box["x"] + 30, box["y"] + box["height"] - 6)
    hand.page.mouse.down()
    hand.page.mouse.move(box["x"] + 50, box["y"] + box["height"] + 20, steps=4)
    hand.page.mouse.move(box["x"] + 70, box["y"] + box["height"] + 44, steps=4)
    hand.page.mouse.up()
    hand.idle()
    assert hand.middle("Heard") == pytest.approx((x + 40, y + 50), abs=2)
    assert gap(hand, "OnChatter", "Heard") == inside
    saved(hand)
    assert stored(file, "Heard") == (300, 500)
    assert stored(file, "listener") == pytest.approx((560 + 40 / scale, 100 + 50 / scale), abs=1)

    hand.shape("listener").press("Space")
    expect(hand.shape("OnChatter")).to_have_count(0)
    expect(hand.shape("listener")).to_have_attribute("aria-expanded", "false")
    two = Hand(visit().page, handle.url)
    assert two.shape("OnChatter").count() == 0  # another tab, where all is closed
    two.open("listener")
    two.click_sign("OnChatter")
    two.click("Listen")  # which lies on the frame, also where no line is on the sheet besides
    expect(two.page.locator("#field-id")).to_have_value("Listen")


def test_a_page_is_opened_drawn_in_and_closed_by_keys(file: Path, edit: Edit, visit: NewVisit) -> None:
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    page, press = hand.page, hand.page.keyboard.press
    hand.shape("talker").focus()
    press("Space")
    expect(hand.shape("talker")).to_be_focused()
    expect(hand.shape("Words")).to_have_accessible_name("place Words, 3 tokens, in talker")
    tool = page.locator("#tools").get_by_role("button", name="place", exact=True)
    tool.focus()
    press("Enter")
    hand.made(id="Kept")
    hand.shape("Say").focus()
    press("Enter")
    press("a")
    hand.shape("Kept").focus()
    press("Enter")
    hand.idle()
    press("Escape")
    hand.shape("Said").focus()
    press("Enter")
    press("F2")
    page.keyboard.insert_text("Spoken")
    press("Enter")
    hand.idle()
    press("Escape")
    hand.shape("Words").focus()
    press("Enter")
    press("Delete")
    expect(hand.shape("Words")).to_have_count(0)
    hand.shape("talker").focus()
    press("Enter")
    expect(page.get_by_role("button", name="Close")).to_be_visible()
    press("Space")
    expect(hand.shape("Kept")).to_have_count(0)
    page.reload()
    page.wait_for_selector("body[data-revision]")
    hand.shape("talker").focus()
    press("Space")
    page.reload()  # what is open stays so for as long as the tab is there
    page.wait_for_selector("body[data-revision]")
    expect(hand.shape("Kept")).to_be_visible()
    saved(hand)
    model = load(file)
    node = find(model, "talker", sym.NodeNet)
    assert [each.id for each in node.objects] == ["Say", "Spoken", "Kept"]
    assert [(label(arc.source), label(arc.target)) for arc in node.arcs] == [
        ("Say", "Spoken"),
        ("Say", "Kept"),
    ]


def test_clicks_draw_where_they_are_and_arcs_lead_from_page_to_page(
    file: Path, edit: Edit, visit: NewVisit
) -> None:
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.idle()
    for name in ("listener", "OnChatter"):
        hand.click_sign(name)
    hand.tool("place")
    box = hand.shape("listener").bounding_box()
    assert box is not None
    hand.page.mouse.click(box["x"] + 12, box["y"] + box["height"] - 8)  # beside the inner frame
    hand.made(id="Beside")
    hand.tool("arc")
    hand.click("Listen")
    hand.click("Beside")
    hand.idle()
    hand.page.keyboard.press("Escape")
    expect(hand.page.locator("#count")).to_have_text("No problems")
    saved(hand)
    model = load(file)
    assert find(model, "Beside", sym.Place).page is find(model, "listener", sym.NodeNet)
    arc = find(model, "OnChatter", pn.Page).arcs[-1]
    assert arc.source.id == "Listen" and isinstance(arc.target, pn.ReferencePlace)
    assert arc.target.target.id == "Beside"
    for _ in ("the arc", "the name", "the place"):
        hand.page.keyboard.press("Control+z")
        hand.idle()
    expect(hand.page.locator("#canvas [aria-label^='place']")).to_have_count(2)


def test_marks_and_games_are_shown_inside(file: Path, edit: Edit, visit: NewVisit) -> None:
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    page = hand.page
    hand.idle()
    hand.click_sign("talker")
    hand.click("Words")
    hand.fill("tokens", "-1")
    expect(page.locator(".djs-shape.has-error")).to_have_count(1)
    assert "Words" in str(page.locator(".djs-shape.has-error").get_attribute("aria-label"))
    hand.click_sign("talker")
    assert "talker" in str(page.locator(".djs-shape.has-error").get_attribute("aria-label"))
    hand.click_sign("talker")
    page.keyboard.press("Control+z")
    hand.idle()
    page.keyboard.press("p")
    wait_until(page, "document.body.dataset.game === 'on'")
    page.locator("#game .signals button").first.click()
    wait_until(page, "dinerosEditor.player.game.at === 1")
    expect(page.locator(".djs-shape.is-enabled")).to_have_count(1)
    hand.click("Say")
    expect(hand.shape("Words")).to_have_accessible_name("place Words, 2 tokens, in talker")
    hand.click_sign("listener")  # also while it is played
    hand.click_sign("OnChatter")
    expect(hand.shape("Heard")).to_be_visible()
    assert page.locator("#path [aria-current]").inner_text() == "greeting"


def test_what_nobody_has_arranged_is_laid_out_in_its_frame(
    tmp_path: Path, edit: Edit, visit: NewVisit
) -> None:
    file = tmp_path / "talker.sym.xmi"
    save(talker(), file)
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.idle()
    hand.click_sign("talker")
    wait_until(hand.page, "dinerosEditor.canvas.computed.size === 2")
    hand.idle()
    (x, y), (x2, y2), (x3, y3) = (hand.middle(each) for each in ("Words", "Say", "Said"))
    assert x < x2 < x3 and y == pytest.approx(y2, abs=2) and y2 == pytest.approx(y3, abs=2)
    hand.drag("Say", 0, 50)
    assert hand.middle("Words") == pytest.approx((x, y), abs=2)
    assert hand.middle("Say") == pytest.approx((x2, y2 + 50), abs=2)
    saved(hand)
    found = load(file)
    drawn = [each.id for each in found.eAllContents() if isinstance(each, pn.Element) and each.graphics]
    assert drawn == ["Words", "Say", "Said"]  # all of that page, as it is seen, and nothing of any other
    hand.page.get_by_role("button", name="Arrange").click()
    hand.idle()
    assert hand.middle("Say")[1] == pytest.approx(hand.middle("Words")[1], abs=2)
