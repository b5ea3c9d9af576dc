"""Live servers that end with their test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from dineros.views.live import serve_live
from dineros.views.serving.handle import PageHandle

Serve = Callable[..., PageHandle]


@pytest.fixture(autouse=True)
def own_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture
def serve() -> Iterator[Serve]:
    handles: list[PageHandle] = []

    def start(*arguments: object, **options: object) -> PageHandle:
        handles.append(serve_live(*arguments, **options))  # type: ignore[arg-type]
        return handles[-1]

    yield start
    for handle in handles:
        handle.stop()
