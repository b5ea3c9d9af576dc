"""Takes the screenshots of the guide's front page; needs Chromium and a built guide.

python -m mkdocs build --site-dir build/site && python docs/screenshots.py
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[1]
SITE = ROOT / "build/site/pictures"
TARGET = ROOT / "docs/pictures"
MODEL = "case_study/sorting.sym.xmi"
SIZE = {"width": 1280, "height": 760}


def main() -> None:
    """Write the three pictures."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        report = Path(folder) / "report.html"
        command = [sys.executable, "-m", "dineros.cli.main", "check", MODEL, "-o", str(report)]
        subprocess.run(
            [*command, "--set", "LeftCellObjects.subscriber.ReqControlL.limit=1"], cwd=ROOT, check=False
        )
        browser = playwright.chromium.launch(executable_path=chromium)
        try:
            for name, page in (
                ("finding", report),
                ("net", SITE / "sorting.html"),
                ("run", SITE / "trace-run.html"),
            ):
                tab = browser.new_page(viewport=SIZE, color_scheme="light")  # type: ignore[arg-type]
                tab.goto(page.as_uri())
                tab.wait_for_timeout(1500)
                tab.screenshot(path=TARGET / f"screenshot-{name}.png")
        finally:
            browser.close()


if __name__ == "__main__":
    main()
