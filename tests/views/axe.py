"""axe-core, which finds faults of pages that keep people from using them (WCAG 2), in the locked version."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Page

SCRIPT = Path(__file__).resolve().parents[2] / "node_modules/axe-core/axe.min.js"
"""Installed by `tools/browser-packages`, which `make test` runs before the tests."""


def faults(page: Page) -> list[str]:
    """Return what axe-core finds on a page as it is now, of what is serious or critical.

    Without axe-core, the test that runs is skipped; with CI set, it fails.
    """
    if not SCRIPT.is_file():
        if os.environ.get("CI"):
            pytest.fail("CI is set: tools/browser-packages must have installed axe-core")
        pytest.skip("without axe-core: run tools/browser-packages")
    page.evaluate(f"{SCRIPT.read_text(encoding='utf-8')}; undefined")
    found: list[dict[str, Any]] = page.evaluate("axe.run().then((result) => result.violations)")
    return [
        f"{one['impact']}: {one['help']} ({one['id']}): {node['html']}"
        for one in found
        for node in one["nodes"]
        if one["impact"] in ("serious", "critical")
    ]
