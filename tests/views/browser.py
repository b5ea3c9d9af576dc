"""Headless Chromium for tests of pages; nothing it opens may reach a network beyond this machine."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.support.programs.system_packages import require

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Page

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
# As root, as in containers, Chromium has no sandbox; and it is to ask nobody for updates.
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
             "--disable-component-update", "--disable-sync"]  # fmt: skip
PATIENCE = 240.0
"""Seconds after which a condition counts as never true; a busy machine may take long to show a page."""


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start a browser; skip the test where there is none, but not in CI."""
    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    if program is None:
        require("chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=ARGUMENTS, timeout=PATIENCE * 1000)
        try:
            yield browser
        finally:
            browser.close()


def wait_until(page: Page, condition: str, timeout: float = PATIENCE) -> None:
    """Wait until an expression of JavaScript is true.

    Playwright's own waiting would evaluate the expression on the page, whose policy forbids that.
    """
    ends = time.monotonic() + timeout
    while not page.evaluate(f"Boolean({condition})"):
        assert time.monotonic() < ends, f"not within {timeout} s: {condition}"
        page.wait_for_timeout(50)


_COUNTING = """(doing) => {
  const done = { marks: 0, steps: 0 };
  const canvas = CanvasRenderingContext2D.prototype;
  const originals = {};
  for (const name of ["fill", "stroke", "fillRect", "strokeRect", "fillText"]) {
    originals[name] = canvas[name];
    canvas[name] = function (...given) { done.marks++; return originals[name].apply(this, given); };
  }
  const [data] = dinerosTrace.traces;
  const steps = data.steps;
  const get = (target, name) => { if (/^[0-9]/.test(String(name))) done.steps++; return target[name]; };
  data.steps = new Proxy(steps, { get });
  try {
    doing();
  } finally {
    Object.assign(canvas, originals);
    data.steps = steps;
  }
  return done;
}"""


def work(page: Page, statements: str) -> dict[str, int]:
    """Return what statements cost on the page of a trace, whatever the machine.

    Returns
    -------
    dict
        ``marks``: how often they drew on a canvas; ``steps``: how often they looked at a step of the trace.
    """
    done: dict[str, int] = page.evaluate(f"({_COUNTING})(() => {{ {statements} }})")
    return done


class Visit:
    """A page and what went wrong on it.

    Attributes
    ----------
    page : Page
        The page.
    problems : list of str
        Errors of scripts and of the console.
    requested : list of str
        Addresses that the page asked for.
    loses_its_server : bool
        Whether the test stops the server, so that a connection which is refused is no problem.
    """

    def __init__(self, browser: Browser, **options: Any) -> None:
        self.page: Page = browser.new_page(**{"viewport": {"width": 1300, "height": 800}, **options})
        self.page.set_default_timeout(PATIENCE * 1000)
        self.problems: list[str] = []
        self.requested: list[str] = []
        self.loses_its_server = False
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("console", self._said)
        self.page.on("request", lambda request: self.requested.append(request.url))

    def _said(self, message: ConsoleMessage) -> None:
        is_expected = self.loses_its_server and "ERR_CONNECTION_REFUSED" in message.text
        if message.type == "error" and not is_expected:
            self.problems.append(message.text)

    def open(self, file: Path, fragment: str = "") -> Page:
        """Open a file and wait until its first picture is drawn."""
        self.page.goto(f"{file.as_uri()}{fragment}")
        self._wait_for_a_picture()
        return self.page

    def reload(self) -> None:
        """Load the page again and wait until its first picture is drawn."""
        self.page.reload()
        self._wait_for_a_picture()

    def _wait_for_a_picture(self) -> None:
        wait_until(self.page, "globalThis.dinerosTrace && dinerosTrace.view.frames > 0")

    def settle(self) -> None:
        """Wait until what was asked for is drawn."""
        self.page.evaluate(
            "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )
