"""What the editor's page offers and shows: tools that fit, a hint where nothing is, arcs by their kinds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pytest
from playwright.sync_api import expect

from dineros.metamodel import pn, sym
from dineros.metamodel.editing import CommandError, Document
from dineros.metamodel.editing.commands import Create
from dineros.metamodel.editing.commands import Place as Put
from dineros.metamodel.editing.composed import compose
from dineros.metamodel.editing.composed.operations import Copy
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.support.systems.talker import talker
from tests.views.browser import Visit
from tests.views.editing.conftest import Edit
from tests.views.editing.driving import Hand

NewVisit = Callable[..., Visit]


N = TypeVar("N", bound=pn.Node)


def at(x: float, y: float, element: N) -> N:
    element.graphics = pn.Graphics(positions=[pn.Point(x=x, y=y)])
    return element


def test_arcs_are_drawn_by_their_kinds_also_in_a_game(tmp_path: Path, edit: Edit, visit: NewVisit) -> None:
    places = [at(80, 80 * number, pn.Place(id=f"p{number}", tokens=1)) for number in (1, 2, 3)]
    step = at(240, 160, pn.Transition(id="t"))
    kinds = ("normal", "read", "inhibitor")
    arcs = [
        pn.Arc(id=kind, source=place, target=step, kind=kind)
        for kind, place in zip(kinds, places, strict=True)
    ]
    save(pn.Net(id="n", pages=[pn.Page(id="page", objects=[*places, step], arcs=arcs)]), tmp_path / "n.xmi")
    _, handle = edit(tmp_path / "n.xmi")
    page = Hand(visit().page, handle.url).page
    for is_played in (False, True):
        if is_played:
            page.keyboard.press("p")
            expect(page.locator("#game")).to_be_visible()
        for kind, heads, rings in (("normal", 1, 0), ("read", 2, 0), ("inhibitor", 0, 1)):
            expect(page.locator(f"#canvas .edge.{kind} .head")).to_have_count(heads)
            expect(page.locator(f"#canvas .edge.{kind} .ring")).to_have_count(rings)


def test_an_empty_sheet_says_what_to_do(tmp_path: Path, edit: Edit, visit: NewVisit) -> None:
    _, handle = edit(tmp_path / "new.sym.xmi")
    hand = Hand(visit().page, handle.url)
    hint = hand.page.locator("#hint")
    expect(hint).to_contain_text("Choose a tool on the left")
    hand.put("node net", 0.5, 0.5, id="talker")  # the hint takes no clicks
    expect(hint).to_be_hidden()
    hand.open("talker")
    expect(hint).to_contain_text("The sheet of talker is empty.")
    hand.page.keyboard.press("Alt+ArrowUp")
    hand.on_sheet("new")
    for _ in ("its id", "the node net"):
        hand.page.keyboard.press("Control+z")
        hand.idle()
    hint.get_by_role("button").click()
    hand.page.keyboard.type("service")
    hand.page.keyboard.press("Enter")
    expect(hint).to_be_hidden()


def test_tools_fit_where_they_are_offered(tmp_path: Path, edit: Edit, visit: NewVisit) -> None:
    model = talker()
    model.middleware = sym.Middleware.ros2
    save(model, tmp_path / "talker.sym.xmi")
    _, handle = edit(tmp_path / "talker.sym.xmi")
    hand = Hand(visit().page, handle.url)
    tools = hand.page.locator("#tools")
    form = hand.page.locator("#form")
    expect(tools.get_by_role("button", name="node net")).to_be_visible()
    hand.open("listener")
    expect(tools.get_by_role("button", name="callback page")).to_be_visible()
    expect(tools.get_by_role("button", name="node net")).to_have_count(0)
    hand.open("OnChatter")
    for words in ("node net", "callback page"):
        expect(tools.get_by_role("button", name=words)).to_have_count(0)
    hand.page.keyboard.press("Alt+ArrowUp")
    hand.page.keyboard.press("Alt+ArrowUp")
    for name in ("Chatter", "listener"):
        hand.click(name)
        expect(form.get_by_role("button", name="+ dispatcher")).to_have_count(0)
    hand.page.keyboard.press("Escape")
    hand.fill("middleware", "ros1")
    for name in ("Chatter", "listener"):
        hand.click(name)
        expect(form.get_by_role("button", name="+ dispatcher")).to_have_count(1)


def test_a_signal_is_found_on_its_sheet(tmp_path: Path, edit: Edit, visit: NewVisit) -> None:
    save(talker(), tmp_path / "talker.sym.xmi")
    _, handle = edit(tmp_path / "talker.sym.xmi")
    hand = Hand(visit().page, handle.url)
    for way in ("from its sheet", "from another one"):
        if way == "from its sheet":
            hand.open("talker")
        else:
            hand.page.keyboard.press("Escape")
            hand.page.keyboard.press("Alt+ArrowUp")
        hand.page.keyboard.press("Control+f")
        hand.page.keyboard.type("Button")
        hand.page.keyboard.press("Enter")
        hand.on_sheet("talker")
        expect(hand.page.locator("#form h2")).to_have_text("Button")


def test_one_problem_is_one(tmp_path: Path, edit: Edit, visit: NewVisit) -> None:
    model = talker()
    find(model, "Chatter", sym.TopicChannel).publishers[0].limit = 0
    save(model, tmp_path / "talker.sym.xmi")
    _, handle = edit(tmp_path / "talker.sym.xmi")
    hand = Hand(visit().page, handle.url)
    expect(hand.page.locator("#count")).to_have_text("1 error, 0 warnings")


def test_a_node_net_is_put_into_no_node_net(tmp_path: Path) -> None:
    save(talker(), tmp_path / "talker.sym.xmi")
    document = Document(tmp_path / "talker.sym.xmi")

    def handle(id: str) -> str:
        found = document.handles.of(find(document.root, id))
        assert found is not None
        return found

    before = document.content().data
    talker_, listener = handle("talker"), handle("listener")
    copied = compose(document.root, document.handles, Copy((talker_,), listener, 0, 0))
    for commands in (
        [Create(listener, "objects", "sym.NodeNet")],
        [Create(handle("OnChatter"), "objects", "sym.NodeNet")],
        [Put(talker_, listener, "objects")],
        copied,
    ):
        with pytest.raises(CommandError, match="cannot hold a node net"):
            document.do(commands)
    assert document.content().data == before
    document.close()
