"""The pictures of the page *Draw a model*: the editor, driven by clicks and keys while the guide is built."""

from __future__ import annotations

import logging
import shutil
import sys
import tempfile
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from playwright.sync_api import Browser

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from dineros.metamodel.editing import Document  # noqa: E402
from dineros.views.editing import serve_editor  # noqa: E402
from tests.views.browser import PROGRAMS, Visit, chromium  # noqa: E402
from tests.views.editing.driving import Hand  # noqa: E402

LOG = logging.getLogger("mkdocs.hooks.editor_pictures")
SIZE = {"width": 1080, "height": 600}
STEPS = ("empty", "system", "talker", "listener", "connected", "clause", "template")
Take = Callable[[str], None]


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the pictures to the guide; the hook that MkDocs calls."""
    for path, content in pictures().items():
        files.append(File.generated(config, path, content=content))
    return files


@cache
def pictures() -> dict[str, bytes]:
    """Return the pictures by their paths in the guide; blank ones where Chromium is missing."""
    if not any(map(shutil.which, PROGRAMS)):
        LOG.info("Chromium is missing: the pictures of the editor are left out")
        return {path(step, theme): blank() for step in STEPS for theme in ("light", "dark")}
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        return drawn(Path(folder) / "greeting.sym.xmi", browser)


def drawn(file: Path, browser: Browser) -> dict[str, bytes]:
    """Draw the model of the page into a file; return the pictures that were taken meanwhile."""
    taken: dict[str, bytes] = {}
    document = Document(file)
    handle = serve_editor(document)
    try:
        visit = Visit(browser, viewport=SIZE)
        hand = Hand(visit.page, handle.url)

        def take(step: str) -> None:
            hand.idle()
            for theme in ("dark", "light"):
                hand.page.emulate_media(color_scheme=theme)
                taken[path(step, theme)] = hand.page.screenshot()

        draw(hand, take)
        visit.page.close()
    finally:
        handle.stop()
        document.close()
    return taken


def path(step: str, theme: str) -> str:
    """Return the path of the picture of a step."""
    return f"pictures/drawing-{step}{'' if theme == 'light' else '-dark'}.png"


def draw(hand: Hand, take: Take) -> None:
    """Do what the page says, and take a picture of each step."""
    take("empty")
    hand.put("node net", 0.25, 0.3, id="talker")
    hand.put("node net", 0.75, 0.3, id="listener")
    hand.click_at("topic channel", 0.5, 0.6)
    hand.dialog(topic="chatter")
    hand.fill("id", "Chatter")
    take("system")

    hand.open("talker")
    hand.put("place", 0.2, 0.4, id="Words", tokens="3")
    hand.put("transition", 0.5, 0.4, id="Say")
    hand.put("place", 0.8, 0.4, id="Said")
    hand.arc("Words", "Say")
    hand.arc("Say", "Said")
    hand.page.keyboard.press("Escape")
    hand.button("+ input signal")
    hand.fill("id", "Button")
    hand.click("Say")
    take("talker")
    hand.page.locator("#field-clause").press_sequentially("Butt")
    take("clause")
    hand.page.keyboard.press("Enter")
    hand.page.keyboard.press("Enter")
    hand.idle()
    hand.click("Said")
    hand.button("+ publisher port of Chatter")

    hand.page.keyboard.press("Alt+ArrowUp")
    hand.on_sheet("greeting")
    hand.open("listener")
    hand.put("callback page", 0.4, 0.4, id="OnChatter")
    hand.open("OnChatter")
    hand.put("place", 0.2, 0.4, id="Heard")
    hand.put("transition", 0.5, 0.4, id="Listen")
    hand.put("place", 0.8, 0.4, id="Noted")
    hand.arc("Heard", "Listen")
    hand.arc("Listen", "Noted")
    hand.click("Heard")
    take("listener")
    hand.button("+ subscriber port of Chatter")
    hand.page.keyboard.press("Alt+ArrowUp")
    hand.on_sheet("listener")
    hand.page.keyboard.press("Alt+ArrowUp")
    hand.on_sheet("greeting")
    hand.page.keyboard.press("Escape")
    take("connected")
    hand.page.keyboard.press("Control+s")
    hand.idle()
    hand.page.keyboard.press("t")
    take("template")


def blank() -> bytes:
    """Return a picture of one white point."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        checked = kind + data
        return len(data).to_bytes(4, "big") + checked + zlib.crc32(checked).to_bytes(4, "big")

    header = (1).to_bytes(4, "big") * 2 + bytes([8, 0, 0, 0, 0])
    data = zlib.compress(b"\0\xff")
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
