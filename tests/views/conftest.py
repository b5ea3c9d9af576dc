"""Pages that must show no error."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.views.browser import Visit

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.fixture
def visit(browser: Browser) -> Iterator[Callable[..., Visit]]:
    """Return what opens pages; at the end no page may have shown an error."""
    visits: list[Visit] = []

    def new(**options: Any) -> Visit:
        visits.append(Visit(browser, **options))
        return visits[-1]

    yield new
    for one in visits:
        one.page.close()
    assert [problem for one in visits for problem in one.problems] == []
