"""Driving the editor's page as people do: by clicks and keys."""

from __future__ import annotations

import re
from typing import Any

from playwright.sync_api import Locator, Page

from tests.views.browser import wait_until


class Hand:
    """Who sits in front of the page.

    Parameters
    ----------
    page : Page
        The page.
    url : str
        Where the editor is.
    """

    def __init__(self, page: Page, url: str) -> None:
        self.page = page
        page.goto(url)
        page.wait_for_selector("body[data-revision]")

    @property
    def revision(self) -> int:
        return int(self.page.evaluate("document.body.dataset.revision"))

    def idle(self) -> None:
        """Wait until everything that was asked is answered, and all has its place."""
        wait_until(self.page, "dinerosEditor.connection.waiting.size === 0 && !document.body.dataset.busy")

    def open(self, name: str) -> None:
        """Open a page by a double click."""
        self.idle()
        self.page.mouse.dblclick(*self.middle(name))
        self.on_sheet(name)

    def click_sign(self, name: str) -> None:
        """Click the sign in the corner of a page."""
        box = self.shape(name).locator(".sign .knob").bounding_box()
        assert box is not None
        self.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        self.idle()

    def on_sheet(self, name: str) -> None:
        """Wait until the sheet of this name is shown."""
        wait_until(self.page, f"document.querySelector('#path [aria-current]').textContent === '{name}'")
        self.idle()

    def shape(self, name: str) -> Locator:
        """Return the shape with a name."""
        return self.page.get_by_role("button", name=re.compile(rf"^[a-z ]+ {re.escape(name)}(,|$)")).and_(
            self.page.locator("#canvas .djs-shape")
        )

    def middle(self, name: str) -> tuple[float, float]:
        """Return where a shape is, in pixels of the window."""
        box = self.shape(name).locator(".djs-hit").first.bounding_box()
        assert box is not None
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def click(self, name: str) -> None:
        self.page.mouse.click(*self.middle(name))

    def choose(self, *names: str) -> None:
        """Choose shapes by keys."""
        for number, name in enumerate(names):
            self.shape(name).focus()
            self.page.keyboard.press("Shift+Enter" if number else "Enter")

    def drag(self, name: str, dx: float, dy: float) -> None:
        """Drag a shape by pixels of the window."""
        x, y = self.middle(name)
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + dx / 2, y + dy / 2, steps=4)
        self.page.mouse.move(x + dx, y + dy, steps=4)
        self.page.mouse.up()
        self.idle()

    def tool(self, words: str) -> None:
        self.page.locator("#tools").get_by_role("button", name=words, exact=True).click()

    def put(self, words: str, x: float, y: float, **fields: str) -> None:
        """Make an element by clicking on the canvas at a share of its width and height; fill in its form."""
        self.click_at(words, x, y)
        self.made(**fields)

    def click_at(self, words: str, x: float, y: float) -> None:
        """Take a tool, and click on the canvas at a share of its width and height."""
        self.tool(words)
        canvas = self.page.locator("#canvas").bounding_box()
        assert canvas is not None
        self.page.mouse.click(canvas["x"] + x * canvas["width"], canvas["y"] + y * canvas["height"])

    def middles(self) -> dict[str, tuple[float, float]]:
        """Return where all shapes of the sheet are, in pixels of the window, by their ids."""
        found: dict[str, tuple[float, float]] = self.page.evaluate(
            """() => Object.fromEntries([...document.querySelectorAll("#canvas .djs-shape")].map((shape) => {
                const { x, y, width, height } = shape.querySelector(".djs-hit").getBoundingClientRect();
                const { values } = dinerosEditor.model.get(shape.dataset.element);
                return [values.id, [x + width / 2, y + height / 2]];
            }))"""
        )
        return found

    def made(self, **fields: str) -> None:
        """Wait until an element is made and shown; fill in its form."""
        self.idle()
        for name, value in fields.items():
            self.fill(name, value)

    def dialog(self, **fields: str) -> None:
        """Fill in the dialog that is open."""
        dialog = self.page.locator("#dialog")
        for name, value in fields.items():
            field = dialog.locator(f"[name={name}]")
            if field.evaluate("(field) => field instanceof HTMLSelectElement"):
                field.select_option(label=value)
            else:
                field.fill(value)
        dialog.get_by_role("button", name="Make").click()
        self.idle()

    def fill(self, name: str, value: str) -> None:
        """Fill in a field of the form."""
        field = self.page.locator(f"#field-{name}")
        if field.evaluate("(field) => field instanceof HTMLSelectElement"):
            field.select_option(value)
        else:
            field.fill(value)
            field.press("Enter")
        self.idle()

    def arc(self, source: str, target: str) -> None:
        self.tool("arc")
        self.click(source)
        self.click(target)
        self.idle()
        self.page.keyboard.press("Escape")

    def button(self, name: str, *, group: str | None = None) -> None:
        """Press a button: of the feature `group` of the form if several features have one of that name."""
        within = self.page if group is None else self.page.get_by_role("group", name=group, exact=True)
        within.get_by_role("button", name=name, exact=True).click()
        self.idle()

    def model(self) -> dict[str, Any]:
        """Return what the page knows."""
        found: dict[str, Any] = self.page.evaluate(
            "({ root: dinerosEditor.model.root, objects: Object.fromEntries(dinerosEditor.model.objects) })"
        )
        return found
