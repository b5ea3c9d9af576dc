"""The page of the case study, which many tests open."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from dineros.views.nets import view_of
from tests.views.nets.drawing.page_parts import opened, saved
from tests.views.nets.samples import case_study

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from tests.views.browser import Visit


@pytest.fixture(scope="package")
def study_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return saved(view_of(case_study()), tmp_path_factory.mktemp("page"))


@pytest.fixture
def study(visit: Callable[..., Visit], study_page: Path) -> Page:
    return opened(visit(), study_page)
