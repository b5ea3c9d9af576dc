"""What the editor's page takes in Chromium: opening a sheet of 500 places and transitions, a drag, a mark.

Seconds by the clock depend on what else the machine does; beside them stands the processor time of the page's
main thread (what Chromium calls TaskDuration), which does not.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import CDPSession, Page

from benchmarks.models.editor import line
from dineros.metamodel.editing import Document
from dineros.metamodel.files import save
from dineros.views.editing import serve_editor
from tests.views.browser import chromium, wait_until

STEPS = 60
EDITS = 5

_DRAG = """([from, steps]) => new Promise((done) => {
  const target = document.elementFromPoint(from.x, from.y);
  const send = (kind, x, y) => target.dispatchEvent(new MouseEvent(kind,
    { bubbles: true, cancelable: true, clientX: x, clientY: y, button: 0, buttons: 1, view: window }));
  send("mousedown", from.x, from.y);
  let step = 0;
  const begun = performance.now();
  const next = () => {
    if (step === steps) {
      send("mouseup", from.x + 2 * steps, from.y + steps);
      done((performance.now() - begun) / steps);
      return;
    }
    step += 1;
    send("mousemove", from.x + 2 * step, from.y + step);
    requestAnimationFrame(next);
  };
  requestAnimationFrame(next);
})"""

_IS_MARKED = """Boolean(document.querySelector("#canvas .has-error[aria-label^='place p130']"))"""

_WATCH = """() => {
  globalThis.marked = [];
  let begun = 0;
  document.addEventListener("change", () => { begun = performance.now(); }, true);
  const shape = document.querySelector("#canvas .djs-shape[aria-label^='place p130']");
  let was = shape.classList.contains("has-error");
  new MutationObserver(() => {
    const now = shape.classList.contains("has-error");
    if (now !== was) requestAnimationFrame(() => marked.push(performance.now() - begun));
    was = now;
  }).observe(shape, { attributeFilter: ["class"] });
}"""


@contextmanager
def thread_time(session: CDPSession, found: list[float]) -> Iterator[None]:
    """Note how much processor time the page's main thread takes meanwhile, in seconds."""

    def taken() -> float:
        metrics = session.send("Performance.getMetrics")["metrics"]
        return float(next(each["value"] for each in metrics if each["name"] == "TaskDuration"))

    begun = taken()
    yield
    found.append(taken() - begun)


def middle(page: Page, name: str) -> dict[str, float]:
    """Return where a place is on the screen."""
    box = page.locator(f"#canvas [aria-label^='place {name}'] .djs-hit").first.bounding_box()
    assert box is not None
    return {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        file = Path(folder) / "line.sym.xmi"
        save(line(), file)
        document = Document(file)
        handle = serve_editor(document)
        try:
            page = browser.new_page(viewport={"width": 1300, "height": 800})
            session = page.context.new_cdp_session(page)
            session.send("Performance.enable", {"timeDomain": "threadTicks"})
            opening(page, session, handle.url)
            dragging(page, session)
            marking(page, session)
        finally:
            handle.stop()
            document.close()


def opening(page: Page, session: CDPSession, url: str) -> None:
    """Open the model, then its sheet of 500."""
    spent: list[float] = []
    begun = time.perf_counter()
    with thread_time(session, spent):
        page.goto(url)
        page.wait_for_selector("body[data-revision]")
        page.evaluate("dinerosEditor.go(dinerosEditor.model.all('sym.NodeNet')[0])")
        wait_until(page, "document.querySelectorAll('#canvas .djs-shape').length >= 500")
        page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    seconds = time.perf_counter() - begun
    print(f"open: {seconds:.2f} s, {spent[0]:.2f} s of the main thread")


def dragging(page: Page, session: CDPSession) -> None:
    """Drag a place over the sheet."""
    spent: list[float] = []
    with thread_time(session, spent):
        frame = page.evaluate(_DRAG, [middle(page, "p130"), STEPS])
    print(f"drag: {1000 / frame:.0f} frames/s, {1000 * spent[0] / STEPS:.1f} ms of the main thread each")


def marking(page: Page, session: CDPSession) -> None:
    """Give a place fewer than no tokens, and wait for its mark; then fix it."""
    wait_until(page, "dinerosEditor.model.revision > 0 && dinerosEditor.connection.waiting.size === 0")
    page.focus("#canvas .djs-shape[aria-label^='place p130']")
    page.keyboard.press("Enter")
    page.evaluate(_WATCH)
    spent: list[float] = []
    for number in range(EDITS):
        for value, shown in (("-1", "true"), ("1", "false")):
            with thread_time(session, spent):
                page.fill("#field-tokens", value)
                page.press("#field-tokens", "Enter")
                wait_until(
                    page, f"{_IS_MARKED} === {shown} && marked.length === {2 * number + 1 + (value == '1')}"
                )
    found = [1000 * sum(spent) / len(spent), *sorted(page.evaluate("marked"))]
    print(f"mark: {found[0]:.0f} ms of the main thread; by the clock {found[1]:.0f} to {found[-1]:.0f} ms")


if __name__ == "__main__":
    main()
